"""Plans an excitation from start to proof."""

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np

from cases.errors import IdentificationError, InfeasiblePlan, Interrupted
from cases.schema import Case
from identification.limit import LimitKind
from identification.limit_proof import PROOF_RATE, prove
from identification.model import identification_model
from planner.families.ptp import controlled, with_steps
from planner.plans import Plan
from planner.rating import PlannedMotion, rated_plan
from planner.request import LONGEST, Request
from planner.search import Failed
from planner.search.feasibility import keep_limits, remedy, require_identifiable, require_rest
from planner.search.parallel import (
    Listener,
    Outcome,
    Runner,
    Schedule,
    enough,
    first_ctrl_c,
    most_starts,
    run_here,
    workers,
)
from planner.search.solving import Start, Task

KEPT = 3  # number of the best orders and periods that get more starts
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
    case.body(request.payload)
    request.family.require_plannable(case, request.duration)
    require_rest(case)


def search(request: Request, case: Case, listener: Listener, run: Runner) -> PlannedMotion:
    """Explores starts until further ones gain too little, refines the best ones, proves the winner.

    Raises:
        InfeasiblePlan: every start failed; the message is that of the first.
        Interrupted: Ctrl-C before any start was done.
    """
    listener(request)
    made_for = request.family.made_for(case)
    own, step_time = controlled(case, made_for)
    own = own.within_margin()  # the proof of the winner asks the limits themselves
    results, interrupted = _explored(request, own, case, listener, run)
    explored = _without_failures(results)
    score = max((s.record.criterion_value for s in explored if s.record.refined), default=-np.inf)
    # An exploration overestimates, and never underestimates: one below the best result so far cannot win.
    promising = sorted((s for s in explored if not s.record.refined and s.promise > score), key=lambda s: -s.promise)
    refinements = [
        Task(own, request.model, s.family, request.criterion, s.record.seed, request.payload, s.begin, case)
        for s in promising[: request.family.refinements(request.criterion)]
    ]
    if refinements and not interrupted:
        second, interrupted = run(Schedule.of(refinements), listener)
        results += second
    starts = sorted(_without_failures(results), key=lambda s: -s.record.criterion_value)
    failed = tuple(r for r in results if isinstance(r, Failed))
    if not starts:
        if interrupted:
            raise Interrupted
        raise InfeasiblePlan(failed[0].reason)
    best = starts[0]
    motion = best.family.motion(keep_limits(own, best.family, best.unknowns, PROOF_RATE)[0])
    report = with_steps(prove(motion, case), step_time)
    settings = {**best.family.settings, **best.family.found(best.unknowns)}
    settings |= {} if made_for is None else {"made_for": made_for}
    settings |= {} if not step_time else {"without": LimitKind.JERK}
    return PlannedMotion(motion, settings, report, tuple(starts), failed, interrupted)


def _without_failures(results: Sequence[Start | Failed]) -> list[Start]:
    return [result for result in results if isinstance(result, Start)]


def _explored(request: Request, case: Case, reference: Case, listener: Listener, run: Runner) -> Outcome:
    """Results of all starts, and whether Ctrl-C ended them.

    Each of several orders and periods has one start first; the starts that follow go to the best of them.

    Args:
        case: case with the limits that its controller enforces, within the margin of their ends.
        reference: case of the reference scaling.
    """
    families, idle = request.family.families(case, request.duration), request.family.idle(request.criterion)
    parameters, most = len(identification_model(case, request.model).names), most_starts(request)
    first = max(len(families), min(1 + idle, most))
    seeds, settings = seeds_of(request.seed, max(first, most)), [family.settings for family in families]

    def task(k: int, results: Sequence[Start | Failed]) -> Task | None:
        known = max(first, k + 1 - AHEAD)
        if k >= first and (k >= most or len(results) < known):
            return None
        if k < first:
            family = families[k % len(families)]
        else:
            starts = sorted(_without_failures(results[:known]), key=lambda s: -s.promise)
            ranked = dict.fromkeys(settings.index(s.family.settings) for s in starts)
            best = [families[n] for n in ranked] or families
            family = best[(k - first) % min(KEPT, len(best))]
        return Task(case, request.model, family, request.criterion, seeds[k], request.payload, None, reference)

    def are_enough(results: Sequence[Start | Failed]) -> bool:
        return len(results) >= first and enough(results, request, parameters)

    return run(Schedule(task, are_enough), listener)


def seeds_of(seed: int, starts: int) -> list[int]:
    """Seeds of the starts, reproducible from one seed; more starts extend the list."""
    return [int(s.generate_state(1)[0]) for s in np.random.SeedSequence(seed).spawn(starts)]


def make(request: Request, case: Case, listener: Listener, run: Runner) -> Plan:
    """Optimises, proves and rates an excitation.

    Raises:
        InfeasiblePlan: no motion satisfies the limits.
        IdentificationError: the motion does not excite all parameters of the model.
        CaseError: the case has no machine or no limits.
        HexciteError: a request that no search can meet; see `require_plannable`.
        Interrupted: Ctrl-C before any start was done.
    """
    require_plannable(request, case)
    start = perf_counter()
    if (by_hand := request.family.motion(case)) is None:
        result = search(request, case, listener, run)
    else:
        motion, file = by_hand
        if not motion.duration <= LONGEST:
            raise InfeasiblePlan(file, f"takes {motion.duration:.0f} s, longer than {LONGEST:g} s; take steps out")
        result = PlannedMotion(motion, {"sequence": str(file)}, prove(motion, case))
    seconds = perf_counter() - start
    if not result.limits.kept:
        worst = result.limits.violations[0]
        raise InfeasiblePlan(f"no feasible motion: {worst.sentence()}; {remedy(worst, case)}")
    try:
        return rated_plan(request, case, result, seconds)
    except IdentificationError as error:
        place = str(result.settings.get("sequence", f"no plan for model {request.model}"))
        raise IdentificationError(place, f"{error.typed}") from error


def make_until_ctrl_c(request: Request, case: Case, listener: Listener) -> Plan:
    """`make`, in the main thread; after the first Ctrl-C the best motion so far is proven and rated."""
    if not request.family.optimised:
        return make(request, case, listener, run_here)
    with first_ctrl_c() as pressed, workers(pressed, request.workers) as run:
        plan = make(request, case, listener, run)
    return replace(plan, interrupted=plan.interrupted or pressed.is_set())
