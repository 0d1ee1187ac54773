"""Parts of deviations by their causes, from the covariances of u."""

from collections.abc import Mapping

import numpy as np

from cases.base.units import Array
from cases.tolerances import kind_of
from identification.findings.tolerances import MEMORY, NOISE
from identification.model.model import Model
from identification.model.parameters import physical_form


def budget_rows(
    model: Model, u: Array, white: Array, random: Array, biases: Mapping[str, Array]
) -> dict[str, dict[str, float]]:
    """Of each physical parameter the parts of its deviation by their causes [SI].

    Args:
        model: model of the parameters.
        u: linear parameters, shape (u,).
        white: their covariance by white noise, shape (u, u).
        random: by all but tolerances, shape (u, u).
        biases: by a deviation of each size of a tolerance, shapes (u, k), by its key.
    """
    form = physical_form(model)

    def variances(covariance: Array) -> Array:
        return np.diag(form.of(u, covariance)[1]).clip(0.0)

    parts = {NOISE: variances(white), MEMORY: np.maximum(variances(random) - variances(white), 0.0)}
    for key, bias in biases.items():
        parts[kind_of(key)] = parts.get(kind_of(key), 0.0) + variances(bias @ bias.T)
    return {
        p.name: {kind: float(np.sqrt(variance[k])) for kind, variance in parts.items()}
        for k, p in enumerate(form.parameters)
    }
