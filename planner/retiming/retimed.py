"""A planned motion at the pace that controllers or limits allow: criteria and limits before and after.

Point-to-point moves get the jerk-limited law that a controller computes online, in whole cycles (ruckig). Other paths
satisfy the limits of rates, accelerations and jerks of coordinates and struts at another pace (ipopt, see
`planner.retiming.path_pace`).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import numpy as np

from cases.errors import HexciteError, InfeasiblePlan
from cases.schema import Case
from cases.units import DEG, MM
from identification.criteria import CRITERIA, Criterion, reference_scaling, singular_values
from identification.limit import LimitReport
from identification.limit_proof import mechanical_pace, prove
from identification.model import Model, identification_model
from identification.motion import Joined, Standstill, Trajectory
from identification.trajectories.moves import (
    CircularMove,
    StraightMove,
    UntimedMotion,
    limits_along,
    ruckig_profile,
)
from planner.bounds.information_limit import Bound, information_limit
from planner.families import Settings
from planner.noise import mean_information
from planner.plans import Plan
from planner.rating import PlannedMotion, rated_plan
from planner.request import LONGEST
from planner.retiming.path_pace import retimed_path
from planner.search.feasibility import MARGIN

METHODS = ("ruckig", "ipopt")


@dataclass(frozen=True, slots=True)
class PaceRating:
    """Criteria of a motion, and the proof of its limits."""

    duration: float  # [s]
    criteria: dict[str, float]  # A, D, K, N in reference scaling; larger is better
    d_efficiency: float  # against the box bound; may be above 1 for a motion that leaves the box
    limits: LimitReport  # proof at 10 kHz


@dataclass(frozen=True, slots=True)
class Retimed:
    """A motion before and after re-timing."""

    method: str  # one of `METHODS`
    motion: Trajectory
    before: PaceRating
    after: PaceRating
    remarks: tuple[str, ...]  # remarks of the method
    off_path: tuple[float, float]  # largest distance from the planned path, of position [m] and of an angle [rad]
    seconds: float  # computing time [s]


def retimed(
    motion: Trajectory,
    case: Case,
    model: Model,
    method: str | None = None,
    fastest: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> Retimed:
    """A motion from rest to rest at another pace, rated beside the planned one, whether it satisfies all limits or not.

    Arguments and errors as of `retime`.
    """
    start, off_path, method = perf_counter(), (0.0, 0.0), method_of(method, motion, fastest)
    after: Trajectory
    try:
        if method == "ruckig":
            after, slowed = by_controller(motion, case)
            sentence = f"{slowed} of {len(after.parts)} moves are slower than their coordinates allow, because of "
            remarks = (f"{sentence}struts, sensors or joints' torques",) if slowed else ()
        else:
            after, off_path, solver = retimed_path(motion, case, fastest, progress)
            remarks = (solver,)
    except UntimedMotion as error:
        raise InfeasiblePlan(f"cannot be re-timed with {method}: {error}") from error
    bound = information_limit(case, model)
    before, rated = (_rating(m, case, model, bound) for m in (motion, after))
    return Retimed(method, after, before, rated, remarks, off_path, perf_counter() - start)


def _rating(motion: Trajectory, case: Case, model: Model, bound: Bound) -> PaceRating:
    information = mean_information(model, reference_scaling(case, model), motion)
    mu = singular_values(information, model.names)
    criteria = {letter: criterion(mu) for letter, criterion in CRITERIA.items()}
    return PaceRating(motion.duration, criteria, bound.efficiency(criteria[Criterion.D]), prove(motion, case))


SLOWINGS = 5  # times at most that a move whose struts are too fast is slowed


def by_controller(motion: Trajectory, case: Case) -> tuple[Joined, int]:
    """Every move under the law of a jerk-limited controller with the motion limits of the case, in whole cycles.

    Straight moves become as fast as the limits of their coordinates allow, less the margin of every plan; arcs as fast
    as the peaks of their planned law; either slower where the limits of the struts need it. Pauses are rounded up.
    Also returns how many moves the struts have slowed.

    Raises:
        UntimedMotion: the motion is not a sequence of moves and pauses.
    """
    case.need_motion("re-timing")
    cycle = case.need_controller("re-timing in whole controller cycles").cycle
    if not isinstance(motion, Joined):
        raise UntimedMotion("it is one continuous path, no sequence of moves; use --method ipopt")
    parts: list[Trajectory] = []
    slowed = 0
    for part in motion.parts:
        if isinstance(part, Standstill):
            parts.append(Standstill(part.pose, float(np.ceil(part.duration / cycle - 1e-9)) * cycle))
            continue
        if not isinstance(part, StraightMove | CircularMove):
            raise UntimedMotion("it contains a continuous path; use --method ipopt")
        pace, move = 1.0, _timed(part, case, 1.0, cycle)
        for _ in range(SLOWINGS):
            worst = mechanical_pace(move, case)
            if worst <= 1.0 - MARGIN / 2:
                break
            pace *= (1.0 - MARGIN) / worst
            move = _timed(part, case, pace, cycle)
        slowed += pace < 1.0
        parts.append(move)
    return Joined(tuple(parts)), slowed


def _timed(part: StraightMove | CircularMove, case: Case, pace: float, cycle: float) -> StraightMove | CircularMove:
    """A move under a controller's own law, with its limits at a share of their pace."""
    v, a, j = pace, pace**2, pace**3
    if isinstance(part, StraightMove):
        box, share = case.need_motion("re-timing")[1], 1.0 - MARGIN
        limits = box.rate * share * v, box.acceleration * share * a, box.jerk * share * j
        velocity, peak, change = limits_along(np.abs(part.end - part.start), *limits)
        return replace(part, profile=ruckig_profile(velocity, peak, change, cycle))
    planned = part.profile
    law = ruckig_profile(planned.peak_velocity * v, planned.acceleration * a, planned.jerk * j, cycle)
    return replace(part, profile=law)


def retime(
    plan: Plan,
    method: str | None = None,
    fastest: bool = False,
    model: int | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Plan:
    """A plan of the same path at another pace.

    Args:
        plan: plan of a motion.
        method: ruckig: moves as a jerk-limited controller times them; ipopt: paths under every limit; by default what
            fits.
        fastest: whether ipopt makes the path as fast as the limits allow, not only as slow as needed.
        model: number in Table 2, by which it is rated; the plan's own unless given.
        progress: shows a line now and then.

    Raises:
        InfeasiblePlan: the motion cannot be re-timed that way; the message says why.
        IdentificationError: the motion does not excite all parameters of the model.
        HexciteError: a plan of poses, an unknown method, or a method that does not fit.
    """
    number = plan.of_motion[0].model
    number = number if model is None else model
    found = retimed(plan.motion, plan.case, identification_model(plan.case, number), method, fastest, progress)
    return retimed_plan(found, plan, number)


def method_of(name: str | None, motion: Trajectory, fastest: bool) -> str:
    """The method of a name; without one ruckig for sequences of moves and pauses, ipopt for everything else.

    Raises:
        HexciteError: unknown, or ruckig with `fastest`.
    """
    if name is not None and name not in METHODS:
        raise HexciteError(f"method {name!r} is unknown; choose {', '.join(METHODS)}")
    parts = motion.parts if isinstance(motion, Joined) else (motion,)
    moves = all(isinstance(part, StraightMove | CircularMove | Standstill) for part in parts)
    method = name or ("ruckig" if moves else "ipopt")
    if fastest and method == "ruckig":
        raise HexciteError("--fastest belongs to --method ipopt; a controller's moves are as fast as its limits allow")
    return method


def retimed_plan(found: Retimed, plan: Plan, model: int) -> Plan:
    """The plan of a motion after re-timing, for an identification model by its number.

    Args:
        plan: the plan that it comes from.

    Raises:
        InfeasiblePlan: the motion exceeds a limit; the message names the limit.
        IdentificationError: the motion does not excite all parameters of the model.
        HexciteError: a plan of poses.
    """
    if violations := found.after.limits.violations:
        raise InfeasiblePlan(f"the re-timed motion is not a plan: {violations[0].sentence()}")
    if not found.motion.duration <= LONGEST:
        raise InfeasiblePlan(f"the motion takes {found.motion.duration:.0f} s, longer than {LONGEST:g} s; shorten it")
    source = plan.folder or Path(plan.name)
    before, off_mm, off_deg = found.before.duration, found.off_path[0] / MM, found.off_path[1] / DEG
    settings: Settings = {
        "retimed_with": found.method,
        "retimed_from": str(source.resolve()),
        "duration_before_s": before,
        "off_path_mm": off_mm,
        "off_path_deg": off_deg,
        **({"stale": list(plan.stale)} if plan.stale else {}),
    }
    off = f", up to {off_mm:.2g} mm and {off_deg:.2g} deg off its path" if off_mm or off_deg else ""
    remark = f"re-timed with {found.method}: {found.motion.duration:.2f} s instead of {before:.2f} s{off}"
    planned = PlannedMotion(found.motion, settings, found.after.limits, remark=remark)
    return rated_plan(replace(plan.of_motion[0], model=model), plan.case, planned, found.seconds)
