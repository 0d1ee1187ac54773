"""Simulates what sensors and encoders record of an executed motion.

No inverse crime: forces follow from the continuous motion's own derivatives, not from the recorded samples, and by
default the recording is delayed, sampled between encoder cycles, quantised and noisy.
"""

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.executed import Execution
from identification.model import identification_model, regressors
from identification.parameters import linear_parameters
from identification.recording import Recording

Array = NDArray[np.float64]

TRUE_MODEL = 9  # rigid body with inertia, offsets and the elastic error terms K2 and K5


def true_forces(case: Case, execution: Execution, t: Array) -> Array:
    """Sensor forces (18) of the simulated machine at times t, shape (n, 6) [N].

    Raises:
        CaseError: the case describes no simulated machine.
    """
    simulation = case.need_simulation("the simulation of sensor forces")
    model = identification_model(case, TRUE_MODEL)
    u = linear_parameters(model, simulation.parameters)
    return np.asarray(regressors(model, execution.kinematics(np.clip(t, 0.0, execution.duration))) @ u)


def simulate_recording(
    case: Case, execution: Execution, trigger_times: Array, seed: int, source: str = "simulation"
) -> Recording:
    """What the machine would have recorded of a run.

    Args:
        case: with a simulated machine.
        execution: the motion that was really executed.
        trigger_times: start and end of each time the trigger was on, shape (k, 2) [s].
        seed: of the noise.
        source: name of the recording, for messages.

    Raises:
        CaseError: the case describes no simulated machine.
    """
    simulation = case.need_simulation("the simulation of sensor forces")
    step = 1.0 / simulation.encoder_rate_Hz
    t: Array = np.arange(int(np.floor(execution.duration / step + 1e-9)) + 1) * np.float64(step)
    late = simulation.force_delay + simulation.force_sampling_offset_cycles * step
    forces = true_forces(case, execution, t - late)
    forces = forces + np.random.default_rng(seed).normal(0.0, simulation.force_noise_N, forces.shape)
    struts = execution.struts(t)
    if simulation.encoder_resolution > 0.0:
        struts = np.round(struts / simulation.encoder_resolution) * simulation.encoder_resolution
    trigger = np.zeros(len(t), dtype=bool)
    for start, end in trigger_times:
        trigger |= (t >= start) & (t < end)
    return Recording(source, t, struts, None, forces, trigger)
