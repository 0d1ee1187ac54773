"""Weights of channels and of samples, from the residuals of a fit, in turns with the fit.

W (24) follows from the residuals of each channel, or from their covariance; poses may err alone. Of the samples, least
trimmed squares use the half that agrees best.
"""

from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from cases.errors import IdentificationError
from cases.units import Array, Flags
from identification.estimation.fit import (
    Fit,
    Regression,
    column_scale,
    gauss_markov,
    orthonormal,
    require_alive,
    settled,
)
from identification.estimation.force_noise import with_kernel
from identification.model import whitening_of

EACH = (0, 1, 2, 3, 4, 5)  # `Regression.alike` where each channel has noise of its own
WEIGHT_ROUNDS = 20
WEIGHT_TOLERANCE = 1e-6
LEAST_FREEDOM = 2.0  # forces of a channel beyond what the parameters take, to judge its variance by


def per_channel(regression: Regression) -> Fit:
    """Gauss-Markov with W from the residual variance of each channel, or of those that are alike, in turns with u.

    Each channel pays for the unknowns by its own leverage, the trace of its block of the hat matrix: the fixed point is
    the restricted maximum likelihood (Patterson & Thompson 1971, Biometrika 58:545). Equal shares instead would let
    a channel that the parameters follow become ever more certain.

    Raises:
        IdentificationError: as `gauss_markov`; or too few samples to judge a channel's variance by.
    """
    regressors, forces, filtered = regression.regressors, regression.forces, regression.filtered
    if len(forces) < 2:
        raise IdentificationError(f"{len(forces)} sample has no scatter to weigh the channels by; record more")
    require_alive(forces)
    alike = np.asarray(regression.alike or EACH)
    same = np.equal.outer(alike, alike).astype(float)  # sums over channels of a kind
    spread = np.sqrt(same @ _own_noise(regressors, forces) ** 2 / same.sum(axis=1))
    weights = 1.0 / np.maximum(spread, 1e-12 * max(spread.max(), 1e-300)) ** 2
    fit = gauss_markov(regression, weights)
    independent = len(forces) * filtered.gain * filtered.stride
    for _ in range(WEIGHT_ROUNDS):
        leverage = channel_leverage(regressors, weights)
        freedom = independent - leverage
        if freedom.min() < LEAST_FREEDOM:
            worst = int(np.argmin(freedom))
            raise IdentificationError(
                f"channel {worst + 1} has {independent:.0f} independent samples, of which the parameters take "
                f"{leverage[worst]:.1f}; at least {LEAST_FREEDOM:g} more are needed to know its noise: record more, "
                "or choose a model with fewer parameters"
            )
        variance = same @ np.sum(fit.residuals**2, axis=0) * filtered.stride / (same @ freedom)
        if variance.min() <= (1e-12 * np.abs(forces).max()) ** 2 * np.finfo(float).eps:
            raise IdentificationError("a channel fits without any residual; its variance cannot be estimated: check it")
        before, weights = weights, 1.0 / variance
        fit = gauss_markov(regression, weights)
        if np.all(np.abs(weights / before - 1.0) < WEIGHT_TOLERANCE):
            break
    return fit


def _own_noise(regressors: Array, forces: Array) -> Array:
    """Noise of each channel to start from, shape (6,): what a fit to this channel alone leaves of it.

    From the channels' spread, a channel whose forces vary much would begin with so little weight that the turns may end
    where it is not fitted at all. Where samples are few, the spread has to do.
    """
    samples, _, unknowns = regressors.shape
    if samples < 2 * unknowns:
        return np.asarray(forces.std(axis=0))
    residuals = [
        forces[:, k] - regressors[:, k] @ np.linalg.lstsq(regressors[:, k], forces[:, k], rcond=None)[0]
        for k in range(forces.shape[1])
    ]
    noise = np.std(residuals, axis=1)
    return np.asarray(np.maximum(noise, 1e-6 * forces.std(axis=0)))


def channel_leverage(regressors: Array, weights: Array) -> Array:
    """How many unknowns each channel determines, shape (6,); they sum to u."""
    return np.asarray(np.sum(orthonormal(regressors, weights)[0] ** 2, axis=(0, 2)))


def independent_poses(regressors: Array, residuals: Array, weights: Array) -> Array:
    """Covariance of u where poses are independent of each other, channels of a pose not, shape (u, u).

    The cluster form of HC3 (CR3; MacKinnon & White 1985, Bell & McCaffrey 2002): residuals of a pose are replaced by
    what they would be had the pose not been part of the fit, so that the covariance of a few poses is not too small.

    From A_j, shape (n, 6, u), residuals of a fit to these, shape (n, 6), and the diagonal of W, shape (6,).
    """
    q, half = orthonormal(regressors, weights)
    left_out = np.linalg.pinv(np.eye(6) - q @ q.transpose(0, 2, 1), rcond=1e-9, hermitian=True)
    scores = np.einsum("nku,nkl,nl->nu", q, left_out, np.sqrt(weights) * residuals)
    return np.asarray(half @ (scores.T @ scores) @ half.T)


LEAST = 60  # independent samples: with fewer the 21 variances and covariances follow the noise they are to judge
DEPENDENT = 1e-10  # least eigenvalue of the channels' correlation below which one follows from the others


def full_weights(regression: Regression) -> tuple[Fit, Array]:
    """Gauss-Markov (24) with W the inverse of the full channel covariance.

    Weights are the diagonal of W; s0 is 1 where the turns have converged.

    W from n samples is on average too large by n / (n - 7), the mean of the inverse Wishart distribution (Hartlap,
    Simon & Schneider 2007, Astron. Astrophys. 464:399), and its scatter costs the estimate up to as much again: the
    covariance is raised by the square (ours; 95 % intervals then hold the truth in 95 to 96 % for Gaussian noise).

    Returns:
        The fit, and the covariance of the noise of the recorded forces, shape (6, 6) [N^2, N^2 m..].

    Raises:
        IdentificationError: as `gauss_markov`; too few samples for 21 variances; a channel that the others determine.
    """
    forces, filtered = regression.forces, regression.filtered
    samples, sensors, unknowns = regression.regressors.shape
    independent = samples * filtered.gain * filtered.stride
    freedom = independent - unknowns / sensors  # each channel pays its share of the unknowns
    if independent < LEAST:
        raise IdentificationError(
            f"{independent:.0f} independent samples are too few for the covariance of six channels, at least {LEAST} "
            "are needed; record more or weight each channel alone"
        )
    spread = forces.std(axis=0)
    channels = np.diag(np.maximum(spread, 1e-12 * max(float(spread.max()), 1e-300)) ** 2)
    fit, rounds, converged = _weighted(regression, channels), 0, False
    while not converged and rounds < WEIGHT_ROUNDS:
        new = fit.residuals.T @ fit.residuals * filtered.stride / freedom  # s0^2 of `gauss_markov`, for each pair
        std = _independent(new, np.abs(forces).max(axis=0))
        converged = bool(np.abs((new - channels) / np.outer(std, std)).max() < WEIGHT_TOLERANCE)
        channels, rounds = new, rounds + 1
        fit = _weighted(regression, channels)
    factor = (independent / (independent - sensors - 1)) ** 2
    findings = settled("full", converged, rounds)
    return replace(fit, covariance=factor * fit.covariance, findings=findings), channels


def _weighted(regression: Regression, channels: Array) -> Fit:
    """Gauss-Markov after whitening: with channels = L L^T the noise of L^-1 f is white and alike in all channels."""
    whiten = whitening_of(channels)
    white = regression.whitened(whiten)
    fit = with_kernel(gauss_markov(white, np.ones(6)), white)
    return replace(fit, residuals=regression.residuals(fit.values), weights=np.sum(whiten**2, axis=0))


def _independent(channels: Array, size: Array) -> Array:
    """Standard deviation of each channel, shape (6,), where no channel is silent or follows from the others."""
    std = np.sqrt(np.diag(channels))
    silent = std <= 1e-12 * size
    if silent.any():
        raise IdentificationError(f"channel {int(np.argmax(silent)) + 1} fits without any residual; check the sensor")
    least, directions = np.linalg.eigh(channels / np.outer(std, std))
    if least[0] < DEPENDENT:
        bound = [str(k + 1) for k in np.flatnonzero(np.abs(directions[:, 0]) > 0.1)]
        raise IdentificationError(
            f"the noise of channels {', '.join(bound)} is not independent; is one computed from the others?"
        )
    return np.asarray(std)


HALF = 0.5  # of the samples that a fit must explain
STRETCHES = (0.25, 0.4)  # of the run, that a search begins from
STARTS = 7  # of each length
ROUNDS = 20  # concentration steps, each of which lowers the trimmed sum of squares
TOGETHER = 0.1  # [s] of neighbours that a sample is judged with
ENOUGH = 5.0  # times as many forces as unknowns, to begin from


def least_trimmed_squares(regressors: Array, forces: Array, w: Array, step: float) -> tuple[Array, Flags] | None:
    """Best of many fits: u of the half of the samples that agree best, and which these are; None of too few samples.

    Least trimmed squares (Rousseeuw 1984, J. Am. Stat. Assoc. 79:871) resist up to half of the samples. As a contact is
    a stretch of time, the search begins from fits to stretches of time, and each sample is judged with its neighbours.

    Args:
        regressors: A_j at ascending times, shape (n, 6, u).
        forces: shape (n, 6) [N, or N and N m].
        w: W for one sample, shape (6, 6).
        step: usual time between samples [s].
    """
    root = np.linalg.cholesky(w).T
    matrices, right = root @ regressors, forces @ root.T
    samples, sensors, unknowns = matrices.shape
    scale = column_scale(matrices.reshape(-1, unknowns))
    matrices = matrices * scale
    count, width = int(np.ceil(HALF * samples)), max(1, round(TOGETHER / step))
    lengths = (round(share * samples) for share in STRETCHES)
    long_enough = [n for n in lengths if n * sensors >= ENOUGH * unknowns]
    if not long_enough:
        return None
    begins = [(int(begin), n) for n in long_enough for begin in np.linspace(0, samples - n, STARTS)]
    place = np.arange(samples)
    fits = (_concentrated(matrices, right, (place >= b) & (place < b + n), count, width) for b, n in begins)
    _, values, rows = min(fits, key=lambda fit: fit[0])
    return scale * values, rows


def _concentrated(matrices: Array, right: Array, rows: Flags, count: int, width: int) -> tuple[float, Array, Flags]:
    """Fits, and selects the samples that fit best, in turns: the trimmed sum, the values and the samples."""
    unknowns = matrices.shape[2]
    objective = np.inf
    values: Array = np.zeros(unknowns)
    for _ in range(ROUNDS):
        stacked = matrices[rows].reshape(-1, unknowns)
        values = np.asarray(np.linalg.lstsq(stacked, right[rows].ravel(), rcond=None)[0], dtype=np.float64)
        squares = np.sum((right - matrices @ values) ** 2, axis=1)
        smooth = uniform_filter1d(squares, width, mode="nearest")
        rows = np.asarray(smooth <= np.partition(smooth, count - 1)[count - 1], dtype=bool)
        new = float(squares[rows].sum())
        if not new < objective * (1.0 - 1e-6):
            break
        objective = new
    return objective, values, rows
