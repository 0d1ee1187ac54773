"""Branch and bound finds proven maxima of functions whose maxima are known."""

import time

import numpy as np

from planner.bounds.certificate import Bounds, maximise
from tests.helpers import seeds


def parabola(peak: np.ndarray, height: float):
    """The function height - |x - peak|^2, bounded by its slope at the middle of the cell: a bound of second order."""

    def bounds(low: np.ndarray, high: np.ndarray) -> Bounds:
        middle, half = (low + high) / 2, (high - low) / 2
        value = height - ((middle - peak) ** 2).sum(axis=1)
        slope = 2 * np.abs(middle - peak)
        return value + (slope * half).sum(axis=1), value, middle, (slope * half).argmax(axis=1)

    return bounds


@seeds(5)
def test_a_proven_maximum_is_above_the_peak_and_within_what_was_asked(seed: int):
    peak = np.random.default_rng(seed).uniform(-1.0, 1.0, 3)
    upper, lower, points = maximise(
        parabola(peak, 5.0), -np.ones((1, 3)), np.ones((1, 3)), 5.01, 5.005, time.process_time() + 60
    )
    assert lower <= 5.0 <= upper <= 5.01
    assert not len(points)


def test_a_value_above_what_is_tolerable_ends_the_search_early_and_is_handed_over():
    peak = np.full(3, 0.3)
    upper, lower, points = maximise(
        parabola(peak, 5.0), -np.ones((1, 3)), np.ones((1, 3)), 4.0, 3.9, time.process_time() + 60
    )
    assert 4.0 < lower <= 5.0 <= upper <= lower + 0.1 + 1e-12
    values = 5.0 - ((points - peak) ** 2).sum(axis=1)
    assert values.min() > 3.9
    assert values[0] == lower


def test_without_time_what_is_known_is_still_an_upper_bound():
    peak = np.full(3, 0.3)
    upper, _, _ = maximise(parabola(peak, 5.0), -np.ones((1, 3)), np.ones((1, 3)), 5.01, 5.005, time.process_time())
    assert upper >= 5.0


def test_cells_that_touch_are_searched_each():
    low, high = np.array([[-1.0], [0.0]]), np.array([[0.0], [1.0]])
    upper, _, _ = maximise(parabola(np.array([0.9]), 2.0), low, high, 2.001, 2.0005, time.process_time() + 60)
    assert 2.0 <= upper <= 2.001
