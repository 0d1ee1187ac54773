"""What is known beforehand, and how well: Gaussian priors on linear or physical parameters.

Estimation from data and priors together: priors are pseudo-measurements beside those of (23).

The noise is judged by the data alone, so that a wrong prior shows as a conflict and does not hide in s0.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from cases.units import Array
from identification.estimation.compressed import (
    column_scale,
    compress,
    degrees_of_freedom,
    determined,
    inverse_root,
    long_run_covariance,
    scores,
)
from identification.estimation.fit import Fit, Regression
from identification.estimation.nonlinear import gauss_newton
from identification.model import Model
from identification.parameters import PhysicalForm, physical_form, require_names


class Prior(NamedTuple):
    """A parameter, linear or physical, its value and standard deviation beforehand [SI]."""

    name: str
    value: float
    std: float


@dataclass(frozen=True, slots=True)
class PseudoMeasurements:
    """Priors as further rows of (23): h(u) = value + error of standard deviation std."""

    priors: tuple[Prior, ...]  # at most one for each name
    model: Model
    form: PhysicalForm

    @classmethod
    def of(cls, priors: Sequence[Prior], model: Model) -> "PseudoMeasurements":
        """Checks the priors.

        Raises:
            IdentificationError: a name that the model does not have, with those that it has; two priors on one name; a
                prior that is not finite or has no uncertainty.
        """
        form = physical_form(model)
        names = [p.name for p in priors]
        require_names(names, list(dict.fromkeys([*model.names, *(p.name for p in form.parameters)])))
        for k, prior in enumerate(priors):
            if prior.name in names[:k]:
                raise IdentificationError(f"two priors on {prior.name}; combine them into one")
            if not (np.isfinite(prior.value) and np.isfinite(prior.std) and prior.std > 0.0):
                raise IdentificationError(
                    f"prior {prior.name} = {prior.value:g} +- {prior.std:g} needs finite numbers and a standard "
                    "deviation above 0; what is known exactly is fixed by a selection"
                )
        return cls(tuple(priors), model, form)

    @property
    def values(self) -> Array:
        """Shape (priors,) [SI]."""
        return np.array([p.value for p in self.priors])

    @property
    def std(self) -> Array:
        """Shape (priors,) [SI]."""
        return np.array([p.std for p in self.priors])

    @property
    def linear(self) -> NDArray[np.bool_]:
        """Which of them are on a component of u, shape (priors,)."""
        return np.array([p.name in self.model.names for p in self.priors], dtype=bool)

    def at(self, u: Array) -> tuple[Array, Array]:
        """H(u), shape (priors,), and dh/du, shape (priors, u); components of u beyond the model have no prior."""
        count = len(self.model.names)
        physical, jacobian = (value.full() for value in self.form.map(u[:count]))
        names = [*self.model.names, *(p.name for p in self.form.parameters)]
        picks = [names.index(prior.name) for prior in self.priors]
        rows = np.zeros((len(self.priors), len(u)))
        rows[:, :count] = np.vstack([np.eye(count), jacobian])[picks]
        return np.r_[u[:count], physical[:, 0]][picks], rows


TOLERANCE = 1e-9  # of a standard deviation of each parameter
ROUNDING = 1e-14  # of the forces: what rounding leaves of data without noise
SILENT = 1e-9  # below this share of the information the data count as silent about a parameter


class PriorEffect(NamedTuple):
    """What a prior did to the parameter that it is about."""

    prior: Prior
    # by how many of the standard deviations that the estimate would have without this prior the prior moved it; 0 where
    # the data are silent
    moved: float
    # by how many standard deviations of their difference the prior is above data and other priors; standard normal
    # where they agree, 0 where the data are silent
    conflict: float
    data_share: float  # of the information about this parameter, the share that is not this prior's, 0 to 1


def with_priors(
    regression: Regression, model: Model, weights: Array, priors: Sequence[Prior]
) -> tuple[Fit, tuple[PriorEffect, ...]]:
    """The most probable u, by Gauss-Newton since a prior on a physical parameter is not linear in u; effects of priors.

    Covariances, rank and condition are those of data and priors together, s0 and its degrees of freedom of the data.

    Args:
        regression: regression of the model; columns beyond it (a delay) have no prior.
        weights: diagonal of W for one sample, shape (6,); s0 is estimated, only their ratios matter.
        priors: priors, at most one for each name.

    Raises:
        IdentificationError: priors that cannot be used (see `PseudoMeasurements.of`), fewer forces than unknowns,
            parameters that neither data nor priors determine, by name, or a search that fails.
    """
    pseudo = PseudoMeasurements.of(priors, model)
    compressed, filtered = compress(regression, weights), regression.filtered
    scale = column_scale(compressed.root)
    zero = compressed.rows * np.finfo(float).eps  # the paper's (Fig. 3)
    free, _, matrix_rank, _ = np.linalg.lstsq(compressed.root * scale, compressed.right, rcond=zero)
    freedom = degrees_of_freedom(compressed.rows, float(matrix_rank), filtered)
    floor = ROUNDING * float(np.sqrt(compressed.rest + np.sum(compressed.right**2)))
    least = max(compressed.chi_squared(scale * free), floor**2)
    noise = float(np.sqrt(least / freedom))  # s0 / sqrt(stride), the noise of (28)
    root, right = compressed.root / noise, compressed.right / noise

    def residual(u: Array) -> tuple[Array, Array]:
        values, rows = pseudo.at(u)
        errors = np.concatenate([root @ u - right, (values - pseudo.values) / pseudo.std])
        return errors, np.vstack([root, rows / pseudo.std[:, None]])

    values, _ = gauss_newton(residual, _start(root, right, pseudo), TOLERANCE + floor / noise)
    jacobian = residual(values)[1]
    rank, condition = determined(jacobian, regression.names, compressed.rows, regression.nuisance)
    spread = inverse_root(jacobian)
    covariance = spread @ spread.T
    residuals = regression.residuals(values)
    of_data = long_run_covariance(scores(regression.regressors, residuals, weights)) / noise**4
    of_priors = jacobian[len(root) :].T @ jacobian[len(root) :]
    fit = Fit(
        values=values,
        covariance=covariance,
        covariance_robust=covariance @ (of_data + of_priors) @ covariance,
        s0=noise * float(np.sqrt(filtered.stride)),
        freedom=freedom,
        residuals=residuals,
        weights=weights,
        rank=rank,
        condition=condition,
    )
    return fit, _effects(pseudo, fit)


def _start(root: Array, right: Array, pseudo: PseudoMeasurements) -> Array:
    """The smallest u that data and linear priors agree on, with a mass above zero, by which others are divided."""
    linear = pseudo.linear
    rows = np.zeros((len(linear), root.shape[1]))
    for k, prior in enumerate(pseudo.priors):
        if linear[k]:
            rows[k, pseudo.model.names.index(prior.name)] = 1.0 / prior.std
    matrix = np.vstack([root, rows])
    scale = column_scale(matrix)
    start = scale * np.linalg.lstsq(matrix * scale, np.r_[right, linear * pseudo.values / pseudo.std], rcond=None)[0]
    mass = pseudo.model.names.index("m")
    if start[mass] <= 0.0:
        start[mass] = max([p.value for p in pseudo.priors if p.name == "m" and p.value > 0.0], default=1.0)
    return np.asarray(start)


def _effects(pseudo: PseudoMeasurements, fit: Fit) -> tuple[PriorEffect, ...]:
    """Takes one prior at a time away again: information adds, so that no further fit is needed."""
    values, rows = pseudo.at(fit.values)
    effects = []
    for prior, value, row in zip(pseudo.priors, values, rows, strict=True):
        variance = float(row @ fit.covariance @ row)
        share = float(np.clip(1.0 - variance / prior.std**2, 0.0, 1.0))
        shift = conflict = 0.0
        if share > SILENT:
            without = np.sqrt(share / variance)  # one over the standard deviation without this prior
            shift = float((prior.value - value) / (prior.std**2 * without))
            conflict = shift * prior.std / np.sqrt(variance)
        effects.append(PriorEffect(prior, shift, float(conflict), share))
    return tuple(effects)
