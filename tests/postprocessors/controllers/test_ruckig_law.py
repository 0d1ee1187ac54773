"""The closed forms of both time laws against ruckig, which knows nothing of them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from ruckig import InputParameter, Ruckig, Trajectory

from identification.motion.moves import fastest_profile, ruckig_profile
from postprocessors.controllers.virtual import by_ruckig

limits = st.tuples(st.floats(0.05, 20.0), st.floats(0.1, 200.0), st.floats(1.0, 5000.0))


@given(limits=limits, stepping=st.booleans())
def test_the_profile_is_ruckigs_own_motion(limits: tuple[float, float, float], stepping: bool):
    """Seven segments of which the last three mirror the first: position and velocity as ruckig itself gives them."""
    limits = (*limits[:2], np.inf if stepping else limits[2])
    request, answer = InputParameter(1), Trajectory(1)
    request.current_position, request.target_position = [0.0], [1.0]
    request.max_velocity, request.max_acceleration, request.max_jerk = ([value] for value in limits)
    Ruckig(1).calculate(request, answer)
    profile = ruckig_profile(*limits)
    assert abs(profile.duration - answer.duration) < 1e-9 * profile.duration
    t = np.linspace(0.0, answer.duration, 51)
    theirs = np.array([[v[0] for v in answer.at_time(float(instant))[:2]] for instant in t])
    np.testing.assert_allclose(np.column_stack(profile.at(t)[:2]), theirs, atol=1e-7 * max(1.0, profile.peak_velocity))


def agree(one, other) -> None:
    assert one.duration == other.duration or abs(one.duration - other.duration) < 1e-9 * other.duration
    assert abs(one.peak_velocity - other.peak_velocity) < 1e-6 * other.peak_velocity
    t = np.linspace(0.0, one.duration, 101)
    for a, b in zip(one.at(t)[:2], other.at(t)[:2], strict=True):
        assert np.allclose(a, b, rtol=1e-6, atol=1e-7 * np.abs(b).max())


@given(limits=limits)
def test_the_seven_segment_profile_is_the_fastest_that_ruckig_knows(limits: tuple[float, float, float]):
    agree(ruckig_profile(*limits), fastest_profile(1.0, *limits))


@given(limits=limits)
def test_the_trapezoid_is_the_fastest_without_a_jerk_limit(limits: tuple[float, float, float]):
    velocity, acceleration, jerk = limits
    law = by_ruckig(lambda v, a, j: fastest_profile(1.0, v, a))
    agree(law(velocity, acceleration, jerk), fastest_profile(1.0, velocity, acceleration))


@given(limits=limits, speed=st.floats(0.05, 1.0))
def test_a_slowed_law_covers_the_same_way_in_the_inverse_share_of_the_time(
    limits: tuple[float, float, float], speed: float
):
    for law in (ruckig_profile(*limits), fastest_profile(1.0, *limits), fastest_profile(1.0, *limits[:2])):
        slow = law.slowed(speed)
        t = np.linspace(0.0, law.duration, 51)
        assert np.allclose(slow.at(t / speed)[0], law.at(t)[0], atol=1e-9)
        assert np.allclose(slow.at(t / speed)[1], law.at(t)[1] * speed, atol=1e-6 * law.peak_velocity)
        assert abs(slow.peak_velocity - law.peak_velocity * speed) < 1e-9 * law.peak_velocity
