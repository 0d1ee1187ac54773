"""Shares of several noises in what a fit leaves, by restricted likelihood: as if the fit had taken nothing.

What a fit leaves of noise with covariance V does not depend on the parameters, nor does its likelihood (Patterson and
Thompson 1971, Biometrika 58:545). All channels have the same V here; how the shares differ between them says one step
of Fisher's scoring from there, Rao's minimum norm quadratic unbiased estimate (1971, J. Multivar. Anal. 1:257), none
negative.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize, nnls

Array = NDArray[np.float64]

UNSEEN = 1e-9  # of the largest singular value or eigenvalue, below which there is only rounding
JITTER = 1e-9  # white noise beside all others, as a share of their variance
SETTLED = 1e-6  # relative change of the likelihood: thousandths, and what is decided is a difference of two
MOST_STEPS = 100

Family = Callable[[Array], tuple[Array, Callable[[Array], Array]]]
"""Logarithms of parameters, shape (p,) -> V, shape (m, m), and what turns dL/dV into dL/d(logarithms), shape (p,)."""


class Left(NamedTuple):
    """What a fit left of some samples, in channels with independent noise.

    Args:
        noise: residuals, shape (m, s).
        taken: columns, without dependent ones, that the fit may have taken any multiple of, shape (m, s, r).
    """

    noise: Array
    taken: Array

    @classmethod
    def of(cls, noise: Array, taken: Array) -> "Left":
        """Of residuals, shape (m, s), and columns of the fit, shape (m, s, u), that may depend on one another."""
        basis, size, _ = np.linalg.svd(taken.reshape(noise.size, -1), full_matrices=False)
        kept = basis[:, size > UNSEEN * size[0]]
        return cls(noise, kept.reshape(*noise.shape, -1))


class _Solved(NamedTuple):
    """P = V^-1 - H H^T over all channels, applied.

    Args:
        inverse: V^-1, shape (m, m).
        spanned: H, shape (m, s, r).
        answer: P applied to the residuals, shape (m, s).
        half_logdet: log of the determinants' root.
    """

    inverse: Array
    spanned: Array
    answer: Array
    half_logdet: float


def _solved(left: Left, covariance: Array) -> _Solved:
    count, channels = left.noise.shape
    jittered = covariance + JITTER * np.trace(covariance) / count * np.eye(count)
    factor, lower = cho_factor(jittered, lower=True)
    inverse = cho_solve((factor, lower), np.eye(count))
    columns = (inverse @ left.taken.reshape(count, -1)).reshape(left.taken.shape)
    inner = np.linalg.cholesky(np.tensordot(left.taken, columns, ((0, 1), (0, 1))))
    spanned = solve_triangular(inner, columns.reshape(-1, len(inner)).T, lower=True).T.reshape(columns.shape)
    rest = np.tensordot(spanned, left.noise, ((0, 1), (0, 1)))
    weighed = inverse @ left.noise
    logdet = channels * np.log(np.diag(factor)).sum() + np.log(np.diag(inner)).sum()
    return _Solved(inverse, spanned, weighed - spanned @ rest, float(logdet))


def likeliest(left: Left, family: Family, start: Array, bounds: Array) -> tuple[Array, float]:
    """Parameters that make what is left likeliest, shape (p,), and minus the logarithm of that likelihood.

    Args:
        left: samples.
        family: of covariances.
        start: parameters to begin with, shape (p,).
        bounds: least and most of each, shape (p, 2).
    """

    def value(logarithms: Array) -> tuple[float, Array]:
        covariance, pulled = family(logarithms)
        found = _solved(left, covariance)
        flat = found.spanned.reshape(len(covariance), -1)
        slope = left.noise.shape[1] * found.inverse - flat @ flat.T - found.answer @ found.answer.T
        return found.half_logdet + float(np.sum(left.noise * found.answer)) / 2.0, pulled(slope / 2.0)

    best = minimize(
        value,
        np.log(start),
        jac=True,
        method="L-BFGS-B",
        bounds=np.log(bounds),
        options={"maxiter": MOST_STEPS, "ftol": SETTLED, "maxcor": 20},
    )
    return np.exp(best.x), float(best.fun)


def mixtures(kernels: Array) -> Family:
    """Covariances that are sums of given ones, shape (c, m, m), with shares of their own."""
    count = kernels.shape[1]
    flat = kernels.reshape(len(kernels), -1)

    def family(logarithms: Array) -> tuple[Array, Callable[[Array], Array]]:
        shares = np.exp(logarithms)
        return (shares @ flat).reshape(count, count), lambda slope: shares * (flat @ slope.ravel())

    return family


def shares_by_channel(left: Left, kernels: Array, shares: Array) -> Array:
    """Shares of noises in each channel, shape (s, c).

    Args:
        left: samples.
        kernels: covariances of the noises, shape (c, m, m).
        shares: that are the likeliest for all channels alike, shape (c,).
    """
    found = _solved(left, np.tensordot(shares, kernels, 1))
    channels, count = left.noise.shape[1], len(kernels)
    inverse, spanned, answer = found.inverse, found.spanned, found.answer
    weighed = inverse @ kernels
    power = np.einsum("ms,cms->sc", answer, np.tensordot(kernels, answer, 1))
    felt = np.tensordot(kernels, spanned, 1)  # K_c H, shape (c, m, s, r)
    within = np.einsum("msu,cmsv->scuv", spanned, felt, optimize=True)
    information = np.einsum("kcuv,ldvu->kcld", within, within, optimize=True)
    whole = np.einsum("aij,bji->ab", weighed, weighed, optimize=True)
    for k in range(channels):
        through = inverse @ felt[:, :, k]
        crossed = np.tensordot(felt[:, :, k], through, ((1, 2), (1, 2)))
        information[k, :, k, :] += whole - 2.0 * crossed
    square = information.reshape(channels * count, -1)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(square), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh((square + square.T) / 2.0 * np.outer(scale, scale))
    seen = values > UNSEEN * values[-1]
    root = np.sqrt(values[seen])
    found_shares, _ = nnls((vectors[:, seen] * root).T, vectors[:, seen].T @ (scale * power.ravel()) / root)
    return np.asarray((found_shares * scale).reshape(channels, count))
