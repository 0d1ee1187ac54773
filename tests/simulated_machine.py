"""The simulated machine without a controller between: motions followed exactly, true forces, averaged standstills."""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from cases.schema import Case
from identification.machines.casadi_batch import over_samples
from identification.machines.executed import Execution
from identification.machines.hexapod import Hexapod
from identification.machines.machine import Kinematics
from identification.machines.rotations import twist, twist_rate
from identification.motion.motion import Trajectory
from identification.recording.recording import Recording
from identification.simulate import UNDISTURBED, Circumstances, force_parts

Array = NDArray[np.float64]

FINE = 2000.0  # [1/s]


@dataclass(frozen=True, slots=True)
class PoseExecution:
    """A controller that follows a trajectory of the platform exactly."""

    machine: Hexapod
    trajectory: Trajectory

    @property
    def duration(self) -> float:
        return self.trajectory.duration

    @property
    def extremes(self) -> Array:
        """A grid of half a millisecond: the motion is smooth."""
        return np.linspace(0.0, self.duration, 1 + int(np.ceil(self.duration * FINE)))

    def drives(self, t: ArrayLike, order: int = 0) -> Array:
        motion = self.trajectory.at(t)
        if order == 0:
            return self.machine.strut_lengths(motion.coordinates)
        return over_samples(self.machine.strut_motion, motion.coordinates, motion.rates, motion.accelerations)[order]

    def kinematics(self, t: ArrayLike) -> Kinematics:
        motion = self.trajectory.at(t)
        return kinematics_of_coordinates(motion.coordinates, motion.rates, motion.accelerations)


def kinematics_of_coordinates(pose: ArrayLike, rates: ArrayLike, accelerations: ArrayLike) -> Kinematics:
    """Kinematics from coordinates and their time derivatives, (37) and (38); shapes (n, 6)."""
    twists, twist_rates = over_samples(_COORDINATES_TO_TWIST, pose, rates, accelerations)
    return Kinematics(np.array(pose, dtype=float), twists, twist_rates)


def _coordinates_to_twist() -> ca.Function:
    pose, rates, accelerations = (ca.SX.sym(n, 6) for n in ("pose", "rates", "accelerations"))
    return ca.Function(
        "coordinates_to_twist",
        [pose, rates, accelerations],
        [twist(pose, rates), twist_rate(pose, rates, accelerations)],
    )


_COORDINATES_TO_TWIST = _coordinates_to_twist()


def true_forces(case: Case, execution: Execution, t: Array, around: Circumstances = UNDISTURBED) -> Array:
    """Sensor forces (18) at times t, evenly spaced where a structural mode vibrates, shape (n, 6) [N]."""
    step = float(t[-1] - t[0]) / max(len(t) - 1, 1)
    motion = execution.kinematics(np.clip(t, 0.0, execution.duration))
    return force_parts(case, motion, step, around).sum(axis=0)


def simulate_standstills(
    case: Case, poses: Array, samples: int, seed: int, around: Circumstances = UNDISTURBED
) -> Recording:
    """What the machine records standing still in poses, shape (n, 6) [m, rad], averaged in each of them."""
    still = Kinematics(poses, np.zeros_like(poses), np.zeros_like(poses))
    forces = force_parts(case, still, 1.0, around).sum(axis=0)
    noise = np.random.default_rng(seed).normal(0.0, case.simulation.force_noise_N / np.sqrt(samples), forces.shape)
    step = case.simulation.encoder_resolution
    struts = np.round(Hexapod.of(case).strut_lengths(poses) / step) * step
    return Recording("simulation", None, struts, None, forces + noise, None)
