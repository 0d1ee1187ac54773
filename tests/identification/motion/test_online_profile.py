"""Ruckig's time laws against the closed form, in whole cycles; and nothing of ruckig that harms can be reached."""

import socket

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from identification.motion.moves import StraightMove, UntimedMotion, fastest_profile, limits_along, ruckig_profile
from tests.helpers import examples

RATE = np.array([0.6, 0.6, 0.6, 1.0, 1.0, 1.0])
ACCELERATION = np.array([6.0, 6.0, 6.0, 10.0, 10.0, 10.0])
JERK = np.array([100.0, 100.0, 100.0, 200.0, 200.0, 200.0])
HERE, THERE = np.zeros(6), np.array([0.1, -0.2, 0.05, 0.1, 0.0, -0.3])


@given(
    st.tuples(st.floats(0.05, 50.0), st.floats(0.5, 500.0), st.floats(5.0, 5000.0)), st.sampled_from([1e-3, 4e-3, 1e-5])
)
@settings(max_examples=examples(20), derandomize=True, deadline=None)
def test_it_is_the_closed_form_rounded_up_to_whole_cycles(limits: tuple[float, float, float], cycle: float):
    profile = ruckig_profile(*limits, cycle)
    cycles = profile.duration / cycle
    assert cycles == pytest.approx(round(cycles), abs=1e-6)
    assert -1e-9 <= profile.duration - fastest_profile(1.0, *limits).duration <= cycle * (1 + 1e-6)
    t = np.linspace(0.0, profile.duration, 2001)
    share, velocity, acceleration, jerk = profile.at(t)
    for values, limit in zip((velocity, acceleration, jerk), limits, strict=True):
        assert np.abs(values).max() <= limit * (1 + 1e-6)
    assert share[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-12)
    assert [velocity[-1], acceleration[-1]] == pytest.approx([0.0, 0.0], abs=1e-12 * max(limits))
    assert np.all(np.diff(share) >= -1e-9)
    assert profile.peak_velocity >= np.abs(velocity).max() - 1e-9


def test_derivatives_belong_together():
    profile = ruckig_profile(1.5, 10.0, 200.0, 1e-3)
    t = np.linspace(0.0, profile.duration, 20_001)
    share, velocity, acceleration, _ = profile.at(t)
    assert np.allclose(np.gradient(share, t), velocity, atol=1e-3)
    assert np.allclose(np.gradient(velocity, t), acceleration, atol=2e-2)


def online_move(start: np.ndarray, end: np.ndarray, *limits: np.ndarray, cycle: float = 1e-3) -> StraightMove:
    """The straight move of a controller that limits each coordinate, all of them in step."""
    with np.errstate(over="ignore"):
        velocity, acceleration, jerk = limits_along(np.abs(end - start), *limits)
    return StraightMove(start, end, ruckig_profile(velocity, acceleration, jerk, cycle))


def test_coordinates_keep_step_and_none_passes_its_limit():
    move = online_move(HERE, THERE, RATE, ACCELERATION, JERK)
    motion = move.at(np.linspace(0.0, move.duration, 3001))
    for values, limit in ((motion.rates, RATE), (motion.accelerations, ACCELERATION), (motion.jerks, JERK)):
        assert (np.abs(values) / limit).max() <= 1 + 1e-6
    shares = motion.coordinates[:, THERE != 0.0] / THERE[THERE != 0.0]
    assert np.allclose(shares, shares[:, :1], atol=1e-12)
    assert np.allclose(motion.coordinates[-1], THERE, rtol=0.0, atol=1e-12)
    fastest = StraightMove.fastest(HERE, THERE, RATE, ACCELERATION, JERK).duration
    assert fastest <= move.duration <= fastest + 1.001e-3


def test_a_slowed_law_covers_the_same_way():
    profile = ruckig_profile(1.5, 10.0, 200.0, 1e-3)
    slow = profile.slowed(0.5)
    assert slow.duration == pytest.approx(2 * profile.duration)
    t = np.linspace(0.0, profile.duration, 100)
    assert np.allclose(slow.at(2 * t)[0], profile.at(t)[0], atol=1e-12)
    assert slow.peak_velocity == pytest.approx(profile.peak_velocity / 2)


@pytest.mark.parametrize("value", [np.nan, 0.0, -1.0, -np.inf])
@pytest.mark.parametrize("which", range(3))
def test_limits_must_be_above_zero(which: int, value: float):
    limits = [RATE.copy(), ACCELERATION.copy(), JERK.copy()]
    limits[which][1] = value
    with pytest.raises(UntimedMotion, match="above 0"):
        online_move(HERE, THERE, *limits)


@pytest.mark.parametrize("cycle", [np.nan, 0.0, -1e-3, np.inf])
def test_the_cycle_must_be_a_duration(cycle: float):
    with pytest.raises(UntimedMotion, match="cycle"):
        online_move(HERE, THERE, RATE, ACCELERATION, JERK, cycle=cycle)


def test_without_any_limit_of_a_kind_there_is_no_law():
    with pytest.raises(UntimedMotion, match="jerk"):
        online_move(HERE, THERE, RATE, ACCELERATION, np.full(6, np.inf))


def test_a_coordinate_without_a_limit_follows_the_others():
    free = RATE.copy()
    free[2] = np.inf
    assert online_move(HERE, THERE, free, ACCELERATION, JERK).duration > 0.0


def test_no_network_is_touched(monkeypatch: pytest.MonkeyPatch):
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("a socket was opened")

    monkeypatch.setattr(socket, "socket", refuse)
    online_move(HERE, THERE, RATE, ACCELERATION, JERK)
