"""Stationary noise with memory: its autocovariance as a series tells it, slow noises that no short series tells."""

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

Array = NDArray[np.float64]

MOST_ORDER = 30  # of the autoregressive model; behind the filter samples are a quarter of its shortest period apart
MOST_ALIKE = 1.0 - 1e-6  # of reflection coefficients, so that no pole lies on the unit circle
LEAST_SAMPLES = 20  # fewer tell no spectrum; here intervals hold already, those of a kernel in four of five cases
PER_ORDER = 16  # samples for each coefficient, at least: more follow what the fit took, dips of the spectrum
MEMORIES = 6  # of slow noises: the run's length, a half, .. of it


def slow_noises(length: int) -> list[Array]:
    """Autocovariances of first-order noises with memories of a run's length, a half, .. of it, each of shape (n,).

    Args:
        length: n, of the run in steps.
    """
    lags = np.arange(length)
    return [np.exp(-lags * 2.0**k / length) for k in range(MEMORIES)]


def autoregressive(noise: Array, here: Array, scale: float) -> Array:
    """Autocovariance of the autoregressive model of the order that Akaike's criterion chooses, shape (n,).

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
        ahead, behind = forward[1:], backward[:-1]
        power = float(np.sum((ahead**2 + behind**2)[whole]))
        if np.count_nonzero(whole) < LEAST_SAMPLES // 2 or power <= 0.0:
            break
        reflection = float(np.clip(2.0 * (ahead @ (behind * whole)) / power, -MOST_ALIKE, MOST_ALIKE))
        forward, backward = ahead - reflection * behind, behind - reflection * ahead
        phi = np.r_[phi - reflection * phi[::-1], reflection]
        variance *= 1.0 - reflection**2
        criterion = count * (np.log(variance) + 2.0 * (order + 1) / (count - order - 2))
        if criterion < best[0]:
            best = (criterion, phi, variance)
    period = next_fast_len(8 * length, real=True)  # so long that what wraps around is little
    spectrum = scale * best[2] / np.abs(rfft(np.r_[1.0, -best[1]], period)) ** 2
    return np.asarray(irfft(spectrum, period)[:length])


def products(series: Array) -> Array:
    """Sums of products of samples that are 0, 1, .. steps apart, shape (n,)."""
    length = next_fast_len(2 * len(series), real=True)
    return np.asarray(irfft(np.abs(rfft(series, length)) ** 2, length)[: len(series)])


def toeplitz(autocovariance: Array, columns: Array) -> Array:
    """Gamma B, Gamma the Toeplitz matrix of an autocovariance of n lags, shape (n, u)."""
    count = len(columns)
    length = next_fast_len(2 * count, real=True)
    ring = np.zeros(length)
    ring[:count] = autocovariance
    ring[length - count + 1 :] = autocovariance[:0:-1]
    return np.asarray(irfft(rfft(ring)[:, None] * rfft(columns, length, axis=0), length, axis=0)[:count])
