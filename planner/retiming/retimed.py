"""A planned motion at the pace that controllers or limits allow: criteria and limits before and after.

Point-to-point moves get the jerk-limited law that a controller computes online, in whole cycles (ruckig). Other paths
keep the limits of rates, accelerations and jerks of coordinates and struts at another pace (ipopt, see
`planner.retiming.path`), or all but those of jerks (toppra).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from cases.errors import InfeasiblePlan
from cases.schema import Case
from identification.criteria import CRITERIA, singular_values
from identification.limited import strut_motion
from identification.limits import PROOF_RATE, LimitReport, prove
from identification.model import Model
from identification.motion import Joined, Standstill, Trajectory, sample
from identification.reference import reference_scaling
from identification.trajectories.circle import CircularMove
from identification.trajectories.online_profile import OnlineProfile, UntimedMove, online_move, online_profile
from identification.trajectories.path_timing import UntimedPath, retime
from identification.trajectories.profile import Profile, StraightMove
from planner.bounds.kept import Bound, box_bound
from planner.families.ptp import unit_profile
from planner.retiming.path import retimed_path
from planner.search.inside import MARGIN
from planner.search.problem import mean_information

Array = NDArray[np.float64]


class Method(StrEnum):
    """How a motion is re-timed."""

    RUCKIG = "ruckig"
    IPOPT = "ipopt"
    TOPPRA = "toppra"


@dataclass(frozen=True, slots=True)
class Rating:
    """What a motion is worth and whether it keeps the limits.

    Args:
        duration: [s].
        criteria: A, D, K, N in reference scaling, better the larger they are.
        d_efficiency: against the box bound; may be above 1 for a motion that leaves the box.
        limits: proof at 10 kHz.
    """

    duration: float
    criteria: dict[str, float]
    d_efficiency: float
    limits: LimitReport


@dataclass(frozen=True, slots=True)
class Retimed:
    """A motion before and after.

    Args:
        method: what re-timed it.
        motion: the motion after.
        before: of the motion as it was.
        after: of the motion after.
        remarks: what the method says of it.
        off_path: largest distance from the planned path, of the position [m] and of an angle [rad].
    """

    method: Method
    motion: Trajectory
    before: Rating
    after: Rating
    remarks: tuple[str, ...]
    off_path: tuple[float, float] = (0.0, 0.0)


def fitting_method(motion: Trajectory) -> Method:
    """Ruckig for sequences of moves and pauses, ipopt for everything else."""
    moves = isinstance(motion, Joined) and all(
        isinstance(part, StraightMove | CircularMove | Standstill) for part in motion.parts
    )
    return Method.RUCKIG if moves else Method.IPOPT


def retimed(
    motion: Trajectory,
    case: Case,
    model: Model,
    method: Method,
    fastest: bool,
    told: Callable[[str], None] = lambda _: None,
) -> Retimed:
    """Re-times a motion and rates both.

    Args:
        motion: from rest to rest.
        case: limits and controller.
        model: whose parameters count.
        method: how.
        fastest: for ipopt and toppra: as fast as the limits allow, instead of never faster than planned.
        told: how it is getting on.

    Raises:
        InfeasiblePlan: the motion cannot be re-timed that way; the message says why.
        IdentificationError: it does not excite all parameters of the model.
        CaseError: the case has no machine, limits or controller.
    """
    off_path, after = (0.0, 0.0), motion
    try:
        if method is Method.RUCKIG:
            after, slowed = by_controller(motion, case)
            remarks = _slowed(slowed, len(after.parts))
        elif method is Method.IPOPT:
            after, off_path, solver = retimed_path(motion, case, fastest, told)
            remarks = (solver,)
        else:
            after = retime(motion, case, fastest)
            remarks = (
                "toppra knows no jerk limit: accelerations step, and the jerk there has no bound; the table shows a "
                "slope",
            )
    except (UntimedMove, UntimedPath) as error:
        raise InfeasiblePlan(f"cannot be re-timed with {method}: {error}") from error
    bound = box_bound(case, model)
    before, rated = (_rating(m, case, model, bound) for m in (motion, after))
    return Retimed(method, after, before, rated, remarks, off_path)


def _slowed(count: int, moves: int) -> tuple[str, ...]:
    if not count:
        return ()
    return (f"{count} of {moves} moves are slower than their coordinates allow, because of the limits of the struts",)


def _rating(motion: Trajectory, case: Case, model: Model, bound: Bound) -> Rating:
    information = mean_information(model, reference_scaling(case, model), motion)
    mu = singular_values(information, model.names)
    criteria = {letter: criterion.of(mu) for letter, criterion in CRITERIA.items()}
    return Rating(motion.duration, criteria, bound.efficiency(criteria["D"]), prove(motion, case))


SLOWINGS = 5  # of a move whose struts are too fast
SAME = 1e-4  # of the way, the largest velocity and acceleration: rounding where the limit of jerk is next to none


def by_controller(motion: Trajectory, case: Case) -> tuple[Joined, int]:
    """Every move under the law of a jerk-limited controller with the motion limits of the case, in whole cycles.

    Straight moves become as fast as the limits of their coordinates allow, less the margin of every plan; arcs as fast
    as the peaks of their planned law; either slower where the limits of the struts need it. Pauses are rounded up.
    Also returns how many moves the struts have slowed.

    Raises:
        UntimedMove: the motion is no sequence of moves and pauses.
        CaseError: the case has no machine, limits or controller.
    """
    case.need_machine("re-timing")
    cycle = case.need_controller("re-timing in whole controller cycles").cycle
    if not isinstance(motion, Joined):
        raise UntimedMove("it is one continuous path, no sequence of moves; use --method ipopt")
    parts: list[Trajectory] = []
    slowed = 0
    for part in motion.parts:
        if isinstance(part, Standstill):
            parts.append(Standstill(part.pose, float(np.ceil(part.duration / cycle - 1e-9)) * cycle))
            continue
        if not isinstance(part, StraightMove | CircularMove) or not isinstance(part.profile, Profile):
            raise UntimedMove("it contains a continuous path; use --method ipopt")
        pace, move = 1.0, _timed(part, case, 1.0, cycle)
        for _ in range(SLOWINGS):
            worst = _of_struts(move, case)
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
        box, kept = case.need_machine("re-timing")[2].motion, 1.0 - MARGIN
        rate, acceleration, jerk = box.rate * kept * v, box.acceleration * kept * a, box.jerk * kept * j
        law = online_move(part.start, part.end, rate, acceleration, jerk, cycle).profile
        assert isinstance(law, OnlineProfile)
        return replace(part, profile=_seven_segments(law))
    planned = part.profile
    assert isinstance(planned, Profile)
    law = online_profile(planned.peak_velocity * v, planned.acceleration * a, planned.jerk * j, cycle)
    return replace(part, profile=_seven_segments(law))


def _seven_segments(law: OnlineProfile) -> Profile:
    """The same law by its three times; from rest to rest ruckig's phases are those of seven segments."""
    jerk_time = float(law.lengths[0])
    hold_time = float(law.lengths[1]) if law.jerks[1] == 0.0 else 0.0
    found = unit_profile(jerk_time, hold_time, max(0.0, law.duration - 4 * jerk_time - 2 * hold_time))
    t = np.cumsum(law.lengths) - law.lengths / 2  # the middle of each phase
    pairs = zip(found.at(t)[:3], law.at(t)[:3], strict=True)
    if any(np.abs(ours - its).max() > SAME * np.abs(its).max() for ours, its in pairs):
        raise UntimedMove("ruckig's time law is not one of seven segments: change the limits or the cycle slightly")
    return found


def _of_struts(move: Trajectory, case: Case) -> float:
    """Largest share of the pace that the struts allow."""
    machine, _, limits = case.need_machine("re-timing")
    _, velocity, acceleration = strut_motion(sample(move, PROOF_RATE), machine)
    return max(
        float(np.abs(velocity).max()) / limits.motion.strut_velocity_m_s,
        float(np.sqrt(np.abs(acceleration).max() / limits.motion.strut_acceleration_m_s2)),
    )
