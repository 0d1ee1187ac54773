"""Forces at the sensors that a motion with a rigid body on the platform will cause: Newton and Euler in {B}.

Written for the proof of limits, from the definitions, without the regressor that the planner uses. Where sensors sit in
struts, a strut is a tube that turns about its base joint and a rod that slides in it, both slender; n points along it,
l is its length. The balance of moments about the base joint gives the force across the strut at the platform, the
balance of the platform the forces along the struts, and that of the rod what a sensor between it and the drive reads.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from cases.sensors import Payloads, RigidBody, SensorFrame
from cases.units import payload_words
from identification.limit import LimitKind
from identification.limited_quantities import Quantity, strut_vectors
from identification.motion import Motion

Array = NDArray[np.float64]

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # of components of an angular velocity
SHARE = 0.8  # of the sensors' range; the rest is for process forces, offsets and the platform's deformation


def sensor_forces(turn: Array, first: Array, second: Array, acceleration: Array, body: RigidBody, case: Case) -> Array:
    """Forces of the sensors in the platform, offsets and compensation apart, shape (n, 6) [N or N m].

    Args:
        turn: R, shape (n, 3, 3).
        first: its time derivative.
        second: its second time derivative.
        acceleration: acceleration of the origin of {P}, shape (n, 3) [m/s^2].
    """
    wrench = load_wrench(turn, first, second, acceleration, body, case.gravity).reshape(-1, 2, 3)
    of_platform = np.einsum("nji,nkj->nki", turn, wrench).reshape(-1, 6, 1)
    return np.asarray(np.linalg.solve(case.sensor_frame.structure[None], of_platform)[:, :, 0])


def load_wrench(
    turn: Array, first: Array, second: Array, acceleration: Array, body: RigidBody, gravity: Array
) -> Array:  # fmt: skip
    """Force and moment about the origin of {P} that move a body with {P}, in {B}, shape (n, 6) [N, N m].

    Args:
        turn: R, shape (n, 3, 3).
        first: its time derivative.
        second: its second time derivative.
        acceleration: acceleration of the origin of {P}, shape (n, 3) [m/s^2].
        gravity: gravity in {B}, shape (3,) [m/s^2].
    """
    omega, alpha = spins((turn, first, second))
    arm = turn @ body.centre_of_gravity
    force = body.mass_kg * (acceleration + (second @ body.centre_of_gravity) - gravity)
    inertia = turn @ body.inertia @ turn.transpose(0, 2, 1)
    momentum = np.einsum("nij,nj->ni", inertia, omega)
    moment = np.einsum("nij,nj->ni", inertia, alpha) + np.cross(omega, momentum) + np.cross(arm, force)
    return np.hstack([force, moment])


def spins(rotation: tuple[Array, Array, Array]) -> tuple[Array, Array]:
    """Angular velocity and acceleration in {B}, shapes (n, 3), from R and its time derivatives, shapes (n, 3, 3)."""
    turn, first, second = rotation
    back = turn.transpose(0, 2, 1)
    matrices = first @ back, second @ back + first @ first.transpose(0, 2, 1)  # S(omega), S(omega')
    omega, alpha = (np.stack([s[:, 2, 1], s[:, 0, 2], s[:, 1, 0]], axis=1) for s in matrices)
    return omega, alpha


@dataclass(frozen=True, slots=True)
class Loads:
    """Forces of the sensors with every body that a case expects, as constants in the axes of the platform.

    f = b (p'' - g) + d alpha + omega Q omega: (17) for a rigid body, whose constants are found by probing
    `sensor_forces` at R = 1. One channel is one sensor with one of the bodies.
    """

    linear: Array  # b, shape (channels, 3)
    angular: Array  # d, shape (channels, 3)
    spin: Array  # Q as coefficients of wx^2, wy^2, wz^2, wx wy, wx wz, wy wz, shape (channels, 6)
    gravity: Array  # shape (3,) [m/s^2]
    limit: Array  # limit of each channel, shape (channels,) [N or N m]
    moments: NDArray[np.bool_]  # which of them are moments with a range of their own, shape (channels,)
    labels: tuple[str, ...]  # labels of the channels

    @classmethod
    def of(cls, case: Case) -> "Loads | None":
        """The constants of a case; None where it names no range or no nominal body."""
        if (most := case.sensors.range) is None or case.nominal is None:
            return None
        request = _Asked(case.sensor_frame, case.nominal, case.payloads, tuple(case.gravity), tuple(most), case)
        return _loads(request)

    def forces(self, rotation: tuple[Array, Array, Array], acceleration: Array) -> Array:
        """Forces, shape (n, channels) [N].

        Args:
            rotation: R and its first and second time derivative, shapes (n, 3, 3).
            acceleration: acceleration of the origin of {P}, shape (n, 3) [m/s^2].
        """
        turn, first, second = rotation
        back = turn.transpose(0, 2, 1)
        spin, change = back @ first, back @ second  # S(omega), and S(alpha) + S(omega)^2
        state = np.empty((len(turn), 12))
        state[:, :3] = ((acceleration - self.gravity)[:, None, :] @ turn)[:, 0]
        for k, (i, j) in enumerate(((2, 1), (0, 2), (1, 0))):
            state[:, 3 + k] = (change[:, i, j] - change[:, j, i]) / 2
        omega = spin[:, (2, 0, 1), (1, 2, 0)]
        for k, (i, j) in enumerate(PAIRS, start=6):
            state[:, k] = omega[:, i] * omega[:, j]
        return np.asarray((np.hstack([self.linear, self.angular, self.spin]) @ state.T).T)


@dataclass(frozen=True, slots=True)
class _Asked:
    """What the constants depend on; `case` holds all of it."""

    frame: SensorFrame
    nominal: RigidBody
    payloads: Payloads | None
    gravity: tuple[float, ...]
    range: tuple[float, ...]
    case: Case = field(compare=False)


@lru_cache(maxsize=8)
def _loads(request: _Asked) -> Loads:
    case = request.case
    axes, none = np.eye(3), np.zeros((6, 3))
    pairs = np.array([axes[i] if i == j else axes[i] + axes[j] for i, j in PAIRS])
    push, turn, spin = (
        np.vstack([axes, none, none[:3]]),
        np.vstack([none[:3], axes, none]),
        np.vstack([none, pairs]),
    )
    first = _cross_matrices(spin)
    second = _cross_matrices(turn) + first @ first
    unturned = np.tile(axes, (len(push), 1, 1))
    coefficients = np.vstack(
        [sensor_forces(unturned, first, second, push + case.gravity, body, case).T for body in case.bodies]
    )
    quadratic = coefficients[:, 6:].copy()
    for column, (i, j) in enumerate(PAIRS):
        if i != j:
            quadratic[:, column] -= coefficients[:, 6 + i] + coefficients[:, 6 + j]
    labels = tuple(f"sensor {k}, {payload_words(count)}" for count in range(len(case.bodies)) for k in range(1, 7))
    limit = SHARE * np.tile(request.range, len(case.bodies))
    moments = np.tile(np.arange(6) >= (3 if case.sensors.range_Nm is not None else 6), len(case.bodies))
    return Loads(coefficients[:, :3], coefficients[:, 3:6], quadratic, np.asarray(case.gravity), limit, moments, labels)


def _cross_matrices(vectors: Array) -> Array:
    matrices = np.zeros((len(vectors), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        matrices[:, j, i], matrices[:, i, j] = vectors[:, k], -vectors[:, k]
    return matrices


def sensor_loads(values: Array, loads: "Loads | StrutLoads") -> Iterable[Quantity]:
    """Predicted sensor forces with every body that the case expects, against 80 % of the sensors' range.

    Args:
        values: the forces, shape (n, channels) [N or N m].
    """
    for kind, channels in ((LimitKind.SENSOR_FORCE, ~loads.moments), (LimitKind.SENSOR_MOMENT, loads.moments)):
        if channels.any():
            labels = tuple(label for label, own in zip(loads.labels, channels, strict=True) if own)
            limit = loads.limit[channels]
            yield Quantity.between(kind, labels, values[:, channels], -limit, limit)


@dataclass(frozen=True, slots=True)
class StrutLoads:
    """Forces of the sensors in the struts with every body that a case expects; one channel is a sensor with a body."""

    case: Case
    limit: Array  # limit of each channel, shape (channels,) [N]
    moments: NDArray[np.bool_]  # none of them is a moment, shape (channels,)
    labels: tuple[str, ...]  # labels of the channels

    @classmethod
    def of(cls, case: Case) -> "StrutLoads | None":
        """Those of a case; None where it names no range or no nominal body."""
        if (most := case.sensors.range) is None or case.nominal is None:
            return None
        labels = tuple(f"sensor {k}, {payload_words(count)}" for count in range(len(case.bodies)) for k in range(1, 7))
        return cls(case, SHARE * np.tile(most, len(case.bodies)), np.zeros(len(labels), dtype=bool), labels)

    def forces(self, motion: Motion, rotation: tuple[Array, Array, Array], acceleration: Array) -> Array:
        """Forces, shape (n, channels) [N].

        Args:
            motion: poses of {P} with their derivatives, of n instants.
            rotation: R and its first and second time derivative, shapes (n, 3, 3).
            acceleration: acceleration of the origin of {P}, shape (n, 3) [m/s^2].
        """
        machine, _, _ = self.case.need_machine("the forces of the sensors")
        sensors, gravity = self.case.sensor_frame.struts, self.case.gravity
        assert sensors is not None
        mass, first_moment = sensors.rod_mass_kg, sensors.rod_first_moment_kg_m
        strut, moving, changing, _ = strut_vectors(motion, rotation, machine)
        length = np.linalg.norm(strut, axis=2)[:, :, None]
        n = strut / length
        speed = _dot(n, moving)
        turning = (moving - speed * n) / length  # n'
        bend = (changing - _dot(n, changing) * n - 2.0 * speed * turning) / length  # n'' across n
        weight = gravity - _dot(n, gravity[None, None]) * n
        inert = sensors.inertia_kg_m2 + length**2 * mass - 2.0 * length * first_moment
        lever = length * mass - first_moment  # first moment of the rod about the base joint
        across = inert * bend + 2.0 * speed * lever * turning - (sensors.tube_first_moment_kg_m + lever) * weight
        omega, _ = spins(rotation)
        at_base, at_platform = self._friction(np.cross(n, turning), omega[:, None])
        across = (across - np.cross(n, at_base + at_platform)) / length  # of the platform on the strut
        arm = (rotation[0] @ machine.platform.points.T).transpose(0, 2, 1)
        carried = np.hstack([across.sum(axis=1), (np.cross(arm, across) - at_platform).sum(axis=1)])
        columns = np.concatenate([n, np.cross(arm, n)], axis=2).transpose(0, 2, 1)
        wrenches = [load_wrench(*rotation, acceleration, body, gravity) + carried for body in self.case.bodies]
        along = np.linalg.solve(columns, np.stack(wrenches, axis=2))
        if sensors.at == "drive":
            turned = _dot(turning, turning)
            sliding = _dot(n, changing) + length * turned  # l''
            along = along + mass * (sliding - _dot(n, gravity[None, None])) - lever * turned
        return np.asarray(along.transpose(0, 2, 1).reshape(len(strut), -1))

    def _friction(self, spin: Array, omega: Array) -> tuple[Array, Array]:
        """Moments against which a strut turns in its base joint, and against the platform, shapes (n, 6, 3) [N m].

        Args:
            spin: angular velocities of the struts, shape (n, 6, 3) [rad/s].
            omega: that of the platform, shape (n, 1, 3) [rad/s].
        """
        sensors = self.case.sensor_frame.struts
        assert sensors is not None
        of_base, of_platform = (
            viscous * rate + coulomb * rate / np.maximum(np.linalg.norm(rate, axis=2, keepdims=True), 1e-12)
            for viscous, coulomb, rate in zip(
                sensors.viscous_friction_Nms or (0.0, 0.0),
                sensors.coulomb_friction_Nm or (0.0, 0.0),
                (spin, spin - omega),
                strict=True,
            )
        )
        return of_base, of_platform


def _dot(one: Array, other: Array) -> Array:
    return np.asarray(np.sum(one * other, axis=2, keepdims=True))
