"""Fourier series through samples: a projection, analytic derivatives, the energy and the noise that pass."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from identification.runs.fourier_series import FourierSeries, fit_series, refined_period

STEP = 1e-3


def truth(period: float, harmonics: int = 6, seed: int = 0) -> FourierSeries:
    return FourierSeries(np.random.default_rng(seed).normal(size=(2 * harmonics + 1, 3)), period, 0.17)


def instants(period: float, periods: int) -> np.ndarray:
    """As many samples as fit, whether or not a period is a whole number of them."""
    return 0.05 + np.arange(round(periods * period / STEP)) * STEP


@given(period=st.floats(0.5, 3.0), periods=st.integers(1, 4), order=st.integers(0, 3))
def test_a_series_is_found_again_with_its_derivatives(period: float, periods: int, order: int) -> None:
    known, t = truth(period), instants(period, periods)
    found = fit_series(t, known.at(t), period, 0.3, 9)
    between = np.linspace(t[0], t[-1], 77)
    np.testing.assert_allclose(
        found.at(between, order), known.at(between, order), atol=1e-9 * (6 * known.omega) ** order * 10
    )


@given(order=st.integers(0, 2), seed=st.integers(0, 100))
def test_each_derivative_is_the_slope_of_the_one_before(order: int, seed: int) -> None:
    series, t, h = truth(2.0, seed=seed), np.linspace(0.0, 2.0, 50), 1e-5
    slope = (series.at(t + h, order) - series.at(t - h, order)) / (2 * h)
    scale = np.abs(series.at(t, order + 1)).max()
    np.testing.assert_allclose(slope, series.at(t, order + 1), atol=1e-7 * scale)


def test_the_energy_of_a_period_is_that_of_its_harmonics() -> None:
    """Parseval."""
    series = truth(2.0)
    t = np.arange(2000) * STEP
    energy = series.coefficients[0] ** 2 + series.power.sum(axis=0) / 2
    np.testing.assert_allclose(np.mean(series.at(t) ** 2, axis=0), energy, rtol=1e-12)


def test_the_fit_is_the_discrete_fourier_transform_at_the_harmonics() -> None:
    values = np.random.default_rng(1).normal(size=(4 * 500, 2))
    t = np.arange(len(values)) * STEP
    series = fit_series(t, values, 0.5, 0.0, 20)
    lines = np.fft.rfft(values, axis=0)[4 : 4 * 21 : 4] * 2 / len(values)
    np.testing.assert_allclose(series.coefficients[1::2], lines.real, atol=1e-12)
    np.testing.assert_allclose(series.coefficients[2::2], -lines.imag, atol=1e-12)


@given(period=st.floats(0.3, 1.0), seed=st.integers(0, 20))
def test_what_has_passed_passes_unchanged_and_nothing_else_is_left_in_the_rest(period: float, seed: int) -> None:
    """A projection: orthogonal to what it leaves."""
    t = instants(period, 3)
    values = np.random.default_rng(seed).normal(size=(len(t), 2))
    series = fit_series(t, values, period, 0.0, 8)
    again = fit_series(t, series.at(t), period, 0.0, 8)
    np.testing.assert_allclose(again.coefficients, series.coefficients, atol=1e-11)
    np.testing.assert_allclose(fit_series(t, values - series.at(t), period, 0.0, 8).coefficients, 0.0, atol=1e-11)


def test_of_white_noise_as_much_passes_as_there_are_coefficients() -> None:
    t, draw = instants(1.0, 3), np.random.default_rng(0)
    passed = fit_series(t, draw.normal(size=(len(t), 400)), 1.0, 0.0, 10).at(t)
    assert passed.var() == pytest.approx(21 / len(t), rel=0.05)


def test_a_constant_moved_far_away_changes_the_constant_alone() -> None:
    t = instants(0.7, 2)
    values = np.random.default_rng(3).normal(size=(len(t), 1))
    near, far = (fit_series(t, values + offset, 0.7, 0.0, 5) for offset in (0.0, 1e6))
    np.testing.assert_allclose(far.coefficients[1:], near.coefficients[1:], atol=1e-9)


@given(period=st.floats(0.5, 2.0), off=st.floats(-8e-4, 8e-4), seed=st.integers(0, 20))
def test_the_period_is_found_from_half_a_sample_away(period: float, off: float, seed: int) -> None:
    known, t = truth(period, seed=seed), instants(period, 4)
    assert refined_period(t, known.at(t), period + off, 8) == pytest.approx(period, rel=1e-9)


@pytest.mark.slow
def test_noise_moves_the_period_by_what_the_information_says() -> None:
    """Cramer-Rao: the variance is that of the noise over the squared slope with the period, coefficients unknown."""
    known, t = truth(1.0), instants(1.0, 4)
    slope = -(t - t.mean())[:, None] * known.at(t, 1)
    bound = 0.1 / np.sqrt(np.sum(slope**2))
    draw = np.random.default_rng(0)
    found = [refined_period(t, known.at(t) + 0.1 * draw.normal(size=(len(t), 3)), 1.0, 6) for _ in range(40)]
    assert np.std(found) == pytest.approx(bound, rel=0.35)
    assert abs(np.mean(found) - 1.0) < 4 * bound / np.sqrt(40)


def test_fewer_samples_than_coefficients_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\b4 samples.*\b2 harmonics"):
        fit_series(np.arange(4.0), np.zeros((4, 1)), 4.0, 0.0, 2)
