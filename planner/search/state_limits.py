"""Limits that are non-linear in the pose coordinates, as CasADi expressions: struts, joints, boxes, sensor forces.

Each in units of itself.

They are kept where every component lies between -1 and 1. `identification.limits` proves them by other means.
"""

from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from cases.units import DEG, MM
from identification.hexapod import Hexapod
from identification.model import identification_model
from identification.overload import SHARE
from identification.parameters import body_parameters
from identification.pose import rotation
from planner.families.family import box_middle
from planner.search.kernel import Kernel
from planner.search.states import STATE, Peak

Array = NDArray[np.float64]

RIGID_BODY = 6  # the smallest model with mass, first moments and inertia
CANDIDATES = 4000  # states of the box that tell which limits can bind
NEAR = 0.9  # largest share in the box of a limit that is none of the optimiser's business: the proof sees to it
BINDS = 1.05  # from which a limit is constrained from the start; others are where they come close
SEED = 7
FORCES = "sensor force"


class LimitGroup(NamedTuple):
    """Limits of one kind.

    Args:
        name: of the kind.
        peak: where they are used most.
        kernel: state -> shares of the limits.
        most: largest share in the motion box; infinity where that was not asked for.
    """

    name: str
    peak: Peak
    kernel: Kernel
    most: float = np.inf


def state_limits(case: Case, loads: tuple[int, ...] = ()) -> tuple[LimitGroup, ...]:
    """The non-linear limits of a case.

    Args:
        case: machine, limits and sensors.
        loads: numbers of payloads with which predicted sensor forces are limited, in this order.

    Boxes that are kept out of enter with the platform's origin, its joints and points of struts and tools, with a
    clearance for what is between these; what it does not hold back is left to the proof and to drawing back.

    Joint angles enter by their cosine, which is smooth at zero: (1 - cos angle) / (1 - cos limit).
    """
    _, workspace, limits = case.need_machine("planning")
    box, hexapod = limits.motion, Hexapod.of(case)
    state = ca.SX.sym("state", STATE)
    pose, rates, accelerations = state[:6], state[6:12], state[12:18]
    length, velocity, acceleration = hexapod.strut_motion.call([pose, rates, accelerations], True, False)
    shortest = max(box.strut_length[0], workspace.strut_length[0])
    longest = min(box.strut_length[1], workspace.strut_length[1])
    at_base, at_platform = hexapod.joint_cosines.call([pose], True, False)
    jacobian = hexapod.inverse_jacobian.call([pose], True, False)[1]
    at_home = float(np.linalg.det(hexapod.inverse_jacobian(hexapod.home)[1].full()))
    joints = ca.vertcat(
        (1 - at_base) / (1 - np.cos(workspace.base_joint_angle_deg * DEG)),
        (1 - at_platform) / (1 - np.cos(workspace.platform_joint_angle_deg * DEG)),
    )
    groups = [
        ("strut length", Peak.POSE, (length - (longest + shortest) / 2) / ((longest - shortest) / 2)),
        ("strut velocity", Peak.VELOCITY, velocity / box.strut_velocity_m_s),
        ("strut acceleration", Peak.ACCELERATION, acceleration / box.strut_acceleration_m_s2),
        ("joint angle", Peak.POSE, joints),
        ("singularity", Peak.POSE, 1 - ca.det(jacobian) / at_home),
        *(("keep-out box", Peak.POSE, share) for share in _keep_out(case, hexapod, pose)),
        *((FORCES, Peak.ACCELERATION, f) for f in _sensor_forces(case, loads, pose, rates, accelerations)),
    ]
    return tuple(LimitGroup(name, peak, Kernel(state, share)) for name, peak, share in groups)


def near_limits(case: Case) -> tuple[LimitGroup, ...]:
    """The non-linear limits that come close somewhere in the motion box, judged by seeded states of it.

    Poses are uniform, and half of them at corners; rates and accelerations are at corners. Of several payloads those
    count with which the sensors carry most in at least one of the states.
    """
    states = _extreme_states(case)
    loads: tuple[int, ...] = ()
    if case.sensors.range_N is not None and case.bodies:
        every = tuple(range(len(case.bodies)))
        shares = [g.kernel.values(states) for g in state_limits(case, every) if g.name == FORCES]
        largest = np.array([np.abs(share).max(axis=1) for share in shares])
        loads = tuple(int(n) for n in np.unique(largest.argmax(axis=0)[largest.max(axis=0) > NEAR]))
    groups = (g._replace(most=float(np.abs(g.kernel.values(states)).max())) for g in state_limits(case, loads))
    return tuple(g for g in groups if g.most > NEAR)


def pose_shares(case: Case, poses: Array) -> dict[str, Array]:
    """Shares of the limits of poses that a standstill uses, by kind, shapes (n, limits of the kind).

    Args:
        case: with machine and limits.
        poses: shape (n, 6) [m, rad].
    """
    states = np.hstack([poses, np.zeros((len(poses), STATE - 6))])
    return {g.name: np.abs(g.kernel.values(states)) for g in state_limits(case) if g.peak is Peak.POSE}


def _extreme_states(case: Case) -> Array:
    machine, _, limits = case.need_machine("planning")
    box = limits.motion
    draw = np.random.default_rng(SEED)
    pose = draw.uniform(box.pose[0], box.pose[1], (CANDIDATES, 6))
    corners = draw.random((CANDIDATES // 2, 6)) < 0.5
    pose[::2] = np.where(corners, box.pose[0], box.pose[1])
    signs = draw.choice((-1.0, 1.0), (2, CANDIDATES, 6))
    table = np.zeros((CANDIDATES, STATE))
    table[:, :18] = np.hstack([machine.home.vector + pose, signs[0] * box.rate, signs[1] * box.acceleration])
    return table


ALONG_STRUTS = (0.25, 0.5, 0.75)  # shares of a strut's length from the base
ALONG_TOOLS = (0.0, 0.5, 1.0)  # of a tool's
ROUNDING = 0.003  # [m] by about which corners of boxes are rounded
CLEARANCE = 0.02  # [m] from boxes, for what comes near them between two points or instants; less where home is nearer
VICINITY = 0.25  # [m] in which the share falls by a factor of e: comparable with the ways of motions


def _keep_out(case: Case, hexapod: Hexapod, pose: ca.SX) -> list[ca.SX]:
    """Shares: 1 where the clearance of a box begins, 0 far away."""
    _, workspace, _ = case.need_machine("planning")
    if not workspace.keep_out:
        return []
    turn = rotation(pose[3:])
    arms = turn @ ca.DM(hexapod.platform.T)
    joints = [pose[:3] + arms[:, k] for k in range(6)]
    base = ca.DM(hexapod.base.T)
    along = [base[:, k] + share * (joint - base[:, k]) for k, joint in enumerate(joints) for share in ALONG_STRUTS]
    around = workspace.strut_radius_mm * MM
    points = [(pose[:3], 0.0), *((joint, 0.0) for joint in joints), *((point, around) for point in along)]
    for tool in workspace.tool:
        low, high = tool.axis
        places = (pose[:3] + turn @ ca.DM(low + share * (high - low)) for share in ALONG_TOOLS)
        points += [(place, tool.radius_mm * MM) for place in places]
    distances = ca.vertcat(
        *(_distance(point, box.corners) - radius for box in workspace.keep_out for point, radius in points)
    )
    at_rest = ca.Function("distances", [pose], [distances])(box_middle(case)[0]).full()
    return [ca.exp((np.clip(at_rest / 2, 0.0, CLEARANCE) - distances) / VICINITY)]


def _distance(point: ca.SX, corners: Array) -> ca.SX:
    """Distance along the axis that separates point and box most, at edges a little less, so that it is smooth [m]."""
    apart = ca.fabs(point - ca.DM(corners.mean(axis=0))) - ca.DM(np.ptp(corners, axis=0) / 2)
    most = ca.mmax(apart)
    return most + ROUNDING * ca.log(ca.sum1(ca.exp((apart - most) / ROUNDING)) / 3)


def _sensor_forces(case: Case, loads: tuple[int, ...], pose: ca.SX, rates: ca.SX, accelerations: ca.SX) -> list[ca.SX]:
    """Shares of 80 % of the sensors' range: (18) with the columns of a rigid body alone, offsets and errors apart."""
    if not loads:
        return []
    if case.sensors.range_N is None:
        case.missing("sensors.range_N", "a limit of predicted sensor forces")
    model = identification_model(case, RIGID_BODY)
    regressor = model.coordinate_regressor.call([pose, rates, accelerations], True, False)[0]
    shares = []
    for count in loads:
        body = body_parameters(case.body(count))
        u = ca.DM([body.get(name, 0.0) for name in model.names])
        shares.append(regressor @ u / (SHARE * case.sensors.range_N))
    return shares
