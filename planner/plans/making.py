"""Plans an excitation from start to proof."""

import math
import time
from dataclasses import replace
from itertools import count
from numbers import Real

from cases.base.errors import Code, HexciteError, IdentificationError, InfeasiblePlan, Interrupted, choice
from cases.base.phrases import phrase
from cases.schema import Case
from identification.limits.limit import UNUSED_SHARE, LimitKind, LimitReport
from identification.limits.proof import PROOF_RATE, prove
from identification.model.model import identification_model
from identification.model.parameters import physical_form
from identification.motion.motion import Trajectory
from planner.controller_limits import controlled, with_steps
from planner.families.plan_settings import SequenceSettings
from planner.families.ptp import PointToPointFamily
from planner.families.settings import Best
from planner.plans.plan import Plan
from planner.plans.rating import PlannedMotion, rated_plan
from planner.request import LONGEST, Request
from planner.search.feasibility import keep_limits, remedy, require_identifiable, require_rest
from planner.search.parallel import Listener, Runner, first_ctrl_c, run_here, workers
from planner.search.record import Failed
from planner.search.rounds import Rounds, without_failures
from planner.search.solving import QUICK_RATE, Start, limited_as_searched

ENDING = 3.0  # [s] at the end of a search of some seconds for proof, figures and page, but half of it at most
HARDLY_MOVING = 0.05  # share of their ways to which moves by a controller's law are shrunk: shorter ones are no plan
PEAKS = 4e-3  # share of what struts and sensors bear, for peaks of moves by a controller's law between instants
BORNE = (
    LimitKind.STRUT_ACCELERATION, LimitKind.SENSOR_FORCE, LimitKind.SENSOR_MOMENT, LimitKind.JOINT_FORCE,
    LimitKind.JOINT_TORQUE,
)  # fmt: skip
"""Limits of what accelerations do, which a shorter move does not lower where it accelerates as hard."""
BETWEEN = 1e-5  # share of a limit that may be used between the instants at which a refined motion was checked


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
    rounds = Rounds(
        request, controlled_case.within_margin(), case, listener, run, until, noise
    )  # the proof asks the limits themselves
    results: list[Start | Failed] = []
    ended_early = late = False
    for number in count():
        more, ended_early, late = rounds.one(number, results)
        results += more
        if ended_early or late or request.seconds is None or all(isinstance(result, Failed) for result in more):
            break
    out_of_time = late or (request.seconds is not None and not more)  # none of a last round had time to end
    starts = sorted(without_failures(results), key=lambda s: -s.record.criterion_value)
    failed = tuple(r for r in results if isinstance(r, Failed))
    if not starts:
        if ended_early and not out_of_time:
            raise Interrupted
        raise InfeasiblePlan(problem=failed[0].reason, code=Code.INFEASIBLE)
    reasons = list[InfeasiblePlan]()
    for best in starts:
        try:
            motion, report = _proven(best, rounds.case, case, step_time)
            break
        except InfeasiblePlan as error:
            reasons.append(error)
    else:
        raise reasons[0]
    beyond = starts[: len(reasons)]
    failed += tuple(Failed(s.record.seed, e.message) for s, e in zip(beyond, reasons, strict=True))
    without = LimitKind.JERK if step_time else None
    settings = best.family.found(best.unknowns).model_copy(update={"made_for": made_for, "without": without})
    interrupted = ended_early and not out_of_time
    kept = tuple(starts[len(reasons) :])
    return PlannedMotion(motion, settings, report, kept, failed, interrupted, out_of_time)


def _proven(start: Start, searched: Case, case: Case, step_time: float) -> tuple[Trajectory, LimitReport]:
    """The motion of a start, drawn back where instants that it was not checked at ask for that, and its proof.

    Args:
        searched: the case with the limits that were searched by.
        case: the case with all of its limits.
        step_time: within which accelerations step, 0 where jerks are limited [s].

    Raises:
        InfeasiblePlan: it exceeds a limit even where hardly anything moves, as where a controller that times moves
            itself accelerates as hard in shorter ones.
    """
    family, unknowns = start.family, start.unknowns
    by_law = isinstance(family, PointToPointFamily) and family.own_law
    if by_law:
        family = family.refined(unknowns)  # an exploration may be slower than the law
    whole, share, none = family.motion(unknowns), 1.0, None
    try:
        if (
            not start.record.refined
        ):  # it was checked at few instants: at more of them first, then at those of the proof
            quick = limited_as_searched(searched, family)
            quick = quick.with_reserve(PEAKS) if by_law else quick
            unknowns, share = keep_limits(quick, family, unknowns, QUICK_RATE)
        motion = family.motion(unknowns)
        report = with_steps(prove(motion, case), step_time)
        if report.worst_ratio > 1.0 - UNUSED_SHARE + BETWEEN:
            unknowns, more = keep_limits(searched, family, unknowns, PROOF_RATE)
            motion, share = family.motion(unknowns), share * more
            report = with_steps(prove(motion, case), step_time)
    except InfeasiblePlan as error:
        none = error
    if by_law and (none is not None or share < HARDLY_MOVING):
        worst = max(prove(whole, searched).checks, key=lambda check: check.ratio)
        if worst.kind in BORNE:
            raise InfeasiblePlan(
                problem=phrase(
                    "accelerates_as_hard",
                    "no feasible motion: {limit}, for the controller accelerates as hard as it is set up in every move",
                    limit=worst.sentence(),
                ),
                remedy=phrase(
                    "lower_or_path",
                    "lower the accelerations of limits.motion and of the controller's set-up, search for longer, or "
                    "plan a path (spline, Fourier series)",
                ),
                code=Code.INFEASIBLE,
            )
    if none is not None:
        raise none
    return motion, report


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
