"""How often the reported 95 % intervals hold the truth, over many seeds of noise on one executed run."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from cases.schema import Case
from identification.identify import estimate_parameters
from identification.machines.executed import Execution
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters
from identification.recording.recording import Recording
from identification.simulate import simulate_recording, truth_rows
from tests.simulated_machine import true_forces


@dataclass(frozen=True, slots=True)
class Coverage:
    """Shares of (seed, parameter) pairs inside the interval by (28) and inside the printed one, in %; worst error."""

    white: float
    reported: float
    worst: float


def idealised(case: Case) -> Case:
    """The case with white force noise as its only imperfection."""
    assert case.simulation is not None
    perfect = {"encoder_resolution_um": 0.0, "force_delay_ms": 0.0, "force_sampling_offset_cycles": 0.0}
    return case.model_copy(update={"simulation": case.simulation.model_copy(update=perfect)})


def coverage(case: Case, execution: Execution, trigger: np.ndarray, seeds: int) -> Coverage:
    """Simulates and identifies one run with `seeds` realisations of noise."""
    simulation = case.need_simulation("the coverage study")
    first = simulate_recording(case, execution, trigger, 0)
    assert first.t is not None
    late = simulation.force_delay + simulation.force_sampling_offset_cycles / simulation.encoder_rate_Hz
    clean = true_forces(case, execution, first.t - late)
    inside = inside_white = pairs = 0
    worst = 0.0
    for seed in range(seeds):
        noise = np.random.default_rng(1000 + seed).normal(0.0, simulation.force_noise_N, clean.shape)
        run = Recording(f"seed {seed}", first.t, first.drives, None, clean + noise, first.trigger)
        estimate = estimate_parameters(run, case, 9)
        for row, value in zip(truth_rows(case, estimate), estimate.physical.values(), strict=True):
            low, high = value.interval(estimate.fit.freedom)
            inside += low <= row["truth"] <= high
            inside_white += abs(row["error"]) <= (high - low) / 2 / value.reported * value.std
            worst = max(worst, abs(row["error"]) / row["std"])
            pairs += 1
    return Coverage(100 * inside_white / pairs, 100 * inside / pairs, worst)


@dataclass(frozen=True, slots=True)
class ColouredCoverage:
    """Shares of (seed, parameter) pairs inside the 95 % intervals, in %; width of the robust ones over the true one."""

    white: float
    robust: float
    width: float


def coloured_coverage(
    case: Case, execution: Execution, trigger: np.ndarray, seeds: int, corner: float = 20.0
) -> ColouredCoverage:
    """The same with noise behind a first-order low-pass of so many Hz, and linear parameters."""
    simulation = case.need_simulation("the coverage study")
    first = simulate_recording(case, execution, trigger, 0)
    assert first.t is not None
    late = simulation.force_delay + simulation.force_sampling_offset_cycles / simulation.encoder_rate_Hz
    clean = true_forces(case, execution, first.t - late)
    truth = linear_parameters(identification_model(case, 9), simulation.parameters)
    keep = np.exp(-2 * np.pi * corner / simulation.encoder_rate_Hz)
    values, white, robust = [], [], []
    for seed in range(seeds):
        drawn = np.random.default_rng(2000 + seed).normal(size=(len(clean) + 1000, 6))
        noise = np.sqrt(1 - keep**2) * lfilter([1.0], [1.0, -keep], drawn, axis=0)[1000:]
        run = Recording(f"seed {seed}", first.t, first.drives, None, clean + noise, first.trigger)
        estimate = estimate_parameters(run, case, 9)
        values.append(estimate.fit.values)
        white.append(np.sqrt(np.diag(estimate.fit.covariance)))
        robust.append(np.sqrt(np.diag(estimate.fit.covariance_robust)))
    errors, spread = np.abs(np.array(values) - truth), np.std(values, axis=0, ddof=1)
    inside = [100.0 * float(np.mean(errors <= 1.96 * np.array(s))) for s in (white, robust)]
    return ColouredCoverage(inside[0], inside[1], float(np.median(np.median(robust, axis=0) / spread)))
