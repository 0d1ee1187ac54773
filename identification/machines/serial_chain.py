"""Kinematics of a serial chain: pose, twist and twist rate of the sensor frame from positions of joints; joint torques.

One recursion from the base to the sensor, all vectors in {B}: a joint at r from the one before it moves with it, and
adds its own rate about or along its axis (Siciliano et al., Robotics, 2009, chapter 7; with Coriolis's term where it
slides).
"""

import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import ClassVar, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from cases.base.units import Array
from cases.chain import Chain
from cases.machine import turned
from cases.schema import Case
from cases.sensors import RigidBody
from identification.limits.limit import LimitKind
from identification.limits.sensor_loads import SHARE
from identification.machines.casadi_batch import over_samples
from identification.machines.clearance import clearance_names, clearance_shares
from identification.machines.machine import FrameMotion, Kinematics, Share

UPRIGHT = 1e-8  # cosine of a pitch below which only rounding separates roll and yaw
ROUNDING = 1e-15  # entries of a rotation below which they are 0, above one minus which they are 1


class _Link(NamedTuple):
    """A moved frame in {B}: origin, R, velocity, acceleration, angular velocity and acceleration, the joint's axis."""

    p: ca.SX
    turn: ca.SX
    v: ca.SX
    a: ca.SX
    omega: ca.SX
    alpha: ca.SX
    axis: ca.SX


class SerialChain:
    """The kinematics of a chain of n joints."""

    of_pose: ClassVar[bool] = False
    elastic: ClassVar[bool] = False  # the error terms are those of a hexapod's platform

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.count = len(chain.joints)
        self.turns = np.array([joint.turns for joint in chain.joints])

    @classmethod
    def of(cls, case: Case) -> "SerialChain":
        """The chain of a case; raises CaseError where its machine is not a chain."""
        if case.chain is None:
            case.missing("machine.chain", "the kinematics")
        return cls(case.chain)

    def frame(self, q: ca.SX, rates: ca.SX, accelerations: ca.SX) -> FrameMotion:
        """Motion of {P} in {B}."""
        *_, last = self._links(q, rates, accelerations)
        return last.p, last.turn, ca.vertcat(last.v, last.omega), ca.vertcat(last.a, last.alpha)

    def frames(self, q: ca.SX) -> list[tuple[ca.SX, ca.SX]]:
        """Origin and R in {B} of the moved frame of each joint, then of {P}."""
        still = ca.SX(self.count, 1)
        return [(frame.p, frame.turn) for frame in self._links(q, still, still)]

    @property
    def named_distances(self) -> list[str]:
        """Names of the clearances."""
        return clearance_names(self.chain)

    def shares(self, case: Case, q: ca.SX, rates: ca.SX, accelerations: ca.SX) -> list[Share]:
        """Clearances, and torques with each number of weights as shares of 80 % of what the drives can do."""
        frames = self.frames(q)
        middle = self.chain.home + case.need_chain("planning")[1].coordinates.mean(axis=0)
        distances = clearance_shares(self.chain, q, middle, frames)
        if not self.chain.limits_effort:
            return distances
        limited = [k for k, joint in enumerate(self.chain.joints) if math.isfinite(joint.effort)]
        most = SHARE * np.array([self.chain.joints[k].effort for k in limited])
        loads = [self.torques(q, rates, accelerations, case.gravity, load) for load in case.bodies or (None,)]
        return [*distances, *((LimitKind.JOINT_TORQUE, 2, torques[limited] / ca.DM(most)) for torques in loads)]

    def positions(self, coordinates: Array) -> Array:
        """Positions of the sensor, shape (k, 3) [m]."""
        return self.kinematics(coordinates, 0.0 * coordinates, 0.0 * coordinates).pose[:, :3]

    def drives(self, coordinates: ArrayLike) -> Array:
        """Encoders measure the joints themselves, which are the coordinates, shape (k, n) [rad or m]."""
        return np.asarray(coordinates, dtype=float)

    coordinates = drives

    def further_drives(
        self, case: Case, q: Array, rates: Array, accelerations: Array
    ) -> tuple[list[Array], tuple[Array, Array]]:
        """None."""
        del case, rates, accelerations
        return [np.zeros((len(q), 0))] * 2, (np.zeros(0), np.zeros(0))

    def torques(
        self, q: ca.SX, rates: ca.SX, accelerations: ca.SX, gravity: Sequence[float] | Array, load: RigidBody | None
    ) -> ca.SX:
        """Torques or forces of the drives to move links and load, without friction, shape (n,) [N m or N].

        `gravity` is the acceleration in {B} [m/s^2], `load` the body behind the sensor, in {P}.
        """
        *links, sensor = self._links(q, rates, accelerations)
        force, moment = ca.SX(3, 1), ca.SX(3, 1)  # of all behind a joint, the moment about the origin of {B}
        torques: list[ca.SX] = []
        if load is not None:
            force, moment = _inertial(sensor, load, gravity)
        for frame, joint in zip(reversed(links), reversed(self.chain.joints), strict=True):
            if joint.link is not None:
                f, m = _inertial(frame, joint.link, gravity)
                force, moment = force + f, moment + m
            torques.insert(0, ca.dot(frame.axis, moment - ca.cross(frame.p, force) if joint.turns else force))
        return ca.vertcat(*torques)

    def _links(
        self, q: ca.SX, rates: ca.SX, accelerations: ca.SX, origins: Sequence[ca.SX] | None = None
    ) -> Iterator[_Link]:
        """The moved frame of each joint, then {P}, which has the last joint's axis.

        `origins`: places of the joints, each in the frame of the one before; by default those of the case.
        """
        p, v, a, omega, alpha = (ca.SX(3, 1) for _ in range(5))
        turn = ca.SX.eye(3)
        for k, joint in enumerate(self.chain.joints):
            r = turn @ (ca.sparsify(ca.DM(joint.origin)) if origins is None else origins[k])
            a, v, p = a + _carried(r, omega, alpha), v + ca.cross(omega, r), p + r
            turn = turn @ ca.sparsify(ca.DM(_turned(joint.rpy)))
            axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
            e = turn @ ca.sparsify(ca.DM(axis))
            drift = ca.cross(omega, e) * rates[k]
            if joint.turns:
                alpha = alpha + e * accelerations[k] + drift
                omega = omega + e * rates[k]
                turn = turn @ _about(axis, q[k])
            else:
                r = e * q[k]
                a = a + _carried(r, omega, alpha) + 2 * drift + e * accelerations[k]
                v, p = v + ca.cross(omega, r) + e * rates[k], p + r
            yield _Link(p, turn, v, a, omega, alpha, e)
        r = turn @ ca.sparsify(ca.DM(self.chain.sensor.origin))
        a, v, p = a + _carried(r, omega, alpha), v + ca.cross(omega, r), p + r
        turn = turn @ ca.sparsify(ca.DM(_turned(self.chain.sensor.rpy)))
        yield _Link(p, turn, v, a, omega, alpha, e)

    @cached_property
    def motion(self) -> ca.Function:
        """(q, q', q'') -> position [m], R column by column, twist [m/s, rad/s], twist rate [m/s^2, rad/s^2], in {B}."""
        q, rates, accelerations = (ca.SX.sym(name, self.count) for name in ("q", "rates", "accelerations"))
        position, turn, twist, twist_rate = self.frame(q, rates, accelerations)
        outputs = [ca.densify(value) for value in (position, ca.vec(turn), twist, twist_rate)]
        return ca.Function("chain_motion", [q, rates, accelerations], outputs, {"cse": True})

    @cached_property
    def by_links(self) -> ca.Function:
        """(q, q', q'') -> how position, velocity and acceleration of {P} in {B} change with places of joints, (9, 3 n).

        These are linear in the places, each in the frame of the joint before, one joint's x, y and z after another.
        """
        q, rates, accelerations = (ca.SX.sym(name, self.count) for name in ("q", "rates", "accelerations"))
        origins = [ca.SX.sym(f"origin_{k}", 3) for k in range(self.count)]
        *_, last = self._links(q, rates, accelerations, origins)
        change = ca.jacobian(ca.vertcat(last.p, last.v, last.a), ca.vertcat(*origins))
        return ca.Function("chain_by_links", [q, rates, accelerations], [ca.densify(change)], {"cse": True})

    def kinematics(
        self, q: ArrayLike, rates: ArrayLike, accelerations: ArrayLike, near: Array | None = None
    ) -> Kinematics:
        """Pose, twist and twist rate of {P} from the motion of the joints, shapes (k, n), one row a sample.

        Where the pitch is a right angle the roll is 0.
        """
        position, columns, twist, twist_rate = over_samples(self.motion, q, rates, accelerations)
        turns = columns.reshape(-1, 3, 3).transpose(0, 2, 1)
        return Kinematics(np.hstack([position.reshape(-1, 3), _angles(turns)]), twist, twist_rate)


def _angles(turns: Array) -> Array:
    """Roll, pitch, yaw of rotation matrices, shape (n, 3, 3) -> (n, 3) [rad]."""
    level = np.hypot(turns[:, 2, 1], turns[:, 2, 2])
    upright = level < UPRIGHT
    roll = np.where(upright, 0.0, np.arctan2(turns[:, 2, 1], turns[:, 2, 2]))
    yaw = np.where(upright, np.arctan2(-turns[:, 0, 1], turns[:, 1, 1]), np.arctan2(turns[:, 1, 0], turns[:, 0, 0]))
    return np.column_stack([roll, np.arctan2(-turns[:, 2, 0], level), yaw])


def _inertial(frame: _Link, body: RigidBody, gravity: Sequence[float] | Array) -> tuple[ca.SX, ca.SX]:
    """Force that moves a body in a frame, and its moment about the origin of {B}."""
    arm = frame.turn @ ca.DM(body.centre_of_gravity)
    force = body.mass_kg * (frame.a + _carried(arm, frame.omega, frame.alpha) - ca.DM(gravity))
    inertia = frame.turn @ ca.DM(body.inertia) @ frame.turn.T
    moment = inertia @ frame.alpha + ca.cross(frame.omega, inertia @ frame.omega)
    return force, moment + ca.cross(frame.p + arm, force)


def _carried(r: ca.SX, omega: ca.SX, alpha: ca.SX) -> ca.SX:
    """Acceleration of the end of r, fixed to a turning body, against that of its beginning."""
    return ca.cross(alpha, r) + ca.cross(omega, ca.cross(omega, r))


def _turned(angles: Array) -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll); right angles give zeros and ones without rounding."""
    turn = turned(angles)
    return np.where(np.abs(turn - np.round(turn)) < ROUNDING, np.round(turn), turn)


def _about(axis: Array, angle: ca.SX) -> ca.SX:
    """Rodrigues' rotation about a unit vector."""
    cross = ca.skew(ca.sparsify(ca.DM(axis)))
    return ca.SX.eye(3) + ca.sin(angle) * cross + (1 - ca.cos(angle)) * (cross @ cross)
