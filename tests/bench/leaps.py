"""Error bars where accelerations leap between samples, as those of controllers without limit of jerk do."""

import numpy as np

from identification.identify import estimate_parameters
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters, physical_form
from identification.simulate import simulate_recording
from tests.identification.leaping import CASE, moves_without_jerk_limit

SEEDS = 40


def leaps() -> list[list[str]]:
    """Coverage and largest mean error over seeds of a run with all imperfections of the simulated machine."""
    model = identification_model(CASE, 9)
    truth = physical_form(model).of(linear_parameters(model, CASE.simulation.parameters), np.eye(20))[0]
    execution = moves_without_jerk_limit(1)
    window = np.array([[0.25, execution.duration - 0.25]])
    late = CASE.simulation.force_delay + CASE.simulation.force_sampling_offset_cycles / CASE.simulation.encoder_rate_Hz
    errors, delays = [], []
    for seed in range(SEEDS):
        found = estimate_parameters(simulate_recording(CASE, execution, window, seed), CASE)
        errors.append([(v.value - t) / v.reported for v, t in zip(found.physical.values(), truth, strict=True)])
        assert found.delay is not None
        delays.append((found.delay.value - late) / found.delay.std)
    z = np.array(errors)
    inside = 100.0 * float(np.mean(np.abs(z) < 1.96))
    centre = float(np.abs(z.mean(axis=0)).max()) * np.sqrt(SEEDS)
    return [
        [f"coverage where accelerations leap, {SEEDS} seeds", f"{inside:.1f} %", "92 to 98 %"],
        ["  worst mean error, in standard deviations of the mean", f"{centre:.1f}", "4"],
        ["  delay: rms error in its standard deviations", f"{float(np.sqrt(np.mean(np.square(delays)))):.2f}", "1"],
    ]
