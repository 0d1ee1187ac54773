"""Simulates what sensors and encoders record of an executed motion.

No inverse crime: forces follow from the continuous motion's own derivatives, not from the recorded samples, and by
default the recording is delayed, sampled between encoder cycles, quantised and noisy. With disturbances the drives
ripple, the structure vibrates and forces err with the pose: nothing of which the identification models know.
"""

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from cases.sensors import Simulation
from identification.executed import Execution
from identification.hexapod import Hexapod, Kinematics
from identification.loaded import (
    UNDISTURBED,
    Circumstances,
    loaded_truth,
    mode_frequency,
    pose_error,
    rippled,
    vibrating,
)
from identification.model import identification_model, regressors
from identification.noise_model import acceleration_to_force
from identification.parameters import linear_parameters
from identification.recording import Recording

Array = NDArray[np.float64]

TRUE_MODEL = 9  # rigid body with inertia, offsets and the elastic error terms K2 and K5


def true_forces(case: Case, execution: Execution, t: Array, around: Circumstances = UNDISTURBED) -> Array:
    """Sensor forces (18) of the simulated machine at times t, shape (n, 6) [N].

    Args:
        case: with a simulated machine.
        execution: the motion that was really executed.
        t: times, evenly spaced where a structural mode vibrates [s].
        around: what is mounted and what disturbs.

    Raises:
        CaseError: the case describes no simulated machine.
    """
    simulation = case.need_simulation("the simulation of sensor forces")
    model = identification_model(case, TRUE_MODEL)
    u = linear_parameters(model, loaded_truth(simulation.parameters, around.weights))
    motion = execution.kinematics(np.clip(t, 0.0, execution.duration))
    found = around.disturbances
    if found is None:
        return np.asarray(regressors(model, motion) @ u)
    frequency = mode_frequency(simulation.parameters, around)
    step = float(t[-1] - t[0]) / (len(t) - 1)
    felt = Kinematics(motion.pose, motion.twist, vibrating(motion.twist_rate, step, frequency, found.mode_damping))
    return np.asarray(regressors(model, felt) @ u + _pose_error(case, motion.pose, around))


def _pose_error(case: Case, poses: Array, around: Circumstances) -> Array:
    assert around.disturbances is not None
    home = case.need_machine("the simulation of sensor forces")[0].home.vector
    return pose_error(around.disturbances, home, poses, around.load * float(np.linalg.norm(case.gravity)))


def simulate_standstills(
    case: Case, poses: Array, samples: int, seed: int, around: Circumstances = UNDISTURBED, source: str = "simulation"
) -> Recording:
    """What the machine would have recorded standing still in poses, averaged in each of them.

    Args:
        case: with a simulated machine.
        poses: shape (n, 6) [m, rad].
        samples: of the sensors that are averaged in each pose.
        seed: of the noise.
        around: what is mounted and what disturbs.
        source: name of the recording, for messages.

    Raises:
        CaseError: the case describes no simulated machine.
    """
    simulation = case.need_simulation("the simulation of sensor forces")
    model = identification_model(case, TRUE_MODEL)
    u = linear_parameters(model, loaded_truth(simulation.parameters, around.weights))
    still = np.zeros_like(poses)
    forces = regressors(model, Kinematics(poses, still, still)) @ u
    if around.disturbances is not None:
        forces = forces + _pose_error(case, poses, around)
    noise = np.random.default_rng(seed).normal(0.0, simulation.force_noise_N / np.sqrt(samples), forces.shape)
    struts = _quantised(Hexapod.of(case).strut_lengths(poses), simulation)
    return Recording(source, None, struts, None, forces + noise, None)


def _quantised(struts: Array, simulation: Simulation) -> Array:
    step = simulation.encoder_resolution
    return np.asarray(np.round(struts / step) * step) if step > 0.0 else struts


def simulate_recording(
    case: Case,
    execution: Execution,
    trigger_times: Array,
    seed: int,
    source: str = "simulation",
    around: Circumstances = UNDISTURBED,
) -> Recording:
    """What the machine would have recorded of a run.

    Args:
        case: with a simulated machine.
        execution: the motion that the controller executed.
        trigger_times: start and end of each time the trigger was on, shape (k, 2) [s].
        seed: of the noise.
        source: name of the recording, for messages.
        around: what is mounted and what disturbs.

    Raises:
        CaseError: the case describes no simulated machine.
    """
    simulation = case.need_simulation("the simulation of sensor forces")
    if around.disturbances is not None:
        execution = rippled(execution, around.disturbances, seed)
    step = 1.0 / simulation.encoder_rate_Hz
    t: Array = np.arange(int(np.floor(execution.duration / step + 1e-9)) + 1) * np.float64(step)
    late = simulation.force_delay + simulation.force_sampling_offset_cycles * step
    forces = true_forces(case, execution, t - late, around)
    draw = np.random.default_rng(seed)
    forces = forces + draw.normal(0.0, simulation.force_noise_N, forces.shape)
    if simulation.acceleration_noise.any():
        model = identification_model(case, TRUE_MODEL)
        u = linear_parameters(model, loaded_truth(simulation.parameters, around.weights))
        shaken = simulation.acceleration_noise * draw.normal(size=forces.shape)
        forces = forces + shaken @ acceleration_to_force(model, u).T
    struts = _quantised(execution.struts(t), simulation)
    trigger = np.zeros(len(t), dtype=bool)
    for start, end in trigger_times:
        trigger |= (t >= start) & (t < end)
    return Recording(source, t, struts, None, forces, trigger)
