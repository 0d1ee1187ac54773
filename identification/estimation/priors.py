"""What is known beforehand, and how well: Gaussian priors on linear or physical parameters.

Priors are pseudo-measurements beside those of (23), some not linear in u; the estimate is from both together. The noise
is judged by the data alone, so that a wrong prior shows as a conflict and does not hide in the noise.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from cases.base.errors import Code, IdentificationError
from cases.base.units import Array
from identification.estimation.fit import (
    Fit,
    Regression,
    column_scale,
    compress,
    degrees_of_freedom,
    determined,
    inverse_root,
)
from identification.estimation.force_noise import long_run_covariance, scores
from identification.finding import Kind, warning
from identification.model.model import Model
from identification.model.parameters import physical_form, require_names


class Prior(NamedTuple):
    """A parameter, linear or physical, its value and standard deviation beforehand [SI].

    >>> hx.Method(priors=(hx.Prior("m", 33.0, 0.5),)).priors[0].std
    0.5
    """

    name: str
    value: float
    std: float


def as_measurements(priors: Sequence[Prior], model: Model) -> Callable[[Array], tuple[Array, Array]]:
    """Priors as further rows of (23), h(u) = value + error of standard deviation std: u, shape (u,), to h and dh/du.

    Raises:
        IdentificationError: a name that the model does not have, with those that it has; two priors on one name; a
            prior that is not finite or has no uncertainty.
    """
    form, count = physical_form(model), len(model.names)
    names, known_names = [*model.names, *(p.name for p in form.parameters)], [p.name for p in priors]
    require_names(known_names, list(dict.fromkeys(names)))
    for k, prior in enumerate(priors):
        if prior.name in known_names[:k]:
            raise IdentificationError(
                problem=f"two priors on {prior.name}", remedy="combine them into one", code=Code.CONTRADICTION
            )
        if not (np.isfinite(prior.value) and np.isfinite(prior.std) and prior.std > 0.0):
            raise IdentificationError(
                problem=f"prior {prior.name} = {prior.value:g} +- {prior.std:g} needs finite numbers and a "
                "standard deviation above 0",
                remedy="what is known exactly is a known value, no prior",
                code=Code.OUT_OF_RANGE,
            )
    picks = [names.index(name) for name in known_names]

    def at(u: Array) -> tuple[Array, Array]:  # components of u beyond the model have no prior
        physical, jacobian = (value.full() for value in form.map(u[:count]))
        rows = np.zeros((len(picks), len(u)))
        rows[:, :count] = np.vstack([np.eye(count), jacobian])[picks]
        return np.r_[u[:count], physical[:, 0]][picks], rows

    return at


EVALUATIONS = 2000  # at most, of the residuals; a few are usual
ROUNDING = 1e-14  # of the forces: what rounding leaves of data without noise
CONFLICT = 3.0  # standard deviations between data and a prior from which it is reported
SILENT = 1e-9  # below this share of the information the data count as silent about a parameter


def with_priors(regression: Regression, model: Model, weights: Array, priors: Sequence[Prior]) -> Fit:
    """The most probable u.

    Covariances, rank and condition are those of data and priors together, noise and its degrees of freedom of the data.
    A finding names each prior that disagrees with the data.

    Args:
        regression: regression of the model; columns beyond it (a delay) have no prior.
        weights: diagonal of W for one sample, shape (6,); the noise is estimated, only their ratios matter.

    Raises:
        IdentificationError: priors that cannot be used (see `as_measurements`), fewer forces than unknowns,
            parameters that neither data nor priors determine, by name, or a search that fails.
    """
    at = as_measurements(priors, model)
    measured, std = (np.array([p[k] for p in priors]) for k in (1, 2))
    (root, right, rest), rows, filtered = compress(regression, weights), regression.forces.size, regression.filtered
    scale = column_scale(root)
    zero = rows * np.finfo(float).eps  # the paper's (Fig. 3)
    free, _, matrix_rank, _ = np.linalg.lstsq(root * scale, right, rcond=zero)
    freedom = degrees_of_freedom(rows, float(matrix_rank), filtered)
    floor = ROUNDING * float(np.sqrt(rest + np.sum(right**2)))
    least = max(float(np.sum((right - root @ (scale * free)) ** 2)) + rest, floor**2)
    noise = float(np.sqrt(least / freedom))  # white noise / sqrt(stride), that of (28)
    root, right = root / noise, right / noise

    def residual(u: Array) -> Array:
        return np.asarray(np.r_[root @ u - right, (at(u)[0] - measured) / std])

    def slopes(u: Array) -> Array:
        return np.vstack([root, at(u)[1] / std[:, None]])

    from scipy.optimize import least_squares  # half a second, which estimates without priors can do without

    start = scale * free
    if "m" in model.names:  # by which others are divided
        mass = model.names.index("m")
        weighed = [p.value for p in priors if p.name == "m"] or [start[mass]]
        start[mass] = weighed[0] if weighed[0] > 0.0 else 1.0
    precise = {"xtol": 1e-14, "ftol": 1e-14, "gtol": 1e-14, "max_nfev": EVALUATIONS}
    solution = least_squares(residual, start, slopes, method="lm", x_scale="jac", **precise)
    if not solution.success or not np.isfinite(solution.cost):
        raise IdentificationError(
            problem="no minimum was found with these priors",
            remedy="check their values and units, or widen them",
            code=Code.NO_CONVERGENCE,
        )
    values = np.asarray(solution.x)
    jacobian = slopes(values)
    rank, condition = determined(jacobian, regression.names, rows, regression.nuisance)
    spread = inverse_root(jacobian)
    covariance = spread @ spread.T
    residuals = regression.residuals(values)
    of_data = long_run_covariance(scores(regression.regressors, residuals, weights)) / noise**4
    of_priors = jacobian[len(root) :].T @ jacobian[len(root) :]
    robust, white_noise = covariance @ (of_data + of_priors) @ covariance, noise * float(np.sqrt(filtered.stride))
    findings = []
    for prior, value, slope in zip(priors, *at(values), strict=True):
        conflict = abs(conflict_of(prior, float(value), float(slope @ covariance @ slope)))
        if conflict > CONFLICT:
            sentence = f"prior {prior.name} disagrees with the data by {conflict:.1f} standard deviations; doubt one"
            findings.append(warning(Kind.ESTIMATOR, sentence))
    return Fit(values, covariance, robust, white_noise, freedom, residuals, weights, rank, condition, tuple(findings))


def conflict_of(prior: Prior, value: float, variance: float) -> float:
    r"""By how many standard deviations of their difference a prior is above data and other priors, 0 where they agree.

    .. math::
        z = \frac{p - \hat{p}}{\sqrt{s_p^2 - \mathrm{var}\,\hat{p}}}

    From the estimate of its parameter with all priors and its variance: information adds, so that no fit without the
    prior is needed; standard normal where they agree.
    """
    return float((prior.value - value) / np.sqrt(max(prior.std**2 - variance, SILENT * prior.std**2)))
