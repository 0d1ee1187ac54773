"""Motions pass the points they are given, from rest to rest, and join without a jump."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from identification.motion.motion import Joined, Motion, Standstill, TimedPoints, sample
from identification.motion.moves import StraightMove
from tests.helpers import HOME, Harmonic, jerked

gaps = st.lists(st.floats(0.05, 2.0), min_size=1, max_size=12)
ORDERS = ("coordinates", "rates", "accelerations", "jerks")


def points(gaps: list[float], seed: int = 0) -> TimedPoints:
    times = np.concatenate([[0.0], np.cumsum(gaps)])
    return TimedPoints.through(times, HOME + np.random.default_rng(seed).uniform(-0.2, 0.2, (len(times), 6)))


def joined() -> Joined:
    first = points([0.5, 0.3])
    last = StraightMove.fastest(first.poses[-1], HOME, np.ones(6), np.full(6, 5.0), np.full(6, 50.0))
    return Joined((Standstill(first.poses[0], 0.4), first, last))


@given(gaps=gaps, seed=st.integers(0, 1000))
def test_timed_points_are_passed_on_time_from_rest_to_rest(gaps: list[float], seed: int) -> None:
    motion = points(gaps, seed)
    np.testing.assert_allclose(motion.at(motion.times).coordinates, motion.poses, atol=1e-9)
    ends = motion.at([0.0, motion.duration])
    speed = np.abs(motion.poses).max() / min(gaps)
    np.testing.assert_allclose(ends.rates, 0.0, atol=1e-8 * speed)
    np.testing.assert_allclose(ends.accelerations, 0.0, atol=1e-7 * speed / min(gaps))


def test_points_of_a_motion_of_constant_jerks_are_that_motion() -> None:
    """Any smoother curve through them would overshoot the jerks where they jump."""
    motion = jerked(np.array([100.0, -50.0, 20.0, 200.0, 10.0, 0.0]), 0.05)
    times = np.linspace(0.0, motion.duration, 41)
    poses = np.round(motion.at(times).coordinates, 8)  # as in a program
    points = TimedPoints.through(times, poses)
    t = np.linspace(0.0, motion.duration, 2001)[1:-1] + 1e-7
    for order, tolerance in zip(ORDERS, (2e-8, 1e-5, 5e-3, 1.0), strict=True):
        np.testing.assert_allclose(getattr(points.at(t), order), getattr(motion.at(t), order), atol=tolerance)


def test_points_of_a_smooth_motion_are_not_taken_for_constant_jerks() -> None:
    motion = StraightMove.fastest(HOME, HOME + 0.1, np.ones(6), np.full(6, 5.0), np.full(6, 50.0))
    times = np.linspace(0.0, motion.duration, 50)
    share = np.sin(np.pi * times / times[-1]) ** 4
    assert TimedPoints.through(times, HOME + 0.1 * share[:, None]).spline.k == 5


def test_timed_points_are_continuous_up_to_the_jerk() -> None:
    motion = points([0.4, 0.2, 0.7])
    for knot in motion.times[1:-1]:
        before, after = motion.at([knot - 1e-9]), motion.at([knot + 1e-9])
        for order in ORDERS:
            change = getattr(after, order) - getattr(before, order)
            np.testing.assert_allclose(change, 0.0, atol=1e-6 * (1 + np.abs(motion.at(motion.times).jerks).max()))


@pytest.mark.parametrize(
    ("times", "count"),
    [([0.0], 1), ([0.0, 1.0, 1.0], 3), ([0.0, 2.0, 1.0], 3), ([0.5, 1.0], 2), ([0.0, 1.0], 3)],
    ids=["one point", "twice the same time", "back in time", "not from 0", "more poses than times"],
)
def test_points_without_increasing_times_are_refused(times: list[float], count: int) -> None:
    with pytest.raises(ValueError, match="times that increase from 0"):
        TimedPoints.through(times, np.zeros((count, 6)))


def test_a_joined_motion_is_each_part_in_its_turn() -> None:
    motion = joined()
    assert motion.duration == pytest.approx(sum(p.duration for p in motion.parts))
    for part, start in zip(motion.parts, motion.starts[:-1], strict=True):
        t = np.linspace(0.0, part.duration, 50)[1:-1]
        for order in ORDERS:
            np.testing.assert_allclose(getattr(motion.at(start + t), order), getattr(part.at(t), order), atol=1e-9)


def test_a_joined_motion_has_no_jump_where_its_parts_meet() -> None:
    motion = joined()
    for seam in motion.starts[1:-1]:
        around = motion.at([seam - 1e-9, seam, seam + 1e-9])
        np.testing.assert_allclose(np.ptp(around.coordinates, axis=0), 0.0, atol=1e-8)
        np.testing.assert_allclose(np.ptp(around.rates, axis=0), 0.0, atol=1e-6)


def test_outside_its_time_a_joined_motion_stands_at_its_ends() -> None:
    motion = joined()
    np.testing.assert_allclose(
        motion.at([-1.0, motion.duration + 1.0]).coordinates, motion.at([0.0, motion.duration]).coordinates, atol=1e-12
    )


def test_a_standstill_stands_still() -> None:
    motion = Standstill(HOME, 2.0).at([0.0, 1.0, 2.0])
    np.testing.assert_array_equal(motion.coordinates, np.tile(HOME, (3, 1)))
    for order in ORDERS[1:]:
        assert not getattr(motion, order).any()


@given(duration=st.floats(1e-3, 5.0), rate=st.floats(1.0, 500.0))
def test_samples_are_even_include_both_ends_and_are_no_rarer_than_asked(duration: float, rate: float) -> None:
    t = sample(Harmonic(duration=duration), rate).t
    assert t[0] == 0.0
    assert t[-1] == duration
    steps = np.diff(t)
    assert steps.max() <= (1 + 1e-6) / rate
    assert np.ptp(steps) <= 1e-12 * max(1.0, duration)


def test_arrays_of_a_motion_must_belong_together_and_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match=r"rates .*\(2, 6\).*\(3, 6\)"):
        Motion(np.zeros(3), np.zeros((3, 6)), np.zeros((2, 6)), np.zeros((3, 6)), np.zeros((3, 6)))
    motion = Harmonic().at([0.0, 1.0])
    for order in ORDERS:
        with pytest.raises(ValueError, match="read-only"):
            getattr(motion, order)[0] = 0.0
