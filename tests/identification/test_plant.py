"""A robot that nobody here wrote: MuJoCo is driven along the executed motion, its sensor recorded and identified."""

from functools import cache

import numpy as np
import pytest

from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.machines.executed import Execution
from identification.machines.serial_chain import SerialChain
from identification.recording.recording import Recording
from identification.simulate import truth_rows
from tests.helpers import seeds
from tests.plant import Plant
from tests.postprocessors.joint_walks import walk

CASE = load_case("ur10_wrist")
RATE, REST = 500.0, 0.4  # [1/s], [s] before and after the motion
SETTINGS = CASE.need_simulation("a test")
DELAY = SETTINGS.force_delay


@cache
def run() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times, positions of the joints, true readings of the sensor without noise, trigger."""
    motion = walk(CASE, moves=14, seed=4)
    grid = np.arange(0.0, motion.duration + 2 * REST, 1e-3)
    path = motion.at(np.clip(grid - REST, 0.0, motion.duration)).coordinates
    execution = Execution.of_set_points(SerialChain.of(CASE), 1e-3, path)
    t = np.arange(0.0, grid[-1], 1.0 / RATE)
    felt = np.clip(t - DELAY, 0.0, None)
    plant = Plant(CASE.chain, SETTINGS.parameters.body, tuple(CASE.gravity))
    wrench = plant.read(*(execution.drives(felt, order) for order in range(3)))["wrench"]
    trigger = (t >= REST) & (t < REST + motion.duration)
    return t, execution.drives(t), np.array(SETTINGS.parameters.offsets_N) - wrench, trigger


def recorded(seed: int) -> Recording:
    """The run as encoders and a sensor with noise tell it."""
    t, joints, forces, trigger = run()
    noise = np.random.default_rng(seed).normal(size=forces.shape) * SETTINGS.force_noise
    step = SETTINGS.turning_resolution
    return Recording(f"seed {seed}", t, np.round(joints / step) * step, None, forces + noise, trigger)


def errors(seed: int) -> np.ndarray:
    """Errors of all parameters in reported standard deviations."""
    estimate = estimate_parameters(recorded(seed), CASE)
    rows = truth_rows(CASE, estimate)
    assert len(rows) == 16
    return np.array([row["error"] / row["std"] for row in rows])


@seeds(3)
def test_all_sixteen_parameters_are_found_within_their_deviations(seed: int) -> None:
    assert np.abs(errors(seed)).max() < 3.5


@pytest.mark.slow
def test_intervals_of_95_percent_hold_the_truth_as_often_as_they_say() -> None:
    found = np.array([errors(seed) for seed in range(20)])
    assert np.abs(found).max() < 3.5
    share = np.mean(np.abs(found) < 1.96)
    print(f"largest error {np.abs(found).max():.2f} deviations, 95 % intervals hold {100 * share:.1f} %")
    assert 0.92 <= share <= 0.98
