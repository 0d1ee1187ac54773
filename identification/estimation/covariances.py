"""Covariances that are singular, or of which two count: coordinates in which all is free, and the larger of two."""

from typing import NamedTuple

import numpy as np

from cases.base.units import Array

FIXED = 1e-13  # of the largest variance in units of the deviations: a combination that is given, not estimated


class Free(NamedTuple):
    """Coordinates x in which all that is estimated is free, and nothing that is given: u = u0 + lift x, x = down u."""

    lift: Array  # shape (u, x)
    down: Array  # shape (x, u)

    @classmethod
    def of(cls, covariance: Array) -> "Free":
        """Those of a covariance of u, shape (u, u)."""
        scale = np.sqrt(np.diag(covariance).clip(0.0))
        scale = np.where(scale > 0.0, scale, 1.0)
        values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
        directions = vectors[:, values > FIXED * values.max()] if len(values) and values.max() > 0.0 else vectors[:, :0]
        return cls(scale[:, None] * directions, directions.T / scale)


def larger_of(least: Array, other: Array) -> Array:
    """The smallest covariance that is nowhere below one that is positive definite, nor below another, shape (x, x)."""
    root = np.linalg.cholesky(least)
    inverse = np.linalg.inv(root)
    values, vectors = np.linalg.eigh(inverse @ (0.5 * (other + other.T)) @ inverse.T)
    rotated = root @ vectors
    return np.asarray((rotated * np.maximum(values, 1.0)) @ rotated.T)
