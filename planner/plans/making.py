"""Plans an excitation from start to proof."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count
from numbers import Real
from typing import NamedTuple

import numpy as np

from cases.base.errors import Code, HexciteError, IdentificationError, InfeasiblePlan, Interrupted, choice
from cases.base.phrases import phrase
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.criteria import Criterion
from identification.limits.limit import UNUSED_SHARE, LimitKind
from identification.limits.proof import PROOF_RATE, prove
from identification.model.model import identification_model
from identification.model.parameters import physical_form
from planner.controller_limits import controlled, with_steps
from planner.families.family import Family
from planner.families.plan_settings import SequenceSettings
from planner.families.settings import Best
from planner.plans.plan import Plan
from planner.plans.rating import PlannedMotion, rated_plan
from planner.request import LONGEST, Request
from planner.search.feasibility import keep_limits, remedy, require_identifiable, require_rest
from planner.search.parallel import (
    REFINEMENT,
    START,
    Listener,
    Planned,
    Runner,
    Schedule,
    enough,
    first_ctrl_c,
    gain,
    most_starts,
    run_here,
    workers,
)
from planner.search.record import Failed
from planner.search.solving import QUICK_RATE, Start, Task, limited_as_searched

KEPT = 3  # number of the best orders, periods, numbers of moves and families, at most, that get more starts
CLOSE = 0.03  # share of an efficiency by which others than the best are worse, at most, that get more starts too
PASSABLE = 0.35  # share of an efficiency by which the best of another family is worse, at most, that is refined too
REFINING = 0.4  # share of what is left of a search of some seconds that the refinements of a round have
ENDING = 3.0  # [s] at the end of a search of some seconds for proof, figures and page, but half of it at most
BETWEEN = 1e-5  # share of a limit that may be used between the instants at which a refined motion was checked
AHEAD = 8  # starts that may run at a time: what a start is depends on the results of those so many before it


def require_plannable(request: Request, case: Case) -> None:
    """Refuses requests that no search can meet.

    Raises:
        CaseError: the case has no machine, limits, controller or payload of this number.
        IdentificationError: an unknown model, or one that no motion of the machine determines.
        HexciteError: a duration too short for the machine.
        InfeasiblePlan: standing still in the middle of the motion box exceeds a limit.
        FileProblem: the sequence cannot be used.
    """
    case.need_motion("planning")
    require_identifiable(case, identification_model(case, request.model))
    require_targets(request, case)
    case.body(request.payload)
    request.family.require_plannable(case, request.duration)
    require_rest(case)


def require_targets(request: Request, case: Case) -> None:
    """Raises HexciteError where a target is not the positive deviation of a parameter [SI], or nothing is searched."""
    names = [p.name for p in physical_form(identification_model(case, request.model)).parameters]
    if request.target and not request.family.optimised:
        raise HexciteError(
            problem=f"a target does nothing with family {request.name}, whose duration is given",
            remedy="leave it out",
            code=Code.CONTRADICTION,
        )
    for name, value in request.target.items():
        if name not in names:
            raise HexciteError(
                place=f"target {name}",
                problem=f"is not a parameter of model {request.model}",
                remedy=choice(name, names),
                code=Code.UNKNOWN,
            )
        if not (isinstance(value, Real) and 0.0 < value < math.inf):
            shown = f"{value:g}" if isinstance(value, Real) else repr(value)
            raise HexciteError(
                place=f"target {name}",
                problem=f"{shown} is not a deviation to reach",
                remedy="give one above 0 in SI units, such as 0.005",
                code=Code.OUT_OF_RANGE,
            )


def search(request: Request, case: Case, listener: Listener, run: Runner, began: float | None = None) -> PlannedMotion:
    """Explores starts until further ones gain too little, refines the best ones, proves the winner.

    A search that lasts some seconds goes on with rounds of this kind, until what follows must begin.

    Args:
        began: from when these seconds count, by `time.monotonic` [s]; None for now.

    Raises:
        InfeasiblePlan: every start failed; the message is that of the first.
        Interrupted: Ctrl-C before any start was done.
    """
    until = math.inf
    if request.seconds is not None:
        began = time.monotonic() if began is None else began
        until = began + max(request.seconds - ENDING, request.seconds / 2)
    listener(request)
    made_for = request.family.made_for(case)
    controlled_case, step_time = controlled(case, made_for)
    noise = None if request.known is None else request.known.by_noise
    rounds = _Rounds(
        request, controlled_case.within_margin(), case, listener, run, until, noise
    )  # the proof asks the limits themselves
    results: list[Start | Failed] = []
    ended_early = late = False
    for number in count():
        more, ended_early, late = rounds.one(number, results)
        results += more
        if ended_early or late or request.seconds is None or all(isinstance(result, Failed) for result in more):
            break
    out_of_time = late
    starts = sorted(_without_failures(results), key=lambda s: -s.record.criterion_value)
    failed = tuple(r for r in results if isinstance(r, Failed))
    if not starts:
        if ended_early and not out_of_time:
            raise Interrupted
        raise InfeasiblePlan(problem=failed[0].reason, code=Code.INFEASIBLE)
    best = starts[0]
    unknowns = best.unknowns
    if not best.record.refined:  # it was checked at few instants: at more of them first, at those of the proof then
        unknowns = keep_limits(limited_as_searched(rounds.case, best.family), best.family, unknowns, QUICK_RATE)[0]
    motion = best.family.motion(unknowns)
    report = with_steps(prove(motion, case), step_time)
    if report.worst_ratio > 1.0 - UNUSED_SHARE + BETWEEN:
        motion = best.family.motion(keep_limits(rounds.case, best.family, unknowns, PROOF_RATE)[0])
        report = with_steps(prove(motion, case), step_time)
    without = LimitKind.JERK if step_time else None
    settings = best.family.found(best.unknowns).model_copy(update={"made_for": made_for, "without": without})
    interrupted = ended_early and not out_of_time
    return PlannedMotion(motion, settings, report, tuple(starts), failed, interrupted, out_of_time)


def _without_failures(results: Sequence[Start | Failed]) -> list[Start]:
    return [result for result in results if isinstance(result, Start)]


def _promising(results: Sequence[Start | Failed]) -> list[Start]:
    """Explorations that have not been refined, the most promising first."""
    starts = _without_failures(results)
    refined = {s.record.seed for s in starts if s.record.refined}  # no two starts of a search have one seed
    return sorted((s for s in starts if s.record.seed not in refined), key=lambda s: -s.promise)


def _with_other_families(starts: Sequence[Start], count: int, criterion: Criterion, parameters: int) -> list[Start]:
    """The first `count` of explorations, and the best of each other family that may pass them once it is refined.

    Families gain differently by that: on a seven-joint arm splines 40 % of an efficiency, moves 5 %.

    Args:
        starts: explorations, the most promising first.
        parameters: their number u.
    """
    chosen = list(starts[:count])
    for start in starts[count:]:
        behind = -gain(criterion, parameters, starts[0].promise, start.promise)
        if start.family.name not in {other.family.name for other in chosen} and behind <= PASSABLE:
            chosen.append(start)
    return chosen


def _best_when_they_came(results: Sequence[Start | Failed], count: int) -> list[Start]:
    """Explorations than which fewer than `count` of those before them were as good, the most promising first.

    What is refined of some starts is refined of more of them too, so that more starts never give less.
    """
    starts = _without_failures(results)
    chosen = [s for k, s in enumerate(starts) if sum(other.promise >= s.promise for other in starts[:k]) < count]
    return sorted(chosen, key=lambda s: -s.promise)


class _Round(NamedTuple):
    """What a round of a search came to."""

    results: list[Start | Failed]  # refinements last
    early: bool  # whether Ctrl-C or its time ended it
    late: bool  # whether the time that is left, if there is any, is too short for more


@dataclass(frozen=True, slots=True)
class _Rounds:
    """Rounds of a search: starts until further ones gain too little, and refinements of the best of them."""

    request: Request
    case: Case  # case with the limits that its controller enforces, within the margin of their ends
    reference: Case  # case of the reference scaling
    listener: Listener
    run: Runner
    until: float  # when the search is to end, by `time.monotonic` [s]
    known: Array | None  # covariance of u by the noise of earlier results, shape (u, u)

    def one(self, number: int, before: Sequence[Start | Failed]) -> _Round:
        """A round: explorations, then refinements of the best until now where there is time for them.

        A start that is stopped takes its time to end: its functions are built, its motion is brought inside the limits.
        Where less than that is left, as measured here, nothing more is begun.

        Args:
            number: number of the round, from 0.
            before: results of earlier rounds.
        """
        request = self.request
        seconds_left = self.until - time.monotonic()
        refining = REFINING * seconds_left if math.isfinite(seconds_left) else 0.0
        schedule = self._explorations(number, self.until - refining, before)
        least, exactly = self._least(), request.starts is not None
        self.listener(Planned(START, least, exactly, schedule.until))
        results, early = self.run(schedule, self.listener)
        late = schedule.late(results)
        ending = max(time.monotonic() - schedule.until, 0.0) if late else 0.0
        count = request.family.refinements(request.criterion)
        if exactly:
            promising = _best_when_they_came(results, count)
        else:
            parameters = len(identification_model(self.case, request.model).names)
            promising = _with_other_families(_promising([*before, *results]), count, request.criterion, parameters)
        refinements = [self._task(s.family, s.record.seed, s.begin) for s in promising]
        early = early and not late  # the end of its time leaves some to refine, or to go on
        if refinements and not early and self.until - time.monotonic() > ending:
            self.listener(Planned(REFINEMENT, len(refinements), True, self.until))
            second, early = self.run(Schedule.of(refinements, self.until), self.listener)
            results = results + second
        return _Round(results, early, self.until - time.monotonic() <= ending)

    def _task(self, family: Family, seed: int, begin: Array | None = None) -> Task:
        request = self.request
        return Task(
            self.case,
            request.model,
            family,
            request.criterion,
            seed,
            request.payload,
            begin,
            self.reference,
            request.solver,
            self.known,
        )

    def _least(self) -> int:
        """Number of starts at least. Where there is a choice the first make it; those that follow may gain nothing."""
        request = self.request
        if request.starts is not None:
            return request.starts
        choices = len(request.family.families(self.case, request.duration))
        return max(choices, 1) + request.family.idle(request.criterion)

    def _explorations(self, number: int, until: float, before: Sequence[Start | Failed]) -> Schedule:
        """The starts of a round. Each of several choices has one first; those that follow go to the best of them.

        None begins with less time left than the longest of those before it took: a part of one finds little.
        """
        request = self.request
        idle = request.family.idle(request.criterion)
        families = request.family.families(self.case, request.duration)[: request.starts]
        parameters, most = len(identification_model(self.case, request.model).names), most_starts(request)
        first, least = max(len(families), min(1 + idle, most)), self._least()
        each = max(first, most)
        seeds = seeds_of(request.seed, (number + 1) * each)[number * each :]
        settings = [family.settings for family in families]

        def task(k: int, results: Sequence[Start | Failed]) -> Task | None:
            known = max(first, k + 1 - AHEAD)
            took = [s.record.seconds for s in _without_failures([*before, *results]) if not s.record.refined]
            if took and time.monotonic() + max(took) > until:
                return None
            if k >= first and (k >= most or len(results) < known):
                return None
            if k < first:
                family = families[k % len(families)]
            else:
                starts = sorted(_without_failures(results[:known]), key=lambda s: -s.promise)
                lost = [-gain(request.criterion, parameters, starts[0].promise, s.promise) for s in starts]
                leading = [s for s, loss in zip(starts, lost, strict=True) if loss <= CLOSE]
                ranked = dict.fromkeys(settings.index(s.family.settings) for s in leading)
                best = [families[n] for n in ranked] or families
                family = best[(k - first) % min(KEPT, len(best))]
            return self._task(family, seeds[k])

        def are_enough(results: Sequence[Start | Failed]) -> bool:
            return len(results) >= least and enough(results, request, parameters)

        return Schedule(task, are_enough, until, self.until)


def seeds_of(seed: int, starts: int) -> list[int]:
    """Seeds of the starts, reproducible from one seed; more starts extend the list."""
    return [int(s.generate_state(1)[0]) for s in np.random.SeedSequence(seed).spawn(starts)]


def make(request: Request, case: Case, listener: Listener, run: Runner, began: float | None = None) -> Plan:
    """Optimises, proves and rates an excitation.

    Args:
        began: see `search`.

    Raises:
        InfeasiblePlan: no motion satisfies the limits.
        IdentificationError: the motion does not excite all parameters of the model.
        CaseError: the case has no machine or no limits.
        HexciteError: a request that no search can meet; see `require_plannable`.
        Interrupted: Ctrl-C before any start was done.
    """
    require_plannable(request, case)
    start = time.perf_counter()
    if (by_hand := request.family.motion(case)) is None:
        result = search(request, case, listener, run, began)
        if isinstance(request.family, Best):
            chosen = request.family.chosen(case, request.duration, result.starts[0].family.name)
            request = replace(request, family=chosen)
    else:
        motion, file = by_hand
        if not motion.duration <= LONGEST:
            raise InfeasiblePlan(
                place=file,
                problem=f"takes {motion.duration:.0f} s, longer than {LONGEST:g} s",
                remedy="take steps out",
                code=Code.INFEASIBLE,
            )
        result = PlannedMotion(motion, SequenceSettings(sequence=file), prove(motion, case))
    seconds = time.perf_counter() - start
    if not result.limits.kept:
        worst = result.limits.violations[0]
        raise InfeasiblePlan(
            problem=phrase("no_motion", "no feasible motion: {limit}", limit=worst.sentence()),
            remedy=remedy(worst, case),
            code=Code.INFEASIBLE,
        )
    try:
        return rated_plan(request, case, result, seconds)
    except IdentificationError as error:
        place = result.settings.source or f"no plan for model {request.model}"
        raise IdentificationError(place=place, problem=error.message, code=Code.NO_EXCITATION) from error


def make_until_ctrl_c(request: Request, case: Case, listener: Listener, began: float | None = None) -> Plan:
    """`make`, in the main thread; after the first Ctrl-C the best motion so far is proven and rated."""
    if not request.family.optimised:
        return make(request, case, listener, run_here)
    with first_ctrl_c() as pressed, workers(pressed, request.workers) as run:
        plan = make(request, case, listener, run, began)
    return replace(plan, interrupted=plan.interrupted or pressed.is_set())
