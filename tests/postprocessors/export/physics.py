"""Force measurement in a moving frame, written down again from (1)-(15) in NumPy: no code of the product.

What is exported is compared with this: signs, frames and the order of everything are stated here a second time.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.schema import Case

Array = NDArray[np.float64]


@dataclass(frozen=True)
class States:
    """Random states: pose, its two time derivatives, twist, twist rate, strut motion and sensor forces; (n, 6) each."""

    pose: Array
    rates: Array
    accelerations: Array
    twist: Array
    twist_rate: Array
    lengths: Array
    velocities: Array
    strut_accelerations: Array
    forces: Array


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(np.cross(a, b))


def twist_of(pose: Array, rates: Array, accelerations: Array) -> tuple[Array, Array]:
    """Angular velocity and acceleration from turning about the three moving axes of yaw, pitch and roll."""
    roll_axis = Rotation.from_euler("xyz", pose[3:]).as_matrix()[:, 0]
    pitch_axis = np.array([-np.sin(pose[5]), np.cos(pose[5]), 0.0])
    yaw_axis = np.array([0.0, 0.0, 1.0])
    roll, pitch, yaw = rates[3:]
    carried = yaw * yaw_axis + pitch * pitch_axis  # how the roll axis turns
    omega = carried + roll * roll_axis
    alpha = accelerations[3] * roll_axis + accelerations[4] * pitch_axis + accelerations[5] * yaw_axis
    alpha = alpha + roll * _cross(carried, roll_axis) + pitch * _cross(yaw * yaw_axis, pitch_axis)
    return np.r_[rates[:3], omega], np.r_[accelerations[:3], alpha]


def strut_motion(case: Case, pose: Array, twist: Array, rate: Array) -> tuple[Array, Array, Array]:
    """Lengths of six struts and how they change, from the motion of their upper ends."""
    assert case.machine is not None
    arms = case.machine.platform.points @ Rotation.from_euler("xyz", pose[3:]).as_matrix().T
    struts = pose[:3] + arms - case.machine.base.points
    lengths = np.linalg.norm(struts, axis=1)
    direction = struts / lengths[:, None]
    omega, alpha = twist[3:], rate[3:]
    velocity = twist[:3] + _cross(omega, arms)
    acceleration = rate[:3] + _cross(alpha, arms) + _cross(omega, _cross(omega, arms))
    along = np.sum(direction * velocity, axis=1)
    speeding = (np.sum(velocity**2, axis=1) - along**2) / lengths + np.sum(direction * acceleration, axis=1)
    return lengths, along, speeding


def states(case: Case, count: int, seed: int) -> States:
    """Random states of the motion box of the case, or of a turning sensor where it has no machine."""
    draw = np.random.default_rng(seed)
    if case.limits is not None and case.machine is not None:
        box = case.limits.motion
        pose = case.machine.home.vector + draw.uniform(box.coordinates[0], box.coordinates[1], (count, 6))
        rates = box.rate * draw.uniform(-1, 1, (count, 6))
        accelerations = box.acceleration * draw.uniform(-1, 1, (count, 6))
    else:
        pose, rates, accelerations = (draw.uniform(-1, 1, (count, 6)) for _ in range(3))
    twists = [twist_of(*state) for state in zip(pose, rates, accelerations, strict=True)]
    twist, rate = (np.array(v) for v in zip(*twists, strict=True))
    if case.machine is not None:
        motion = [strut_motion(case, *state) for state in zip(pose, twist, rate, strict=True)]
    else:
        motion = [(np.zeros(6),) * 3] * count
    lengths, velocities, speeding = (np.array(v) for v in zip(*motion, strict=True))
    forces = 300.0 * draw.normal(size=(count, 6))
    return States(pose, rates, accelerations, twist, rate, lengths, velocities, speeding, forces)


def _structure(case: Case) -> Array:
    frame = case.sensor_frame
    if frame.transducer is not None:
        return np.eye(6) * (1.0 if frame.transducer.sense == "sensor_on_load" else -1.0)
    assert frame.bars is not None
    lower, upper = frame.bars.lower.points, frame.bars.upper.points
    columns = [(u - h) / np.linalg.norm(u - h) for h, u in zip(lower, upper, strict=True)]
    return np.array([np.r_[n, _cross(h, n)] for h, n in zip(lower, columns, strict=True)]).T


def external(case: Case, values: dict[str, float], pose: Array, twist: Array, rate: Array, forces: Array) -> Array:
    """(1): what acts on the platform from outside, force and moment about the origin of {P} along its axes."""
    turn = Rotation.from_euler("xyz", pose[3:]).as_matrix()
    gravity = turn.T @ case.gravity
    omega, alpha = turn.T @ twist[3:], turn.T @ rate[3:]
    m = values["m"]
    first = np.array([values["mxC"], values["myC"], values["mzC"]])
    xx, xy, xz, yy, yz, zz = (values.get(f"I{k}", 0.0) for k in ("11", "12", "13", "22", "23", "33"))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    origin = turn.T @ rate[:3]
    inertial_force = m * origin + _cross(alpha, first) + _cross(omega, _cross(omega, first))
    inertial_moment = _cross(first, origin) + inertia @ alpha + _cross(omega, inertia @ omega)
    weight, weight_moment = m * gravity, _cross(first, gravity)
    structure = _structure(case)
    gibbs = Rotation.from_matrix(turn).as_mrp()  # tan(angle/4) axis
    gibbs = 2 * gibbs / (1 - gibbs @ gibbs)  # tan(angle/2) axis
    sensors = np.array([values[f"f_q0_{k}"] for k in range(1, 7)])
    for k in range(6):
        for letter, factors in (("K1", pose[:2]), ("K3", gravity), ("K4", gibbs)):
            for c, factor in zip("xyz", factors, strict=False):
                sensors[k] += values.get(f"{letter}_{k + 1}{c}", 0.0) * factor
    k0, k1, k2, k3 = (values.get(f"k{k}", 0.0) for k in range(4))
    bent = np.r_[k0 * pose[0] - k2 * gibbs[1], k0 * pose[1] + k2 * gibbs[0], 0.0]
    twisted = np.r_[k1 * pose[1] + k3 * gibbs[0], -k1 * pose[0] + k3 * gibbs[1], 0.0]
    corrected = forces - sensors - np.linalg.solve(structure, np.r_[bent, twisted])
    return np.r_[inertial_force - weight, inertial_moment - weight_moment] - structure @ corrected
