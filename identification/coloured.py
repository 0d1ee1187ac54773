"""How sure an estimate is where noise has memory: the sandwich with the autocovariance of an autoregressive model.

Kernel estimates of the long-run covariance (`fit.long_run_covariance`) need long runs: at the frequencies of the
motion, where it matters, a short run leaves them too few residuals. Here the residuals' whole spectrum is described by
an autoregressive model (Yule-Walker, its order by Akaike 1974), channels by their covariance at lag zero, and what the
fit took out of the residuals is put back by a parametric bootstrap (Efron & Tibshirani 1993, chapter 6).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from identification.compressed import inverse_root

Array = NDArray[np.float64]

MOST_ORDER = 30  # of the autoregressive model; behind the filter samples are a quarter of its shortest period apart
LEAST_SAMPLES = 40  # fewer tell no spectrum
PER_ORDER = 4  # samples for each coefficient, at least
DRAWS = 8  # of the bootstrap: the mean of eight is known to some percent
BOOTSTRAPPED = 4000  # samples up to which what the fit took matters
SEED = 0


def coloured_covariance(regressors: Array, residuals: Array, weights: Array) -> Array | None:
    """Covariance of u, shape (u, u), for noise of any colour that stays the same over the run; None for short runs.

    Args:
        regressors: A_j at equal steps, shape (n, 6, u), of full rank.
        residuals: f - A u of the weighted fit, shape (n, 6).
        weights: diagonal of W for one sample, shape (6,).
    """
    samples, sensors, unknowns = regressors.shape
    if samples < LEAST_SAMPLES:
        return None
    root = np.sqrt(weights)
    weighted = regressors * root[:, None]
    half = inverse_root(np.asarray(np.linalg.qr(weighted.reshape(-1, unknowns), mode="r")))
    basis = weighted @ half  # Q of the QR decomposition: F = 1 in its coordinates
    freedom = samples - unknowns / sensors
    noise = residuals * root
    channels = noise.T @ noise / freedom
    jitter = 1e-12 * float(np.trace(channels)) + np.finfo(float).tiny
    mixing = np.linalg.cholesky(channels + jitter * np.eye(sensors))
    turned = np.einsum("ab,nau->nbu", mixing, basis)  # per channel of unit variance, independent at lag zero
    white: Array = np.asarray(np.linalg.solve(mixing, noise.T), dtype=np.float64).T
    models = [_autoregression(white[:, k], freedom) for k in range(sensors)]
    meat = _meat(turned, models)
    if samples <= BOOTSTRAPPED:
        scale = 1.0 / np.sqrt(_what_remains(basis, turned, mixing, models, freedom, np.diag(meat)))
        meat = scale[:, None] * meat * scale
    return np.asarray(half @ meat @ half.T)


class _Model(NamedTuple):
    """Coefficients phi, shape (p,), of x_t = phi . (x_t-1 .. x_t-p) + e_t, and the variance of e."""

    phi: Array
    variance: float


def _autoregression(series: Array, freedom: float) -> _Model:
    """The Yule-Walker model of the order that Akaike's criterion chooses, by Levinson's recursion."""
    count = len(series)
    most = min(MOST_ORDER, count // PER_ORDER)
    lags = np.array([series[h:] @ series[: count - h] for h in range(most + 1)]) / freedom
    phi, variance = np.zeros(0), max(float(lags[0]), np.finfo(float).tiny)
    best = (count * np.log(variance), phi, variance)
    for order in range(1, most + 1):
        reflection = float((lags[order] - phi @ lags[order - 1 : 0 : -1][: order - 1]) / variance)
        reflection = float(np.clip(reflection, -0.999999, 0.999999))
        phi = np.r_[phi - reflection * phi[::-1], reflection]
        variance *= 1.0 - reflection**2
        criterion = count * np.log(variance) + 2.0 * order
        if criterion < best[0]:
            best = (criterion, phi, variance)
    return _Model(best[1], best[2])


def _spectrum(model: _Model, length: int) -> Array:
    """Power at the frequencies of a transform of so many samples, shape (length // 2 + 1,)."""
    return np.asarray(model.variance / np.abs(rfft(np.r_[1.0, -model.phi], length)) ** 2)


def _meat(turned: Array, models: Sequence[_Model]) -> Array:
    """Sum over channels of B^T Gamma B, Gamma the Toeplitz autocovariance of the channel's model, shape (u, u)."""
    samples, _, unknowns = turned.shape
    length = next_fast_len(2 * samples, real=True)
    meat = np.zeros((unknowns, unknowns))
    for k, model in enumerate(models):
        seen = rfft(turned[:, k], length, axis=0)
        meat += turned[:, k].T @ irfft(_spectrum(model, length)[:, None] * seen, length, axis=0)[:samples]
    return (meat + meat.T) / 2.0


def _what_remains(
    basis: Array, turned: Array, mixing: Array, models: Sequence[_Model], freedom: float, meat: Array
) -> Array:
    """What a fit leaves of the variance of each u, as this estimates it: the mean over noise drawn from the models.

    Returns:
        Shape (u,), in the coordinates of `basis`; 1 where nothing is lost.
    """
    samples, sensors, unknowns = basis.shape
    draw = np.random.default_rng(SEED)
    length = next_fast_len(2 * samples, real=True)
    flat = basis.reshape(-1, unknowns)
    found = np.zeros(unknowns)
    for _ in range(DRAWS):
        series = np.empty((samples, sensors))
        for k, model in enumerate(models):
            shaped = np.sqrt(_spectrum(model, length)) * rfft(draw.normal(size=length))
            series[:, k] = irfft(shaped, length)[:samples]
        noise = series @ mixing.T
        left = noise - basis @ (flat.T @ noise.ravel())
        white: Array = np.asarray(np.linalg.solve(mixing, left.T), dtype=np.float64).T
        again = [_autoregression(white[:, k], freedom) for k in range(sensors)]
        found += np.diag(_meat(turned, again)) / DRAWS
    return np.clip(found / meat, 0.1, 1.0)
