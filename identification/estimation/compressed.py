"""Gauss-Markov estimation (23) to (28) of a regression in as many rows as it has unknowns.

After one QR, which also gives the rank, the size of the regression no longer matters:

W^1/2 (A f) = Q (R c; 0 d) turns chi^2 of (27) into |c - R u|^2 + d^2 (Golub & Van Loan 2013, section 5.3).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from cases.errors import IdentificationError
from cases.units import Array
from identification.estimation.fit import Filtered, Fit, Regression
from identification.finding import Finding, Kind, warning

_PART = 600  # rows of a QR that stay in the cache
_PIECE = 20_000  # samples whose rows are in memory at once


@dataclass(frozen=True, slots=True)
class Compressed:
    """chi^2 of (27) as a function of u."""

    root: Array  # R, upper triangular, R^T R = A^T W A, shape (u, u)
    right: Array  # c, shape (u,)
    rest: float  # d^2, the chi^2 that no u explains
    rows: int  # m n, the forces behind it
    regression: Regression
    weights: Array  # diagonal of W for one sample, shape (6,)

    def chi_squared(self, values: Array) -> float:
        """(27) at u, shape (u,)."""
        return float(np.sum((self.right - self.root @ values) ** 2)) + self.rest


def compress(regression: Regression, weights: Array) -> Compressed:
    """The QR of a regression with the diagonal of W for one sample, shape (6,).

    Raises:
        IdentificationError: fewer forces than unknowns.
    """
    samples, sensors, unknowns = regression.regressors.shape
    if samples * sensors <= unknowns:
        raise IdentificationError(
            f"{samples} samples give {samples * sensors} forces for {unknowns} unknowns; record more or choose a model "
            "with fewer parameters"
        )
    r = joint_triangle(regression.regressors, regression.forces, np.sqrt(weights))
    return Compressed(r[:-1, :-1], r[:-1, -1], float(r[-1, -1] ** 2), samples * sensors, regression, weights)


def joint_triangle(regressors: Array, forces: Array, root: Array) -> Array:
    """R of the QR of all (A_j f_j), rows multiplied by `root`, shape (6,), piece by piece, shape (u + 1, u + 1)."""
    tops = [
        triangle(
            (
                np.concatenate([regressors[k : k + _PIECE], forces[k : k + _PIECE, :, None]], axis=2) * root[:, None]
            ).reshape(-1, regressors.shape[2] + 1)
        )
        for k in range(0, len(forces), _PIECE)
    ]
    return tops[0] if len(tops) == 1 else triangle(np.vstack(tops))


def column_scale(root: Array) -> Array:
    """H of (26): one over the norm of each column, 1 where a column is zero, shape (u,)."""
    norms = np.linalg.norm(root, axis=0)
    return np.where(norms > 0.0, 1.0 / np.where(norms > 0.0, norms, 1.0), 1.0)


def determined(root: Array, names: Sequence[str], rows: int, nuisance: int = 0) -> tuple[int, float]:
    """Rank and condition mu_1 / mu_u (26) of the scaled regression, which determines all its parameters.

    Args:
        root: R, or any matrix with R^T R the information, shape (k, u).
        rows: m n of the paper's numerical zero (Fig. 3).
        nuisance: so many of the last columns are not parameters of the model and are not counted.

    Raises:
        IdentificationError: parameters that are not determined, by name.
    """
    count = root.shape[1] - nuisance
    scaled = triangle(root * column_scale(root))[:count, :count]
    singular, directions = np.linalg.svd(scaled)[1:]
    rank = int(np.sum(singular > rows * np.finfo(float).eps * singular[0]))
    if rank < count:
        share = np.abs(directions[rank:]).max(axis=0)
        hidden = [name for name, s in zip(names, share, strict=False) if s > 1e-3]
        raise IdentificationError(
            f"rank {rank} of {count}: {', '.join(hidden)} not determined by this run; excite them (plan a motion or "
            "more poses) or choose a model without them"
        )
    return rank, float(singular[0] / singular[-1])


def inverse_root(root: Array) -> Array:
    """L with L L^T = (R^T R)^-1, shape (u, u), for R of full rank, shape (k, u)."""
    scale = column_scale(root)
    return np.asarray(scale[:, None] * solve_triangular(triangle(root * scale), np.eye(root.shape[1])))


def orthonormal(regressors: Array, weights: Array) -> tuple[Array, Array]:
    """Q of the QR decomposition of W^1/2 A, shape (n, 6, u), and L with L L^T = F^-1, shape (u, u)."""
    weighted = regressors * np.sqrt(weights)[:, None]
    half = inverse_root(weighted.reshape(-1, regressors.shape[2]))
    return weighted @ half, half


def triangle(matrix: Array) -> Array:
    """R of the QR decomposition, shape (u, u), in parts that stay in the cache of the processor.

    The QR of the parts' R is that of the whole, as stable and four times as fast (Demmel, Grigori, Hoemmen & Langou
    2012, SIAM J. Sci. Comput. 34:A206).
    """
    rows, columns = matrix.shape
    parts = rows // _PART
    if parts > 1 and columns < _PART // 4:
        tops = np.asarray(np.linalg.qr(matrix[: parts * _PART].reshape(parts, _PART, columns), mode="r"))
        return triangle(np.vstack([tops.reshape(-1, columns), matrix[parts * _PART :]]))
    return np.asarray(np.linalg.qr(matrix, mode="r"))


def degrees_of_freedom(rows: int, used: float, filtered: Filtered) -> float:
    """Degrees of freedom by which the noise is judged (see `gauss_markov` for filtered data).

    Raises:
        IdentificationError: there are none.
    """
    independent = rows * filtered.gain * filtered.stride
    if independent <= used:
        raise IdentificationError(
            f"{rows} forces, {independent:.0f} of them independent, for {used:.0f} unknowns; record longer or raise "
            "filter_cutoff_Hz"
        )
    return independent - used


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


def settled(name: str, converged: bool, rounds: int) -> tuple[Finding, ...]:
    """What to say of an estimator that finds its weights in turns."""
    if converged:
        return ()
    return (warning(Kind.ESTIMATOR, f"{name}: W still changed after {rounds} rounds; compare with gauss-markov"),)


def scores(regressors: Array, residuals: Array, weights: Array) -> Array:
    """A_j^T W r_j of each sample, shape (n, u); the covariance of an estimate follows from their spread."""
    return np.asarray(np.einsum("nku,nk->nu", regressors, weights * residuals))


def fit_along(compressed: Compressed, names: Sequence[str], values: Array, tangent: Array) -> Fit:
    """The Fit at the least chi^2 among u = u(theta), its uncertainty along du/dtheta.

    Args:
        names: names of the free parameters theta, in their order; the last are the regression's nuisances.
        values: u(theta) at the minimum, shape (u,).
        tangent: du/dtheta there, shape (u, theta).

    Raises:
        IdentificationError: parameters that are not determined, by name, or no degree of freedom.
    """
    root = compressed.root @ tangent
    regression, weights, filtered = compressed.regression, compressed.weights, compressed.regression.filtered
    rank, condition = determined(root, names, compressed.rows, regression.nuisance)
    residuals = regression.residuals(values)
    freedom = degrees_of_freedom(compressed.rows, tangent.shape[1], filtered)
    s0 = float(np.sqrt(np.sum(weights * residuals**2) * filtered.stride / freedom))  # (27)
    half = tangent @ inverse_root(root)
    inverse = half @ half.T  # F^-1 of (28), along du/dtheta
    covariance = s0**2 / filtered.stride * inverse
    return Fit(values, covariance, covariance, s0, freedom, residuals, weights, rank, condition)


def with_kernel(fit: Fit, regression: Regression) -> Fit:
    """A fit of `fit_along` that allows for noise with memory by Bartlett's kernel, `long_run_covariance`."""
    inverse = fit.covariance * regression.filtered.stride / max(fit.s0**2, np.finfo(float).tiny)
    # Of u, not of theta: the bandwidth inside then depends on no choice of theta.
    long_run = long_run_covariance(scores(regression.regressors, fit.residuals, fit.weights))
    return replace(fit, covariance_robust=inverse @ long_run @ inverse)


def gauss_markov(regression: Regression, weights: Array) -> Fit:
    """Weighted least squares with W the same diagonal at every sample.

    Where regressors and forces went through a low-pass that leaves the regressors as they are, the estimate is that of
    the unfiltered problem for all noise in the pass band. White noise of variance s0^2 then leaves residuals of
    variance gain s0^2, of which every stride-th is used: chi^2 / (m n gain - u / stride) estimates s0^2, and s0^2 /
    stride F^-1 is the covariance, F being that of the used samples.

    Args:
        weights: diagonal of W for one sample, shape (6,) [1/force^2], or ones.

    Raises:
        IdentificationError: fewer forces than unknowns, or parameters that the data do not determine, by name.
    """
    compressed, names = compress(regression, weights), regression.names
    determined(compressed.root, names, compressed.rows, regression.nuisance)
    norms = np.linalg.norm(compressed.root, axis=0)
    remainders = np.abs(np.diag(compressed.root))  # of each column, what the columns before it do not explain
    unseen = np.flatnonzero(remainders <= compressed.rows * np.finfo(float).eps * norms)
    if len(unseen):
        raise IdentificationError(f"{names[unseen[0]]} is not determined: the forces do not change; check the channels")
    half = inverse_root(compressed.root)
    values = np.asarray(half @ ((compressed.root @ half).T @ compressed.right))  # (24)
    return fit_along(compressed, names, values, np.eye(len(values)))


def require_alive(forces: Array) -> None:
    """Raises IdentificationError where a channel of two samples or more reads one and the same value, shape (n, 6).

    A cable came off, or an amplifier is at its end.
    """
    stuck = np.flatnonzero(np.ptp(forces, axis=0) == 0.0)
    if len(stuck):
        raise IdentificationError(
            f"channel {stuck[0] + 1} reads {forces[0, stuck[0]]:g} at every sample; check its cable and amplifier"
        )
