"""The shortest motion whose predicted deviations reach targets, found by planning motions of several durations.

White noise lets deviations fall with the root of the duration, above what tolerances leave, and beside what earlier
results say. Errors that depend on the pose do not average out where a motion returns, and a short motion has no room
for long ways: so each duration is planned, and what earlier ones reached only says which is next. After the first,
which determines the family, durations are searched from one start, a few percent from what more find; the shortest one
that reaches the targets is searched whole.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

from cases.base.errors import Code, HexciteError, InfeasiblePlan, Interrupted, option
from cases.base.phrases import Phrase, phrase
from cases.schema import Case
from identification.model.model import identification_model
from identification.model.parameters import physical_form
from identification.texts import legible, std_text
from planner.options import DURATION
from planner.plans.plan import Plan
from planner.plans.prediction import NOISE, Prediction
from planner.request import Request

KNOWN_FIRST = DURATION / 4.0  # [s] the first duration where something is known: less is missing
CLOSE = 1.04  # ratio of the shortest duration that reaches the targets to the longest below it that does not
MOST = 14  # durations at most
LONGER, SHORTER = 4.0, 0.25  # ratio of a duration to the one before, at most and at least
AMONG = 0.15  # nearest share of the way, in logarithms, between two durations at which the next one lies
NEXT_TO_NOTHING = 1e-6  # of a duration
ROUNDING = 1e-9  # of a number of steps
STEEPEST, FLATTEST = -2.0, -0.05  # powers of the duration by which deviations are taken to change


@dataclass(frozen=True, slots=True)
class Trial:
    """A duration that was planned."""

    duration: float  # that was asked for [s]
    plan: Plan | None  # None where there is no motion of this duration
    excess: float  # largest ratio of a predicted deviation to its target; infinity without a motion
    share: float  # of the duration that is enough by white noise; infinity where none is, and without a motion
    problem: HexciteError | None = None  # why there is no motion


def shortest(request: Request, case: Case, plan_of: Callable[[Request], Plan]) -> Plan:
    """The shortest motion that reaches the targets of a request, whose duration is the longest allowed.

    Where the family is open, the first motion that succeeds determines it. The motion is one of those that were
    planned, with what was asked for but the duration found.

    Args:
        plan_of: request without targets -> its plan.

    Raises:
        InfeasiblePlan: no duration reaches the targets; the message says by what the best motion misses them.
        Interrupted: Ctrl-C before a motion reached them.
    """
    targets, longest, family = request.target, request.duration, request.family
    trials: list[Trial] = []
    first = DURATION if request.known is None else KNOWN_FIRST
    duration: float | None = _whole(min(max(first, family.least(case)), longest), family.step)
    while duration is not None and len(trials) < MOST:
        trial_request = replace(request, family=family, duration=duration, target={})
        if any(trial.plan is not None for trial in trials):
            trial_request = _from_one_start(trial_request)
        trial = _trial(trial_request, targets, plan_of)
        trials.append(trial)
        if trial.plan is not None:
            family = trial.plan.of_motion[0].family
            if trial.plan.interrupted:
                break
        duration = following(trials, family.least(case), longest, family.step)
    enough = [trial for trial in trials if trial.excess <= 1.0]
    if not enough:
        raise _missed(trials, request, case)
    best = min(enough, key=lambda trial: trial.duration)
    interrupted = any(trial.plan is not None and trial.plan.interrupted for trial in trials)
    plan = best.plan
    assert plan is not None
    if not interrupted and plan.of_motion[0].starts != request.starts:
        whole = _trial(replace(plan.of_motion[0], starts=None), targets, plan_of)
        if whole.plan is not None and whole.excess <= 1.0:
            best, plan = whole, whole.plan
            interrupted = plan.interrupted
    motion, worth = plan.of_motion
    worth = replace(worth, notes=(_note(best, trials, targets, case, motion.model), *worth.notes))
    request_of_motion = replace(motion, starts=request.starts, target=targets)
    return replace(plan, request=request_of_motion, worth=worth, interrupted=interrupted)


def _from_one_start(request: Request) -> Request:
    """A request whose search is short, unless it is asked when it ends."""
    return request if request.starts is not None or request.seconds is not None else replace(request, starts=1)


def require_more(request: Request, case: Case) -> None:
    """Raises HexciteError where what is known reaches the targets of a request already: no motion is needed."""
    if request.known is None:
        return
    from identification.results.pooling import mean_of

    mean = mean_of([request.known])
    std = Prediction(identification_model(case, request.model), request.known.values, mean.random, mean.biases).std
    if all(std[name] <= at for name, at in request.target.items()):
        raise HexciteError(
            place=f"target {deviations_in_words(request.target, request.target, case, request.model)}",
            problem=phrase(
                "target_is_reached",
                "is reached by {results}: {deviations}",
                results=", ".join(request.known.results),
                deviations=deviations_in_words(request.target, std, case, request.model),
            ),
            remedy=phrase("no_motion_needed", "no motion is needed"),
            code=Code.OUT_OF_RANGE,
        )


def _trial(request: Request, targets: Mapping[str, float], plan_of: Callable[[Request], Plan]) -> Trial:
    try:
        plan = plan_of(request)
    except HexciteError as error:  # too short for its family, or for what the model has to determine
        return Trial(request.duration, None, math.inf, math.inf, error)
    excess = max(plan.std_after[name] / at for name, at in targets.items())
    share = max(_share(plan, name, at) for name, at in targets.items())
    return Trial(request.duration, plan, excess, min(share, 1.0) if excess <= 1.0 else share)


def _share(plan: Plan, name: str, at: float) -> float:
    """The share of its duration after which a plan reaches a target by white noise, whose information grows with time.

    What is known has its information already, and what tolerances leave stays; infinity where that is more than the
    target.
    """
    promise = plan.promise if plan.gain is None else plan.gain.after
    after = promise.budget[name][NOISE] if promise.budget else promise.std[name]
    stays = promise.std[name] ** 2 - after**2
    information = 0.0 if plan.gain is None else 1.0 / max(plan.gain.before[name] ** 2 - stays, after**2)
    if at**2 <= stays:
        return math.inf
    missing, added = 1.0 / (at**2 - stays) - information, 1.0 / after**2 - information
    if missing <= 0.0:
        return NEXT_TO_NOTHING
    return max(missing / added, NEXT_TO_NOTHING) if added > 0.0 else math.inf


def following(trials: list[Trial], least: float, longest: float, step: float) -> float | None:
    """The duration to plan next [s]; None where none is worth it.

    Args:
        trials: in the order of planning.
        least: duration below which there is no motion [s].
        longest: [s].
        step: between two durations [s].
    """
    reached = [trial for trial in trials if trial.excess <= 1.0]
    upper = min(reached, key=lambda trial: trial.duration, default=None)
    below = [t for t in trials if t.excess > 1.0 and (upper is None or t.duration < upper.duration)]
    lower = max(below, key=lambda trial: trial.duration, default=None)
    if upper is None:
        assert lower is not None
        two = sorted(below, key=lambda trial: trial.duration)[-2:]
        power = -0.5 if len(two) < 2 else _power(two[0], two[1], lambda trial: math.sqrt(trial.share))
        ratio = 2.0
        if math.isfinite(lower.share):
            ratio = lower.share ** (-0.5 / power)
        duration = min(lower.duration * min(max(ratio, CLOSE), LONGER), longest)
    elif lower is None:
        duration = upper.duration * min(max(upper.share, SHORTER), 0.9)
    elif upper.duration <= CLOSE * lower.duration:
        return None
    else:
        share = 0.5
        if math.isfinite(lower.share):
            share = math.log(lower.share) / math.log(lower.share / upper.share)
        share = min(max(share, AMONG), 1.0 - AMONG)
        duration = lower.duration * (upper.duration / lower.duration) ** share
    duration = max(_whole(duration, step), _whole(math.ceil(least / step - ROUNDING) * step, step))
    if lower is not None:
        duration = max(duration, _whole(lower.duration + step, step))
    if upper is not None:
        duration = min(duration, _whole(upper.duration - step, step))
    durations = {trial.duration for trial in trials}
    return duration if duration not in durations and least - step / 2 < duration <= longest else None


def _whole(duration: float, step: float) -> float:
    """The nearest whole number of steps, at least one, without the noise of the product."""
    return round(max(round(duration / step), 1) * step, 9)


def _power(shorter: Trial, longer: Trial, deviation: Callable[[Trial], float]) -> float:
    """The power of the duration with which a deviation changed between two."""
    before, after = deviation(shorter), deviation(longer)
    if not (math.isfinite(before) and math.isfinite(after)):
        return -0.5
    slope = math.log(after / before) / math.log(longer.duration / shorter.duration)
    return min(max(slope, STEEPEST), FLATTEST)


def deviations_in_words(names: Iterable[str], values: Mapping[str, float], case: Case, model: int) -> str:
    """Deviations for people, such as `m 0.0049 kg, xC 0.02 mm`."""
    units = {p.name: legible(p.unit) for p in physical_form(identification_model(case, model)).parameters}
    return ", ".join(f"{name} {std_text(values[name] * units[name][0])} {units[name][1]}" for name in names)


def _predicted(trial: Trial, targets: Mapping[str, float], case: Case, model: int) -> str:
    assert trial.plan is not None
    return deviations_in_words(targets, trial.plan.std_after, case, model)


def _note(best: Trial, trials: list[Trial], targets: Mapping[str, float], case: Case, model: int) -> Phrase:
    """What was asked for, what the motion predicts, and what the longest shorter one does."""
    words = phrase(
        "shortest",
        "{duration} s is the shortest of {count} durations that reaches {targets}: it predicts {predicted}",
        duration=f"{best.duration:g}",
        count=len(trials),
        targets=deviations_in_words(targets, targets, case, model),
        predicted=_predicted(best, targets, case, model),
    )
    shorter = [trial for trial in trials if trial.duration < best.duration]
    if not shorter:
        return words
    last = max(shorter, key=lambda trial: trial.duration)
    if last.plan is None:
        return phrase("shorter_none", "{words}; {duration} s has no motion", words=words, duration=f"{last.duration:g}")
    return phrase(
        "shorter_predicts",
        "{words}; {duration} s predicts {predicted}",
        words=words,
        duration=f"{last.duration:g}",
        predicted=_predicted(last, targets, case, model),
    )


def _missed(trials: list[Trial], request: Request, case: Case) -> HexciteError | Interrupted:
    """Why no motion reaches the targets."""
    planned = [trial for trial in trials if trial.plan is not None]
    if not planned:
        problem = trials[-1].problem
        assert problem is not None
        return problem
    best = min(planned, key=lambda trial: trial.excess)
    if any(trial.plan is not None and trial.plan.interrupted for trial in trials):
        return Interrupted()
    targets, model = request.target, request.model
    longest = max(trial.duration for trial in planned)
    return InfeasiblePlan(
        place=f"no motion of up to {longest:g} s reaches {deviations_in_words(targets, targets, case, model)}",
        problem=phrase(
            "target_missed",
            "the best, of {duration} s, predicts {predicted}, {times} times as much as asked for",
            duration=f"{best.duration:g}",
            predicted=_predicted(best, targets, case, model),
            times=f"{best.excess:.2f}",
        ),
        remedy=_remedy(planned, request, best.plan),
        code=Code.INFEASIBLE,
    )


def _remedy(planned: list[Trial], request: Request, best: Plan | None) -> str:
    """What to do: allow more time where that would help, else ask for less, or know the machine better."""
    promise = None if best is None else best.promise if best.gain is None else best.gain.after
    if best and promise and any(promise.least.get(name, 0.0) > at for name, at in request.target.items()):
        parameters = physical_form(identification_model(best.case, best.model)).parameters
        words = promise.lasting_words(parameters, request.target, phrase("more_seconds", "more seconds lower"))
        return f"{words}: ask for larger deviations, or lower these tolerances, as by a known weight"
    last = sorted(planned, key=lambda trial: trial.duration)[-2:]
    if len(last) == 2 and _power(last[0], last[1], lambda trial: trial.excess) > -0.25:
        return "longer motions hardly help: ask for larger deviations"
    return f"allow a longer {option('duration')}, or ask for larger deviations"
