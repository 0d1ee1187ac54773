"""Fourier excitations: at rest after every period, linear in their unknowns, bounded by Bernstein's inequality."""

import numpy as np
import pytest

from cases.schema import Case
from identification.trajectories.curves import FourierMotion
from planner.families.fourier import DENSITY, FourierFamily, resting_basis
from planner.families.states import SHARE
from tests.helpers import HOME, taylor_slope

HALF = np.array([0.25, 0.25, 0.1, 0.35, 0.35, 0.35])
ORDERS = range(2, 8)


def family(order: int, period: float = 3.0, repeats: int = 2) -> FourierFamily:
    return FourierFamily(order, period, repeats, HOME, HALF)


def random_motion(order: int, seed: int = 0) -> FourierMotion:
    some = family(order)
    return some.motion(np.random.default_rng(seed).normal(size=some.unknowns * 6))


@pytest.mark.parametrize("order", ORDERS)
def test_it_rests_at_the_start_and_after_every_period(order: int):
    motion = random_motion(order)
    at_rest = motion.at([0.0, 3.0, 6.0])
    between = motion.at(np.linspace(0.0, 3.0, 100))
    assert np.abs(at_rest.rates).max() < 1e-12 * np.abs(between.rates).max()
    assert np.abs(at_rest.accelerations).max() < 1e-12 * np.abs(between.accelerations).max()
    assert np.allclose(at_rest.pose, at_rest.pose[0], atol=1e-13)


@pytest.mark.parametrize("order", ORDERS)
def test_resting_takes_two_unknowns_of_each_coordinate_and_no_more(order: int):
    basis = resting_basis(order)
    assert basis.shape == (2 * order + 1, 2 * order - 1)
    assert np.allclose(basis.T @ basis, np.eye(2 * order - 1))


def test_a_single_harmonic_cannot_rest():
    """Sin and cos together have no common zero of rate and acceleration: only a constant is left."""
    assert np.allclose(np.abs(resting_basis(1)[:, 0]), [1.0, 0.0, 0.0])


def test_the_weighted_mean_over_the_grid_is_the_time_average(hexapod_case: Case):
    some = family(4)
    motion = some.motion(np.random.default_rng(4).normal(size=some.unknowns * 6))
    fine = motion.at((np.arange(100_000) + 0.5) * motion.duration / 100_000)
    states = some.layout(hexapod_case, 0.0).states.at(np.random.default_rng(4).normal(size=some.unknowns * 6))[0]
    weights, rates = states[:, SHARE], states[:, 6:12]
    assert weights.sum() == pytest.approx(1.0)
    assert weights @ rates**2 == pytest.approx((fine.rates**2).mean(axis=0), rel=5e-3)


@pytest.mark.parametrize("name", ["rates", "accelerations", "jerks"])
@pytest.mark.parametrize("order", [2, 5, 7])
def test_each_derivative_is_the_derivative_of_the_one_before(name: str, order: int):
    motion = random_motion(order, seed=3)
    before = {"rates": "pose", "accelerations": "rates", "jerks": "accelerations"}[name]
    derivative = getattr(motion.at([1.234]), name)
    assert taylor_slope(lambda t: getattr(motion.at([t]), before), 1.234, derivative, 0.01) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("order", ORDERS)
def test_maps_give_on_the_grid_what_the_motion_is_there(order: int):
    some = family(order)
    unknowns = np.random.default_rng(order).normal(size=some.unknowns * 6)
    motion = some.motion(unknowns).at(some.grid)
    table = unknowns.reshape(some.unknowns, 6)
    expected = (motion.pose - HOME, motion.rates, motion.accelerations, motion.jerks)
    for matrix, values in zip(some.limit_maps(), expected, strict=True):
        assert np.allclose(matrix @ table * HALF, values, rtol=1e-12, atol=1e-12 * np.abs(values).max())


def test_the_grid_covers_one_period_evenly_with_its_density_for_the_highest_harmonic():
    grid = family(5).grid
    assert len(grid) == 5 * DENSITY
    assert np.allclose(np.diff(np.r_[grid, 3.0]), 3.0 / (5 * DENSITY))


def test_repeats_make_it_longer_and_nothing_else():
    once, thrice = (family(3, 2.0, n).motion(np.ones(30)) for n in (1, 3))
    assert (once.duration, thrice.duration) == (2.0, 6.0)
    assert np.allclose(thrice.at([4.7]).pose, once.at([0.7]).pose)
