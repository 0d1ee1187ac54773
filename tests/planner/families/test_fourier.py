"""Fourier excitations: at rest after every period, linear in their unknowns; order 1 led in and out; a free period."""

from dataclasses import replace

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import box_middle, reference_scaling
from identification.model.model import identification_model
from identification.motion.curves import FourierMotion
from planner.families.fourier import DENSITY, FourierFamily, FreePeriod, resting_basis
from planner.families.settings import Fourier
from planner.families.states import SHARE
from planner.noise import mean_information
from planner.plans.folder import motion_entries, motion_of_entries
from planner.plans.rating import fourier_notes, needless_harmonics
from planner.request import Request
from planner.search.feasibility import keep_limits
from tests.helpers import HOME, taylor_slope, tells

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
    assert np.allclose(at_rest.coordinates, at_rest.coordinates[0], atol=1e-13)


@pytest.mark.parametrize("order", ORDERS)
def test_resting_takes_two_unknowns_of_each_coordinate_and_no_more(order: int):
    basis = resting_basis(order)
    assert basis.shape == (2 * order + 1, 2 * order - 1)
    assert np.allclose(basis.T @ basis, np.eye(2 * order - 1))


def test_a_single_harmonic_cannot_rest():
    """Sin and cos together have no common zero of rate and acceleration: only a constant is left. It is led in."""
    assert np.allclose(np.abs(resting_basis(1)[:, 0]), [1.0, 0.0, 0.0])


def led_family(order: int = 1, centred: bool = False) -> FourierFamily:
    return replace(FourierFamily.lasting(1, 3.0, 4, HOME, HALF, centred), order=order)


@pytest.mark.parametrize("centred", [False, True])
def test_order_1_is_led_out_of_rest_and_back_within_the_same_duration(centred: bool):
    some = led_family(centred=centred)
    motion = some.motion(np.random.default_rng(1).normal(size=some.unknowns * 6))
    assert (motion.duration, motion.run_in, motion.repeats) == (12.0, 1.5, 3)
    ends, circle = motion.at([0.0, 12.0]), motion.at(np.linspace(1.5, 10.5, 300))
    assert np.abs(ends.rates).max() < 1e-12
    assert np.abs(ends.accelerations).max() < 1e-10
    assert ends.coordinates == pytest.approx(np.array([motion.centre, motion.centre]), abs=1e-12)
    w = 2 * np.pi / 3.0
    assert circle.accelerations == pytest.approx(
        -(w**2) * (circle.coordinates - motion.centre), abs=1e-12
    )  # one harmonic


@pytest.mark.parametrize("order", [1, 2, 5])
def test_centred_series_turn_about_the_middle_of_the_box(order: int):
    some = FourierFamily.lasting(order, 3.0, 2, HOME, HALF, centred=True)
    motion = some.motion(np.random.default_rng(order).normal(size=some.unknowns * 6))
    assert motion.centre == pytest.approx(HOME)
    series = motion.at(motion.run_in + np.arange(1000) * 3.0 / 1000)
    assert series.coordinates.mean(axis=0) == pytest.approx(HOME, abs=1e-12)
    assert np.abs(motion.at([0.0]).rates).max() < 1e-12


def test_a_saved_run_in_comes_back_and_a_damaged_one_is_named():
    motion = led_family().motion(np.random.default_rng(6).normal(size=18))
    entries = motion_entries(motion)
    again, t = motion_of_entries(entries), np.linspace(0.0, 12.0, 50)
    assert again.duration == motion.duration
    assert np.array_equal(again.at(t).coordinates, motion.at(t).coordinates)
    with pytest.raises(ValueError, match="run_in_s"):
        motion_of_entries({"fourier": entries["fourier"] | {"run_in_s": -1.0}})


@pytest.mark.parametrize("t", [1.5, 10.5])
def test_pose_rates_and_accelerations_pass_from_run_in_to_series_and_out_without_a_step(t: float):
    motion = led_family().motion(np.random.default_rng(2).normal(size=18))
    before, after = motion.at([t - 1e-9]), motion.at([t + 1e-9])
    for name in ("coordinates", "rates", "accelerations"):
        assert getattr(before, name) == pytest.approx(getattr(after, name), abs=1e-6), name


@pytest.mark.parametrize("name", ["rates", "accelerations", "jerks"])
@pytest.mark.parametrize("t", [0.7, 11.3])
def test_each_derivative_of_run_in_and_run_out_is_that_of_the_one_before(name: str, t: float):
    motion = led_family(3).motion(np.random.default_rng(3).normal(size=42))
    before = {"rates": "coordinates", "accelerations": "rates", "jerks": "accelerations"}[name]
    derivative = getattr(motion.at([t]), name)
    assert taylor_slope(lambda t: getattr(motion.at([t]), before), t, derivative, 0.01) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("centred", [False, True])
def test_maps_of_order_1_give_on_the_grid_what_the_motion_is_there(centred: bool):
    some = led_family(1, centred)
    unknowns = np.random.default_rng(1).normal(size=some.unknowns * 6)
    motion = some.motion(unknowns).at(some.grid)
    table = unknowns.reshape(some.unknowns, 6)
    expected = (motion.coordinates - HOME, motion.rates, motion.accelerations, motion.jerks)
    for matrix, values in zip(some.limit_maps(), expected, strict=True):
        assert np.allclose(matrix @ table * HALF, values, rtol=1e-12, atol=1e-12 * np.abs(values).max())


def test_a_slower_pace_leads_in_as_much_more_slowly():
    motion = led_family().motion(np.random.default_rng(2).normal(size=18))
    slow, t = motion.slowed(0.5), np.linspace(0.0, 12.0, 40)
    assert slow.duration == pytest.approx(24.0)
    assert slow.at(2 * t).coordinates == pytest.approx(motion.at(t).coordinates, abs=1e-12)
    assert slow.at(2 * t).accelerations == pytest.approx(motion.at(t).accelerations / 4, abs=1e-10)


def free_family(order: int = 3, duration: float = 12.0) -> FourierFamily:
    return FourierFamily.lasting(order, 3.0, 4, HOME, HALF, free=FreePeriod(0.5, 6.0, duration))


@pytest.mark.parametrize("order", [1, 3])
@pytest.mark.parametrize("pace", [0.6, 1.0, 1.7])
def test_with_a_free_period_the_largest_whole_number_of_periods_fits(order: int, pace: float):
    some = free_family(order)
    motion = some.motion(np.append(np.full(some.unknowns * 6, 0.1), pace))
    assert motion.period == pytest.approx(3.0 / pace)
    assert motion.duration <= 12.0 + 1e-9 < motion.duration + motion.period
    assert np.abs(motion.at([0.0, motion.duration]).rates).max() < 1e-12
    found = some.found(np.append(np.full(some.unknowns * 6, 0.1), pace))
    assert found.period_s == motion.period
    assert found.repeats == motion.repeats
    assert some.once.motion(np.append(np.full(some.unknowns * 6, 0.1), pace)).repeats == 1


@pytest.mark.parametrize("order", [1, 3])
def test_states_and_rows_of_a_free_period_are_those_of_the_motion_at_equal_phases(order: int, hexapod_case: Case):
    some, draw = free_family(order), np.random.default_rng(5)
    unknowns = np.append(0.1 * draw.normal(size=some.unknowns * 6), 1.3)
    layout, box = some.layout(hexapod_case, 0.0), hexapod_case.limits.motion
    series = some.grid[(some.grid >= some.run_in) & (some.grid < some.run_in + 3.0)]
    at = some.motion(unknowns).at(series / 1.3)
    places = np.isin(some.grid, series)
    states = layout.critical.at(unknowns)[0][places]
    assert states[:, :18] == pytest.approx(np.hstack([at.coordinates, at.rates, at.accelerations]), abs=1e-10)
    shares = np.hstack([(at.coordinates - HOME) / HALF, at.rates / box.rate, at.accelerations / box.acceleration])
    values = layout.rows[0].all_values(unknowns).reshape(-1, len(some.grid), 6)[:, places]
    assert np.hstack(list(values[1:3])) == pytest.approx(shares[:, 6:], abs=1e-10)
    assert values[3] == pytest.approx(at.jerks / box.jerk, abs=1e-10)


def test_a_shrunk_motion_of_a_free_period_keeps_its_period():
    some = free_family()
    unknowns = np.append(np.full(30, 0.2), 1.3)
    whole, half = (some.motion(some.shrunk(unknowns, share)) for share in (1.0, 0.5))
    assert half.period == whole.period
    assert half.at([1.0]).rates == pytest.approx(whole.at([1.0]).rates / 2)


@pytest.mark.first(1)
@pytest.mark.parametrize("lower", [2, 3])
def test_harmonics_that_are_not_there_are_needless(lower: int, hexapod_case: Case):
    """A series of a low order, written with more coefficients, that are zero or as good as that."""
    model = identification_model(hexapod_case, 5)
    low = FourierFamily(lower, 3.0, 2, *box_middle(hexapod_case))
    draw = np.random.default_rng(lower)
    motion = low.motion(keep_limits(hexapod_case, low, 0.4 * draw.normal(size=low.unknowns * 6), 500.0)[0])
    more = 1e-6 * draw.normal(size=(2, 2, 6))
    written = replace(motion, a=np.vstack([motion.a, more[0]]), b=np.vstack([motion.b, more[1]]))
    scaling = reference_scaling(hexapod_case, model)
    logdet = np.linalg.slogdet(mean_information(model, scaling, written))[1]
    order, loss = needless_harmonics(hexapod_case, model, written, logdet)
    assert order == lower
    assert loss < 0.002
    (note,) = fourier_notes(hexapod_case, model, Request(Fourier(lower + 2, 3.0), 6.0), written, logdet)
    assert tells(note, f"above {lower}", f"order {lower}")


@pytest.mark.parametrize("some", [family(4), led_family()])
def test_the_weighted_mean_over_the_grid_is_the_time_average(some: FourierFamily, hexapod_case: Case):
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
    before = {"rates": "coordinates", "accelerations": "rates", "jerks": "accelerations"}[name]
    derivative = getattr(motion.at([1.234]), name)
    assert taylor_slope(lambda t: getattr(motion.at([t]), before), 1.234, derivative, 0.01) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("order", ORDERS)
def test_maps_give_on_the_grid_what_the_motion_is_there(order: int):
    some = family(order)
    unknowns = np.random.default_rng(order).normal(size=some.unknowns * 6)
    motion = some.motion(unknowns).at(some.grid)
    table = unknowns.reshape(some.unknowns, 6)
    expected = (motion.coordinates - HOME, motion.rates, motion.accelerations, motion.jerks)
    for matrix, values in zip(some.limit_maps(), expected, strict=True):
        assert np.allclose(matrix @ table * HALF, values, rtol=1e-12, atol=1e-12 * np.abs(values).max())


def test_the_grid_covers_one_period_evenly_with_its_density_for_the_highest_harmonic():
    grid = family(5).grid
    assert len(grid) == 5 * DENSITY
    assert np.allclose(np.diff(np.r_[grid, 3.0]), 3.0 / (5 * DENSITY))


def test_repeats_make_it_longer_and_nothing_else():
    once, thrice = (family(3, 2.0, n).motion(np.ones(30)) for n in (1, 3))
    assert (once.duration, thrice.duration) == (2.0, 6.0)
    assert np.allclose(thrice.at([4.7]).coordinates, once.at([0.7]).coordinates)
