"""Estimators: Gauss-Markov with known values, priors and weights of the channels, and one that resists gross errors.

W (24) is 1, stated, or follows from the residuals of each channel in turns with the fit.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from numbers import Real

import numpy as np
from scipy.linalg import block_diag

from cases import checks_arguments
from cases.errors import IdentificationError
from cases.sensors import Sensors
from cases.units import Array
from identification.estimation.fit import (
    Fit,
    Regression,
    column_scale,
    gauss_markov,
    orthonormal,
    require_alive,
)
from identification.estimation.priors import Prior, with_priors
from identification.model import Model
from identification.parameters import Selection, select

EACH = (0, 1, 2, 3, 4, 5)  # `Regression.alike` where each channel has noise of its own
ALIKE = {"equal": None, "per_channel": EACH, "per_unit": (0, 0, 0, 1, 1, 1), "stated": None}
"""Weights by name -> channels with the same noise, see `Regression`; stated noise is made white before."""


@checks_arguments
@dataclass(frozen=True, slots=True)
class Method:
    """What is known beforehand, and how channels are weighted; IdentificationError where there are no such weights."""

    known: Mapping[str, float] = field(default_factory=dict)  # exact values by linear or physical name [SI]
    dropped: tuple[str, ...] = ()  # linear parameters without a column
    priors: tuple[Prior, ...] = ()
    # `equal`, `per_channel`, `per_unit` or `stated`, see `cases.sensors`; None for those of the case
    weights: str | None = None

    def __post_init__(self) -> None:
        if self.weights is not None and self.weights not in ALIKE:
            raise IdentificationError(f"weights {self.weights!r} are unknown; choose {', '.join(ALIKE)}")
        given = [*self.known.items(), *((p.name, number) for p in self.priors for number in (p.value, p.std))]
        for name, value in given:
            if not (isinstance(name, str) and isinstance(value, Real) and math.isfinite(value)):
                raise IdentificationError(f"Method: {name} = {value!r}", "is not a finite number", "give one in SI")
        if self.priors and (self.known or self.dropped):
            raise IdentificationError(
                "priors go with all parameters free; give what is known exactly as a prior with a small standard "
                "deviation"
            )

    def weights_for(self, sensors: Sensors) -> str:
        """The weights of the channels: its own, or those of the case.

        Raises:
            IdentificationError: weights from stated noise where none is stated.
        """
        weights = self.weights or sensors.weights
        if weights == "stated" and sensors.force_noise is None:
            raise IdentificationError(
                "weights stated: the case states no noise; give sensors.force_noise_N and acceleration_noise_m_s2, or "
                "choose the weights equal or per_channel"
            )
        return weights

    def selection(self, model: Model) -> Selection:
        """What of a model is estimated.

        Raises:
            IdentificationError: names that the model does not have, or known values that are not linear.
        """
        return select(model, self.known, self.dropped)

    def estimate(self, regression: Regression, model: Model) -> Fit:
        """The estimate of all parameters of a model, from a regression whose first columns are its own.

        Raises:
            IdentificationError: names that the model does not have, or as the estimator does.
        """
        if self.priors:
            weights = np.ones(6) if regression.alike is None else per_channel(regression).weights
            return with_priors(regression, model, weights, self.priors)
        return estimate_selected(regression, self.selection(model), gauss_markov_of)


def estimate_selected(regression: Regression, selection: Selection, estimator: Callable[[Regression], Fit]) -> Fit:
    """The fit of the free parameters with all of u, and no variance along what is known.

    Rank and condition are those of the free ones; errors are the estimator's.

    Args:
        regression: regression of the full model; columns beyond it (a delay) stay free.
        selection: selection of that model.
    """
    unknowns, free = selection.basis.shape
    if free == unknowns:
        return estimator(regression)
    basis = block_diag(selection.basis, np.eye(len(regression.names) - unknowns))
    offset = np.pad(selection.offset, (0, len(basis) - unknowns))
    names = [*selection.names, *regression.names[unknowns:]]
    right = regression.residuals(offset)
    fit = estimator(regression._replace(regressors=regression.regressors @ basis, forces=right, names=names))
    covariance, robust = (basis @ square @ basis.T for square in (fit.covariance, fit.covariance_robust))
    return replace(fit, values=offset + basis @ fit.values, covariance=covariance, covariance_robust=robust)


def gauss_markov_of(regression: Regression) -> Fit:
    """(24) with W = 1, or from the variance of each channel."""
    return gauss_markov(regression, np.ones(6)) if regression.alike is None else per_channel(regression)


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


HUBER_K = 1.345  # residuals beyond so many standard deviations count less: 95 % efficiency where noise is Gaussian
MAD_TO_STD = 1.482602218505602  # 1 / Phi^-1(3/4): makes the MAD of Gaussian noise its standard deviation
HUBER_ROUNDS = 100
HUBER_TOLERANCE = 1e-7  # of a standard deviation of each parameter: far below what matters, far above rounding


def huber(regression: Regression) -> Array:
    """Huber's M-estimate of u, shape (u,), by iteratively reweighted least squares: gross errors count less.

    Huber & Ronchetti 2009, Robust Statistics, chapter 7. The scale of channels that are alike is their MAD, in turns.
    """
    regressors, forces = regression.regressors, regression.forces
    samples, _, unknowns = regressors.shape
    kind = np.asarray(regression.alike or 6 * (0,))
    spread = np.array([np.sqrt(np.mean(forces.var(axis=0)[kind == k])) for k in kind])
    spread = np.maximum(spread, 1e-12 * max(float(spread.max()), 1e-300))
    matrix, right = (regressors / spread[:, None]).reshape(-1, unknowns), (forces / spread).ravel()
    scale = column_scale(matrix)
    q, r = np.linalg.qr(matrix * scale)  # in the coordinates v = R u the information is that of the weights alone
    v, floor = q.T @ right, 1e-14 * float(np.linalg.norm(right))
    for _ in range(HUBER_ROUNDS):
        size = np.abs(right - q @ v)
        mad = np.array([np.median(size.reshape(-1, 6)[:, kind == k]) for k in kind])
        noise = np.tile(np.maximum(MAD_TO_STD * mad, 1e-12), samples)
        weighted = q * (np.minimum(1.0, HUBER_K * noise / np.maximum(size, 1e-300)) / noise**2)[:, None]
        before, v = v, np.linalg.solve(q.T @ weighted, weighted.T @ right)
        if np.abs(v - before).max() <= HUBER_TOLERANCE * noise.min() + floor:
            break
    return np.asarray(scale * np.linalg.lstsq(r, v, rcond=None)[0])
