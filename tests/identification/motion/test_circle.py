"""Arcs and polynomial pieces: their derivatives, where they end, what they keep."""

import numpy as np
import pytest

from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Trajectory
from identification.motion.moves import CircularMove, Plane, fastest_circle, fastest_profile

START = np.array([0.1, -0.05, 0.9, 0.05, -0.1, 0.2])
TURNED = np.array([0.1, 0.05, -0.1])
LIMITS = (np.full(6, 0.5), np.full(6, 4.0), np.full(6, 60.0))


def derivatives_agree(motion: Trajectory) -> None:
    """Each derivative is the central difference of the one before, away from the corners of the jerk."""
    h = 1e-6
    t = np.linspace(0.013, motion.duration - 0.013, 40)
    before, after, here = motion.at(t - h), motion.at(t + h), motion.at(t)
    for lower, upper in (("coordinates", "rates"), ("rates", "accelerations")):
        slope = (getattr(after, lower) - getattr(before, lower)) / (2 * h)
        assert np.allclose(slope, getattr(here, upper), atol=2e-4)
    slope = (after.accelerations - before.accelerations) / (2 * h)
    assert np.median(np.abs(slope - here.jerks)) < 1e-4


@pytest.mark.parametrize("plane", Plane)
@pytest.mark.parametrize("angle", [1.0, -2.5, 2 * np.pi, -2 * np.pi])
def test_an_arc_keeps_its_radius_and_its_plane_and_turns_as_far_as_asked(plane: Plane, angle: float):
    first, second, normal = plane.axes
    centre = START[[first, second]] + [0.03, -0.04]
    move = CircularMove(START, TURNED, plane, centre, angle, fastest_profile(1.0, 1.0, 4.0, 30.0))
    derivatives_agree(move)
    t = np.linspace(0.0, move.duration, 400)
    pose = move.at(t).coordinates
    arm = pose[:, [first, second]] - centre
    assert np.allclose(np.linalg.norm(arm, axis=1), 0.05)
    assert np.allclose(pose[:, normal], START[normal])
    swept = np.unwrap(np.arctan2(arm[:, 1], arm[:, 0]))
    assert swept[-1] - swept[0] == pytest.approx(angle)
    assert np.allclose(pose[-1], move.end, atol=1e-12)
    assert np.allclose(pose[-1, 3:], TURNED)
    assert move.length == pytest.approx(0.05 * abs(angle))


def test_counter_clockwise_is_seen_from_the_positive_end_of_the_normal():
    """From the first axis towards the second, and the three axes are right-handed."""
    for plane in Plane:
        first, second, normal = plane.axes
        assert np.allclose(np.cross(np.eye(3)[first], np.eye(3)[second]), np.eye(3)[normal])


@pytest.mark.parametrize("plane", Plane)
def test_the_fast_circle_uses_a_limit_fully_and_passes_none(plane: Plane):
    first, second, _ = plane.axes
    move = fastest_circle(START, plane, START[[first, second]] + [0.08, 0.0], 2 * np.pi, *LIMITS)
    motion = move.at(np.linspace(0.0, move.duration, 9000))
    pairs = zip((motion.rates, motion.accelerations, motion.jerks), LIMITS, strict=True)
    used = [float(np.max(np.abs(values) / limit)) for values, limit in pairs]
    assert 0.98 < max(used) <= 1.0 + 1e-3


def test_an_arc_without_radius_or_angle_or_of_more_than_a_circle_is_none():
    profile = fastest_profile(1.0, 1.0, 4.0, 30.0)
    for centre, angle in (([0.1, -0.05], 1.0), ([0.2, 0.0], 0.0), ([0.2, 0.0], 7.0)):
        with pytest.raises(ValueError, match="an arc"):
            CircularMove(START, TURNED, Plane.XY, np.array(centre), angle, profile)


def two_pieces() -> PolynomialMotion:
    """A quintic from rest to rest, cut in two."""
    whole = np.zeros((6, 6))
    whole[0] = START
    whole[3:, :] = np.array([10.0, -15.0, 6.0])[:, None] * np.linspace(-0.1, 0.1, 6)
    shifted = np.array([np.polynomial.Polynomial(c)(np.polynomial.Polynomial([0.4, 1.0])).coef for c in whole.T]).T
    return PolynomialMotion.of_pieces([(whole, 0.4), (shifted, 0.6)])


def test_pieces_join_without_a_jump_and_end_at_rest():
    motion = two_pieces()
    derivatives_agree(motion)
    edge = motion.at([0.4 - 1e-9, 0.4 + 1e-9])
    assert np.abs(np.diff(edge.accelerations, axis=0)).max() < 1e-6
    last = motion.at([1.0])
    assert np.allclose(last.coordinates, START + np.linspace(-0.1, 0.1, 6))
    assert np.allclose(last.rates, 0.0, atol=1e-12)


def test_a_slowed_spline_takes_the_same_path():
    fast, slow = two_pieces(), two_pieces().slowed(0.1)
    t = np.linspace(0.0, 1.0, 33)
    assert slow.duration == pytest.approx(10.0)
    assert np.allclose(fast.at(t).coordinates, slow.at(10 * t).coordinates, atol=1e-12)
    assert np.allclose(fast.at(t).jerks, 1000 * slow.at(10 * t).jerks, atol=1e-9)


def test_pieces_with_a_gap_between_them_are_no_motion():
    pieces = two_pieces()
    with pytest.raises(ValueError, match="does not begin where"):
        PolynomialMotion(pieces.table[:, ::-1], pieces.durations[::-1])
