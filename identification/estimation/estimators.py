"""Estimators: Gauss-Markov with known values, priors and weights of the channels, and one that resists gross errors.

W (24) is 1, stated, or follows from the residuals of each channel in turns with the fit.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Annotated

import numpy as np
from scipy.linalg import block_diag

from cases.base.doors import checks_arguments
from cases.base.errors import Code, IdentificationError, option
from cases.base.options import Option, documented
from cases.base.units import Array
from cases.sensors import Sensors
from identification.estimation.fit import (
    Fit,
    Regression,
    column_scale,
    gauss_markov,
    orthonormal,
    require_alive,
)
from identification.estimation.force_noise import long_run_covariance
from identification.estimation.priors import Prior, with_priors
from identification.finding import Finding, Kind, note
from identification.model.model import Model
from identification.model.parameters import Selection, physical_form, require_physical, select, tangent_at
from identification.model.stated_noise import whitening_of
from identification.options import PRIORS, Dropped, Known, Weights

MOST_STEPS = 50  # of Gauss and Newton for the non-linear form
STEP = 1e-6  # of a standard deviation of each parameter: a smaller step is the last
ROUNDING = 1e-12  # of a value, likewise
EACH = (0, 1, 2, 3, 4, 5)  # `Regression.alike` where each channel has noise of its own
ALIKE = {
    "equal": None, "per_channel": EACH, "per_unit": (0, 0, 0, 1, 1, 1), "stated": None, "huber": EACH, "full": EACH,
}  # fmt: skip
"""Weights by name -> channels with the same noise, see `Regression`; stated and full noise is made white before."""


@checks_arguments
@documented()
@dataclass(frozen=True, slots=True)
class Method:
    """What is known beforehand, and how channels are weighted.

    >>> hx.Method(known={"m": 93.1}, weights="per_channel").known
    {'m': 93.1}

    Args:
        OPTIONS
        tangent: local Jacobian of the non-linear form, where a fit of it has ended.
        robust: whether deviations allow for noise with memory and errors of the pose; without that those of white
            noise, (28), stand in their place: enough where values and residuals alone are looked at.

    Raises:
        IdentificationError: there are no such weights, or choices that do not go together.
    """

    known: Known = field(default_factory=dict)
    dropped: Dropped = ()
    priors: Annotated[tuple[Prior, ...], PRIORS] = ()
    weights: Weights = None
    nonlinear: Annotated[
        bool,
        Option(
            "Iterate the non-linear form (18) by its local Jacobian: physical parameters, also central inertia, may be "
            "known then."
        ),
    ] = False
    tangent: Selection | None = None
    robust: bool = True

    def __post_init__(self) -> None:
        if self.weights is not None and self.weights not in ALIKE:
            raise IdentificationError(
                problem=f"weights {self.weights!r} are unknown", remedy=f"choose {', '.join(ALIKE)}", code=Code.UNKNOWN
            )
        stated_numbers = [*self.known.items(), *((p.name, number) for p in self.priors for number in (p.value, p.std))]
        for name, value in stated_numbers:
            if not (isinstance(name, str) and isinstance(value, Real) and math.isfinite(value)):
                raise IdentificationError(
                    place=f"Method: {name} = {value!r}",
                    problem="is not a finite number",
                    remedy="give one in SI",
                    code=Code.OUT_OF_RANGE,
                )
        if self.priors and (self.nonlinear or self.weights in ("huber", "full")):
            raise IdentificationError(
                problem="priors go with the linear form and the weights equal, per_channel, per_unit or stated",
                remedy="leave the other choice out",
                code=Code.CONTRADICTION,
            )
        if self.priors and (self.known or self.dropped):
            raise IdentificationError(
                problem="priors go with all parameters free",
                remedy="give what is known exactly as a prior with a small standard deviation",
                code=Code.CONTRADICTION,
            )

    def weights_for(self, sensors: Sensors) -> str:
        """The weights of the channels: its own, or those of the case.

        Raises:
            IdentificationError: weights from stated noise where none is stated.
        """
        weights = self.weights or sensors.weights
        if weights == "stated" and sensors.force_noise is None:
            raise IdentificationError(
                problem="weights stated: the case states no noise",
                remedy="give sensors.force_noise_N and acceleration_noise_m_s2, or "
                "choose the weights equal or per_channel",
                code=Code.MISSING,
            )
        return weights

    def selection(self, model: Model) -> Selection:
        """What of a model is estimated.

        Raises:
            IdentificationError: names that the model does not have, or known values that are not linear.
        """
        if self.tangent is not None:
            return self.tangent
        if self.nonlinear:  # to begin from
            require_physical(model, (*self.known, *self.dropped))
            return select(model, {n: v for n, v in self.known.items() if not n.startswith("IC")}, self.dropped)
        return select(model, self.known, self.dropped)

    def estimate(self, regression: Regression, model: Model) -> Fit:
        """The estimate of all parameters of a model, from a regression whose first columns are its own.

        Raises:
            IdentificationError: names that the model does not have, or as the estimator does.
        """
        if self.priors:
            weights = np.ones(6) if regression.alike is None else per_channel(regression.within_span()).weights
            return with_priors(regression, model, weights, self.priors)
        estimator = huber_of if self.weights == "huber" else gauss_markov_of
        return estimate_selected(regression, self.selection(model), estimator)

    def settled(self, regression: Regression, model: Model) -> tuple["Method", tuple[Finding, ...]]:
        """The method at the minimum of the non-linear form (18), and how it was found; itself where that is not asked.

        Each step is the linear estimate along the local Jacobian.

        Raises:
            IdentificationError: no minimum was found, or as `estimate` does.
        """
        if not self.nonlinear:
            return self, ()
        begin = replace(self, tangent=None)
        linear = begin.estimate(regression, model)
        count, form = len(model.names), physical_form(model)
        known = np.array([p.name in self.known for p in form.parameters])
        at = form.of(linear.values[:count], np.zeros((count, count)))[0]
        at[[name in self.dropped for name in model.names]] = 0.0
        at[known] = [self.known[p.name] for p, fixed in zip(form.parameters, known, strict=True) if fixed]
        dropped = np.array([name in self.dropped for name in model.names])
        for steps in range(1, MOST_STEPS + 1):
            tangent = tangent_at(model, at, known | dropped)
            fit = replace(self, tangent=tangent).estimate(regression, model)
            free = np.linalg.lstsq(tangent.basis, fit.values[:count] - tangent.offset, rcond=None)[0]
            step = free - at[~(known | dropped)]
            at[~(known | dropped)] = free
            half = np.linalg.pinv(tangent.basis)
            spread = np.sqrt(np.diag(half @ fit.covariance[:count, :count] @ half.T))
            if np.all(np.abs(step) <= STEP * spread + ROUNDING * np.abs(free)):
                apart = np.abs(form.of(linear.values[:count], np.zeros((count, count)))[0][~(known | dropped)] - free)
                most = float(np.max(apart / np.maximum(spread, np.finfo(float).tiny)))
                words = f"non-linear form (18): {steps} Gauss-Newton steps; the linear form, from which they began, is "
                words += f"at most {most:.2g} standard deviations away"
                return replace(self, tangent=tangent_at(model, at, known | dropped)), (note(Kind.ESTIMATOR, words),)
        raise IdentificationError(
            problem=f"the non-linear form has no minimum within {MOST_STEPS} steps",
            remedy=f"leave {option('nonlinear', 'estimator')} out",
            code=Code.NO_CONVERGENCE,
        )


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


def symmetric_platform(model: Model, nonlinear: bool = False) -> dict[str, float]:
    """What is known of a symmetric platform without accessories: five parameters (section 5), by name [SI].

    Where xC = yC = 0 products of inertia are alike about the origin of {P} and about the centre of gravity.
    """
    products = [f"IC{k}" if nonlinear else f"I{k}" for k in ("12", "13", "23") if f"I{k}" in model.names]
    return dict.fromkeys(("xC", "yC", *products), 0.0) if "m" in model.names else {}


def gauss_markov_of(regression: Regression) -> Fit:
    """(24) with W = 1, or from the variance of each channel."""
    return gauss_markov(regression, np.ones(6)) if regression.alike is None else per_channel(regression)


WEIGHT_ROUNDS = 20
WEIGHT_TOLERANCE = 1e-6
LEAST_FREEDOM = 2.0  # forces of a channel beyond what the parameters take, to judge its variance by


def per_channel(regression: Regression) -> Fit:
    r"""Gauss-Markov with W from the residual variance of each channel, or of those that are alike, in turns with u.

    .. math::
        W_{ii} = \frac{1}{s_i^2}, \qquad s_i^2 = \frac{\sum_k r_{ki}^2}{n - h_i}, \qquad
        h_i = W_{ii} \sum_k a_{ki}^T F^{-1} a_{ki}

    for n samples that were not filtered, residuals :math:`r_{ki}`, rows :math:`a_{ki}^T` of :math:`A_k`, and F of (24).

    Each channel pays for the unknowns by its own leverage, the trace of its block of the hat matrix: the fixed point is
    the restricted maximum likelihood (Patterson & Thompson 1971, Biometrika 58:545). Equal shares instead would let
    a channel that the parameters follow become ever more certain.

    Raises:
        IdentificationError: as `gauss_markov`; or too few samples to judge a channel's variance by.
    """
    regressors, forces, filtered = regression.regressors, regression.forces, regression.filtered
    if len(forces) < 2:
        raise IdentificationError(
            problem=f"{len(forces)} sample has no scatter to weigh the channels by",
            remedy="record more",
            code=Code.TOO_FEW,
        )
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
                problem=f"channel {worst + 1} has {independent:.0f} independent samples, of which the "
                f"parameters take {leverage[worst]:.1f}",
                remedy=f"at least {LEAST_FREEDOM:g} more are needed to know its noise: record more, "
                "or choose a model with fewer parameters",
                code=Code.TOO_FEW,
            )
        variance = same @ np.sum(fit.residuals**2, axis=0) * filtered.stride / (same @ freedom)
        if variance.min() <= (1e-12 * np.abs(forces).max()) ** 2 * np.finfo(float).eps:
            raise IdentificationError(
                problem=f"channel {int(variance.argmin()) + 1} fits without any residual, so that it has no variance",
                remedy=f"check what it recorded, or choose {option('weights')} equal",
                code=Code.NO_EXCITATION,
            )
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
    r"""Covariance of u where poses are independent of each other, channels of a pose not, shape (u, u).

    .. math::
        C = \sum_j g_j g_j^T, \qquad g_j = F^{-1} A_j^T W^{1/2} (1 - H_j)^{-1} W^{1/2} r_j, \qquad
        H_j = W^{1/2} A_j F^{-1} A_j^T W^{1/2}

    The cluster form of HC3 (CR3; MacKinnon & White 1985, Bell & McCaffrey 2002): residuals of a pose are replaced by
    what they would be had the pose not been part of the fit, so that the covariance of a few poses is not too small.

    From A_j, shape (n, 6, u), residuals of a fit to these, shape (n, 6), and the diagonal of W, shape (6,).
    """
    q, half = orthonormal(regressors, weights)
    left_out = np.linalg.pinv(np.eye(6) - q @ q.transpose(0, 2, 1), rcond=1e-9, hermitian=True)
    scores = np.einsum("nku,nkl,nl->nu", q, left_out, np.sqrt(weights) * residuals)
    return np.asarray(half @ (scores.T @ scores) @ half.T)


HUBER_K = 1.345  # residuals beyond so many standard deviations count less: 95 % efficiency where noise is Gaussian
MEAN_SQUARE_PSI = 0.710165  # E psi(z)^2 for Gaussian z and HUBER_K
MAD_TO_STD = 1.482602218505602  # 1 / Phi^-1(3/4): makes the MAD of Gaussian noise its standard deviation
HUBER_ROUNDS = 100
HUBER_TOLERANCE = 1e-7  # of a standard deviation of each parameter: far below what matters, far above rounding


LEAST = 60  # independent samples: with fewer the 21 variances and covariances follow the noise they are to judge
DEPENDENT = 1e-10  # least eigenvalue of the channels' correlation below which one follows from the others


def full_whitening(regression: Regression, selection: Selection) -> tuple[Array, float]:
    """Root of W, the inverse of the covariance of the channels' residuals, in turns with the fit, shape (6, 6).

    W from n samples is on average too large by n / (n - 7), the mean of the inverse Wishart distribution (Hartlap,
    Simon & Schneider 2007, Astron. Astrophys. 464:399), and its scatter costs the estimate up to as much again: the
    covariance of an estimate is to be raised by the square, the second value.

    Raises:
        IdentificationError: too few samples for 21 variances, or a channel that follows from others.
    """
    filtered = regression.filtered
    samples, sensors, unknowns = regression.regressors.shape
    independent = samples * filtered.gain * filtered.stride
    freedom = independent - unknowns / sensors  # each channel pays its share of the unknowns
    if independent < LEAST:
        raise IdentificationError(
            problem=f"{independent:.0f} independent samples are too few for the covariance of six "
            f"channels, at least {LEAST} are needed",
            remedy=f"record more, or choose {option('weights')} per_channel",
            code=Code.TOO_FEW,
        )
    fit = estimate_selected(regression, selection, gauss_markov_of)
    plain, before = regression._replace(alike=None), np.zeros((6, 6))
    whitening: Array = np.eye(6)
    for _ in range(WEIGHT_ROUNDS):
        channels = fit.residuals.T @ fit.residuals * filtered.stride / freedom
        std = np.sqrt(np.diag(channels))
        if np.linalg.eigvalsh(channels / np.outer(std, std))[0] < DEPENDENT:
            raise IdentificationError(
                problem="the noise of a channel follows from that of others",
                remedy=f"is one computed from them? Choose {option('weights')} per_channel",
                code=Code.NO_EXCITATION,
            )
        whitening = whitening_of(channels)
        if np.abs((channels - before) / np.outer(std, std)).max() < WEIGHT_TOLERANCE:
            break
        before = channels
        white = estimate_selected(plain.whitened(whitening), selection, gauss_markov_of)
        fit = replace(white, residuals=regression.residuals(white.values))
    return whitening, (independent / (independent - sensors - 1)) ** 2


def huber_of(regression: Regression) -> Fit:
    """Huber's M-estimate with its covariances: the sandwich of Huber 1967 and White 1980, and for noise with memory.

    Weights are one over the squared normalised MAD of each channel.

    Raises:
        IdentificationError: as `gauss_markov`, or too few forces agree with each other.
    """
    regressors, forces, filtered = regression.regressors, regression.forces, regression.filtered
    require_alive(forces)
    values = huber(regression)
    residuals, kind = regression.residuals(values), np.asarray(regression.alike or 6 * (0,))
    mad = np.array([np.median(np.abs(residuals[:, kind == k])) for k in kind])
    if mad.min() <= 1e-12 * np.abs(forces).max():
        raise IdentificationError(
            problem=f"channel {int(mad.argmin()) + 1} fits without any residual",
            remedy="check it",
            code=Code.NO_EXCITATION,
        )
    start = gauss_markov(regression, mad**-2.0)
    # residuals are smaller than the noise by what the unknowns took, see `gauss_markov` for filtered data
    shrunk = float(np.sqrt(forces.size * filtered.gain * filtered.stride / start.freedom))
    noise = MAD_TO_STD * mad * shrunk
    q, half = orthonormal(regressors, noise**-2.0)
    sizes = residuals / noise
    psi, inner = np.clip(sizes, -HUBER_K, HUBER_K), np.abs(sizes) <= HUBER_K
    information = np.einsum("nku,nk,nkv->uv", q, inner.astype(float), q)
    if np.linalg.cond(information) > 1.0 / np.finfo(float).eps:
        raise IdentificationError(
            problem="too few forces agree with each other for a robust estimate",
            remedy="choose other weights",
            code=Code.TOO_FEW,
        )
    spread = half @ np.linalg.inv(information)
    meat = np.einsum("nku,nk,nkv->uv", q, psi**2, q) * (forces.size / start.freedom)
    memory = long_run_covariance(np.einsum("nku,nk->nu", q, psi))
    share = ", ".join(f"{100 * s:.0f}" for s in np.mean(~inner, axis=0))
    words = f"huber: {share} % of the samples of channels 1 to 6 count less (18 % where noise is Gaussian)"
    scale = shrunk * float(np.sqrt(np.mean(psi**2) / MEAN_SQUARE_PSI))  # Huber's proposal 2, for a scale near it
    return replace(
        start, values=values, covariance=spread @ meat @ spread.T, covariance_robust=spread @ memory @ spread.T,
        white_noise=scale, residuals=residuals, weights=filtered.gain / noise**2,
        findings=(note(Kind.ESTIMATOR, words),),
    )  # fmt: skip


def huber(regression: Regression) -> Array:
    r"""Huber's M-estimate of u, shape (u,), by iteratively reweighted least squares: gross errors count less.

    .. math::
        \sum_{k,i} \frac{a_{ki}}{s_i} \psi\left(\frac{r_{ki}}{s_i}\right) = 0, \qquad
        \psi(z) = \max(-c, \min(c, z)), \qquad c = 1.345, \qquad s_i = 1.4826 \, \mathrm{med}_k |r_{ki}|

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
