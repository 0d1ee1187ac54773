"""Error bars are honest: over many runs as many of them hold the truth as they promise."""

import numpy as np
import pytest

from cases.loading import load_case
from identification.executed import PoseExecution
from identification.hexapod import Hexapod
from identification.identify import identify
from identification.model import identification_model
from identification.parameters import linear_parameters, physical_form
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, ideal, simulated

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
        estimate = identify(recording, CASE)
        intervals = np.array([v.interval(estimate.freedom) for v in estimate.physical.values()])
        inside.append((intervals[:, 0] <= PHYSICAL) & (intervals[:, 1] >= PHYSICAL))
    return float(np.mean(inside))


def test_of_30_runs_about_95_percent_of_the_intervals_hold_the_truth() -> None:
    assert 0.90 <= coverage(30) <= 0.99


@pytest.mark.slow
def test_of_100_runs_about_95_percent_of_the_intervals_hold_the_truth() -> None:
    assert 0.92 <= coverage(100) <= 0.98
