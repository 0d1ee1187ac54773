"""Error bars are honest: over many runs as many of them hold the truth as they promise."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters, physical_form
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, few, ideal, simulated
from tests.simulated_machine import PoseExecution

# White noise, no steps of the encoder: the conditions under which (28) must hold.
CASE = simulated(ideal(load_case("hexapod")), force_noise_N=1.0)
TRUTH = linear_parameters(identification_model(CASE, 9), CASE.simulation.parameters)
PHYSICAL = physical_form(identification_model(CASE, 9)).of(TRUTH, np.eye(20))[0]
MOTION = Harmonic(seed=1, duration=2.0)


def coverage(seeds: int) -> float:
    """Share of the 95 % intervals of 20 parameters that hold the truth."""
    execution, inside = PoseExecution(Hexapod.of(CASE), MOTION), []
    for seed in range(seeds):
        recording = simulate_recording(CASE, execution, np.array([[0.1, 1.9]]), seed)
        estimate = estimate_parameters(recording, CASE)
        intervals = np.array([v.interval(estimate.fit.freedom) for v in estimate.physical.values()])
        inside.append((intervals[:, 0] <= PHYSICAL) & (intervals[:, 1] >= PHYSICAL))
    return float(np.mean(inside))


@pytest.mark.slow
def test_of_30_runs_about_95_percent_of_the_intervals_hold_the_truth() -> None:
    assert 0.90 <= coverage(30) <= 0.99


@pytest.mark.slow
@pytest.mark.parametrize("colour", few(20.0, 0.0))
def test_the_delay_is_as_sure_as_it_says_also_under_noise_with_memory(colour: float) -> None:
    """White, and behind a 20 Hz filter of first order, which makes the white formula four times too sure."""
    execution, window = PoseExecution(Hexapod.of(CASE), MOTION), np.array([[0.1, 1.9]])
    clean = simulate_recording(simulated(CASE, force_noise_N=0.0), execution, window, 0)
    keep = np.exp(-2 * np.pi * colour / 1000.0) if colour else 0.0
    errors = []
    for seed in range(20):
        drawn = np.random.default_rng(seed).normal(size=(len(clean.forces) + 1000, 6))
        noise = np.sqrt(1 - keep**2) * lfilter([1.0], [1.0, -keep], drawn, axis=0)[1000:]
        delay = estimate_parameters(replace(clean, forces=clean.forces + noise), CASE).delay
        errors.append(delay.value / delay.std)
    assert 0.65 < np.sqrt(np.mean(np.square(errors))) < 1.4  # 20 runs tell it to 16 %


@pytest.mark.slow
def test_of_100_runs_about_95_percent_of_the_intervals_hold_the_truth() -> None:
    assert 0.92 <= coverage(100) <= 0.98
