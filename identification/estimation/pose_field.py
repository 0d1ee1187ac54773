"""Errors of a channel that are alike in poses near each other, as a random field over the lengths of the struts."""

import numpy as np

from cases.base.units import Array
from cases.sensors import PoseField


def squared_distances(places: Array, others: Array) -> Array:
    """Between places, shapes (n, d) and (m, d), shape (n, m)."""
    middle = others.mean(axis=0)
    first, second = places - middle, others - middle
    total = np.sum(first**2, axis=1)[:, None] + np.sum(second**2, axis=1)
    return np.asarray(np.maximum(total - 2.0 * first @ second.T, 0.0))


def matern(distance: Array) -> tuple[Array, Array]:
    """Matern's correlation of smoothness 3/2 at a distance in lengths, and its derivative by the length's logarithm."""
    scaled = np.sqrt(3.0) * distance
    fading = np.exp(-scaled)
    return (1.0 + scaled) * fading, scaled**2 * fading


def field_covariance(field: PoseField, struts: Array) -> Array:
    """Covariance of a channel's errors between places, shape (n, n) [N^2]; struts: shape (n, 6) [m]."""
    return field.size**2 * matern(np.sqrt(squared_distances(struts, struts)) / field.length)[0]
