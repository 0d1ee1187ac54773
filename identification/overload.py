"""Forces at the sensors that a motion with a rigid body on the platform will cause: Newton and Euler in {B}.

Written for the proof of limits, from the definitions, without the regressor that the planner uses.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from cases.sensors import RigidBody
from identification.frame import structure_matrix
from identification.limited import Quantity, rotation_motion
from identification.motion import Motion

Array = NDArray[np.float64]

SHARE = 0.8  # of the sensors' range; the rest is for process forces, offsets and the platform's deformation


def sensor_forces(turn: Array, first: Array, second: Array, acceleration: Array, body: RigidBody, case: Case) -> Array:
    """Forces of the sensors, offsets and compensation apart, shape (n, 6) [N or N m].

    Args:
        turn: R, shape (n, 3, 3).
        first: its time derivative.
        second: its second time derivative.
        acceleration: of the origin of {P}, shape (n, 3) [m/s^2].
        body: what the sensors carry.
        case: gravity and sensor frame.
    """
    back = turn.transpose(0, 2, 1)
    spin = first @ back  # S(omega)
    spin_rate = second @ back + first @ first.transpose(0, 2, 1)  # S(omega')
    omega, alpha = (np.stack([s[:, 2, 1], s[:, 0, 2], s[:, 1, 0]], axis=1) for s in (spin, spin_rate))
    arm = turn @ body.centre_of_gravity
    force = body.mass_kg * (acceleration + (second @ body.centre_of_gravity) - case.gravity)
    inertia = turn @ body.inertia @ back
    momentum = np.einsum("nij,nj->ni", inertia, omega)
    moment = np.einsum("nij,nj->ni", inertia, alpha) + np.cross(omega, momentum) + np.cross(arm, force)
    wrench = np.concatenate([np.einsum("nji,nj->ni", turn, v)[:, :, None] for v in (force, moment)], axis=1)
    return np.asarray(np.linalg.solve(structure_matrix(case.sensor_frame)[None], wrench)[:, :, 0])


def sensor_loads(motion: Motion, case: Case) -> Iterable[Quantity]:
    """Predicted sensor forces with every body that the case expects, against 80 % of the sensors' range.

    Nothing where the case names no range or no nominal body.
    """
    if case.sensors.range_N is None or not case.bodies:
        return
    rotation = rotation_motion(motion)
    acceleration = motion.accelerations[:, :3]
    values = np.concatenate([sensor_forces(*rotation, acceleration, body, case) for body in case.bodies], axis=1)
    labels = tuple(f"sensor {k}, {count} payloads" for count in range(len(case.bodies)) for k in range(1, 7))
    limit = np.full(values.shape[1], SHARE * case.sensors.range_N)
    yield Quantity.between("sensor force", "N", labels, values, -limit, limit, 1.0)
