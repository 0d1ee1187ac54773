"""Gauss-Markov estimation of the linear parameters: (23) to (28), with column scaling, weights and rank said aloud."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from cases.errors import IdentificationError

Array = NDArray[np.float64]


class Filtered(NamedTuple):
    """What a low-pass did to white noise before the fit, and how many samples of it were kept.

    Args:
        gain: variance of filtered noise over that of recorded noise, the sum of the squared kernel.
        stride: recorded samples for each one that is kept.
    """

    gain: float
    stride: int


UNFILTERED = Filtered(1.0, 1)
WEIGHT_ROUNDS = 20
WEIGHT_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True)
class Fit:
    """An estimate of u.

    Args:
        values: u, shape (u,).
        covariance: s0^2 F^-1, (28), shape (u, u): right where the recorded noise is white.
        covariance_robust: autocorrelation-robust, shape (u, u): right also where they are not.
        s0: (27), of the recorded forces; dimensionless where weights are given, else [N].
        freedom: degrees of freedom of s0.
        residuals: f - A u, shape (n, 6) [N, or N and N m].
        weights: diagonal of W for one sample, shape (6,).
        rank: of the scaled regressor.
        condition: mu_1 / mu_u of the scaled regressor (26).
    """

    values: Array
    covariance: Array
    covariance_robust: Array
    s0: float
    freedom: float
    residuals: Array
    weights: Array
    rank: int
    condition: float


def gauss_markov(
    regressors: Array,
    forces: Array,
    names: Sequence[str],
    weights: Array,
    nuisance: int = 0,
    filtered: Filtered = UNFILTERED,
) -> Fit:
    """Weighted least squares with W the same diagonal at every sample.

    Where regressors and forces went through a low-pass that leaves the regressors as they are, the estimate is that of
    the unfiltered problem for all noise in the pass band. White noise of variance s0^2 then leaves residuals of
    variance gain s0^2, of which every stride-th was kept: chi^2 / (m n gain - u / stride) estimates s0^2, and s0^2 /
    stride F^-1 is the covariance, F being that of the kept samples.

    Args:
        regressors: A_j, shape (n, 6, u).
        forces: shape (n, 6) [N, or N and N m].
        names: of the u columns.
        weights: diagonal of W for one sample, shape (6,) [1/force^2], or ones.
        nuisance: so many of the last columns are no parameters of the model: they are estimated too, and cost
            certainty, but rank and condition are told without them.
        filtered: what was done to both before.

    Raises:
        IdentificationError: fewer forces than unknowns, or parameters that the data do not determine, by name.
    """
    samples, sensors, unknowns = regressors.shape
    if samples * sensors <= unknowns:
        raise IdentificationError(
            f"{samples} samples give {samples * sensors} forces for {unknowns} unknowns; record more or choose a model "
            "with fewer parameters"
        )
    root = np.sqrt(weights)
    matrix = (regressors * root[:, None]).reshape(-1, unknowns)
    right = (forces * root).ravel()
    norms = np.linalg.norm(matrix, axis=0)
    scale = np.where(norms > 0.0, 1.0 / np.where(norms > 0.0, norms, 1.0), 1.0)  # (26)
    q, r = np.linalg.qr(matrix * scale)
    singular, directions = np.linalg.svd(r[: unknowns - nuisance, : unknowns - nuisance])[1:]
    # The paper's numerical zero (Fig. 3), m n eps max|R_ii|; mu_1 bounds max|R_ii| from above.
    zero = samples * sensors * np.finfo(float).eps * singular[0]
    rank = int(np.sum(singular > zero))
    if rank < len(singular):
        share = np.abs(directions[rank:]).max(axis=0)
        hidden = [name for name, s in zip(names, share, strict=False) if s > 1e-3]
        raise IdentificationError(
            f"rank {rank} of {len(singular)}: {', '.join(hidden)} not determined by this run; excite them (plan a "
            "motion or more poses) or choose a model without them"
        )
    unseen = np.flatnonzero(np.abs(np.diag(r)) <= zero)
    if len(unseen):
        raise IdentificationError(f"{names[unseen[0]]} is not determined: the forces do not change; check the channels")
    scaled = solve_triangular(r, q.T @ right)
    values = scale * scaled
    residuals = forces - regressors @ values
    chi_squared = float(np.sum(weights * residuals**2))  # (27)
    freedom = samples * sensors * filtered.gain * filtered.stride - unknowns
    if freedom <= 0.0:
        raise IdentificationError(
            f"{samples * filtered.stride} samples hold {freedom + unknowns:.0f} independent forces behind the filter "
            f"for {unknowns} unknowns; record longer or raise filter_cutoff_Hz"
        )
    s0 = float(np.sqrt(chi_squared * filtered.stride / freedom))
    inverse_root = scale[:, None] * solve_triangular(r, np.eye(unknowns))
    inverse = inverse_root @ inverse_root.T  # F^-1
    scores = np.einsum("nku,nk->nu", regressors, weights * residuals)
    robust = inverse @ long_run_covariance(scores) @ inverse
    condition = float(singular[0] / singular[-1])
    covariance = s0**2 / filtered.stride * inverse
    return Fit(values, covariance, robust, s0, freedom, residuals, weights, rank, condition)


def long_run_covariance(scores: Array) -> Array:
    """Sum over all lags of the autocovariance of a series times its length, by Bartlett's kernel (Newey and West 1987).

    The bandwidth follows Andrews (1991) from the lag-one autocorrelation of each column.

    Args:
        scores: shape (n, u).
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


def require_alive(forces: Array) -> None:
    """Refuses channels that read one and the same value: a cable came off, or an amplifier is at its end.

    Args:
        forces: as recorded, shape (n, 6), n >= 2.

    Raises:
        IdentificationError: names the first such channel.
    """
    stuck = np.flatnonzero(np.ptp(forces, axis=0) == 0.0)
    if len(stuck):
        raise IdentificationError(
            f"channel {stuck[0] + 1} reads {forces[0, stuck[0]]:g} at every sample; check its cable and amplifier"
        )


def per_channel(regressors: Array, forces: Array, names: Sequence[str]) -> Fit:
    """Gauss-Markov with W from the residual variance of each channel, estimated in turns with the parameters.

    Args: see `gauss_markov`.

    Raises:
        IdentificationError: as `gauss_markov`.
    """
    if len(forces) < 2:
        raise IdentificationError(f"{len(forces)} sample has no scatter to weigh the channels by; record more")
    require_alive(forces)
    # Start from each channel's own spread: N and N m are not comparable.
    spread = forces.std(axis=0)
    weights = 1.0 / np.maximum(spread, 1e-12 * max(spread.max(), 1e-300)) ** 2
    fit = gauss_markov(regressors, forces, names, weights)
    freedom = 1.0 - regressors.shape[2] / forces.size  # each channel pays its share of the unknowns
    for _ in range(WEIGHT_ROUNDS):
        variance = np.mean(fit.residuals**2, axis=0) / freedom
        if variance.min() <= 0.0:
            raise IdentificationError("a channel fits without any residual; its variance cannot be estimated: check it")
        new = 1.0 / variance
        settled = bool(np.all(np.abs(new / weights - 1.0) < WEIGHT_TOLERANCE))
        weights = new
        fit = gauss_markov(regressors, forces, names, weights)
        if settled:
            break
    return fit
