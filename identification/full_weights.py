"""W from the full covariance of the six channels, estimated in turns with u (feasible generalised least squares).

Zellner 1962, J. Am. Stat. Assoc. 57:348, with the parameters common to all channels. Bars of one frame share what
shakes the platform, so that their noise is correlated; a diagonal W then wastes data and misjudges the errors.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from identification.estimator import UNFILTERED, WEIGHT_ROUNDS, WEIGHT_TOLERANCE, Filtered, Fit, gauss_markov

Array = NDArray[np.float64]

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

    W from n samples is on average too large by n / (n - 7) (the mean of the inverse Wishart distribution; Hartlap,
    Simon & Schneider 2007, Astron. Astrophys. 464:399, (17)); the covariances are raised by this.

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
    if freedom <= sensors + 1:
        raise IdentificationError(
            f"{samples} samples are too few for the covariance of six channels; record more or weight each channel alone"
        )
    spread = forces.std(axis=0)
    channels = np.diag(np.maximum(spread, 1e-12 * max(float(spread.max()), 1e-300)) ** 2)
    fit, rounds, converged = _weighted(regressors, forces, names, channels, nuisance, filtered), 0, False
    while not converged and rounds < WEIGHT_ROUNDS:
        new = fit.residuals.T @ fit.residuals * filtered.stride / (freedom * filtered.stride)
        new = new if filtered.gain == 1.0 else new
        _independent(new)
        std = np.sqrt(np.diag(new))
        converged = bool(np.abs((new - channels) / np.outer(std, std)).max() < WEIGHT_TOLERANCE)
        channels, rounds = new, rounds + 1
        fit = _weighted(regressors, forces, names, channels, nuisance, filtered)
    raised = independent / (independent - sensors - 1)
    fit = replace(fit, covariance=raised * fit.covariance, covariance_robust=raised * fit.covariance_robust)
    return FullWeightsFit(fit, channels, converged, rounds)
