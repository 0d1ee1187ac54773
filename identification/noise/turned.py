"""A fit's residuals with the channels turned to be independent at lag zero, and what the fit does to noise in them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from identification.estimation.compressed import inverse_root

Array = NDArray[np.float64]
Places = NDArray[np.int64]


class Turned(NamedTuple):
    """Residuals of a weighted fit with six turned channels.

    Args:
        half: F^-1 = half half^T, shape (u, u).
        answer: B, the parameters half^-1 u answer to noise x with the sum of B_k^T x_k over channels, shape (n, 6, u).
        taken: C, the fit takes C_k times that away from channel k, shape (n, 6, u).
        noise: residuals, of variance 1 but for degrees of freedom, shape (n, 6).
        freedom: degrees of freedom of a channel.
        places: of the samples in a series of equal steps, from 0 upwards, shape (n,).
        share: of the run's samples that these are; noise in all of them tells that much more.
    """

    half: Array
    answer: Array
    taken: Array
    noise: Array
    freedom: float
    places: Places
    share: float = 1.0

    @property
    def length(self) -> int:
        """Steps from the first sample to the last."""
        return int(self.places[-1]) + 1

    def series(self, values: Array) -> Array:
        """Samples, shape (n, ..), at their places in the series, zero between."""
        spread = np.zeros((self.length, *values.shape[1:]))
        spread[self.places] = values
        return spread

    def covariance(self, meat: Array) -> Array:
        """Covariance of u from that of half^-1 u, shape (u, u)."""
        return np.asarray(self.half @ ((meat + meat.T) / 2.0) @ self.half.T)


def turned(regressors: Array, residuals: Array, weights: Array, places: Places | None = None) -> Turned:
    """The residuals of a fit in turned channels.

    Args:
        regressors: A_j, shape (n, 6, u), of full rank.
        residuals: f - A u of the weighted fit, shape (n, 6).
        weights: diagonal of W for one sample, shape (6,).
        places: of the samples in a series of equal steps, ascending, shape (n,); by default one after the other.
    """
    samples, sensors, unknowns = regressors.shape
    root = np.sqrt(weights)
    weighted = regressors * root[:, None]
    half = inverse_root(np.asarray(np.linalg.qr(weighted.reshape(-1, unknowns), mode="r")))
    basis = weighted @ half  # Q of the QR decomposition: F = 1 in its coordinates
    freedom = samples - unknowns / sensors
    noise = residuals * root
    channels = noise.T @ noise / freedom
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
