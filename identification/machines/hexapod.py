"""Kinematics of a hexapod: struts from pose, pose from struts, and their first and second time derivatives (7)-(9).

Strut k joins base joint b_k (in {B}) to platform joint p_k (in {P}): s_k = o + R p_k - b_k, l_k = |s_k|. Written once
as CasADi functions; NumPy arrays go through them sample by sample.
"""

from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import ClassVar

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from cases.base.errors import Code, IdentificationError
from cases.base.units import DEG, MM, Array, Flags, Indices
from cases.schema import Case
from identification.limits.limit import LimitKind
from identification.machines.casadi_batch import over_samples
from identification.machines.clearance import ROUNDING, distance_from_box
from identification.machines.machine import VICINITY, FrameMotion, Kinematics, Share
from identification.machines.rotations import pose_rates, rotation, rpy, twist, twist_rate

# Forward kinematics stops when the struts agree to a thousandth of a nanometre: far below any encoder, far above
# rounding (1e-16 relative to 1 m).
STRUT_TOLERANCE = 1e-12  # [m]
MOST_STEPS = 25
EVERY, FEW = 16, 1000  # of so many samples, or more, each 16th is solved first


class StrutsDoNotClose(IdentificationError):
    """No pose has the strut lengths, shape (6,) [m], of a sample, counted from 0, or of a place in a file."""

    def __init__(self, sample: int, lengths: Array, place: str | None = None) -> None:
        self.sample, self.lengths = sample, lengths
        words = ", ".join(f"{v * 1e3:.3f}" for v in lengths)
        problem = f"no pose has the strut lengths {words} mm"
        super().__init__(
            place=place or f"sample {sample + 1}",
            problem=problem,
            remedy="check unit, sign, order and offset of the struts",
            code=Code.MISFIT,
        )
        self.doubtful = True


class Hexapod:
    """A hexapod with joints of the base in {B} and of the platform in {P}, shapes (6, 3) [m], and home [m, rad]."""

    count: ClassVar[int] = 6
    of_pose: ClassVar[bool] = True
    elastic: ClassVar[bool] = True  # a platform's deformation makes forces

    def __init__(self, base: ArrayLike, platform: ArrayLike, home: ArrayLike) -> None:
        self.base = np.asarray(base, dtype=float)
        self.platform = np.asarray(platform, dtype=float)
        self.home = np.asarray(home, dtype=float)
        self.turns = np.zeros(6, dtype=bool)  # struts slide

    @staticmethod
    def of(case: Case) -> "Hexapod":
        """The hexapod of a case; raises CaseError where the case has no machine. Joints and home are enough."""
        machine = case.hexapod
        if machine is None or case.setup == "1a":
            machine = case.need_machine("the kinematics")[0]
        joints, home = np.stack([machine.base.points, machine.platform.points]), machine.home.vector
        return _of_joints(joints.tobytes(), home.tobytes())

    def frame(self, pose: ca.SX, rates: ca.SX, accelerations: ca.SX) -> FrameMotion:
        """Motion of {P} in {B} from the pose and its derivatives, (37) and (38)."""
        return pose[:3], rotation(pose[3:]), twist(pose, rates), twist_rate(pose, rates, accelerations)

    @property
    def named_distances(self) -> list[str]:
        """None."""
        return []

    def shares(self, case: Case, pose: ca.SX, rates: ca.SX, accelerations: ca.SX) -> list[Share]:
        """Limits of struts, joints, singularities and boxes."""
        return hexapod_shares(self, case, pose, rates, accelerations)

    def positions(self, coordinates: Array) -> Array:
        """Positions of the origin of {P} at poses, shape (n, 3) [m]."""
        return coordinates[:, :3]

    def _struts(self, pose: ca.SX) -> tuple[ca.SX, ca.SX]:
        return _struts(pose, ca.DM(self.base.T), ca.DM(self.platform.T))

    def _inverse_jacobian(self, pose: ca.SX) -> tuple[ca.SX, ca.SX]:
        return _inverse_jacobian(*self._struts(pose))

    @cached_property
    def inverse(self) -> ca.Function:
        """Pose -> strut lengths."""
        pose = ca.SX.sym("pose", 6)
        return ca.Function("inverse", [pose], [self._inverse_jacobian(pose)[0]])

    @cached_property
    def inverse_jacobian(self) -> ca.Function:
        """Pose -> strut lengths, J_Hex^-1."""
        pose = ca.SX.sym("pose", 6)
        return ca.Function("inverse_jacobian", [pose], list(self._inverse_jacobian(pose)))

    @cached_property
    def joint_cosines(self) -> ca.Function:
        """Pose -> cosines of the angles between struts and the normals of base and of platform, shapes (6,)."""
        pose = ca.SX.sym("pose", 6)
        struts, _ = self._struts(pose)
        normal = rotation(pose[3:])[:, 2]
        directions = [struts[:, k] / ca.norm_2(struts[:, k]) for k in range(6)]
        at_base = ca.vertcat(*(d[2] for d in directions))
        at_platform = ca.vertcat(*(ca.dot(d, normal) for d in directions))
        return ca.Function("joint_cosines", [pose], [at_base, at_platform])

    @cached_property
    def strut_motion(self) -> ca.Function:
        """(pose, rates, accelerations) -> strut lengths, velocities, accelerations."""
        pose, rates, accelerations = (ca.SX.sym(n, 6) for n in ("pose", "rates", "accelerations"))
        lengths, jacobian = self._inverse_jacobian(pose)
        velocity = jacobian @ twist(pose, rates)
        acceleration = ca.jtimes(velocity, pose, rates) + ca.jtimes(velocity, rates, accelerations)
        return ca.Function("strut_motion", [pose, rates, accelerations], [lengths, velocity, acceleration])

    @cached_property
    def jacobian_drift(self) -> ca.Function:
        """(pose, twist) -> d/dt(J_Hex^-1) twist, the part of l'' that is there without acceleration."""
        pose, motion = ca.SX.sym("pose", 6), ca.SX.sym("twist", 6)
        drift = _drift(pose, motion, self._inverse_jacobian(pose)[1])
        return ca.Function("jacobian_drift", [pose, motion], [drift], {"cse": True})

    @property
    def newton_step(self) -> ca.Function:
        """(pose, step in position and rotation vector) -> pose; turns about the axes of {B}."""
        return _newton_step()

    def strut_lengths(self, poses: ArrayLike) -> Array:
        """Inverse kinematics: strut lengths at poses, shapes (n, 6) [m]."""
        return over_samples(self.inverse, poses)[0]

    def poses(self, lengths: ArrayLike) -> Array:
        """Forward kinematics (7), the assembly that is reached from home: poses of struts, shapes (n, 6) [m, rad].

        Raises StrutsDoNotClose with the first sample whose struts cannot close.
        """
        poses, _, closed = self._solved(np.asarray(lengths, dtype=float))
        _require_closed(closed, lengths)
        return poses

    drives, coordinates = strut_lengths, poses

    def further_drives(
        self, case: Case, pose: Array, rates: Array, accelerations: Array
    ) -> tuple[list[Array], tuple[Array, Array]]:
        """The struts."""
        limits = case.need_machine("the motion of struts")[2]
        most = np.full(6, limits.strut_velocity_m_s), np.full(6, limits.strut_acceleration_m_s2)
        return over_samples(self.strut_motion, pose, rates, accelerations)[1:], most

    def _solved(self, lengths: Array, near: Array | None = None) -> tuple[Array, Array, Flags]:
        """As `_newton` from `near` or home; of many samples those between two that are solved begin between them."""
        home, rows = np.tile(self.home, (len(lengths), 1)), np.arange(len(lengths))
        if near is None and len(lengths) < FEW:
            return self._newton(lengths, home)
        if near is None:
            coarse, _, closed = self._newton(lengths[::EVERY], home[::EVERY])
            coarse[~closed] = self.home
            near = np.column_stack([np.interp(rows, rows[::EVERY], values) for values in coarse.T])
        pose, jacobians, closed = self._newton(lengths, near)
        again = ~closed
        pose[again], jacobians[again], closed[again] = self._newton(lengths[again], home[again])
        return pose, jacobians, closed

    def _newton(self, lengths: Array, start: Array) -> tuple[Array, Array, Flags]:
        return _newton(lengths, start, lambda _, pose: over_samples(self.inverse_jacobian, pose))

    def kinematics(
        self, lengths: ArrayLike, velocities: ArrayLike, accelerations: ArrayLike, near: Array | None = None
    ) -> Kinematics:
        """Pose, twist and twist rate from strut motion, shapes (n, 6) [m, m/s, m/s^2]: (7), (8), (9).

        (9) is used in the equivalent form v' = J_Hex (q'' - d/dt(J_Hex^-1) v), since J_Hex is known by its inverse.
        Raises StrutsDoNotClose.
        """
        first, second = np.asarray(velocities), np.asarray(accelerations)
        motion, closed = self.kinematics_where_closed(np.asarray(lengths), first, second, near)
        _require_closed(closed, lengths)
        return motion

    def kinematics_where_closed(
        self, lengths: Array, velocities: Array, accelerations: Array, near: Array | None = None
    ) -> tuple[Kinematics, Flags]:
        """Kinematics of samples whose struts need not close, in any order; and which close.

        They mean nothing where struts do not close.
        """
        pose, jacobian, closed = self._solved(lengths, near)
        pose[~closed], jacobian[~closed] = self.home, np.eye(6)
        moving = np.asarray(np.linalg.solve(jacobian, velocities[:, :, None])[:, :, 0], dtype=np.float64)
        drift = over_samples(self.jacobian_drift, pose, moving)[0]
        rate = np.linalg.solve(jacobian, (accelerations - drift)[:, :, None])[:, :, 0]
        return Kinematics(pose, moving, np.asarray(rate, dtype=np.float64)), closed


def kinematics_of_hexapods(
    joints: Array, home: Array, lengths: Array, velocities: Array, accelerations: Array, steps: int = MOST_STEPS
) -> tuple[Kinematics, Flags]:
    """Kinematics of samples each of which has a hexapod of its own; and which of them close, shape (n,).

    They mean nothing where struts do not close.

    Args:
        joints: joints of the base in {B}, then those of the platform in {P}, shape (n, 36) [m].
        home: home of each, from where poses are looked for, shape (n, 6) [m, rad].
        lengths: strut lengths, shape (n, 6) [m].
        velocities: their first derivatives [m/s].
        accelerations: their second derivatives [m/s^2].
        steps: number of Newton's steps after which struts count as not closing.
    """
    inverse_jacobian, jacobian_drift = _of_any_joints()
    pose, jacobian, closed = _newton(
        lengths, home, lambda rows, pose: over_samples(inverse_jacobian, joints[rows], pose), steps
    )
    pose[~closed], jacobian[~closed] = home[~closed], np.eye(6)
    moving = np.asarray(np.linalg.solve(jacobian, velocities[:, :, None])[:, :, 0], dtype=np.float64)
    drift = over_samples(jacobian_drift, joints, pose, moving)[0]
    rate = np.linalg.solve(jacobian, (accelerations - drift)[:, :, None])[:, :, 0]
    return Kinematics(pose, moving, np.asarray(rate, dtype=np.float64)), closed


def _struts(pose: ca.SX, base: ca.SX, platform: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Strut vectors, shape (3, 6), and arms R p_k from the origin of {P} to the platform joints, shape (3, 6)."""
    arms = rotation(pose[3:]) @ platform
    return ca.repmat(pose[:3], 1, 6) + arms - base, arms


def _inverse_jacobian(struts: ca.SX, arms: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Strut lengths and J_Hex^-1 of (8): l' = J_Hex^-1 twist."""
    lengths = [ca.norm_2(struts[:, k]) for k in range(6)]
    rows = []
    for k in range(6):
        direction = struts[:, k] / lengths[k]
        rows.append(ca.horzcat(direction.T, ca.cross(arms[:, k], direction).T))
    return ca.vertcat(*lengths), ca.vertcat(*rows)


def _drift(pose: ca.SX, motion: ca.SX, inverse_jacobian: ca.SX) -> ca.SX:
    """d/dt(J_Hex^-1) twist, shape (6,)."""
    return ca.jtimes(inverse_jacobian @ motion, pose, pose_rates(pose, motion))


@lru_cache(maxsize=1)
def _newton_step() -> ca.Function:
    """(pose, step in position and rotation vector) -> pose; turns about the axes of {B}."""
    pose, step = ca.SX.sym("pose", 6), ca.SX.sym("step", 6)
    half = step[3:] / 2  # Cayley: a proper rotation for every step, equal to it to second order
    turn = ca.solve(ca.SX.eye(3) - ca.skew(half), (ca.SX.eye(3) + ca.skew(half)) @ rotation(pose[3:]))
    return ca.Function("newton_step", [pose, step], [ca.vertcat(pose[:3] + step[:3], rpy(turn))])


@lru_cache(maxsize=1)
def _of_any_joints() -> tuple[ca.Function, ca.Function]:
    """(joints, pose) -> strut lengths, J_Hex^-1; (joints, pose, twist) -> d/dt(J_Hex^-1) twist."""
    joints, pose, motion = ca.SX.sym("joints", 36), ca.SX.sym("pose", 6), ca.SX.sym("twist", 6)
    base, platform = ca.horzsplit(ca.reshape(joints, 3, 12), 6)
    lengths, jacobian = _inverse_jacobian(*_struts(pose, base, platform))
    of_pose = ca.Function("inverse_jacobian_of_joints", [joints, pose], [lengths, jacobian], {"cse": True})
    drift = _drift(pose, motion, jacobian)
    return of_pose, ca.Function("jacobian_drift_of_joints", [joints, pose, motion], [drift], {"cse": True})


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # samples that diverge are given up
def _newton(
    lengths: Array, start: Array, inverse_jacobian: Callable[[Indices, Array], list[Array]], steps: int = MOST_STEPS
) -> tuple[Array, Array, Flags]:
    """Poses by Newton's method from a start, J_Hex^-1 there, and for which samples the struts close.

    `inverse_jacobian` gives strut lengths and J_Hex^-1 of some samples, by their numbers, at poses.
    """
    count = len(lengths)
    pose, jacobians, closed = start.copy(), np.empty((count, 6, 6)), np.zeros(count, dtype=bool)
    active = np.arange(count)
    for _ in range(steps):
        estimate, jacobian = inverse_jacobian(active, pose[active])
        error = lengths[active] - estimate
        converged = np.abs(error).max(axis=1) <= STRUT_TOLERANCE
        closed[active[converged]] = True
        jacobians[active[converged]] = jacobian[converged]
        # Only a sample that diverges, or that comes into a singularity, is given up, not the others.
        alive = ~converged & np.isfinite(error).all(axis=1)
        active, error, jacobian = active[alive], error[alive], jacobian[alive]
        if not len(active):
            break
        try:
            step = np.linalg.solve(jacobian, error[:, :, None])[:, :, 0]
        except np.linalg.LinAlgError:  # one of them is singular
            regular = np.abs(np.linalg.det(jacobian)) > np.finfo(float).tiny
            active = active[regular]
            step = np.linalg.solve(jacobian[regular], error[regular][:, :, None])[:, :, 0]
        pose[active] = over_samples(_newton_step(), pose[active], step)[0]
    return pose, jacobians, closed


def _require_closed(closed: Flags, lengths: ArrayLike) -> None:
    if not closed.all():
        first = int(np.argmin(closed))
        raise StrutsDoNotClose(first, np.asarray(lengths)[first])


@lru_cache(maxsize=32)
def _of_joints(joints: bytes, home: bytes) -> Hexapod:
    """The hexapod with these joints, made once, so that its CasADi functions are built once."""
    base, platform = np.frombuffer(joints).reshape(2, 6, 3)
    return Hexapod(base, platform, np.frombuffer(home))


ALONG_STRUTS = (0.25, 0.5, 0.75)  # shares of a strut's length from the base


ALONG_TOOLS = (0.0, 0.5, 1.0)  # shares of a tool's length


CLEARANCE = 0.02  # [m] from boxes, for what comes near them between two points or instants; less where home is nearer


def hexapod_shares(hexapod: Hexapod, case: Case, pose: ca.SX, rates: ca.SX, accelerations: ca.SX) -> list[Share]:
    """Shares of the limits that a pose and its first and second derivative use, shapes (6,) [m, rad]."""
    _, workspace, box = case.need_machine("planning")
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
    return [
        (LimitKind.STRUT_LENGTH, 0, (length - (longest + shortest) / 2) / ((longest - shortest) / 2)),
        (LimitKind.STRUT_VELOCITY, 1, velocity / box.strut_velocity_m_s),
        (LimitKind.STRUT_ACCELERATION, 2, acceleration / box.strut_acceleration_m_s2),
        (LimitKind.JOINT_ANGLE, 0, joints),
        (LimitKind.SINGULARITY, 0, 1 - ca.det(jacobian) / at_home),
        *((LimitKind.DISTANCE_FROM_BOX, 0, share) for share in _keep_out(case, hexapod, pose)),
    ]


def _keep_out(case: Case, hexapod: Hexapod, pose: ca.SX) -> list[ca.SX]:
    """Shares: 1 where the clearance of a box begins, 0 far away."""
    _, workspace, limits = case.need_machine("planning")
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
        *(
            distance_from_box(point, box.corners, ROUNDING) - radius
            for box in workspace.keep_out
            for point, radius in points
        )
    )
    at_rest = ca.Function("distances", [pose], [distances])(hexapod.home + limits.coordinates.mean(axis=0)).full()
    return [ca.exp((np.clip(at_rest / 2, 0.0, CLEARANCE) - distances) / VICINITY)]
