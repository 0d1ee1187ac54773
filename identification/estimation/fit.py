"""What every estimator gives back, and what is said about errors that are not white; W of (24) as its root.

Errors that depend on the pose: encoders, joints, frame and geometry err in the same way wherever a motion comes back to
a place. As in kriging (Cressie 1993, Statistics for Spatial Data), the error of a channel is a random function of the
place: its correlation is of Matern's form with smoothness 3/2 (Stein 1999, Interpolation of Spatial Data), and channels
are independent of each other. Struts are one unit for places and turns.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.sensors import Sensors
from cases.units import MM
from identification.findings import Finding, Kind, warning

Array = NDArray[np.float64]


class Uncertain(NamedTuple):
    """A value and its standard deviation."""

    value: float
    std: float


class Filtered(NamedTuple):
    """What a low-pass did to white noise before the fit, and how many samples of it were kept."""

    gain: float  # variance of filtered noise over that of recorded noise, the sum of the squared kernel
    stride: float  # recorded samples for each one that is kept


UNFILTERED = Filtered(1.0, 1)
EACH = (0, 1, 2, 3, 4, 5)  # channels that have the same noise carry the same number: here none


@dataclass(frozen=True, slots=True)
class PoseField:
    """A field of errors."""

    size: float  # standard deviation of a channel's error [N]
    length: float  # distance in the space of the six strut lengths at which errors are half alike [m]

    @classmethod
    def of(cls, sensors: Sensors) -> "PoseField | None":
        """The field that a case states; None where it states none."""
        if sensors.pose_error_N is None or sensors.pose_error_length_mm is None:
            return None
        return cls(sensors.pose_error_N, sensors.pose_error_length_mm * MM)

    @property
    def keys(self) -> dict[str, float]:
        """As `[sensors]` of a case states it."""
        return {"pose_error_N": float(f"{self.size:.3g}"), "pose_error_length_mm": float(f"{self.length / MM:.3g}")}

    @property
    def words(self) -> str:
        """For people."""
        return f"{self.size:.3g} N over {self.length / MM:.3g} mm of strut lengths"

    def covariance(self, struts: Array) -> Array:
        """Covariance of a channel's errors between places, shape (n, n) [N^2]; struts: shape (n, 6) [m]."""
        return self.size**2 * matern(np.sqrt(squared_distances(struts, struts)) / self.length)[0]


def squared_distances(places: Array, others: Array) -> Array:
    """Between places, shapes (n, d) and (m, d), shape (n, m)."""
    middle = others.mean(axis=0)
    first, second = places - middle, others - middle
    total = np.sum(first**2, axis=1)[:, None] + np.sum(second**2, axis=1)
    return np.asarray(np.maximum(total - 2.0 * first @ second.T, 0.0))


def matern(distance: Array) -> tuple[Array, Array]:
    """Matern's correlation of smoothness 3/2, and its derivative by the logarithm of the length.

    Args:
        distance: distance in lengths.
    """
    scaled = np.sqrt(3.0) * distance
    fading = np.exp(-scaled)
    return (1.0 + scaled) * fading, scaled**2 * fading


class Robust(NamedTuple):
    """What a run says of an estimate where noise is not white."""

    covariance: Array  # covariance of u, shape (u, u)
    findings: tuple[Finding, ...] = ()
    field: PoseField | None = None  # errors that depend on the pose, where the run shows them


@dataclass(frozen=True, slots=True)
class Fit:
    """An estimate of u."""

    values: Array  # u, shape (u,)
    covariance: Array  # s0^2 F^-1, (28), shape (u, u): right where the recorded noise is white
    covariance_robust: Array  # autocorrelation-robust, shape (u, u): right also where they are not
    s0: float  # (27), of the recorded forces; dimensionless where weights are given, else [N]
    freedom: float  # degrees of freedom of s0
    residuals: Array  # f - A u, shape (n, 6) [N, or N and N m]
    weights: Array  # diagonal of W for one sample, shape (6,)
    rank: int  # rank of the scaled regressor
    condition: float  # mu_1 / mu_u of the scaled regressor (26)
    # what the estimator did beside, as a constraint that bound, or a prior that moved it, and what speaks against it,
    # as a prior that disagrees, or a search that did not settle
    findings: tuple[Finding, ...] = ()
    field: PoseField | None = None  # errors that depend on the pose, where the run shows them


def settled(name: str, converged: bool, rounds: int) -> tuple[Finding, ...]:
    """What to say of an estimator that finds its weights in turns."""
    if converged:
        return ()
    return (warning(Kind.ESTIMATOR, f"{name}: W still changed after {rounds} rounds; compare with gauss-markov"),)


Estimator = Callable[[Array, Array, Sequence[str]], Fit]
"""Regressors (n, 6, u), forces (n, 6) and names -> Fit; bind weights and the like with functools.partial."""


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


def whitened(whitening: Array | None, matrices: Array, forces: Array) -> tuple[Array, Array]:
    """Both multiplied with the root of W, shapes (6, 6), (n, 6, u) and (n, 6); as they are where it is None."""
    return (matrices, forces) if whitening is None else (whitening @ matrices, forces @ whitening.T)


def of_forces(whitening: Array | None, fit: Fit, matrices: Array, forces: Array) -> Fit:
    """A fit to whitened forces with the residuals of the forces themselves, and the diagonal of W.

    Args:
        whitening: root of W, shape (6, 6); None where nothing was whitened.
        matrices: A, not whitened, shape (n, 6, u).
        forces: not whitened, shape (n, 6) [N, or N and N m].
    """
    if whitening is None:
        return fit
    return replace(fit, residuals=forces - matrices @ fit.values, weights=np.sum(whitening**2, axis=0))


def w_of(whitening: Array | None, fit: Fit) -> Array:
    """W for one sample, shape (6, 6)."""
    return np.diag(fit.weights) if whitening is None else whitening.T @ whitening
