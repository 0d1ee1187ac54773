"""Weights per channel: channels of unlike units and noise are told apart from their residuals."""

import numpy as np
import pytest

from cases.base.errors import IdentificationError
from identification.estimation.estimators import channel_leverage, independent_poses, per_channel
from identification.estimation.fit import Regression, gauss_markov
from tests.helpers import one_line

DRAW = np.random.default_rng(0)
A = DRAW.normal(size=(1000, 6, 4))
U = np.array([1.0, -2.0, 0.5, 3.0])
NAMES = ["m", "mxC", "myC", "mzC"]
NOISE_STD = np.array([1.0, 0.1, 10.0, 2e-3, 5e-3, 3.0])
FORCES = A @ U + NOISE_STD * DRAW.normal(size=(1000, 6))


def test_the_noise_of_each_channel_is_recovered() -> None:
    """Each standard deviation is known to 1 / sqrt(2000) = 2.2 % from 1000 residuals."""
    fit = per_channel(Regression(A, FORCES, NAMES))
    np.testing.assert_allclose(1 / np.sqrt(fit.weights), NOISE_STD, rtol=0.08)
    assert fit.white_noise == pytest.approx(1.0, abs=0.01)


def test_it_settles_where_weights_and_residuals_agree() -> None:
    fit = per_channel(Regression(A, FORCES, NAMES))
    again = gauss_markov(Regression(A, FORCES, NAMES), fit.weights)
    np.testing.assert_allclose(again.values, fit.values, rtol=1e-9)
    variance = np.sum(again.residuals**2, axis=0) / (len(FORCES) - channel_leverage(A, fit.weights))
    np.testing.assert_allclose(1 / variance, fit.weights, rtol=1e-4)


def test_leverages_of_the_channels_share_the_unknowns_and_follow_the_weights() -> None:
    leverage = channel_leverage(A, NOISE_STD**-2.0)
    assert leverage.sum() == pytest.approx(4.0)
    assert leverage[3] > 3.0  # the quietest channel determines nearly everything
    assert channel_leverage(A, np.ones(6)) == pytest.approx([4 / 6] * 6, abs=0.1)


def test_a_few_samples_still_give_each_channel_the_variance_that_it_has() -> None:
    """Twelve samples of six channels for four unknowns: on average over seeds the variances are right to some percent.

    With equal shares of the unknowns the quiet channels collapse: their variance comes out four times too small.
    """
    few = A[:12]
    ratio = [
        1
        / per_channel(
            Regression(few, few @ U + np.random.default_rng(s).normal(size=(12, 6)) * NOISE_STD, NAMES)
        ).weights
        for s in range(200)
    ]
    # A channel whose rivals are a thousand times louder has 8 degrees of freedom of its own.
    np.testing.assert_allclose(np.mean(ratio, axis=0) / NOISE_STD**2, np.ones(6), rtol=0.25)


def test_too_few_samples_for_a_variance_are_refused() -> None:
    """Two samples of a channel, less its share of the four unknowns, leave too little to judge its noise by."""
    forces = A[:2] @ U + np.random.default_rng(1).normal(size=(2, 6))
    with pytest.raises(IdentificationError, match=r"channel \d .*\b2 independent samples.*record more") as caught:
        per_channel(Regression(A[:2], forces, NAMES))
    one_line(caught.value)


def test_a_few_poses_do_not_praise_themselves() -> None:
    """Leave-one-out residuals: with poses that are noisier than others the robust intervals are wide enough."""
    few, spread = A[:8], np.repeat([1.0, 4.0], 4)[:, None]
    errors, variances = [], []
    for seed in range(300):
        forces = few @ U + spread * np.random.default_rng(seed).normal(size=(8, 6))
        fit = gauss_markov(Regression(few, forces, NAMES), np.ones(6))
        errors.append((fit.values - U) ** 2)
        variances.append(np.diag(independent_poses(few, fit.residuals, fit.weights)))
    ratio = np.mean(variances, axis=0) / np.mean(errors, axis=0)
    assert np.all(ratio > 0.9)  # on the safe side, as leave-one-out is
    assert np.all(ratio < 2.5)


def test_it_is_nearer_to_the_truth_than_equal_weights_and_says_so() -> None:
    weighted, equal = per_channel(Regression(A, FORCES, NAMES)), gauss_markov(Regression(A, FORCES, NAMES), np.ones(6))
    assert np.linalg.norm(weighted.values - U) < 0.1 * np.linalg.norm(equal.values - U)
    assert np.all(np.diag(weighted.covariance) < np.diag(equal.covariance))
    std = np.sqrt(np.diag(weighted.covariance))
    assert np.all(np.abs(weighted.values - U) < 4 * std)


def test_the_unit_of_a_channel_does_not_matter() -> None:
    """Moments in N m or N mm give the same body."""
    unit = np.array([1.0, 1.0, 1.0, 1e3, 1e3, 1e3])
    plain, scaled = (
        per_channel(Regression(A, FORCES, NAMES)),
        per_channel(Regression(A * unit[:, None], FORCES * unit, NAMES)),
    )
    np.testing.assert_allclose(scaled.values, plain.values, rtol=1e-7)
    np.testing.assert_allclose(scaled.covariance, plain.covariance, rtol=1e-5, atol=1e-20)


@pytest.mark.parametrize("channel", range(6))
@pytest.mark.parametrize("reading", [0.0, 5.0])
def test_a_channel_that_is_stuck_is_named(channel: int, reading: float) -> None:
    """A cable that came off reads the same value for ever; offsets fit it without residual."""
    matrices = np.dstack([A, np.tile(np.eye(6), (1000, 1, 1))])
    forces = FORCES.copy()
    forces[:, channel] = reading
    with pytest.raises(IdentificationError, match=f"channel {channel + 1} ") as caught:
        per_channel(Regression(matrices, forces, NAMES + [f"f_q0_{k}" for k in range(1, 7)]))
    one_line(caught.value)


@pytest.mark.parametrize("samples", [1, 30])
def test_forces_that_are_all_zero_are_refused(samples: int) -> None:
    with pytest.raises(IdentificationError) as caught:
        per_channel(Regression(A[:samples], np.zeros((samples, 6)), NAMES))
    one_line(caught.value)


def test_channels_that_are_alike_share_one_variance_which_is_the_mean_of_their_own() -> None:
    """So a channel whose residuals are small by chance, or by a model that fits it better, does not rule the fit."""
    alike = (0, 0, 0, 1, 1, 1)
    fit = per_channel(Regression(A, FORCES, NAMES, alike=alike))
    noise = 1 / np.sqrt(fit.weights)
    assert np.ptp(noise[:3]) == np.ptp(noise[3:]) == 0.0
    np.testing.assert_allclose(
        noise[[0, 3]] ** 2, [np.mean(NOISE_STD[k] ** 2) for k in (slice(3), slice(3, 6))], rtol=0.1
    )
    left = np.sum(fit.residuals**2, axis=0) / (len(FORCES) - channel_leverage(A, fit.weights))
    assert left[:3].mean() * fit.weights[0] == pytest.approx(1.0, rel=1e-2)


def test_one_kind_for_all_is_the_fit_with_equal_weights() -> None:
    one, equal = (
        per_channel(Regression(A, FORCES, NAMES, alike=(0,) * 6)),
        gauss_markov(Regression(A, FORCES, NAMES), np.ones(6)),
    )
    np.testing.assert_allclose(one.values, equal.values, rtol=1e-9)
    np.testing.assert_allclose(one.covariance, equal.covariance, rtol=1e-6)
    assert 1 / np.sqrt(one.weights) == pytest.approx([equal.white_noise] * 6, rel=1e-6)
