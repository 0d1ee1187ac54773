"""How often the reported 95 % intervals hold the truth, over many seeds of noise on one executed run."""

from dataclasses import dataclass

import numpy as np

from cases.schema import Case
from identification.executed import Execution
from identification.identify import identify
from identification.recording import Recording
from identification.simulate import simulate_recording, true_forces
from planner.comparison import truth_rows


@dataclass(frozen=True, slots=True)
class Coverage:
    """Share of (seed, parameter) pairs inside the interval, in %, and the worst error in reported deviations."""

    white: float
    robust: float
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
    inside_white = inside_robust = pairs = 0
    worst = 0.0
    for seed in range(seeds):
        noise = np.random.default_rng(1000 + seed).normal(0.0, simulation.force_noise_N, clean.shape)
        run = Recording(f"seed {seed}", first.t, first.struts, None, clean + noise, first.trigger)
        estimate = identify(run, case, 9)
        for row, value in zip(truth_rows(case, estimate), estimate.physical.values(), strict=True):
            low, high = value.interval(estimate.freedom)
            half = (high - low) / 2 / value.std * value.std_robust
            inside_white += low <= row["truth"] <= high
            inside_robust += abs(row["error"]) <= half
            worst = max(worst, abs(row["error"]) / row["std"])
            pairs += 1
    return Coverage(100 * inside_white / pairs, 100 * inside_robust / pairs, worst)
