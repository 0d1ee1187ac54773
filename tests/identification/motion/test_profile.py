"""The seven-segment profile: as fast as ruckig, inside its limits, and its own derivatives."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruckig import InputParameter, Result, Ruckig, Trajectory

from identification.motion.moves import Profile, StraightMove, fastest_profile

size = st.floats(1e-3, 1e3)
limits = st.tuples(size, size, size, size)  # distance, velocity, acceleration, jerk
# One of each shape: short, acceleration-limited, velocity-limited without and with hold, all with cruise.
SHAPES = [
    (1e-3, 1.0, 1.0, 1.0),
    (1.0, 9.0, 1.0, 9.0),
    (9.0, 0.1, 9.0, 1.0),
    (9.0, 1.0, 1.0, 9.0),
    (0.5, 0.6, 6.0, 100.0),
]


def ruckig_duration(distance: float, velocity: float, acceleration: float, jerk: float) -> float:
    order = InputParameter(1)
    order.current_position, order.target_position = [0.0], [distance]
    order.max_velocity, order.max_acceleration, order.max_jerk = [velocity], [acceleration], [jerk]
    trajectory = Trajectory(1)
    assert Ruckig(1).calculate(order, trajectory) == Result.Working
    return float(trajectory.duration)


@given(limits=limits)
def test_no_rest_to_rest_move_is_faster(limits: tuple[float, float, float, float]) -> None:
    assert fastest_profile(*limits).duration == pytest.approx(ruckig_duration(*limits), rel=1e-9)


@given(limits=st.tuples(size, size, size))
def test_without_a_limit_of_jerk_no_move_is_faster_either(limits: tuple[float, float, float]) -> None:
    """Ruckig, asked with an infinite jerk, knows nothing of the closed form."""
    profile = fastest_profile(*limits)
    assert profile.duration == pytest.approx(ruckig_duration(*limits, np.inf), rel=1e-9)
    assert profile.jerk_time == 0.0
    assert profile.jerk == np.inf


@given(limits=st.tuples(size, size, size))
def test_a_trapezoid_is_what_very_large_limits_of_jerk_come_near(limits: tuple[float, float, float]) -> None:
    trapezoid = fastest_profile(*limits)
    near = fastest_profile(*limits, 1e7 * limits[2] / trapezoid.duration)
    assert near.duration == pytest.approx(trapezoid.duration, rel=1e-5)
    t = np.linspace(0.0, trapezoid.duration, 57)
    assert trapezoid.at(t)[0] == pytest.approx(near.at(t)[0], abs=1e-5 * limits[0])


def test_where_accelerations_step_the_value_after_the_step_counts() -> None:
    profile = fastest_profile(1.0, 1.0, 4.0)  # 0.25 s up, 0.75 s of cruise, 0.25 s down
    assert profile == pytest.approx((4.0, 0.0, 0.25, 0.75))
    assert profile.at([0.0, 0.25, 1.0, 1.25])[2].tolist() == [4.0, 0.0, -4.0, -4.0]
    assert not profile.at(np.linspace(0.0, 1.25, 101))[3].any()
    assert profile.slowed(0.5) == pytest.approx((1.0, 0.0, 0.5, 1.5))


@given(limits=limits)
def test_a_profile_ends_at_rest_where_it_should_inside_its_limits(limits: tuple[float, float, float, float]) -> None:
    distance, velocity, acceleration, jerk = limits
    profile = fastest_profile(*limits)
    s, v, a, j = profile.at(np.linspace(0.0, profile.duration, 999))
    assert s[0] == v[0] == a[0] == 0.0
    assert s[-1] == pytest.approx(distance, rel=1e-9)
    assert abs(v[-1]) <= 1e-9 * v.max()
    clock = np.spacing(profile.duration)  # after a cruise of days the end is known to this alone
    assert abs(a[-1]) <= profile.jerk * (1e-9 * profile.jerk_time + 4 * clock)
    assert v.max() <= velocity * (1 + 1e-9)
    assert np.abs(a).max() <= acceleration * (1 + 1e-9)
    assert np.abs(j).max() <= jerk * (1 + 1e-9)
    assert v.min() >= -1e-9 * v.max()  # never backwards


@pytest.mark.parametrize("shape", SHAPES)
def test_velocity_and_acceleration_are_the_integrals_of_the_jerk(shape: tuple[float, float, float, float]) -> None:
    """Simpson's rule is exact for the cubic pieces, so between corners each order is the integral of the next."""
    profile = fastest_profile(*shape)
    lengths = [profile.jerk_time, profile.hold_time, profile.jerk_time, profile.cruise_time]
    corners = np.cumsum([0.0, *lengths, *lengths[2::-1]])
    for start, end in pairwise(corners):
        inner = np.array([start, (start + end) / 2, np.nextafter(end, 0.0)]) if end > start else np.full(3, start)
        values = profile.at(inner)
        for order in range(3):
            simpson = (end - start) / 6 * (values[order + 1] @ [1, 4, 1])
            assert values[order][-1] - values[order][0] == pytest.approx(simpson, rel=1e-9, abs=1e-9)


def test_before_and_after_its_time_a_profile_stands_at_its_ends() -> None:
    profile = Profile(acceleration=4.0, jerk_time=0.5, hold_time=0.1, cruise_time=0.2)
    s = profile.at([-1.0, 0.0, profile.duration, profile.duration + 1.0])[0]
    assert s[0] == s[1] == 0.0
    assert s[2] == s[3] > 0.0


@given(
    end=st.lists(st.floats(-0.3, 0.3), min_size=6, max_size=6).filter(lambda e: max(map(abs, e)) > 1e-3),
    seed=st.integers(0, 1000),
)
def test_a_straight_move_is_straight_and_saturates_a_limit(end: list[float], seed: int) -> None:
    """It keeps every coordinate's limits, and as it is the fastest, some limit is used up."""
    bounds = np.random.default_rng(seed).uniform(0.5, 5.0, (3, 6)) * [[1.0], [10.0], [100.0]]
    start = np.full(6, 0.1)
    move = StraightMove.fastest(start, start + end, *bounds)
    motion = move.at(np.linspace(0.0, move.duration, 2001))
    along = (motion.coordinates - start) @ end / np.dot(end, end)
    np.testing.assert_allclose(motion.coordinates, start + along[:, None] * end, atol=1e-12)
    np.testing.assert_allclose(motion.coordinates[-1], start + end, atol=1e-9)
    used = [
        np.abs(v).max(axis=0) / b
        for v, b in zip((motion.rates, motion.accelerations, motion.jerks), bounds, strict=True)
    ]
    assert 0.999 < np.max(used) <= 1 + 1e-9


def test_a_move_to_where_it_starts_is_refused() -> None:
    with pytest.raises(ValueError, match="two different poses"):
        StraightMove.fastest(np.ones(6), np.ones(6), np.ones(6), np.ones(6), np.ones(6))
