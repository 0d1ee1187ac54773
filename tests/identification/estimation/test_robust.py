"""Huber's estimate costs 5 % where all is well and saves the run where it is not."""

import numpy as np
import pytest

from cases.errors import IdentificationError
from identification.estimation import estimators
from identification.estimation.channel_weights import EACH
from identification.estimation.estimators import huber
from identification.estimation.fit import Filtered, Regression, gauss_markov
from tests.helpers import few, one_line, tells
from tests.identification.moving_run import NAMES, ONES, A, U, coverage, forces

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
    """Efficiency 0.95 within what 100 runs can show, and s0 of (27)."""
    pairs = [
        (huber(Regression(A, forces(s), NAMES))[0], gauss_markov(Regression(A, forces(s), NAMES), ONES))
        for s in range(100)
    ]
    efficiency = sum(distance(g.values) for _, g in pairs) / sum(distance(h.values) for h, _ in pairs)
    assert 0.92 < efficiency < 0.98
    assert np.mean([h.s0 / g.s0 for h, g in pairs]) == pytest.approx(1.0, abs=0.01)
    ratio = np.mean([np.diag(h.covariance) / np.diag(g.covariance) for h, g in pairs])
    assert ratio == pytest.approx(1 / 0.95, abs=0.05)


@pytest.mark.parametrize("pooled", [True, False])
def test_gross_errors_of_5_percent_do_little_to_it_and_ruin_least_squares(pooled: bool) -> None:
    found = [huber(Regression(A, with_gross_errors(s), NAMES, alike=None if pooled else EACH))[0] for s in range(10)]
    assert all(r.findings == () for r in found)
    assert np.mean([distance(r.values) for r in found]) < 2.0 * 20
    assert (
        np.mean([distance(gauss_markov(Regression(A, with_gross_errors(s), NAMES), ONES).values) for s in range(10)])
        > 200 * 20
    )
    for r in found:
        np.testing.assert_allclose(r.weights**-0.5, 1.0, rtol=0.35)  # an MAD of 200 forces is known to 8 %


@pytest.mark.parametrize("pooled", few(True, False))
@pytest.mark.parametrize("data", few(with_gross_errors, forces))
def test_95_of_100_intervals_hold_the_truth_with_and_without_gross_errors(pooled: bool, data) -> None:
    assert (
        0.92 <= coverage(lambda s: huber(Regression(A, data(s), NAMES, alike=None if pooled else EACH))[0], U) <= 0.98
    )


def test_it_solves_hubers_equations() -> None:
    """Sum psi(r / s) a / s = 0 at the scale of the residuals themselves."""
    result, _ = huber(Regression(A, with_gross_errors(3), NAMES, alike=EACH))
    residuals = result.residuals
    mad = 1.482602218505602 * np.median(np.abs(residuals), axis=0) * np.sqrt(1200 / 1180)
    np.testing.assert_allclose(result.weights**-0.5, mad, rtol=1e-9)
    psi = np.clip(residuals / mad, -1.345, 1.345)
    parts = A * (psi / mad)[:, :, None]
    np.testing.assert_allclose(parts.sum(axis=(0, 1)) / np.abs(parts).sum(axis=(0, 1)), 0.0, atol=1e-7)


def test_attention_falls_where_forces_are_wrong() -> None:
    measured = forces(5)
    measured[40:44, 2] += 300.0
    _, kept = huber(Regression(A, measured, NAMES))
    assert kept[40:44, 2].max() < 0.01
    np.testing.assert_allclose(np.mean(kept < 1.0, axis=0), 0.179, atol=0.09)
    assert np.all((kept >= 0.0) & (kept <= 1.0))


def test_units_of_channels_do_not_matter_where_each_has_its_scale() -> None:
    plain, _ = huber(Regression(A, forces(0), NAMES, alike=EACH))
    scaled, _ = huber(Regression(A * UNITS[:, None], forces(0) * UNITS, NAMES, alike=EACH))
    np.testing.assert_allclose(scaled.values, plain.values, rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(scaled.covariance, plain.covariance, rtol=1e-4, atol=1e-12)
    np.testing.assert_allclose(scaled.weights, plain.weights / UNITS**2, rtol=2e-5)
    assert scaled.s0 == pytest.approx(1.0, abs=0.05)


def test_it_meets_exact_data_exactly() -> None:
    np.testing.assert_allclose(huber(Regression(A, A @ U, NAMES))[0].values, U, rtol=1e-9, atol=1e-9)


def test_behind_a_filter_it_agrees_with_gauss_markov() -> None:
    """White noise after a moving average over 5 samples, every fifth kept: variance 1/5, and again white."""
    filtered, noise = Filtered(0.2, 5), np.random.default_rng(0).normal(size=(1000, 6))
    kept = A @ U + noise.reshape(200, 5, 6).mean(axis=1)
    (result, _), expected = (
        huber(Regression(A, kept, NAMES, filtered=filtered)),
        gauss_markov(Regression(A, kept, NAMES, filtered=filtered), ONES),
    )
    assert result.s0 == pytest.approx(expected.s0, rel=0.05)
    np.testing.assert_allclose(np.diag(result.covariance) / np.diag(expected.covariance), 1.05, atol=0.25)


def test_it_says_when_it_does_not_converge(monkeypatch: pytest.MonkeyPatch) -> None:
    assert huber(Regression(A, with_gross_errors(0), NAMES))[0].findings == ()
    monkeypatch.setattr(estimators, "HUBER_ROUNDS", 3)
    result, _ = huber(Regression(A, with_gross_errors(0), NAMES))
    assert tells(result.findings[0].sentence, "W ", "3 rounds")


@pytest.mark.parametrize("reading", [0.0, 5.0])
def test_a_stuck_channel_is_named(reading: float) -> None:
    matrices = np.dstack([np.random.default_rng(1).normal(size=(200, 6, 4)), np.tile(np.eye(6), (200, 1, 1))])
    measured = np.random.default_rng(2).normal(size=(200, 6))
    measured[:, 3] = reading
    with pytest.raises(IdentificationError, match="channel 4 ") as caught:
        huber(Regression(matrices, measured, [f"u{k}" for k in range(10)], alike=EACH))
    one_line(caught.value)


def test_forces_that_are_all_zero_are_refused_where_each_channel_has_its_scale() -> None:
    with pytest.raises(IdentificationError) as caught:
        huber(Regression(A, np.zeros((200, 6)), NAMES))
    one_line(caught.value)


def test_channels_that_are_alike_share_one_scale() -> None:
    found, _ = huber(Regression(A * UNITS[:, None], forces(0) * UNITS, NAMES, alike=(0, 0, 0, 1, 1, 1)))
    scales = found.weights**-0.5
    assert np.ptp(scales[:3]) == np.ptp(scales[3:]) == 0.0
    assert scales[3] == pytest.approx(1e-3 * scales[0], rel=0.1)
