"""The estimators that a user can name, each as a function of a regression, and what they are made for.

Selections and consistency wrap an estimator, so that each combination that makes sense is a composition.

Huber's M-estimate by iteratively reweighted least squares (IRLS): gross errors count less, none is removed.
Huber & Ronchetti 2009, Robust Statistics, chapter 7. Only errors of the forces are resisted, not those of the
regressor, and one-sided ones still bias: a share e of them by up to about 1.6 e of the noise's standard deviation.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag, solve_triangular

from cases.errors import IdentificationError
from cases.sensors import Sensors
from cases.units import Array, Indices
from identification.estimation.channel_weights import EACH, full_weights, per_channel
from identification.estimation.fit import Fit, Regression, column_scale, gauss_markov, settled
from identification.estimation.force_noise import long_run_covariance
from identification.estimation.physical import consistent_of
from identification.estimation.priors import Prior, with_priors
from identification.finding import Kind, note
from identification.model import Model
from identification.parameters import Selection, select

WHITENED = ("gauss-markov", "consistent")  # which take forces whose noise is white in all channels
ALIKE = {"equal": None, "per_channel": EACH, "per_unit": (0, 0, 0, 1, 1, 1), "stated": None}
"""Weights by name -> channels with the same noise, see `Regression`; stated noise is made white before."""


@dataclass(frozen=True, slots=True)
class Method:
    """How parameters are estimated."""

    name: str  # name of the estimator
    known: Mapping[str, float]  # exact values by linear or physical name [SI]
    dropped: tuple[str, ...]  # linear parameters without a column
    priors: tuple[Prior, ...]
    # `equal`, `per_channel`, `per_unit` or `stated`, see `cases.sensors`; None for those of the case
    weights: str | None = None

    def weights_for(self, sensors: Sensors) -> str:
        """The weights of the channels: its own, or those of the case.

        Raises:
            IdentificationError: weights from stated noise where none is stated, or with an estimator of their own.
        """
        weights = self.weights or sensors.weights
        if weights == "stated" and self.name not in WHITENED:
            raise IdentificationError(
                f"the weights stated go with the estimators {', '.join(WHITENED)}; {self.name} finds its own"
            )
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
            IdentificationError: a combination that is not defined, names that the model does not have, or as the
                estimator does.
        """
        if self.priors:
            if self.name != "gauss-markov" or self.known or self.dropped:
                raise IdentificationError(
                    "priors go with the estimator gauss-markov and all parameters free; leave the other choice out, "
                    "or give what is known exactly as a prior with a small standard deviation"
                )
            weights = np.ones(6) if regression.alike is None else per_channel(regression).weights
            return with_priors(regression, model, weights, self.priors)
        fit = estimate_selected(regression, self.selection(model), ESTIMATORS[self.name])
        return consistent_of(regression, fit) if self.name == "consistent" else fit


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


HUBER_K = 1.345  # residuals beyond so many standard deviations count less: 95 % efficiency where noise is Gaussian
MAD_TO_STD = 1.482602218505602  # 1 / Phi^-1(3/4): makes the MAD of Gaussian noise its standard deviation
MEAN_SQUARE_PSI = 0.710165  # E psi(z)^2 for Gaussian z and HUBER_K: makes s0 that of Gaussian noise
HUBER_ROUNDS = 100
HUBER_TOLERANCE = 1e-7  # of a standard deviation of each parameter: far below what matters, far above rounding
SILENT = 1e-12  # of the largest force: smaller residuals of a channel are rounding, not noise


def huber(regression: Regression) -> tuple[Fit, Array]:
    """Huber's M-estimate of u with the scale of the noise estimated in turns.

    Its covariance is the sandwich of Huber 1967 and White 1980, right also where the spread of the forces changes over
    the run; weights are one over the squared normalised MAD of the channels that are alike, or ones where all are. A
    low-pass smears gross errors, so look for them before it.

    Returns:
        The fit, and the weight of each force, from 0 to 1, shape (n, 6): below 1 for 18 % of Gaussian noise.

    Raises:
        IdentificationError: as `gauss_markov`; or a channel fits without any residual.
    """
    regressors, forces, filtered = regression.regressors, regression.forces, regression.filtered
    samples, sensors, unknowns = regressors.shape
    pooled = regression.alike is None
    kind = np.asarray(regression.alike or 6 * (0,))
    std = np.array([np.sqrt(np.mean(forces.var(axis=0)[kind == k])) for k in kind])
    spread = np.ones(6) if pooled else np.maximum(std, 1e-12 * max(float(std.max()), 1e-300))
    least = np.zeros(6) if pooled else SILENT * np.abs(forces).max() / spread
    start = gauss_markov(regression, spread**-2.0)
    matrix = (regressors / spread[:, None]).reshape(-1, unknowns)
    scale = column_scale(matrix)
    q, r = np.linalg.qr(matrix * scale)  # in the coordinates v = R u the information is that of the weights alone
    right = (forces / spread).ravel()
    v, rows = q.T @ right, samples * sensors
    # Residuals are smaller than the noise by what the unknowns took, see `gauss_markov` for filtered data.
    shrunk = np.sqrt(rows * filtered.gain * filtered.stride / start.freedom)
    floor = 1e-14 * float(np.linalg.norm(right))
    converged, rounds = False, 0
    while not converged and rounds < HUBER_ROUNDS:
        residuals = right - q @ v
        noise = _noise(residuals.reshape(-1, 6), kind, least) * shrunk
        attention = _attention(residuals, noise)
        weighted = q * (attention / noise**2)[:, None]
        new = np.linalg.solve(q.T @ weighted, weighted.T @ right)
        converged = bool(np.abs(new - v).max() <= HUBER_TOLERANCE * noise.min() + floor)
        v, rounds = new, rounds + 1
    residuals = right - q @ v
    noise = _noise(residuals.reshape(-1, 6), kind, least) * shrunk
    psi = np.clip(residuals / noise, -HUBER_K, HUBER_K)
    back = scale[:, None] * solve_triangular(r, np.eye(unknowns))
    spread_of_u = back @ _bread(q, residuals, noise)
    meat = (q * (psi / noise)[:, None] ** 2).T @ q * (rows / start.freedom)
    influence = (q * (psi / noise)[:, None]).reshape(samples, sensors, unknowns).sum(axis=1)
    recorded = noise[:6] * spread / np.sqrt(filtered.gain)  # of the forces before the filter
    values, covariance = back @ v, spread_of_u @ meat @ spread_of_u.T
    robust = spread_of_u @ long_run_covariance(influence) @ spread_of_u.T
    s0 = float(shrunk * np.sqrt(np.mean(psi**2) / MEAN_SQUARE_PSI))  # Huber's proposal 2, for a scale near it
    s0, weights = (s0 * float(recorded[0]), np.ones(6)) if pooled else (s0, recorded**-2.0)
    left, found = regression.residuals(values), settled("robust", converged, rounds)
    fit = Fit(values, covariance, robust, s0, start.freedom, left, weights, start.rank, start.condition, found)
    return fit, _attention(residuals, noise).reshape(samples, sensors)


def _noise(residuals: Array, kind: Indices, least: Array) -> Array:
    """Normalised MAD about zero, which the offsets make the centre, one value a force, shape (6 n,)."""
    size = np.abs(residuals)
    mad = np.array([np.median(size[:, kind == k]) for k in kind])
    silent = mad <= least
    if silent.any():
        raise IdentificationError(
            f"channel {int(np.argmax(silent)) + 1} fits without any residual; check it, record more, or pool the scales"
        )
    return np.tile(MAD_TO_STD * mad, len(residuals))


def _attention(residuals: Array, noise: Array) -> Array:
    """psi(z) / z of Huber's psi, shape (6 n,)."""
    return np.minimum(1.0, HUBER_K * noise / np.maximum(np.abs(residuals), np.finfo(float).tiny))


def _bread(q: Array, residuals: Array, noise: Array) -> Array:
    """Inverse of the sum of psi' a a^T in the coordinates of q, shape (u, u)."""
    inner = q[np.abs(residuals) <= HUBER_K * noise]
    slope = noise[np.abs(residuals) <= HUBER_K * noise] ** -2.0
    information = (inner * slope[:, None]).T @ inner
    if np.linalg.cond(information) > 1.0 / np.finfo(float).eps:
        raise IdentificationError("too few forces agree with each other for a covariance of the robust estimate")
    return np.asarray(np.linalg.inv(information))


def robust_of(regression: Regression) -> Fit:
    """Huber's M-estimate: gross errors of the forces count less."""
    fit, factors = huber(regression)
    share = ", ".join(f"{100 * r:.0f}" for r in np.mean(factors < 1.0, axis=0))
    sentence = f"robust: {share} % of the samples of channels 1 to 6 count less (18 % where noise is Gaussian)"
    return replace(fit, findings=(note(Kind.ESTIMATOR, sentence), *fit.findings))


ESTIMATORS: dict[str, Callable[[Regression], Fit]] = {
    "gauss-markov": gauss_markov_of,
    "robust": robust_of,
    "full": lambda regression: full_weights(regression)[0],  # (24) with W from the channels' full covariance
    "consistent": gauss_markov_of,  # then the nearest parameters that a body of positive density has
}


def method(
    name: str = "gauss-markov",
    known: Mapping[str, float] | None = None,
    dropped: Sequence[str] = (),
    priors: Sequence[Prior] = (),
    weights: str | None = None,
) -> Method:
    """A method by the name of its estimator.

    Raises:
        IdentificationError: no such estimator or weights, with those that there are.
    """
    if weights is not None and weights not in ALIKE:
        raise IdentificationError(f"weights {weights!r} are unknown; choose {', '.join(ALIKE)}")
    if name not in ESTIMATORS:
        raise IdentificationError(f"estimator {name!r} is unknown; choose {', '.join(ESTIMATORS)}")
    return Method(name, dict(known or {}), tuple(dropped), tuple(priors), weights)
