"""Noise of forces as residuals show it: turned channels, autocovariances, and what memory does to an estimate.

Kernel estimates of the sandwich (`long_run_covariance`) need long runs; moving runs are described by a mixture of
noises instead (`noise_mixtures`).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from cases.base.units import Array, Indices
from identification.estimation.fit import orthonormal

Spectra = NDArray[np.complex128]


class Turned(NamedTuple):
    """Residuals of a weighted fit with six turned channels."""

    half: Array  # F^-1 = half half^T, shape (u, u)
    # B, the parameters half^-1 u answer to noise x with the sum of B_k^T x_k over channels, shape (n, 6, u)
    answer: Array
    taken: Array  # C, the fit takes C_k times that away from channel k, shape (n, 6, u)
    noise: Array  # residuals, of variance 1 but for degrees of freedom, shape (n, 6)
    freedom: float  # degrees of freedom of a channel
    places: Indices  # places of the samples in a series of equal steps, from 0 upwards, shape (n,)
    share: float = 1.0  # share of the run's samples that these are; noise in all of them is known that much better
    # autocovariances behind the filter of what is white before it, noise of the forces and of accelerations, each 1 at
    # lag zero, shape (2, l); None where nothing was filtered
    sources: Array | None = None

    @property
    def length(self) -> int:
        """Steps of a series that holds the samples, a few more where spectra of so many are found sooner."""
        return int(next_fast_len(int(self.places[-1]) + 1, real=True))

    def series(self, values: Array) -> Array:
        """Samples, shape (n, ..), at their places in the series, zero between."""
        spread = np.zeros((self.length, *values.shape[1:]))
        spread[self.places] = values
        return spread

    def lags(self, autocovariance: Array) -> Array:
        """An autocovariance with as many lags as the series has, zero beyond its own, shape (n,)."""
        spread = np.zeros(self.length)
        spread[: len(autocovariance)] = autocovariance[: self.length]
        return spread

    def covariance(self, meat: Array) -> Array:
        """Covariance of u from that of half^-1 u, shape (u, u)."""
        return np.asarray(self.half @ ((meat + meat.T) / 2.0) @ self.half.T)


def turned(regressors: Array, residuals: Array, weights: Array, places: Indices | None = None) -> Turned:
    """The residuals of a fit in turned channels.

    Args:
        regressors: A_j, shape (n, 6, u), of full rank.
        residuals: f - A u of the weighted fit, shape (n, 6).
        weights: diagonal of W for one sample, shape (6,).
        places: places of the samples in a series of equal steps, ascending, shape (n,); by default one after the other.
    """
    basis, half = orthonormal(regressors, weights)  # F = 1 in these coordinates
    noise = residuals * np.sqrt(weights)
    return in_turned_channels(basis, half, noise, places, slow_part(noise, places))


def slow_part(noise: Array, places: Indices | None) -> Array:
    """What of a noise lies below a third of the highest frequency, shape (n, 6)."""
    at = np.arange(len(noise)) if places is None else places - places[0]
    series = np.zeros((int(at[-1]) + 1, noise.shape[1]))
    series[at] = noise
    spectrum = rfft(series, axis=0)
    spectrum[len(spectrum) // 3 + 1 :] = 0.0
    return np.asarray(irfft(spectrum, len(series), axis=0))


def in_turned_channels(
    basis: Array, half: Array, noise: Array, places: Indices | None, alike: Array | None = None
) -> Turned:
    """The same from an orthonormal basis of the weighted regressors, shape (n, 6, u), and weighted residuals."""
    samples, sensors, unknowns = basis.shape
    freedom = samples - unknowns / sensors
    slow = noise if alike is None else alike
    channels = slow.T @ slow / freedom
    jitter = 1e-12 * float(np.trace(channels)) + np.finfo(float).tiny
    mixing = np.linalg.cholesky(channels + jitter * np.eye(sensors))
    unmixing = np.linalg.inv(mixing)
    return Turned(
        half,
        np.einsum("ab,nau->nbu", mixing, basis),
        np.einsum("ab,nbu->nau", unmixing, basis),
        noise @ unmixing.T,
        freedom,
        np.arange(samples) if places is None else places - places[0],
    )


MOST_ORDER = 30  # of the autoregressive model; behind the filter samples are a quarter of its shortest period apart
MOST_ALIKE = 1.0 - 1e-6  # of reflection coefficients, so that no pole lies on the unit circle
LEAST_SAMPLES = 20  # fewer show no spectrum; here intervals hold already, those of a kernel in four of five cases
PER_ORDER = 16  # samples for each coefficient, at least: more follow what the fit took, dips of the spectrum
MEMORIES = 6  # of slow noises: the run's length, a half, .. of it; those below are short
SHORTEST = 2.0  # samples that a noise remembers, next to which it is white


def slow_noises(length: int) -> list[Array]:
    """Autocovariances of first-order noises with memories of a run of n steps, a half, .. of it, each of shape (n,)."""
    lags = np.arange(length)
    return [np.exp(-lags * 2.0**k / length) for k in range(MEMORIES)]


def memories(length: int) -> list[Array]:
    """Autocovariances of white noise, and of first-order noises of all memories up to a run of n steps, shape (n,)."""
    lags, count = np.arange(length), max(MEMORIES, int(np.log2(max(length / SHORTEST, 1.0))) + 1)
    return [(lags == 0) * 1.0, *(np.exp(-lags * 2.0**k / length) for k in range(count))]


def autoregressive(noise: Array, here: Array, scale: float) -> tuple[Array, int]:
    """Autocovariance of the autoregressive model whose order Akaike's criterion chooses, shape (n,), and the order.

    By Burg's recursion over stretches without gaps (de Waele and Broersen 2000, IEEE Trans. Signal Process. 48:2876),
    which is always stable.

    Args:
        noise: shape (n,), zero where there is no sample.
        here: 1 where there is a sample, shape (n,).
        scale: samples over degrees of freedom.
    """
    count, length = int(here.sum()), len(noise)
    phi, variance = np.zeros(0), max(float(noise @ noise) / count, np.finfo(float).tiny)
    best = (count * (np.log(variance) + 2.0 / (count - 2)), phi, variance)
    forward, backward, whole = noise, noise, here > 0.0
    for order in range(1, min(MOST_ORDER, count // PER_ORDER) + 1):
        whole = whole[1:] & (here[:-order] > 0.0)
        later, earlier = forward[1:], backward[:-1]
        power = float(np.sum((later**2 + earlier**2)[whole]))
        if np.count_nonzero(whole) < LEAST_SAMPLES // 2 or power <= 0.0:
            break
        reflection = float(np.clip(2.0 * (later @ (earlier * whole)) / power, -MOST_ALIKE, MOST_ALIKE))
        forward, backward = later - reflection * earlier, earlier - reflection * later
        phi = np.r_[phi - reflection * phi[::-1], reflection]
        variance *= 1.0 - reflection**2
        criterion = count * (np.log(variance) + 2.0 * (order + 1) / (count - order - 2))
        if criterion < best[0]:
            best = (criterion, phi, variance)
    period = next_fast_len(8 * length, real=True)  # so long that what wraps around is little
    spectrum = scale * best[2] / np.abs(rfft(np.r_[1.0, -best[1]], period)) ** 2
    return np.asarray(irfft(spectrum, period)[:length]), len(best[1])


def products(series: Array) -> Array:
    """Sums of products of samples that are 0, 1, .. steps apart, shape (n,)."""
    length = next_fast_len(2 * len(series), real=True)
    return np.asarray(irfft(np.abs(rfft(series, length)) ** 2, length)[: len(series)])


def toeplitz(autocovariance: Array, columns: Array) -> Array:
    """Gamma B, Gamma the Toeplitz matrix of an autocovariance of n lags, shape (n, u)."""
    count = len(autocovariance)
    period = next_fast_len(2 * count, real=True)
    ring = rings(autocovariance[None], period)[0]
    return np.asarray(irfft(ring * rfft(columns.T, period), period)[:, :count].T)


def rings(autocovariances: Array, period: int) -> Spectra:
    """Spectra of noises, shape (c, f), by which products with their Toeplitz matrices are products of spectra."""
    count = autocovariances.shape[1]
    rings = np.zeros((len(autocovariances), period))
    rings[:, :count] = autocovariances
    rings[:, period - count + 1 :] = autocovariances[:, :0:-1]
    return np.asarray(rfft(rings))


def scores(regressors: Array, residuals: Array, weights: Array) -> Array:
    """A_j^T W r_j of each sample, shape (n, u); the covariance of an estimate follows from their spread."""
    return np.asarray(np.einsum("nku,nk->nu", regressors, weights * residuals))


def long_run_covariance(scores: Array) -> Array:
    """Sum over all lags of the autocovariance of a series times its length, by Bartlett's kernel (Newey and West 1987).

    The bandwidth follows Andrews (1991) from the lag-one autocorrelation of each column of the series, shape (n, u).
    """
    count = len(scores)
    variance = np.maximum(np.sum(scores[1:] ** 2, axis=0), np.finfo(float).tiny)
    rho = np.clip(np.sum(scores[1:] * scores[:-1], axis=0) / variance, -0.97, 0.97)
    alpha = float(np.mean(4 * rho**2 / ((1 - rho) ** 2 * (1 + rho) ** 2)))
    width = int(np.clip(np.ceil(1.1447 * (alpha * count) ** (1 / 3)), 1, max(1, count // 4)))
    # A Bartlett-weighted sum of lagged products is the mean product of moving sums over the bandwidth.
    padded = np.vstack([np.zeros((1, scores.shape[1])), np.cumsum(np.pad(scores, ((0, width - 1), (0, 0))), axis=0)])
    upper = np.arange(1, count + width)
    moving = padded[upper] - padded[np.maximum(upper - width, 0)]
    return np.asarray(moving.T @ moving / width)
