"""Control points of the features over cells of angles and angular rates: every feature vector is a mixture of them.

Angles. A function of an angle in the span of 1, cos, sin is a rational quadratic Bezier curve with positive weights
over an interval of half width h below 90 degrees: it stays in the convex hull of its values at both ends and of a
third control point, f(0) + (f(0) - (f(-h) + f(h)) / 2) / cos h. Gravity, specific and angular acceleration in {P} are
such functions of each angle. The others are interpolated in that span at the middle and both ends; what that misses is
bounded by Polya's mean value theorem, |f - Pf| <= max|f''' + f'| max|w| with w(t) = t - h sin t / sin h, since
D (D^2 + 1) is disconjugate there:

- Gibbs vector: turning by an angle moves it along a straight line, g = k0 + k1 tan(t/2 - t0), and
  |g''' + g'| = 3/4 |k1| sec^4 <= 3 / (4 q^4), q the cosine of half the whole rotation's angle.
- products of the angular velocity: a harmonic of second order with amplitude a has |f''' + f'| <= 6 a; a is at most
  (pitch'^2 + yaw'^2) / 2 along roll, yaw'^2 / 2 along pitch, 0 along yaw.

Three angles: g - P1 P2 P3 g = (1 - P1) g + P1 (1 - P2) g + P1 P2 (1 - P3) g, and |P f| <= sqrt(2) max|f|.

Angular rates. The features are polynomials of second degree in each rate, hence in the hull of the control points with
(r, r^2) = (l, l^2), ((l + u) / 2, l u), (u, u^2).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.bounds.features import PAIRS, Features

Array = NDArray[np.float64]

NODES = np.array(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3, indexing="ij")).reshape(3, 27).T
CONTROL = np.array(np.meshgrid(*[[0, 1, 2]] * 3, indexing="ij")).reshape(3, 27).T
_INTERPOLATION = np.sqrt(2.0)  # norm of the interpolation at -h, 0, h: 1 + max(sin t/sin h - (1-cos t)/(1-cos h))
WIDEST = np.pi / 4  # [rad] of a half width: the enclosure needs less than pi / 2


class Enclosure(NamedTuple):
    """Control points over n cells."""

    tables: Array  # T of the features at the control points of the angles, shape (n, 27, 21, 15)
    products: Array  # products of the rates at their control points, shape (n, 27, 6)
    gibbs_error: Array  # what the interpolated Gibbs vector misses, its length, shape (n,)
    product_error: Array  # what each interpolated product of the angular velocity misses, shape (n,)
    angle_error: Array  # what an angle itself misses when interpolated, shape (n, 3)


def enclose(features: Features, low: Array, high: Array) -> Enclosure:
    """Control points over cells of roll, pitch, yaw and their rates, shapes (n, 6) [rad, rad/s].

    Half widths of the angles must be at most `WIDEST`.
    """
    count, middle, half = len(low), (low + high) / 2, (high - low) / 2
    nodes = middle[:, None, :3] + NODES * half[:, None, :3]
    tables = features.tables(nodes.reshape(-1, 3)).reshape(count, 3, 3, 3, -1)
    for axis in range(3):
        tables = np.moveaxis(_to_control(np.moveaxis(tables, 1 + axis, 1), half[:, axis]), 1, 1 + axis)
    missed = _missed(half[:, :3])
    return Enclosure(
        tables.reshape(count, 27, 21, 15),
        rate_products(low[:, 3:], high[:, 3:]),
        _gibbs_error(low[:, :3], high[:, :3], missed),
        _product_error(low[:, 3:], high[:, 3:], missed),
        missed,
    )


def _to_control(values: Array, half: Array) -> Array:
    """Values at -h, 0, h along axis 1 -> control points."""
    cosine = np.cos(half).reshape(-1, *[1] * (values.ndim - 2))
    control = values.copy()
    control[:, 1] += (values[:, 1] - (values[:, 0] + values[:, 2]) / 2) / cosine
    return control


def rate_products(low: Array, high: Array) -> Array:
    """Products of the rates at their 27 control points, shapes (n, 3) -> (n, 27, 6)."""
    single = np.stack([low, (low + high) / 2, high], axis=1)
    square = np.stack([low**2, low * high, high**2], axis=1)
    columns = [
        square[:, CONTROL[:, i], i] if i == j else single[:, CONTROL[:, i], i] * single[:, CONTROL[:, j], j]
        for i, j in PAIRS
    ]
    return np.stack(columns, axis=-1)


def _missed(half: Array) -> Array:
    """max|t - h sin t / sin h| for |t| <= h; it is stationary where cos t = sin h / h."""
    ratio = np.sinc(half / np.pi)
    t = np.arccos(np.clip(ratio, -1.0, 1.0))
    return np.abs(t - np.sin(t) / ratio)


def _gibbs_error(low: Array, high: Array, missed: Array) -> Array:
    largest = np.maximum(np.abs(low), np.abs(high)) / 2
    q = np.prod(np.cos(largest), axis=1) - np.prod(np.sin(largest), axis=1)  # real part of the quaternion, at least
    chain = missed @ _INTERPOLATION ** np.arange(3)
    with np.errstate(divide="ignore"):
        return np.asarray(np.where((q > 0.0) & (largest.max(axis=1) < np.pi / 2), 0.75 / q**4 * chain, np.inf))


def _product_error(low: Array, high: Array, missed: Array) -> Array:
    square = np.maximum(low**2, high**2)
    along_roll, along_pitch = 3.0 * (square[:, 1] + square[:, 2]), 3.0 * square[:, 2]
    return np.asarray(along_roll * missed[:, 0] + _INTERPOLATION * along_pitch * missed[:, 1])
