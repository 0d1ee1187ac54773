"""The nearest cubic spline: splines are met exactly, smooth motions to the fourth order, rest at both ends always."""

from dataclasses import dataclass

import numpy as np
import pytest

from identification.motion import Motion
from planner.retiming.path import fitted_spline


@dataclass(frozen=True)
class Swing:
    """sin^4: at rest with four derivatives at both ends."""

    duration: float = 2.0

    def at(self, t):
        time = np.asarray(t, dtype=float)
        pose = np.sin(np.pi * time / self.duration)[:, None] ** 4 * np.array([0.2, -0.1, 0.05, 0.3, -0.2, 0.1])
        return Motion(time, pose, *(np.zeros_like(pose) for _ in range(3)))


def worst(step: float) -> float:
    swing, spline = Swing(), fitted_spline(Swing(), step)
    t = np.linspace(0.0, swing.duration, 3000)
    return float(np.abs(spline.at(t).pose - swing.at(t).pose).max())


def test_halving_the_intervals_makes_the_error_sixteen_times_smaller():
    assert worst(0.1) / worst(0.05) == pytest.approx(16.0, rel=0.15)
    assert worst(0.05) < 3e-5


def test_a_spline_over_the_same_intervals_is_met_exactly():
    first = fitted_spline(Swing(), 0.1)
    again = fitted_spline(first, 0.1)
    t = np.linspace(0.0, first.duration, 500)
    one, other = first.at(t), again.at(t)
    assert np.abs(one.pose - other.pose).max() < 1e-12
    assert np.abs(one.accelerations - other.accelerations).max() < 1e-8


def test_it_is_at_rest_at_both_ends_and_smooth_between():
    spline = fitted_spline(Swing(), 0.07)
    assert spline.duration == pytest.approx(2.0)
    ends = spline.at([0.0, spline.duration])
    assert np.abs(ends.rates).max() < 1e-12
    assert np.abs(ends.accelerations).max() < 1e-11
    for order in range(3):
        assert np.allclose(spline.at_ends(order)[:-1], spline.at_starts(order)[1:], atol=1e-9)
