"""W from the full covariance of the six channels, estimated in turns with u (feasible generalised least squares).

Zellner 1962, J. Am. Stat. Assoc. 57:348, with the parameters common to all channels. Bars of one frame share what
shakes the platform, so that their noise is correlated; a diagonal W then wastes data and misjudges the errors.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from identification.estimation.compressed import with_kernel
from identification.estimation.estimator import WEIGHT_ROUNDS, WEIGHT_TOLERANCE, gauss_markov
from identification.estimation.fit import UNFILTERED, Filtered, Fit

Array = NDArray[np.float64]

LEAST = 60  # independent samples: with fewer the 21 variances and covariances follow the noise they are to judge
DEPENDENT = 1e-10  # least eigenvalue of the channels' correlation below which one follows from the others


@dataclass(frozen=True, slots=True)
class FullWeightsFit:
    """An estimate with W = channels^-1 at every sample.

    Args:
        fit: `weights` is the diagonal of W; s0 is 1 up to the turns that are left; covariances allow for W being
            estimated.
        channels: covariance of the six channels' noise, of the recorded forces, shape (6, 6) [N^2, N^2 m..].
        converged: whether the last turn changed it by less than `WEIGHT_TOLERANCE` of its variances.
        rounds: turns taken.
    """

    fit: Fit
    channels: Array
    converged: bool
    rounds: int


def full_weights(
    regressors: Array,
    forces: Array,
    names: Sequence[str],
    nuisance: int = 0,
    filtered: Filtered = UNFILTERED,
) -> FullWeightsFit:
    """Gauss-Markov (24) with W the inverse of the full channel covariance.

    W from n samples is on average too large by n / (n - 7), the mean of the inverse Wishart distribution (Hartlap,
    Simon & Schneider 2007, Astron. Astrophys. 464:399), and its scatter costs the estimate up to as much again: the
    covariance is raised by the square (ours; 95 % intervals then hold the truth in 95 to 96 % for Gaussian noise).

    Args:
        regressors: A_j, shape (n, 6, u).
        forces: shape (n, 6) [N, or N and N m].
        names: of the u columns.
        nuisance: so many of the last columns are no parameters of the model.
        filtered: what was done to both before.

    Raises:
        IdentificationError: as `gauss_markov`; too few samples for 21 variances; a channel that the others determine.
    """
    samples, sensors, unknowns = regressors.shape
    independent = samples * filtered.gain * filtered.stride
    freedom = independent - unknowns / sensors  # each channel pays its share of the unknowns
    if independent < LEAST:
        raise IdentificationError(
            f"{independent:.0f} independent samples are too few for the covariance of six channels, at least {LEAST} "
            "are needed; record more or weight each channel alone"
        )
    spread = forces.std(axis=0)
    channels = np.diag(np.maximum(spread, 1e-12 * max(float(spread.max()), 1e-300)) ** 2)
    fit, rounds, converged = _weighted(regressors, forces, names, channels, nuisance, filtered), 0, False
    while not converged and rounds < WEIGHT_ROUNDS:
        new = fit.residuals.T @ fit.residuals * filtered.stride / freedom  # s0^2 of `gauss_markov`, for each pair
        std = _independent(new, np.abs(forces).max(axis=0))
        converged = bool(np.abs((new - channels) / np.outer(std, std)).max() < WEIGHT_TOLERANCE)
        channels, rounds = new, rounds + 1
        fit = _weighted(regressors, forces, names, channels, nuisance, filtered)
    raised = (independent / (independent - sensors - 1)) ** 2
    return FullWeightsFit(replace(fit, covariance=raised * fit.covariance), channels, converged, rounds)


def _weighted(
    regressors: Array, forces: Array, names: Sequence[str], channels: Array, nuisance: int, filtered: Filtered
) -> Fit:
    """Gauss-Markov after whitening: with channels = L L^T the noise of L^-1 f is white and alike in all channels."""
    std = np.sqrt(np.diag(channels))  # apart, so that newtons and newton metres do not meet in one factorisation
    whiten = np.linalg.inv(np.linalg.cholesky(channels / np.outer(std, std))) / std
    white = whiten @ regressors
    fit = with_kernel(gauss_markov(white, forces @ whiten.T, names, np.ones(6), nuisance, filtered), white, filtered)
    residuals = forces - regressors @ fit.values
    return replace(fit, residuals=residuals, weights=np.sum(whiten**2, axis=0))


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
