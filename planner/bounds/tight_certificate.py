"""The largest value over the box of d less the Lagrangian of the moment constraints, proven.

The function is h = d - l, d = y^T Q y the directional derivative, l that of `planner.bounds.moments.Multipliers`. Over
a cell of angles, angular rates and accelerations it is convex in x, y, z (corners); features and products of rates lie
in the hull of control points (`planner.bounds.branch`); and in the accelerations a = m + e, |e_i| <= h_i, it is
quadratic. There mixed terms are bounded by 2 C_ij e_i e_j <= |C_ij| (e_i^2 h_j / h_i + e_j^2 h_i / h_j), after which
every acceleration has its maximum by itself, in closed form.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from planner.bounds.branch import CONTROL, Bounded, Enclosure, enclose
from planner.bounds.certificate import BoxDerivative, first_cells
from planner.bounds.features import Features
from planner.bounds.moments import Multipliers

Array = NDArray[np.float64]

_CORNERS = np.array(list(product([-1.0, 1.0], repeat=3)))  # of x, y, z
_ACCELERATIONS = slice(3, 9)  # columns of T
_FIXED = [0, 1, 2, *range(9, 15)]  # constant, x, y, products of rates
_ANGLES_AND_RATES = [3, 4, 5, 9, 10, 11]


def first_tight_cells(features: Features) -> tuple[Array, Array]:
    """Cells of angles, angular rates [rad, rad/s] and accelerations [shares] that cover the box, shapes (n, 12)."""
    low, high = first_cells(features)
    wide = np.ones((len(low), 6))
    return np.hstack([low, -wide]), np.hstack([high, wide])


@dataclass(frozen=True)
class TightDerivative:
    """Bounds of h over cells; see `planner.bounds.branch.Bounding`."""

    features: Features
    form: Array  # Q of the design
    multipliers: Multipliers

    def at(self, shares: Array) -> Array:
        """Values of h at states given as shares, shape (n,)."""
        y = self.features.of(shares)
        return np.asarray(np.einsum("nk,kl,nl->n", y, self.form, y) - self.multipliers.of(shares))

    def __call__(self, low: Array, high: Array) -> Bounded:
        """Bounds over cells, shapes (n, 12)."""
        control = enclose(self.features, low[:, :6], high[:, :6])
        middle, wide = (low[:, 6:] + high[:, 6:]) / 2, (high[:, 6:] - low[:, 6:]) / 2
        forms = np.swapaxes(control.tables, -1, -2) @ (self.form @ control.tables)  # (n, 27, 15, 15)
        curvature = forms[:, :, _ACCELERATIONS, _ACCELERATIONS]
        fixed = _fixed(control.products)
        coupled = np.einsum("nrwk,nakv->narwv", fixed, forms[:, :, _FIXED, _ACCELERATIONS], optimize=True)
        rest = np.einsum("nrwk,nakl->narwl", fixed, forms[:, :, _FIXED][..., _FIXED], optimize=True)
        square = np.einsum("narwl,nrwl->narw", rest, fixed, optimize=True)  # y^T Q y without accelerations
        at_middle, steep = self._at_middle(low, high, control, middle, curvature, coupled, square)
        mixed = np.abs(curvature)
        mixed[..., range(6), range(6)] = 0.0
        bend = np.diagonal(curvature, axis1=-2, axis2=-1) - self.multipliers.squares
        bend = bend + (mixed @ wide[:, None, :, None])[..., 0] / wide[:, None]
        gain, step = _largest(bend[:, :, None, None], steep, wide[:, None, None, None])
        values = at_middle + gain.sum(axis=-1)  # (n, 27 angles, 27 rates, 8 corners)

        index = np.arange(len(low))
        place = values.reshape(len(low), -1).argmax(axis=1)
        angle, rate, corner = np.unravel_index(place, values.shape[1:])
        error = self._missed(control, square, curvature, np.abs(middle) + wide)
        states = self._states(low, high, (angle, rate, corner), middle + step[index, angle, rate, corner])
        slack = (mixed[index, angle] * wide[:, :, None] * wide[:, None, :]).sum(axis=-1)
        grid = values.max(axis=-1).reshape(len(low), *[3] * 6)
        split = [
            _split(grid[k], np.r_[CONTROL[angle[k]], CONTROL[rate[k]]], slack[k], error[k], high[k] - low[k])
            for k in index
        ]
        return Bounded(values[index, angle, rate, corner] + error, self.at(states), states, np.array(split))

    def _at_middle(
        self,
        low: Array,
        high: Array,
        control: Enclosure,
        middle: Array,
        curvature: Array,
        coupled: Array,
        square: Array,
    ) -> tuple[Array, Array]:
        """Values of h at the middle of the accelerations, (n, 27, 27, 8), and half its slope there, (..., 6)."""
        m, half = self.multipliers, self.features.half[9:12]
        slope = m.linear + self._places(low, high) @ m.mixed  # of l in the accelerations, (n, 27, 8, 6)
        both = (m.rates + m.rates.T) / np.outer(half, half)
        both[range(3), range(3)] /= 2
        of_rates = control.products @ both[np.triu_indices(3)]  # (n, 27)
        products = (curvature @ middle[:, None, :, None])[..., 0]  # (n, 27, 6)
        own = (products * middle[:, None]).sum(axis=-1) - (m.squares * middle**2).sum(axis=-1)[:, None]
        value = square - of_rates[:, None, :, None] - m.constant + own[:, :, None, None]
        value = value + 2.0 * np.einsum("narwi,ni->narw", coupled, middle, optimize=True)
        value = value - np.einsum("nawi,ni->naw", slope, middle, optimize=True)[:, :, None]
        steep = coupled + (products - (m.squares * middle)[:, None])[:, :, None, None] - slope[:, :, None] / 2
        return value, steep

    def _places(self, low: Array, high: Array) -> Array:
        """Shares q at control points of the angles (which interpolate them) and corners, shape (n, 27, 8, 6)."""
        levels = np.stack([low[:, :3], (low[:, :3] + high[:, :3]) / 2, high[:, :3]], axis=1)
        angles = levels[:, CONTROL, np.arange(3)]  # (n, 27, 3)
        place = np.empty((len(low), 27, 8, 6))
        place[..., :3] = _CORNERS
        place[..., 3:] = ((angles - self.features.middle[3:6]) / self.features.half[3:6])[:, :, None]
        return place

    def _missed(self, control: Enclosure, square: Array, curvature: Array, reach: Array) -> Array:
        """What the interpolation misses: (|y| + e)^2 - |y|^2 in the norm of Q, and the angles in q_i a_j."""
        length = np.sqrt(np.maximum(square, 0.0).reshape(len(reach), -1).max(axis=1))
        diagonal = np.sqrt(np.maximum(np.diagonal(curvature, axis1=-2, axis2=-1), 0.0)).max(axis=1)
        length = length + (diagonal * reach).sum(axis=1)
        error = BoxDerivative(self.features, self.form).error(control.gibbs_error, control.product_error)
        angles = control.angle_error / self.features.half[3:6] @ np.abs(self.multipliers.mixed[3:6]).sum(axis=1)
        return np.asarray(2.0 * error * length + error**2 + angles)

    def _states(self, low: Array, high: Array, place: tuple[Array, Array, Array], accelerations: Array) -> Array:
        """States, as shares, near control points: the middle of a coordinate where its control point is inside."""
        angle, rate, corner = place
        ends = np.concatenate([CONTROL[angle], CONTROL[rate]], axis=1)
        levels = np.stack([low[:, :6], (low[:, :6] + high[:, :6]) / 2, high[:, :6]], axis=1)
        values = np.take_along_axis(levels, ends[:, None], axis=1)[:, 0]
        shares = np.zeros((len(low), 18))
        shares[:, :3] = _CORNERS[corner]
        shares[:, _ANGLES_AND_RATES] = (values - self.features.middle[_ANGLES_AND_RATES]) / self.features.half[
            _ANGLES_AND_RATES
        ]
        shares[:, 12:] = accelerations
        return np.clip(shares, -1.0, 1.0)


def _fixed(products: Array) -> Array:
    """(1, x, y, products of rates) at the control points of the rates and the corners, shape (n, 27, 8, 9)."""
    fixed = np.empty((len(products), 27, 8, 9))
    fixed[..., 0] = 1.0
    fixed[..., 1:3] = _CORNERS[:, :2]
    fixed[..., 3:] = products[:, :, None]
    return fixed


def _largest(bend: Array, steep: Array, wide: Array) -> tuple[Array, Array]:
    """Largest bend e^2 + 2 steep e for |e| <= wide, and the e where it is."""
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = np.where(bend < 0.0, -steep / bend, np.inf)
    step = np.where(np.abs(inner) < wide, inner, np.where(steep < 0.0, -wide, wide))
    return bend * step**2 + 2.0 * steep * step, step


def _split(values: Array, place: Array, slack: Array, error: float, width: Array) -> int:
    """The coordinate to halve: where the control point stands out most, or the bound of mixed terms is loosest."""
    excess = np.zeros(12)
    for k in np.flatnonzero(place == 1):
        ends = [values[tuple(np.where(np.arange(6) == k, end, place))] for end in (0, 2)]
        excess[k] = values[tuple(place)] - sum(ends) / 2
    excess[6:] = slack
    if not excess.max() >= error / 3:
        return int(width[:3].argmax())
    return int(excess.argmax())
