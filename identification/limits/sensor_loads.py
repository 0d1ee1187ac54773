"""Forces at the sensors that a motion with a rigid body on the platform will cause: Newton and Euler.

Written for the proof of limits, from the definitions, without the regressor that the planner uses. Where sensors sit in
struts, a strut is a tube that turns about its base joint and a rod that slides in it, both slender; n points along it,
l is its length. The balance of moments about the base joint gives the force across the strut at the platform, the
balance of the platform the forces along the struts, and that of the rod what a sensor between it and the drive reads.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cases.base.units import Array, Flags
from cases.schema import Case
from cases.sensors import RigidBody, payload_words
from identification.limits.hexapod import strut_vectors
from identification.limits.limit import LimitKind, Quantity
from identification.motion.motion import Motion

SHARE = 0.8  # of the sensors' range; the rest is for process forces, offsets and the platform's deformation
_CROSS = np.cross(np.eye(3)[:, None], np.eye(3)).transpose(0, 2, 1)  # S of each unit vector


@dataclass(frozen=True, slots=True)
class Loads:
    """Forces of the sensors with every body that a case expects; one channel is one sensor with one of the bodies.

    Offsets and compensation are not included.
    """

    case: Case
    wrenches: Array  # `body_wrench` of each body, shape (bodies, 6, 15)
    limit: Array  # limit of each channel, shape (channels,) [N or N m]
    moments: Flags  # which of them are moments with a range of their own, shape (channels,)
    labels: tuple[str, ...]  # labels of the channels

    @classmethod
    def of(cls, case: Case) -> "Loads | None":
        """Loads of a case; None where it names no range or no nominal body."""
        if (most := case.sensors.range) is None or case.nominal is None:
            return None
        bodies = case.bodies
        labels = tuple(f"sensor {k}, {payload_words(count)}" for count in range(len(bodies)) for k in range(1, 7))
        moments = np.tile(np.arange(6) >= (3 if case.sensors.range_Nm is not None else 6), len(bodies))
        wrenches = np.array([body_wrench(body) for body in bodies])
        return cls(case, wrenches, SHARE * np.tile(most, len(bodies)), moments, labels)

    @property
    def coefficients(self) -> Array:
        """Matrix from the `_state` of {P} to the forces of sensors in the platform, shape (channels, 15)."""
        return np.asarray(np.linalg.solve(self.case.sensor_frame.structure, self.wrenches).reshape(-1, 15))

    def forces(self, motion: Motion, rotation: tuple[Array, Array, Array], acceleration: Array) -> Array:
        """Forces, shape (n, channels) [N or N m], of a motion in the coordinates; the others as in `LoadMotion`."""
        state = _state(rotation, acceleration - self.case.gravity)
        if self.case.sensor_frame.struts is not None:
            return _in_struts(self.case, motion, rotation, state, self.wrenches)
        return np.asarray((self.coefficients @ state.T).T)


def body_wrench(body: RigidBody) -> Array:
    """Matrix from the state of {P} to the force and moment about its origin that move a body with it, shape (6, 15).

    Newton and Euler in the axes of {P}: m (a + alpha x c + omega x (omega x c)) and c x m a + I alpha + omega x I omega
    with a = p'' - g, I about the origin.
    """
    mass, c = body.mass_kg, body.centre_of_gravity
    lever = np.tensordot(c, _CROSS, 1)  # S(c)
    inertia = body.inertia - mass * lever @ lever
    axes = np.eye(3)
    spin = mass * (np.einsum("ki,j->kij", axes, c) - np.einsum("ij,k->kij", axes, c))
    turning = np.einsum("ikl,lj->kij", _CROSS, inertia)
    products = np.concatenate([spin, turning]).reshape(6, 9)
    return np.hstack([np.vstack([mass * axes, mass * lever]), np.vstack([-mass * lever, inertia]), products])


def _state(rotation: tuple[Array, Array, Array], specific: Array) -> Array:
    """State of {P}: p'' - g, angular acceleration and products of angular velocities, in its axes, shape (n, 15).

    From R and its first and second time derivative, shapes (n, 3, 3), and p'' - g in {B}, shape (n, 3) [m/s^2].
    """
    turn, first, second = rotation
    inverse = turn.transpose(0, 2, 1)
    spin, change = inverse @ first, inverse @ second  # S(omega), and S(alpha) + S(omega)^2
    omega = spin[:, (2, 0, 1), (1, 2, 0)]
    alpha = (change - change.transpose(0, 2, 1))[:, (2, 0, 1), (1, 2, 0)] / 2
    products = (omega[:, :, None] * omega[:, None]).reshape(-1, 9)
    return np.hstack([(specific[:, None, :] @ turn)[:, 0], alpha, products])


def sensor_loads(values: Array, loads: Loads) -> Iterable[Quantity]:
    """Forces, shape (n, channels) [N or N m], with every body that the case expects, against 80 % of the range."""
    for kind, channels in ((LimitKind.SENSOR_FORCE, ~loads.moments), (LimitKind.SENSOR_MOMENT, loads.moments)):
        if channels.any():
            labels = tuple(label for label, of_its_kind in zip(loads.labels, channels, strict=True) if of_its_kind)
            limit = loads.limit[channels]
            yield Quantity.between(kind, labels, values[:, channels], -limit, limit)


def _in_struts(
    case: Case, motion: Motion, rotation: tuple[Array, Array, Array], state: Array, wrenches: Array
) -> Array:
    """Forces of sensors in the struts, shape (n, channels) [N]; arguments as in `Loads.forces`."""
    machine, _, _ = case.need_machine("the forces of the sensors")
    sensors, gravity, turn = case.sensor_frame.struts, case.gravity, rotation[0]
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
    spin = rotation[1] @ turn.transpose(0, 2, 1)  # S(omega) in {B}
    of_strut, omega = np.cross(n, turning), spin[:, None, (2, 0, 1), (1, 2, 0)]
    at_base, at_platform = (  # moments against which a strut turns in its base joint, and against the platform
        viscous * rate + coulomb * rate / np.maximum(np.linalg.norm(rate, axis=2, keepdims=True), 1e-12)
        for viscous, coulomb, rate in zip(
            sensors.viscous_friction_Nms or (0.0, 0.0),
            sensors.coulomb_friction_Nm or (0.0, 0.0),
            (of_strut, of_strut - omega),
            strict=True,
        )
    )
    across = (across - np.cross(n, at_base + at_platform)) / length  # of the platform on the strut
    arm = (turn @ machine.platform.points.T).transpose(0, 2, 1)
    carried = np.hstack([across.sum(axis=1), (np.cross(arm, across) - at_platform).sum(axis=1)])
    columns = np.concatenate([n, np.cross(arm, n)], axis=2).transpose(0, 2, 1)
    of_bodies = (wrenches @ state.T).transpose(2, 0, 1).reshape(len(state), -1, 3) @ turn.transpose(0, 2, 1)  # in {B}
    along = np.linalg.solve(columns, (of_bodies.reshape(len(state), -1, 6) + carried[:, None]).transpose(0, 2, 1))
    if sensors.at == "drive":
        squared = _dot(turning, turning)  # |n'|^2
        sliding = _dot(n, changing) + length * squared  # l''
        along = along + mass * (sliding - _dot(n, gravity[None, None])) - lever * squared
    return np.asarray(along.transpose(0, 2, 1).reshape(len(strut), -1))


def _dot(one: Array, other: Array) -> Array:
    return np.asarray(np.sum(one * other, axis=2, keepdims=True))
