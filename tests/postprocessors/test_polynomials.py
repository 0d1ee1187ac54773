"""POLY pieces: exact where the motion is made of polynomials, within a tolerance where not; two laws of time."""

import numpy as np
import pytest

from cases.base.errors import CaseError
from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Joined
from identification.motion.moves import StraightMove
from planner.families.fourier import FourierFamily
from postprocessors.blocks import (
    TimedPath,
    ToHome,
    even_deviation,
    knots,
    path_speed_deviation,
    pieces,
    timed_path,
)
from postprocessors.reading import Timed
from tests.helpers import polynomials_of
from tests.postprocessors.changed_case import changed
from tests.postprocessors.other_dialects import CASE, SINUMERIK, text_of
from tests.postprocessors.programs import HOME

TIGHT = (1e-9, 1e-9)
LIMITS = [0.9 * v for v in (CASE.limits.motion.rate, CASE.limits.motion.acceleration, CASE.limits.motion.jerk)]
FAR = HOME + np.r_[0.05, -0.03, 0.02, 0.1, -0.05, 0.1]


def spline(degree: int, seed: int = 0) -> PolynomialMotion:
    """A bump from rest to rest and back in every coordinate: t^2 (1-t)^2 (..), one polynomial, cut in the middle."""
    draw = np.random.default_rng(seed).normal(size=(degree - 3, 6)) * 0.02
    bump = np.array([0.0, 0.0, 1.0, -2.0, 1.0])
    whole = np.array([np.convolve(bump, draw[:, k]) for k in range(6)]).T
    whole[0] += HOME
    shifted = [np.polynomial.polynomial.polyval(0.5, _derivative(whole, k)) / _factorial(k) for k in range(len(whole))]
    return PolynomialMotion.of_pieces([(whole, 0.5), (np.array(shifted), 0.5)])


def _derivative(coefficients: np.ndarray, order: int) -> np.ndarray:
    for _ in range(order):
        coefficients = np.polynomial.polynomial.polyder(coefficients)
    return coefficients


def _factorial(k: int) -> float:
    return float(np.prod(np.arange(1, k + 1)))


@pytest.mark.parametrize("degree", [4, 5])
def test_polynomials_of_the_allowed_degree_are_met_exactly(degree: int):
    found = pieces(spline(degree), 5, 0.07, TIGHT)
    assert len(found.durations) == 16
    assert even_deviation(found, spline(degree))[0] < 1e-14


def test_seven_segment_moves_are_met_exactly_by_their_segments():
    limits = CASE.limits.motion
    move = StraightMove.fastest(HOME, HOME + 0.1, limits.rate, limits.acceleration, limits.jerk)
    back = StraightMove.fastest(HOME + 0.1, HOME, limits.rate, limits.acceleration, limits.jerk)
    both = Joined((move, back))
    assert len(knots(both)) == 2 * (len(knots(move)) - 1) + 1
    for degree in (3, 5):
        assert even_deviation(pieces(both, degree, 0.02, TIGHT), both)[0] < 1e-13


@pytest.mark.parametrize(("degree", "order"), [(3, 4), (5, 6)])
def test_other_motions_are_approached_with_the_order_of_hermite_interpolation(degree: int, order: int):
    motion = FourierFamily(3, 2.0, 1, HOME, np.full(6, 0.1)).motion(np.random.default_rng(1).normal(size=30) / 9)
    lengths = np.array([0.1, 0.05, 0.025])
    off = [even_deviation(pieces(motion, degree, h, (1.0, 1.0)), motion)[0] for h in lengths]
    slope = np.polyfit(np.log(lengths), np.log(off), 1)[0]
    assert slope == pytest.approx(order, abs=0.4)


def test_pieces_are_cut_until_the_tolerance_is_kept_or_it_is_said_that_none_keeps_it():
    motion = FourierFamily(3, 2.0, 1, HOME, np.full(6, 0.1)).motion(np.random.default_rng(1).normal(size=30) / 9)
    tolerance = (1e-6, 1e-5)
    found = pieces(motion, 3, 0.5, tolerance)
    assert len(found.durations) > 4
    off = even_deviation(found, motion)
    assert off[0] <= tolerance[0]
    assert off[1] <= tolerance[1]
    with pytest.raises(ValueError, match="degree 3 stay"):
        pieces(motion, 3, 2.0, (1e-16, 1e-16))


def test_at_constant_path_speed_a_quadratic_piece_is_a_quarter_of_its_way_off():
    """With x = L p^2 in time and L p at constant speed they differ most at p = 1/2, by L / 4."""
    way = np.zeros((3, 6))
    way[0], way[2, 0] = HOME, 0.02
    motion = PolynomialMotion.of_pieces([(way, 1.0)])
    found = pieces(motion, 5, 10.0, TIGHT)
    assert path_speed_deviation(found, motion)[0] == pytest.approx(0.02 / 4, rel=1e-3)
    assert even_deviation(found, motion)[0] < 1e-15


def test_shorter_blocks_leave_the_controllers_law_of_time_less_to_decide():
    """A quarter of the deviation for half the block: acceleration times the square of the duration."""
    motion = spline(5)
    off = [path_speed_deviation(pieces(motion, 5, h, TIGHT), motion)[0] for h in (0.05, 0.025, 0.0125)]
    assert off[0] / off[1] == pytest.approx(4, rel=0.3)
    assert off[1] / off[2] == pytest.approx(4, rel=0.3)


@pytest.mark.parametrize("degree", [4, 5])
def test_a_spline_passes_through_the_text_up_to_its_decimals(degree: int):
    motion = spline(degree)
    text = text_of(SINUMERIK, (ToHome(HOME, 0.05), timed_path("spline", motion, 0.01, 1.0)))
    read = next(s for s in SINUMERIK.read(text).stretches if isinstance(s, Timed))
    t = np.linspace(0.0, 1.0, 1001)
    found, exact = read.points.at(t), motion.at(t)
    assert np.abs(found.coordinates - exact.coordinates).max() < 6e-9
    assert np.abs(found.rates - exact.rates).max() < 1e-6
    assert np.abs(found.accelerations - exact.accelerations).max() < 1e-4
    assert "off the plan by" in text


def test_too_few_axes_or_too_tight_a_tolerance_name_the_key():
    path = TimedPath("walk", np.array([0.0, 1.0]), np.vstack([HOME, HOME + 0.01]), spline(7))
    program = (ToHome(HOME, 0.05), path)
    for key, value, words in (
        ("poly_axes", 5, r"controller\.sinumerik\.poly_axes: 5 cannot carry six coordinates; set path = 'lines'"),
        ("poly_tolerance_mm", 1e-15, r"controller\.sinumerik\.poly_tolerance_mm: is not reached: .*; loosen it"),
    ):
        with pytest.raises(CaseError, match=words):
            text_of(SINUMERIK, program, changed(CASE, **{f"controller__sinumerik__{key}": value}))


def test_moves_of_seven_segments_become_cubic_pieces_of_the_same_law():
    moves = [StraightMove.fastest(HOME, FAR, *LIMITS), StraightMove.fastest(FAR, HOME, *LIMITS)]
    t = np.linspace(0.0, sum(m.duration for m in moves), 3001)[1:-1] + 1e-6
    motion, exact = polynomials_of(moves).at(t), Joined(tuple(moves)).at(t)
    for name in ("coordinates", "rates", "accelerations", "jerks"):
        assert np.abs(getattr(motion, name) - getattr(exact, name)).max() < 1e-6 * np.abs(getattr(exact, name)).max()
