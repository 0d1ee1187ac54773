"""Motions from rest to rest, and closed ones, keep every moment constraint; their Lagrangian's mean is at most 0."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from cases.schema import load_case
from identification.criteria import reference_scaling
from identification.model import identification_model
from identification.motion import Joined, Motion
from identification.trajectories.moves import CircularMove, Plane, StraightMove, fastest_profile
from planner.bounds.features import box_features, lagrangian, mean_square_share, monomials, motion_moments

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
FEATURES = box_features(CASE, MODEL, reference_scaling(CASE, MODEL))
EQUAL, AT_MOST = MOMENTS = motion_moments(CASE, FEATURES)
BOX = CASE.limits.motion
HOME = CASE.machine.home.vector


def shares_of(motion: Motion) -> np.ndarray:
    states = np.hstack([motion.pose, motion.rates, motion.accelerations])
    return (states - FEATURES.middle) / FEATURES.half


def random_moves(seed: int) -> Motion:
    """Straight moves at the limits of velocity, acceleration and jerk, not back to where they began."""
    draw = np.random.default_rng(seed)
    poses = HOME + draw.uniform(BOX.pose[0], BOX.pose[1], (draw.integers(2, 9), 6)) * draw.uniform(0.05, 1.0)
    ways = pairwise(poses)
    path = Joined(tuple(StraightMove.fastest(a, b, BOX.rate, BOX.acceleration, BOX.jerk) for a, b in ways))
    count = 40_000
    return path.at((np.arange(count) + 0.5) * path.duration / count)


def random_spline(seed: int) -> Motion:
    """A periodic quartic spline, stretched in time until every derivative keeps its limit."""
    draw = np.random.default_rng(seed)
    knots = int(draw.integers(6, 20))
    values = draw.uniform(-1.0, 1.0, (knots, 6)) * FEATURES.half[:6] * 0.9
    spline = BSpline(np.arange(-4.0, knots + 5.0), np.vstack([values, values[:4]]), 4, extrapolate="periodic")
    phase = (np.arange(40_000) + 0.5) * knots / 40_000
    return at_the_limits(phase, [spline(phase, nu=order) for order in range(4)])


def random_fourier(seed: int) -> Motion:
    """A Fourier series of order 1 to 7, likewise."""
    draw = np.random.default_rng(seed)
    order = int(draw.integers(1, 8))
    phase = (np.arange(40_000) + 0.5) * 2 * np.pi / 40_000
    a, b = draw.normal(size=(2, order, 6)) / order
    harmonics = np.arange(1, order + 1)
    angle = phase[:, None] * harmonics
    derivatives = [
        (np.cos(angle + k * np.pi / 2) * harmonics**k) @ a + (np.sin(angle + k * np.pi / 2) * harmonics**k) @ b
        for k in range(4)
    ]
    shrink = 0.95 * FEATURES.half[:6] / np.abs(derivatives[0]).max(axis=0)
    return at_the_limits(phase, [d * shrink for d in derivatives])


def random_circles(seed: int) -> Motion:
    """A full circle in each coordinate plane under seven segments, one after the other, as hand-made motions have."""
    draw = np.random.default_rng(seed)
    parts = []
    for plane in Plane:
        first, second, _ = plane.axes
        radius = draw.uniform(0.02, 0.05)
        heading = draw.uniform(0.0, 2 * np.pi)
        centre = HOME[[first, second]] + radius * np.array([np.cos(heading), np.sin(heading)])
        way = 2 * np.pi * radius
        law = fastest_profile(1.0, 0.3 / way, 2.0 / way, 20.0 / way)
        parts.append(CircularMove(HOME, HOME[3:], plane, centre, 2 * np.pi, law))
    path = Joined(tuple(parts))
    motion = path.at((np.arange(40_000) + 0.5) * path.duration / 40_000)
    for values, limit in ((motion.rates, BOX.rate), (motion.accelerations, BOX.acceleration), (motion.jerks, BOX.jerk)):
        assert np.all(np.abs(values) <= limit)
    return motion


def at_the_limits(phase: np.ndarray, derivatives: list[np.ndarray]) -> Motion:
    """The motion at the pace at which the first limit of rates, accelerations or jerks binds."""
    limits = (BOX.rate, BOX.acceleration, BOX.jerk)
    pace = min(
        float((limit / np.abs(d).max(axis=0)).min()) ** (1.0 / order)
        for order, (d, limit) in enumerate(zip(derivatives[1:], limits, strict=True), start=1)
    )
    t = phase / pace
    return Motion(t, FEATURES.middle[:6] + derivatives[0], *(d * pace**k for k, d in enumerate(derivatives[1:], 1)))


def lagrangian_means(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    means = monomials(shares_of(motion)).mean(axis=0)
    return EQUAL @ means, AT_MOST @ means


FAMILIES = [random_moves, random_spline, random_fourier, random_circles]


@given(seed=st.integers(0, 2**32 - 1), make=st.sampled_from(FAMILIES))
@settings(max_examples=10, derandomize=True, deadline=None)
def test_every_motion_keeps_the_constraints(seed: int, make):
    equal, at_most = lagrangian_means(make(seed))
    assert np.abs(equal).max() < 2e-4
    assert at_most.max() < 2e-4


def test_a_motion_that_ends_while_it_moves_breaks_them():
    """Otherwise the test above could not fail."""
    motion = random_moves(1)
    half = len(motion.t) // 3
    equal, _ = lagrangian_means(Motion(*(v[:half] for v in (motion.t, motion.pose, motion.rates, motion.accelerations,
                                                            motion.jerks))))  # fmt: skip
    assert np.abs(equal).max() > 1e-2


def test_rates_of_change_hold_for_each_ordered_pair_by_itself():
    """The identities that the constraints are made of, on one motion, odd ones included."""
    motion = random_spline(7)
    q, v, a = motion.pose - FEATURES.middle[:6], motion.rates, motion.accelerations
    n = len(q)
    size = np.abs(q).max(axis=0)[:, None] * np.abs(a).max(axis=0)
    assert np.abs(v.mean(axis=0) / np.abs(v).max(axis=0)).max() < 1e-4
    assert np.abs((v.T @ v + q.T @ a) / n / size).max() < 1e-4
    assert np.abs((q.T @ v + v.T @ q) / n / (np.abs(q).max(axis=0)[:, None] * np.abs(v).max(axis=0))).max() < 1e-4
    assert np.abs((v.T @ a + a.T @ v) / n / (np.abs(v).max(axis=0)[:, None] * np.abs(a).max(axis=0))).max() < 1e-4


@given(st.floats(0.1, 2.0), st.floats(1.0, 20.0), st.floats(5.0, 500.0))
@settings(max_examples=20, derandomize=True, deadline=None)
def test_the_largest_mean_square_is_that_of_full_speed_back_and_forth(v: float, a: float, j: float):
    """From -V to V and back at full jerk and acceleration: the bound is reached, in both cases of c."""
    peak = min(a, np.sqrt(2.0 * v * j))  # trapezoid or triangle whose area is 2 V
    rise = peak / j
    hold = 2.0 * v / peak - rise
    t = np.linspace(0.0, 2 * rise + hold, 20_001)
    course = np.minimum(np.minimum(j * t, peak), j * (t[-1] - t))
    assert np.trapezoid(course, t) == pytest.approx(2.0 * v, rel=1e-3)
    share = float(mean_square_share(*(np.array([x]) for x in (v, a, j)))[0])
    assert np.trapezoid(course**2, t) / t[-1] == pytest.approx(share * a**2, rel=1e-3)


def test_both_cases_agree_where_they_meet():
    v, a = 0.5, 5.0
    j = a**2 / (2.0 * v)  # h = 0
    below, above = (mean_square_share(*(np.array([x]) for x in (v, a, j * f)))[0] for f in (1 - 1e-9, 1 + 1e-9))
    assert below == pytest.approx(above, rel=1e-6)
    assert mean_square_share(BOX.rate, BOX.acceleration, BOX.jerk) == pytest.approx([0.692] * 3 + [0.743] * 3, abs=1e-3)


def test_multipliers_add_up_to_the_constraints_they_come_from():
    draw = np.random.default_rng(0)
    of_equal, of_at_most = draw.normal(size=len(EQUAL)), draw.uniform(0.0, 1.0, len(AT_MOST))
    rows = monomials(draw.uniform(-1.0, 1.0, (20, 18)))
    expected = rows @ EQUAL.T @ of_equal + rows @ AT_MOST.T @ of_at_most
    assert np.allclose(rows @ lagrangian(MOMENTS, of_equal, of_at_most), expected)
    second = lagrangian(MOMENTS, of_equal, -of_at_most)  # of inequalities negative ones do not count
    assert np.allclose(rows @ second, rows @ EQUAL.T @ of_equal)
