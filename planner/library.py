"""Plans from Python: what notebooks and the command line call."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypedDict, Unpack

import numpy as np
from threadpoolctl import threadpool_limits

from cases.errors import InfeasiblePlan, Interrupted
from cases.schema import Case
from cases.units import Array
from identification.model import full_model, identification_model, static_model
from planner.bounds.information_limit import information_limit
from planner.families.manual import load_poses
from planner.families.settings import FamilySettings, PointToPoint
from planner.noise import expected_noise
from planner.planning import make_until_ctrl_c, require_plannable
from planner.plans import Plan
from planner.request import DURATION, LONGEST, PoseRequest, Request, TypedValue, parse_targets
from planner.search import Failed
from planner.search.parallel import Listener, silent, without_gain
from planner.search.solving import Start


class Settings(TypedDict, total=False):
    """What may be asked of a motion; `planner.request.Request` has the defaults."""

    criterion: str  # letter of Table 4
    model: int  # number in Table 2; the largest of the machine unless given
    payload: int  # number of the case's payloads that are mounted, at most
    payload_from: int | None  # fewest payloads, where that is another number
    targets: tuple[
        str, ...
    ]  # standard deviations to be met, such as m=0.05kg; the duration is then the longest allowed
    starts: int | None  # number of random starts; as many as pay unless given
    seed: int  # seed of the starts
    workers: int | None  # processes that search; one a core unless given


class PoseSettings(TypedDict, total=False):
    """What may be asked of poses; `planner.request.PoseRequest` has the defaults."""

    criterion: str  # letter of Table 4
    count: int | None  # number of poses
    method: str  # name of the method
    model: int  # number in Table 2, 0 to 5; the largest of the machine unless given
    candidates: int | None  # number of quasi-random candidates; the grid of the case unless given, of a chain 2048
    seed: int  # seed of these
    noise: float | None  # standard deviation of an averaged force [N]


def plan(
    case: Case,
    family: FamilySettings | None = None,
    duration: float = DURATION,
    *,
    progress: Callable[[str], None] | None = None,
    **settings: Unpack[Settings],
) -> Plan:
    """The most informative motion inside the machine's limits, proven.

    Ctrl-C ends the search and keeps the best motion found so far; a second one gives up. The search runs in `workers`
    processes, which do not run the caller's script.

    Args:
        case: machine and limits.
        family: family of motions; unless given point-to-point moves.
        duration: duration of the excitation [s].
        progress: shows a line now and then.
        **settings: criterion, model, payload, payload_from, targets, starts, seed, workers; see `Settings`.

    Raises:
        HexciteError: what was asked for cannot be met; the message says what to change.
    """
    settings.setdefault("model", full_model(case))
    request = Request(family or PointToPoint(), duration, **settings)  # type: ignore[arg-type]  # a letter will do
    return planned(request, case, progress)


def planned(request: Request, case: Case, progress: Callable[[str], None] | None = None) -> Plan:
    """`plan` for settings that are one value."""
    require_plannable(request, case)
    with threadpool_limits(limits=1, user_api="blas"):  # matrices are small: threads of BLAS would wait for each other
        listener = silent if progress is None else follower(request, case, progress)

        def make(wanted: Request) -> Plan:
            return make_until_ctrl_c(wanted, case, listener)

        return shortest_plan(request, case, make) if request.targets else make(request)


def plan_poses(
    case: Case,
    at: Path | Array | None = None,
    *,
    progress: Callable[[int], None] | None = None,
    **settings: Unpack[PoseSettings],
) -> Plan:
    """The most informative poses to stand at, in the fastest order, proven.

    Args:
        at: poses of one's own instead, to see what they are worth beside chosen ones: a CSV file, or coordinates of the
            machine, shape (n, k) [m or rad].
        case: machine, limits and poses.
        progress: called with the number of poses after each step of the choice.
        **settings: criterion, count, method, model, candidates, seed, noise; see `PoseSettings`.

    Raises:
        HexciteError: what was asked for cannot be met; the message says what to change.
    """
    from planner.poses.planned_poses import poses_planned  # SciPy, which motions do without

    settings.setdefault("model", static_model(case))
    if at is not None:
        settings["method"] = "given"
    request = PoseRequest(**settings)  # type: ignore[arg-type]  # a letter will do
    own = load_poses(Path(at), case.need_motion("a plan of poses")[1].columns) if isinstance(at, Path | str) else at
    with threadpool_limits(limits=1, user_api="blas"):
        return poses_planned(request, case, progress or (lambda _: None), own)


ROUNDS = 4  # of shortening: each lands within a few percent of what the information rate promises
RESERVE = 1.03  # shorter motions carry a little less information a second: turning round at the ends takes its time
SHORTER = 0.97  # share of the duration below which another plan is worth its time
SHORTEST = 2.0  # [s]


def shortest_plan(request: Request, case: Case, make: Callable[[Request], Plan]) -> Plan:
    """Plans at the request's duration, the longest allowed, then shorter ones as long as the targets are met.

    Every plan is optimal by the request's criterion for its duration; the shortest of these that meets the targets need
    not be the shortest of all motions. Ctrl-C keeps the shortest found until then.

    Raises:
        HexciteError: a target that cannot be read.
        InfeasiblePlan: a target is not met; the message says what is reached, and about how long would do.
        Interrupted: Ctrl-C before a plan met the targets.
    """
    targets = parse_targets(request.targets, case, request.model)

    def use(plan: Plan) -> tuple[float, TypedValue]:
        """The largest share of a target that a plan needs, and which one that is."""
        return max(((plan.predicted_std[t.name] / t.value, t) for t in targets), key=lambda pair: pair[0])

    best = make(request)
    if use(best)[0] > 1.0:
        raise _missed(request, best, *use(best))
    too_short = SHORTEST / 2
    for _ in range(ROUNDS):
        duration = max(best.motion.duration * use(best)[0] ** 2 * RESERVE, SHORTEST)
        if duration <= too_short:
            duration = (too_short + best.motion.duration) / 2
        duration = request.family.allowed_duration(duration)
        if duration > SHORTER * best.motion.duration or best.interrupted:
            break
        try:
            trial = make(request.lasting(duration))
        except InfeasiblePlan:  # so short that no start led anywhere
            too_short = duration
            continue
        except Interrupted:
            return replace(best, interrupted=True)
        if use(trial)[0] <= 1.0:
            best = trial
        elif trial.interrupted:
            return replace(best, interrupted=True)
        else:
            too_short = duration
    return best


def _missed(request: Request, best: Plan, share: float, target: TypedValue) -> BaseException:
    """What to say of the longest motion that is allowed where it does not meet a target."""
    text = f"{best.predicted_std[target.name] / target.scale:.3g} {target.unit}"
    if best.interrupted:
        return Interrupted(f"the best found until then has {text}, not {target.text}: nothing was written")
    minimum = request.duration * share**2 * RESERVE
    longer = request.family.allowed_duration(float(np.ceil(minimum)))
    remedy = f"allow --duration {longer:g} or a wider target"
    if longer > LONGEST:
        remedy = f"even the longest motion, {LONGEST:g} s, would not do: set a wider target"
    return InfeasiblePlan(
        f"target {target.text} is out of reach in {request.duration:g} s: the best found has {text}; {remedy}"
    )


def follower(asked: Request, case: Case, remark: Callable[[str], None]) -> Listener:
    """A listener that shows a line while starts are under way, and as each of them ends."""
    model, bound = identification_model(case, asked.model), None
    if asked.family.optimised and expected_noise(case, model, asked.payload).whitening is None:
        remark("the limit of information")
        bound = information_limit(case, model)
    request, began, results = asked, time.monotonic(), list[Start | Failed]()

    def follow(event: Request | Start | Failed | None) -> None:
        nonlocal request, began, results
        if isinstance(event, Request):
            request, began, results = event, time.monotonic(), []
            return
        results += [] if event is None else [event]
        seconds, count = time.monotonic() - began, len(results)
        best = max((r for r in results if isinstance(r, Start)), key=lambda s: s.promise, default=None)
        if best is None:
            remark(f"first starts, {seconds:.0f} s")
            return
        text = f"criterion {request.criterion} {best.record.criterion_value:.4g}"
        if bound is not None:
            text = f"{100 * bound.efficiency(best.record.logdet):.1f} % of the limit of information"
        left = _time_left(request, results, seconds, len(model.names))
        remark(f"{text} after {count} start{'s' * (count > 1)}, {seconds:.0f} s, {left}")

    return follow


def _time_left(request: Request, results: Sequence[Start | Failed], seconds: float, parameters: int) -> str:
    if request.starts is not None:
        rest = request.starts - len(results)
    else:
        rest = request.family.idle(request.criterion) - without_gain(results, request.criterion, parameters)
    if rest <= 0:
        return "refining the best"
    return f"about {seconds / len(results) * rest:.0f} s left{'' if request.starts else ' unless more is found'}"
