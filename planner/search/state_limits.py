"""Limits that are non-linear in the coordinates, as CasADi expressions: those of the machine, and sensor forces.

Each is in units of itself and satisfied where every component lies between -1 and 1. `identification.limit_proof`
proves them by other means.
"""

from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.limit import LimitKind
from identification.machines import machine_of
from identification.model import identification_model
from identification.overload import SHARE
from identification.parameters import nominal_parameters
from planner.families.family import box_middle
from planner.search.states import Kernel, Peak, state_size

Array = NDArray[np.float64]

RIGID_BODY = 6  # the smallest model with mass, first moments and inertia
CANDIDATES = 4000  # states of the box that tell which limits can bind
NEAR = 0.9  # largest share in the box of a limit that is none of the optimiser's business: the proof sees to it
BINDS = 1.05  # from which a limit is constrained from the start; others are where they come close
SEED = 7


class LimitGroup(NamedTuple):
    """Limits of one kind."""

    kind: LimitKind
    peak: Peak  # where they are used most
    kernel: Kernel  # state -> shares of the limits
    most: float = np.inf  # largest share in the motion box; infinity where that was not asked for


def state_limits(case: Case, loads: tuple[int, ...] = ()) -> tuple[LimitGroup, ...]:
    """The non-linear limits of a case.

    Args:
        case: machine, limits and sensors.
        loads: numbers of payloads with which predicted sensor forces are limited, in this order.
    """
    n = len(box_middle(case)[0])
    state = ca.SX.sym("state", state_size(n))
    motion = state[:n], state[n : 2 * n], state[2 * n : 3 * n]
    groups = [
        *((kind, Peak.of_order(order), value) for kind, order, value in machine_of(case).shares(case, *motion)),
        *((LimitKind.SENSOR_FORCE, Peak.ACCELERATION, f) for f in _sensor_forces(case, loads, *motion)),
    ]
    return tuple(LimitGroup(kind, peak, Kernel(state, share)) for kind, peak, share in groups)


def near_limits(case: Case) -> tuple[LimitGroup, ...]:
    """The non-linear limits that come close somewhere in the motion box, judged by seeded states of it.

    Poses are uniform, and half of them at corners; rates and accelerations are at corners. Of several payloads those
    count with which the sensors carry most in at least one of the states.
    """
    states = _extreme_states(case)
    loads: tuple[int, ...] = ()
    if case.sensors.range is not None and case.bodies:
        every = tuple(range(len(case.bodies)))
        shares = [g.kernel.values(states) for g in state_limits(case, every) if g.kind is LimitKind.SENSOR_FORCE]
        largest = np.array([np.abs(share).max(axis=1) for share in shares])
        loads = tuple(int(n) for n in np.unique(largest.argmax(axis=0)[largest.max(axis=0) > NEAR]))
    groups = (g._replace(most=float(np.abs(g.kernel.values(states)).max())) for g in state_limits(case, loads))
    return tuple(g for g in groups if g.most > NEAR)


def pose_shares(case: Case, poses: Array) -> dict[str, Array]:
    """Shares of the limits of poses that a standstill uses, by kind, shapes (n, limits of the kind).

    Args:
        poses: coordinates, shape (n, k) [m or rad].
    """
    states = np.hstack([poses, np.zeros((len(poses), state_size(poses.shape[1]) - poses.shape[1]))])
    return {g.kind: np.abs(g.kernel.values(states)) for g in state_limits(case) if g.peak is Peak.POSE}


def standing_limits(case: Case) -> ca.Function:
    """Coordinates -> shares of the limits that a standstill uses, torques and sensor forces with each load among them.

    Raises:
        CaseError: the case has no machine or no limits.
    """
    count = len(box_middle(case)[0])
    pose, still = ca.SX.sym("pose", count), ca.SX.zeros(count)
    loads = tuple(range(len(case.bodies))) if case.sensors.range is not None else ()
    of_machine = [share.value for share in machine_of(case).shares(case, pose, still, still)]
    shares = ca.vertcat(ca.SX(0, 1), *of_machine, *_sensor_forces(case, loads, pose, still, still))
    return ca.Function("standing_limits", [pose], [ca.densify(shares)], {"cse": True})


def _extreme_states(case: Case) -> Array:
    home, box = case.need_motion("planning")
    n = len(home)
    draw = np.random.default_rng(SEED)
    pose = draw.uniform(box.pose[0], box.pose[1], (CANDIDATES, n))
    corners = draw.random((CANDIDATES // 2, n)) < 0.5
    pose[::2] = np.where(corners, box.pose[0], box.pose[1])
    signs = draw.choice((-1.0, 1.0), (2, CANDIDATES, n))
    return np.hstack(
        [home + pose, signs[0] * box.rate, signs[1] * box.acceleration, np.zeros((CANDIDATES, state_size(n) - 3 * n))]
    )


def _sensor_forces(case: Case, loads: tuple[int, ...], pose: ca.SX, rates: ca.SX, accelerations: ca.SX) -> list[ca.SX]:
    """Shares of 80 % of the sensors' range: (18) with the columns of a rigid body alone, offsets and errors apart."""
    if not loads:
        return []
    if (most := case.sensors.range) is None:
        case.missing("sensors.range_N", "a limit of predicted sensor forces")
    model = identification_model(case, RIGID_BODY)
    regressor = model.coordinate_regressor.call([pose, rates, accelerations], True, False)[0]
    shares = []
    for count in loads:
        u = ca.DM(nominal_parameters(model, case.body(count)))
        shares.append(regressor @ u / ca.DM(SHARE * most))
    return shares
