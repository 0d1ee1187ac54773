"""Noise that channels share is told from noise that they do not."""

import numpy as np
import pytest

from cases.errors import IdentificationError
from identification.estimation import channel_weights as module
from identification.estimation.channel_weights import full_weights, per_channel
from identification.estimation.fit import Filtered, Regression, gauss_markov
from tests.helpers import few, one_line, tells
from tests.identification.moving_run import NAMES, SAMPLES, A, U, coverage, forces

Array = np.ndarray
# All bars feel the same shaking of the platform, five times as strong as their own noise.
SHAKEN = np.eye(6) + 25.0 * np.outer([1, 1, -1, 1, -1, 1], [1, 1, -1, 1, -1, 1])
ROOT = np.linalg.cholesky(SHAKEN)


def shaken(seed: int, samples: int = SAMPLES) -> Array:
    rows = np.linspace(0, SAMPLES - 1, samples).astype(int)
    return A[rows] @ U + np.random.default_rng(seed).normal(size=(samples, 6)) @ ROOT.T


def test_the_covariance_of_the_channels_is_recovered() -> None:
    found = np.mean([full_weights(Regression(A, shaken(s), NAMES))[1] for s in range(20)], axis=0)
    np.testing.assert_allclose(found, SHAKEN, atol=0.06 * 26)


def test_independent_channels_give_per_channel_weights() -> None:
    """Where the residuals' products vanish, up to who pays for the unknowns: all alike, or each its leverage."""
    draw = np.random.default_rng(0)
    matrices = np.dstack([draw.normal(size=(80, 6, 3)), np.tile(np.eye(6), (80, 1, 1))])
    columns = matrices.reshape(80, -1)
    unused = np.linalg.svd(columns)[0][:, np.linalg.matrix_rank(columns) :]
    names = [f"u{k}" for k in range(9)]
    noise = unused[:, :6] * [1.0, 0.1, 10.0, 2.0, 0.5, 3.0]
    measured = matrices @ np.arange(9.0) + noise
    (full, _), diagonal = (
        full_weights(Regression(matrices, measured, names)),
        per_channel(Regression(matrices, measured, names)),
    )
    np.testing.assert_allclose(full.values, diagonal.values, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(full.weights, diagonal.weights, rtol=0.04)  # leverages differ
    np.testing.assert_allclose(full.covariance / (80 / 73) ** 2, diagonal.covariance, rtol=0.05, atol=1e-5)


def test_it_settles_where_weights_and_residuals_agree() -> None:
    fit, channels = full_weights(Regression(A, shaken(0), NAMES))
    residuals = fit.residuals
    assert fit.findings == ()
    np.testing.assert_allclose(residuals.T @ residuals / (200 - 20 / 6), channels, rtol=1e-4, atol=1e-4)
    assert fit.s0 == pytest.approx(1.0, abs=1e-4)
    np.testing.assert_allclose(fit.weights, np.diag(np.linalg.inv(channels)))


def test_the_estimate_is_generalised_least_squares_with_its_channels() -> None:
    fit, channels = full_weights(Regression(A, shaken(0), NAMES))
    weight = np.linalg.inv(channels)
    information = np.einsum("nki,kl,nlj->ij", A, weight, A)
    values = np.linalg.solve(information, np.einsum("nki,kl,nl->i", A, weight, shaken(0)))
    np.testing.assert_allclose(fit.values, values, rtol=1e-8, atol=1e-9)


def test_it_is_nearer_to_the_truth_than_a_diagonal_w() -> None:
    errors = [
        (full_weights(Regression(A, shaken(s), NAMES))[0].values, per_channel(Regression(A, shaken(s), NAMES)).values)
        for s in range(20)
    ]
    full, diagonal = (np.std([e[k] - U for e in errors], axis=0) for k in (0, 1))
    assert np.exp(np.mean(np.log(full / diagonal))) < 0.7


@pytest.mark.parametrize(("samples", "seeds"), few((200, 100), (60, 100)))
def test_95_of_100_intervals_hold_the_truth_although_the_weights_are_estimated(samples: int, seeds: int) -> None:
    rows = np.linspace(0, SAMPLES - 1, samples).astype(int)
    assert 0.92 <= coverage(lambda s: full_weights(Regression(A[rows], shaken(s, samples), NAMES))[0], U, seeds) <= 0.98


def test_the_unit_of_a_channel_does_not_matter() -> None:
    unit = np.array([1.0, 1.0, 1.0, 1e3, 1e3, 1e3])
    plain, channels = full_weights(Regression(A, shaken(0), NAMES))
    scaled, scaled_channels = full_weights(Regression(A * unit[:, None], shaken(0) * unit, NAMES))
    np.testing.assert_allclose(scaled.values, plain.values, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(scaled_channels, channels * np.outer(unit, unit), rtol=1e-4)


def test_behind_a_filter_the_channels_are_those_of_the_recorded_forces() -> None:
    """A moving average over 5 samples, every fifth kept, has a gain of 1/5."""
    filtered = Filtered(0.2, 5)
    noise = (np.random.default_rng(0).normal(size=(1000, 6)) @ ROOT.T).reshape(200, 5, 6).mean(axis=1)
    fit, channels = full_weights(Regression(A, A @ U + noise, NAMES, filtered=filtered))
    np.testing.assert_allclose(channels, SHAKEN, atol=0.35 * 26)
    assert fit.s0 == pytest.approx(1.0, abs=1e-4)
    # The same kept samples without a word about the filter: the same estimate, as sure of itself.
    plain, _ = full_weights(Regression(A, A @ U + noise, NAMES))
    np.testing.assert_allclose(fit.values, plain.values, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(np.diag(fit.covariance), np.diag(plain.covariance), rtol=1e-9)


def test_it_says_when_it_does_not_settle(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "WEIGHT_ROUNDS", 1)
    fit, _ = full_weights(Regression(A, shaken(0), NAMES))
    assert tells(fit.findings[0].sentence, "W ", "1 rounds")


def test_too_few_samples_are_refused() -> None:
    with pytest.raises(IdentificationError, match=r"59 independent samples.*at least 60") as caught:
        full_weights(Regression(A[:59], forces(0)[:59], NAMES))
    one_line(caught.value)


def test_a_channel_computed_from_others_is_found() -> None:
    matrices = np.tile(np.eye(6), (200, 1, 1))
    measured = np.random.default_rng(0).normal(size=(200, 6))
    measured[:, 4] = measured[:, 0] - 2.0 * measured[:, 1]
    with pytest.raises(IdentificationError, match=r"channels 1, 2, 5 .*not independent") as caught:
        full_weights(Regression(matrices, measured, NAMES[10:16]))
    one_line(caught.value)


def test_a_stuck_channel_is_named() -> None:
    matrices = np.tile(np.eye(6), (200, 1, 1))
    measured = np.random.default_rng(0).normal(size=(200, 6))
    measured[:, 2] = 7.0
    with pytest.raises(IdentificationError, match="channel 3 ") as caught:
        full_weights(Regression(matrices, measured, NAMES[10:16]))
    one_line(caught.value)


def test_it_agrees_with_equal_weights_on_equal_channels_within_the_noise() -> None:
    full, equal = (
        full_weights(Regression(A, forces(0), NAMES))[0],
        gauss_markov(Regression(A, forces(0), NAMES), np.ones(6)),
    )
    assert np.all(np.abs(full.values - equal.values) < 0.7 * np.sqrt(np.diag(equal.covariance)))
    np.testing.assert_allclose(np.diag(full.covariance) / np.diag(equal.covariance), 1.0, atol=0.3)
