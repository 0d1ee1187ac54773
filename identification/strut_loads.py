"""Forces at sensors in struts that a motion with a rigid body on the platform will cause: Newton and Euler in {B}.

Written for the proof of limits, from the definitions, without the regressor that the planner uses. A strut is a tube
that turns about its base joint and a rod that slides in it, both slender; n points along it, l is its length. The
balance of moments about the base joint gives the force across the strut at the platform, the balance of the platform
the forces along the struts, and that of the rod what a sensor between it and the drive reads.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.limited_quantities import strut_vectors
from identification.motion import Motion
from identification.overload import SHARE, load_wrench, spins

Array = NDArray[np.float64]


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
        labels = tuple(f"sensor {k}, {count} payloads" for count in range(len(case.bodies)) for k in range(1, 7))
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
