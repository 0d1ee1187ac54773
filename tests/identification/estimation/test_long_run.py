"""The autocorrelation-robust covariance: Bartlett's kernel, and noise that is not white."""

import numpy as np
import pytest
from scipy.signal import lfilter

from identification.estimation.fit import Regression, gauss_markov
from identification.estimation.force_noise import long_run_covariance, scores


def auto_regressive(phi: float, count: int, seed: int, columns: int = 1) -> np.ndarray:
    """AR(1) noise with innovations of variance 1, in its stationary state."""
    return lfilter([1.0], [1.0, -phi], np.random.default_rng(seed).normal(size=(count + 500, columns)), axis=0)[500:]


@pytest.mark.parametrize(("count", "phi"), [(50, 0.5), (400, 0.9), (400, 0.0), (300, -0.5), (7, 0.3)])
def test_it_is_the_bartlett_weighted_sum_of_autocovariances(count: int, phi: float) -> None:
    """Literally as Newey and West (1987) print it, with the bandwidth of Andrews (1991), table I, Bartlett."""
    scores = auto_regressive(phi, count, seed=1, columns=3)
    rho = np.array([s[1:] @ s[:-1] / (s[1:] @ s[1:]) for s in scores.T]).clip(-0.97, 0.97)
    alpha = np.mean(4 * rho**2 / ((1 - rho) ** 2 * (1 + rho) ** 2))
    width = int(np.clip(np.ceil(1.1447 * (alpha * count) ** (1 / 3)), 1, count // 4))
    expected = scores.T @ scores
    for lag in range(1, width):
        product = scores[lag:].T @ scores[:-lag]
        expected = expected + (1 - lag / width) * (product + product.T)
    np.testing.assert_allclose(long_run_covariance(scores), expected, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("phi", [-0.5, 0.0, 0.3, 0.6, 0.9])
def test_autoregressive_noise_has_its_theoretical_long_run_variance(phi: float) -> None:
    """sigma^2 / (1 - phi)^2 a sample; the kernel's bias and scatter at 40 000 samples stay below 15 %."""
    count = 40_000
    found = long_run_covariance(auto_regressive(phi, count, seed=2))[0, 0] / count
    assert found == pytest.approx(1 / (1 - phi) ** 2, rel=0.15)


def test_it_is_a_covariance() -> None:
    matrix = long_run_covariance(auto_regressive(0.8, 60, seed=3, columns=8))
    np.testing.assert_allclose(matrix, matrix.T)
    assert np.linalg.eigvalsh(matrix).min() > -1e-9 * np.trace(matrix)


def robust_ratio(noise: np.ndarray) -> float:
    """Robust over plain standard deviation of the mean of six equal, constant forces."""
    ones = np.ones((len(noise), 6, 1))
    fit = gauss_markov(Regression(ones, noise, ["mean"]), np.ones(6))
    inverse = fit.covariance / fit.white_noise**2
    robust = inverse @ long_run_covariance(scores(ones, fit.residuals, np.ones(6))) @ inverse
    return float(np.sqrt(robust[0, 0] / fit.covariance[0, 0]))


def test_for_white_noise_both_covariances_agree() -> None:
    assert robust_ratio(auto_regressive(0.0, 20_000, seed=4, columns=6)) == pytest.approx(1.0, abs=0.05)


def test_noise_that_lasts_makes_the_robust_standard_deviation_larger_as_theory_says() -> None:
    """The mean of AR(1) noise scatters sqrt((1 + phi) / (1 - phi)) times as much as its spread suggests."""
    phi = 0.8
    expected = np.sqrt((1 + phi) / (1 - phi))
    assert robust_ratio(auto_regressive(phi, 40_000, seed=5, columns=6)) == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize(
    "scores", [np.zeros((30, 2)), np.ones((30, 2)), np.ones((2, 1))], ids=["zero", "constant", "two"]
)
def test_degenerate_scores_give_finite_values(scores: np.ndarray) -> None:
    assert np.isfinite(long_run_covariance(scores)).all()
