"""A planned motion at the pace that controllers or limits allow: criteria and limits before and after.

Point-to-point moves get the jerk-limited law that a controller computes online, in whole cycles (ruckig). Other paths
keep the limits of rates, accelerations and jerks of coordinates and struts at another pace (ipopt, see
`planner.retiming.path`), or all but those of jerks (toppra).
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from cases.errors import InfeasiblePlan
from cases.schema import Case
from identification.criteria import CRITERIA, reference_scaling, singular_values
from identification.limits import LimitReport, prove
from identification.model import Model
from identification.motion import Joined, Standstill, Trajectory
from identification.trajectories.circle import CircularMove
from identification.trajectories.online_profile import UntimedMove
from identification.trajectories.path_timing import UntimedPath, retime
from identification.trajectories.profile import StraightMove
from planner.bounds.kept import Bound, box_bound
from planner.retiming.moves import by_controller
from planner.retiming.path import retimed_path
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
