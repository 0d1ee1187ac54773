"""Huber's estimate, from which the search for contacts begins: good on clean data, hardly moved by gross errors."""

import numpy as np
import pytest

from identification.estimation.estimators import EACH, huber
from identification.estimation.fit import Regression, gauss_markov
from tests.identification.moving_run import NAMES, ONES, A, U, forces

Array = np.ndarray
PRECISION = np.linalg.inv(gauss_markov(Regression(A, forces(0), NAMES), ONES).covariance)
UNITS = np.array([1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3])


def with_gross_errors(seed: int, share: float = 0.05) -> Array:
    """One force in twenty wrong by 20 to 200 standard deviations, either way."""
    draw, clean = np.random.default_rng(1000 + seed), forces(seed)
    wrong = draw.random(clean.shape) < share
    return clean + wrong * draw.choice([-1, 1], clean.shape) * draw.uniform(20.0, 200.0, clean.shape)


def distance(values: Array) -> float:
    """(u - truth)^T F (u - truth) / s0^2: 20 on average for the best estimate from clean data."""
    return float((values - U) @ PRECISION @ (values - U))


@pytest.mark.slow
def test_of_clean_data_it_wastes_5_percent() -> None:
    """Efficiency 0.95 within what 100 runs can show."""
    pairs = [
        (huber(Regression(A, forces(s), NAMES)), gauss_markov(Regression(A, forces(s), NAMES), ONES).values)
        for s in range(100)
    ]
    assert 0.92 < sum(distance(g) for _, g in pairs) / sum(distance(h) for h, _ in pairs) < 0.98


@pytest.mark.parametrize("pooled", [True, False])
def test_gross_errors_of_5_percent_do_little_to_it_and_ruin_least_squares(pooled: bool) -> None:
    runs = [Regression(A, with_gross_errors(s), NAMES, alike=None if pooled else EACH) for s in range(10)]
    assert np.mean([distance(huber(r)) for r in runs]) < 2.0 * 20
    assert np.mean([distance(gauss_markov(r, ONES).values) for r in runs]) > 200 * 20


def test_it_solves_hubers_equations() -> None:
    """Sum psi(r / s) a / s = 0 at the scale of the residuals themselves."""
    measured = with_gross_errors(3)
    residuals = measured - A @ huber(Regression(A, measured, NAMES, alike=EACH))
    mad = 1.482602218505602 * np.median(np.abs(residuals), axis=0)
    psi = np.clip(residuals / mad, -1.345, 1.345)
    parts = A * (psi / mad)[:, :, None]
    np.testing.assert_allclose(parts.sum(axis=(0, 1)) / np.abs(parts).sum(axis=(0, 1)), 0.0, atol=1e-7)


def test_units_of_channels_do_not_matter_where_each_has_its_scale() -> None:
    plain = huber(Regression(A, forces(0), NAMES, alike=EACH))
    scaled = huber(Regression(A * UNITS[:, None], forces(0) * UNITS, NAMES, alike=EACH))
    np.testing.assert_allclose(scaled, plain, rtol=1e-5, atol=1e-7)


def test_it_meets_exact_data_exactly() -> None:
    np.testing.assert_allclose(huber(Regression(A, A @ U, NAMES)), U, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("reading", [0.0, 5.0])
def test_a_stuck_channel_does_no_harm(reading: float) -> None:
    matrices = np.dstack([np.random.default_rng(1).normal(size=(200, 6, 4)), np.tile(np.eye(6), (200, 1, 1))])
    measured = np.random.default_rng(2).normal(size=(200, 6))
    measured[:, 3] = reading
    assert np.isfinite(huber(Regression(matrices, measured, [f"u{k}" for k in range(10)], alike=EACH))).all()
