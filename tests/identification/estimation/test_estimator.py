"""Gauss-Markov estimation, (23)-(28): exact where it can be, honest where it cannot."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from cases.base.errors import IdentificationError
from identification.estimation.fit import Regression, gauss_markov
from tests.helpers import one_line

DRAW = np.random.default_rng(0)
A = DRAW.normal(size=(40, 6, 5))
U = np.array([31.8, 0.1, -3.3, 1.2, 300.0])
NAMES = ["m", "mxC", "myC", "mzC", "k0"]
NOISE = DRAW.normal(size=(40, 6))
ONES = np.ones(6)


def test_data_without_noise_give_the_parameters_exactly() -> None:
    fit = gauss_markov(Regression(A, A @ U, NAMES), ONES)
    np.testing.assert_allclose(fit.values, U, rtol=1e-12)
    assert fit.white_noise < 1e-11
    assert (fit.rank, fit.residuals.shape) == (5, (40, 6))


def test_estimate_and_covariance_are_those_of_the_normal_equations() -> None:
    """(24), (27), (28) literally, with a W that is not 1."""
    w = np.array([1.0, 2.0, 0.5, 1.0, 4.0, 0.1])
    forces, matrix, weight = A @ U + NOISE, A.reshape(-1, 5), np.diag(np.tile(w, 40))
    information = matrix.T @ weight @ matrix
    values = np.linalg.solve(information, matrix.T @ weight @ forces.ravel())
    residuals = forces.ravel() - matrix @ values
    s0 = np.sqrt(residuals @ weight @ residuals / (240 - 5))
    fit = gauss_markov(Regression(A, forces, NAMES), w)
    np.testing.assert_allclose(fit.values, values, rtol=1e-10)
    assert fit.white_noise == pytest.approx(s0)
    np.testing.assert_allclose(fit.covariance, s0**2 * np.linalg.inv(information), rtol=1e-10, atol=1e-16)


def test_equal_weights_give_ordinary_least_squares() -> None:
    forces = A @ U + NOISE
    expected = np.linalg.lstsq(A.reshape(-1, 5), forces.ravel())[0]
    np.testing.assert_allclose(
        gauss_markov(Regression(A, forces, NAMES), ONES).values, expected, rtol=1e-11, atol=1e-11
    )


@given(exponents=st.lists(st.integers(-6, 6), min_size=5, max_size=5))
def test_units_of_the_parameters_change_their_numbers_and_nothing_else(exponents: list[int]) -> None:
    unit, forces = 10.0 ** np.array(exponents), A @ U + NOISE
    plain, scaled = (
        gauss_markov(Regression(A, forces, NAMES), ONES),
        gauss_markov(Regression(A * unit, forces, NAMES), ONES),
    )
    np.testing.assert_allclose(scaled.values * unit, plain.values, rtol=1e-9)
    np.testing.assert_allclose(scaled.covariance * np.outer(unit, unit), plain.covariance, rtol=1e-8, atol=1e-18)
    assert scaled.condition == pytest.approx(plain.condition)  # (26) makes it independent of units


@given(factor=st.floats(1e-3, 1e3))
def test_a_common_factor_of_the_weights_changes_no_estimate(factor: float) -> None:
    forces = A @ U + NOISE
    plain, weighted = (
        gauss_markov(Regression(A, forces, NAMES), ONES),
        gauss_markov(Regression(A, forces, NAMES), factor * ONES),
    )
    np.testing.assert_allclose(weighted.values, plain.values, rtol=1e-10)
    np.testing.assert_allclose(weighted.covariance, plain.covariance, rtol=1e-9, atol=1e-18)
    assert weighted.white_noise == pytest.approx(np.sqrt(factor) * plain.white_noise)


def test_residuals_are_orthogonal_to_the_regressor() -> None:
    fit = gauss_markov(Regression(A, A @ U + NOISE, NAMES), ONES)
    np.testing.assert_allclose(A.reshape(-1, 5).T @ fit.residuals.ravel(), 0.0, atol=1e-10)


def test_more_data_of_the_same_kind_shrink_standard_deviations_with_the_root() -> None:
    once, fourfold = (
        gauss_markov(Regression(np.tile(A, (k, 1, 1)), np.tile(A @ U + NOISE, (k, 1)), NAMES), ONES) for k in (1, 4)
    )
    ratio = np.sqrt(np.diag(once.covariance) / np.diag(fourfold.covariance))
    np.testing.assert_allclose(ratio, 2.0, rtol=0.02)  # (27) counts the unknowns once in 240 and once in 960


@pytest.mark.parametrize("nothing", range(5))
def test_a_parameter_that_nothing_excites_is_named(nothing: int) -> None:
    silent = A * (np.arange(5) != nothing)
    with pytest.raises(IdentificationError, match=rf"rank 4 of 5: {NAMES[nothing]}\b") as caught:
        gauss_markov(Regression(silent, A @ U, NAMES), ONES)
    one_line(caught.value)


def test_parameters_that_only_act_together_are_named_together() -> None:
    twins = A.copy()
    twins[:, :, 4] = -2.0 * A[:, :, 1]
    with pytest.raises(IdentificationError, match=r"rank 4 of 5: mxC, k0\b"):
        gauss_markov(Regression(twins, A @ U, NAMES), ONES)


@pytest.mark.parametrize(("samples", "enough"), [(1, False), (2, True)])
def test_fewer_forces_than_unknowns_are_refused(samples: int, enough: bool) -> None:
    six = np.random.default_rng(1).normal(size=(samples, 6, 6))
    names = [*NAMES, "k1"]
    if enough:
        gauss_markov(Regression(six, np.ones((samples, 6)), names), ONES)
        return
    with pytest.raises(IdentificationError, match=r"\b1 samples .*6 forces .*6 unknowns; record more") as caught:
        gauss_markov(Regression(six, np.ones((samples, 6)), names), ONES)
    one_line(caught.value)


def test_a_nuisance_is_estimated_and_costs_certainty_but_is_not_counted() -> None:
    plain = gauss_markov(Regression(A[:, :, :4], A @ U + NOISE, NAMES[:4]), ONES)
    with_nuisance = gauss_markov(Regression(A, A @ U + NOISE, NAMES, 1), ONES)
    assert (with_nuisance.rank, len(with_nuisance.values)) == (4, 5)
    assert with_nuisance.condition == pytest.approx(plain.condition)
    inverse, plain_inverse = (
        with_nuisance.covariance / with_nuisance.white_noise**2,
        plain.covariance / plain.white_noise**2,
    )
    assert np.all(np.diag(inverse)[:4] > np.diag(plain_inverse))


def test_a_nuisance_that_nothing_excites_is_an_error_in_words() -> None:
    """A delay shows nowhere when the forces do not change: all force channels dead, for example."""
    silent = np.dstack([A, np.zeros((40, 6))])
    with pytest.raises(IdentificationError, match="delay") as caught:
        gauss_markov(Regression(silent, np.zeros((40, 6)), [*NAMES, "delay"], 1), ONES)
    one_line(caught.value)


def test_white_noise_gives_errors_as_large_as_predicted() -> None:
    """Over 200 noises (u - u_hat)^T M^-1 (u - u_hat) / 5 follows Fisher's distribution, and s0^2 chi-square."""
    draw, distance, variance = np.random.default_rng(2), [], []
    for _ in range(200):
        fit = gauss_markov(Regression(A, A @ U + 0.7 * draw.normal(size=(40, 6)), NAMES), ONES)
        error = fit.values - U
        distance.append(error @ np.linalg.solve(fit.covariance, error) / 5)
        variance.append((fit.white_noise / 0.7) ** 2 * 235)
    assert stats.kstest(distance, stats.f(5, 235).cdf).pvalue > 0.01
    assert stats.kstest(variance, stats.chi2(235).cdf).pvalue > 0.01
