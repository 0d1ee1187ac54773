"""The largest directional derivative over the motion box, proven; less a Lagrangian of moment constraints, too.

For given angles and angular rates d is convex in x, y and the six accelerations, and depends on nothing else: its
maximum lies at one of their 256 corners. Over a cell of angles and rates d is convex in the features, and these lie in
the hull of the control points of `planner.bounds.branch`: the largest value at a control point, plus what the
interpolation misses, is an upper bound. Corners of cells are states of the box: their values are lower bounds.
Rounding (1e-12 of d) is not enclosed.

The tight one is h = d - l, d = y^T Q y, l that of `planner.bounds.features.lagrangian`. Over a cell of
angles, angular rates and accelerations it is convex in x, y, z (corners); features and products of rates lie in the
hull of control points; and in the accelerations a = m + e, |e_i| <= h_i, it is quadratic. There mixed terms are bounded
by 2 C_ij e_i e_j <= |C_ij| (e_i^2 h_j / h_i + e_j^2 h_i / h_j), after which every acceleration has its maximum by
itself, in closed form.
"""

from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np

from cases.units import Array
from planner.bounds.branch import CONTROL, WIDEST, Bounds, control_tables, enclosure_errors, rate_products
from planner.bounds.features import (
    CONSTANT,
    CORNER_COORDINATES,
    CORNERS,
    GIBBS,
    LINEAR,
    MIXED,
    PRODUCTS,
    RATES,
    SQUARES,
    Features,
    monomials,
)

_SIGNS = np.array(list(product([-1.0, 1.0], repeat=CORNERS))).T  # (8, 256)
_UPPER = np.triu_indices(CORNERS)
_SIGN_PRODUCTS = _SIGNS[_UPPER[0]] * _SIGNS[_UPPER[1]] * np.where(_UPPER[0] == _UPPER[1], 1.0, 2.0)[:, None]
_VARYING = slice(1, 1 + CORNERS)  # columns of T that belong to the corners; the others are the constant and the rates
_FIXED = [0, *range(1 + CORNERS, 15)]
_ANGLES_AND_RATES = [3, 4, 5, 9, 10, 11]  # coordinates of a state that cells are made of


def first_cells(features: Features) -> tuple[Array, Array]:
    """Cells of roll, pitch, yaw and their rates that cover the box, small enough for the enclosure; shapes (n, 6).

    The features do not change where all rates change their sign: negative yaw rates need no cell.
    """
    middle, half = features.middle[_ANGLES_AND_RATES], features.half[_ANGLES_AND_RATES]
    low, high = middle - half, middle + half
    low[5] = 0.0
    grids = []
    for k in range(6):
        pieces = int(np.ceil((high[k] - low[k]) / (2 * WIDEST))) if k < 3 else 1
        edges = np.linspace(low[k], high[k], pieces + 1)
        grids.append(list(pairwise(edges)))
    cells = np.array(list(product(*grids)))
    return cells[:, :, 0], cells[:, :, 1]


def box_bounds(features: Features, form: Array, low: Array, high: Array) -> Bounds:
    """Bounds of d over cells of angles and angular rates, shapes (n, 6) [rad, rad/s]; form: Q of the design."""
    tables, products = control_tables(features, low[:, :3], high[:, :3]), rate_products(low[:, 3:], high[:, 3:])
    values = _at_control_points(form, tables, products)  # (n, 3^6, 256)
    count = len(low)
    index = np.arange(count)
    control_point, corner = np.divmod(values.reshape(count, -1).argmax(axis=1), values.shape[2])
    largest = values[index, control_point, corner]
    upper = (np.sqrt(np.maximum(largest, 0.0)) + _error(form, *enclosure_errors(low, high)[:2])) ** 2
    grid = values.reshape(count, *[3] * 6, -1)
    places = np.column_stack(np.unravel_index(control_point, [3] * 6))
    split = [
        _split(_excess(grid[k][..., corner[k]], places[k]), upper[k] - largest[k], high[k] - low[k]) for k in index
    ]
    at_corners = grid[:, ::2, ::2, ::2, ::2, ::2, ::2].reshape(count, -1)
    best = at_corners.argmax(axis=1)
    ends, corner = np.divmod(best, _SIGNS.shape[1])
    upper_end = (ends[:, None] >> np.arange(5, -1, -1)) & 1
    shares = np.zeros((count, 18))
    shares[:, CORNER_COORDINATES] = _SIGNS[:, corner].T
    shares[:, _ANGLES_AND_RATES] = _shares(features, np.where(upper_end == 1, high, low))
    return upper, at_corners[index, best], np.clip(shares, -1.0, 1.0), np.array(split)


def _at_control_points(form: Array, tables: Array, products: Array) -> Array:
    """The derivative at all control points: constant, linear and quadratic part in the signs of the corner."""
    forms = np.swapaxes(tables, -1, -2) @ (form @ tables)  # (n, 27, 15, 15)
    fixed = np.concatenate([np.ones((*products.shape[:2], 1)), products], axis=-1)  # (n, 27, 7)
    of_fixed = forms[:, :, _FIXED]
    linear = np.einsum("nrk,nakv->narv", fixed, of_fixed[..., _VARYING], optimize=True)
    constant = np.einsum("nrk,nakl,nrl->nar", fixed, of_fixed[..., _FIXED], fixed, optimize=True)
    quadratic = forms[:, :, _VARYING, _VARYING][:, :, _UPPER[0], _UPPER[1]] @ _SIGN_PRODUCTS
    values = 2.0 * (linear @ _SIGNS) + constant[..., None] + quadratic[:, :, None, :]
    return np.asarray(values.reshape(len(tables), 27 * 27, -1))


def _error(form: Array, of_gibbs_vector: Array, of_each_product: Array) -> Array:
    """Length in Q of the enclosure's errors of the Gibbs vector and of the products of the angular velocity, (n,)."""
    of_gibbs = float(np.sqrt(max(0.0, np.linalg.eigvalsh(form[GIBBS, GIBBS])[-1])))
    of_products = float(np.sqrt(np.maximum(np.diag(form)[PRODUCTS], 0.0)).sum())
    with np.errstate(invalid="ignore"):  # 0 * inf: a model without orientation has no such error
        gibbs_error = np.nan_to_num(of_gibbs * of_gibbs_vector, posinf=np.inf)
    return np.asarray(gibbs_error + of_products * of_each_product)


def _shares(features: Features, values: Array) -> Array:
    """Angles and their rates as shares of the half widths of the box, shapes (n, 6)."""
    return np.asarray((values - features.middle[_ANGLES_AND_RATES]) / features.half[_ANGLES_AND_RATES])


def _split(excess: Array, error: float, width: Array) -> int:
    """The coordinate to halve: where the bound exceeds the values most, or the widest angle if the error is larger."""
    if excess.max() <= 0.0 or not excess.max() >= error / 3:
        return int(width[:3].argmax())
    return int(excess.argmax())


def _excess(values: Array, place: Array) -> Array:
    """By how much a control point exceeds the ends of its line in each of six directions, shape (6,)."""
    excess = np.zeros(6)
    for k in np.flatnonzero(place == 1):
        ends = [values[tuple(np.where(np.arange(6) == k, end, place))] for end in (0, 2)]
        excess[k] = values[tuple(place)] - sum(ends) / 2
    return excess


_CORNERS = np.array(list(product([-1.0, 1.0], repeat=3)))  # of x, y, z
_ACCELERATIONS = slice(3, 9)  # columns of T
_NOT_ACCELERATIONS = [0, 1, 2, *range(9, 15)]  # constant, x, y, products of rates


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
    multipliers: Array  # Lagrangian of the constraints, shape (58,)

    def at(self, shares: Array) -> Array:
        """Values of h at states given as shares, shape (n,)."""
        y = self.features.of(shares)
        return np.asarray(np.einsum("nk,kl,nl->n", y, self.form, y) - monomials(shares) @ self.multipliers)

    def __call__(self, low: Array, high: Array) -> Bounds:
        """Bounds over cells, shapes (n, 12)."""
        tables = control_tables(self.features, low[:, :3], high[:, :3])
        products = rate_products(low[:, 3:6], high[:, 3:6])
        middle, wide = (low[:, 6:] + high[:, 6:]) / 2, (high[:, 6:] - low[:, 6:]) / 2
        forms = np.swapaxes(tables, -1, -2) @ (self.form @ tables)  # (n, 27, 15, 15)
        curvature = forms[:, :, _ACCELERATIONS, _ACCELERATIONS]
        # (1, x, y, products of rates) at the control points of the rates and the corners
        fixed = np.empty((len(low), 27, 8, 9))
        fixed[..., 0], fixed[..., 1:3], fixed[..., 3:] = 1.0, _CORNERS[:, :2], products[:, :, None]
        coupled = np.einsum("nrwk,nakv->narwv", fixed, forms[:, :, _NOT_ACCELERATIONS, _ACCELERATIONS], optimize=True)
        rest = np.einsum(
            "nrwk,nakl->narwl", fixed, forms[:, :, _NOT_ACCELERATIONS][..., _NOT_ACCELERATIONS], optimize=True
        )
        square = np.einsum("narwl,nrwl->narw", rest, fixed, optimize=True)  # y^T Q y without accelerations
        at_middle, steep = self._at_middle(low, high, middle, curvature, coupled, square)
        mixed = np.abs(curvature)
        mixed[..., range(6), range(6)] = 0.0
        bend = np.diagonal(curvature, axis1=-2, axis2=-1) - self.multipliers[SQUARES]
        bend = bend + (mixed @ wide[:, None, :, None])[..., 0] / wide[:, None]
        gain, step = _largest(bend[:, :, None, None], steep, wide[:, None, None, None])
        values = at_middle + gain.sum(axis=-1)  # (n, 27 angles, 27 rates, 8 corners)

        index = np.arange(len(low))
        place = values.reshape(len(low), -1).argmax(axis=1)
        angle, rate, corner = np.unravel_index(place, values.shape[1:])
        error = self._missed(low, high, square, curvature, np.abs(middle) + wide)
        states = self._states(low, high, (angle, rate, corner), middle + step[index, angle, rate, corner])
        slack = (mixed[index, angle] * wide[:, :, None] * wide[:, None, :]).sum(axis=-1)
        grid = values.max(axis=-1).reshape(len(low), *[3] * 6)
        places = np.hstack([CONTROL[angle], CONTROL[rate]])  # slack: of the mixed terms in each acceleration
        split = [_split(np.append(_excess(grid[k], places[k]), slack[k]), error[k], high[k] - low[k]) for k in index]
        return values[index, angle, rate, corner] + error, self.at(states), states, np.array(split)

    def _at_middle(
        self,
        low: Array,
        high: Array,
        middle: Array,
        curvature: Array,
        coupled: Array,
        square: Array,
    ) -> tuple[Array, Array]:
        """Values of h at the middle of the accelerations, (n, 27, 27, 8), and half its slope there, (..., 6)."""
        m, half = self.multipliers, self.features.half[9:12]
        squares, rates = m[SQUARES], m[RATES].reshape(3, 3)
        slope = m[LINEAR] + self._places(low, high) @ m[MIXED].reshape(6, 6)  # of l in the accelerations, (n, 27, 8, 6)
        both = (rates + rates.T) / np.outer(half, half)
        both[range(3), range(3)] /= 2
        of_rates = rate_products(low[:, 3:6], high[:, 3:6]) @ both[np.triu_indices(3)]  # (n, 27)
        products = (curvature @ middle[:, None, :, None])[..., 0]  # (n, 27, 6)
        own = (products * middle[:, None]).sum(axis=-1) - (squares * middle**2).sum(axis=-1)[:, None]
        value = square - of_rates[:, None, :, None] - m[CONSTANT] + own[:, :, None, None]
        value = value + 2.0 * np.einsum("narwi,ni->narw", coupled, middle, optimize=True)
        value = value - np.einsum("nawi,ni->naw", slope, middle, optimize=True)[:, :, None]
        steep = coupled + (products - (squares * middle)[:, None])[:, :, None, None] - slope[:, :, None] / 2
        return value, steep

    def _places(self, low: Array, high: Array) -> Array:
        """Shares q at control points of the angles (which interpolate them) and corners, shape (n, 27, 8, 6)."""
        levels = np.stack([low[:, :3], (low[:, :3] + high[:, :3]) / 2, high[:, :3]], axis=1)
        angles = levels[:, CONTROL, np.arange(3)]  # (n, 27, 3)
        place = np.empty((len(low), 27, 8, 6))
        place[..., :3] = _CORNERS
        place[..., 3:] = ((angles - self.features.middle[3:6]) / self.features.half[3:6])[:, :, None]
        return place

    def _missed(self, low: Array, high: Array, square: Array, curvature: Array, reach: Array) -> Array:
        """Interpolation error: (|y| + e)^2 - |y|^2 in the norm of Q, and that of the angles in q_i a_j."""
        length = np.sqrt(np.maximum(square, 0.0).reshape(len(reach), -1).max(axis=1))
        diagonal = np.sqrt(np.maximum(np.diagonal(curvature, axis1=-2, axis2=-1), 0.0)).max(axis=1)
        length = length + (diagonal * reach).sum(axis=1)
        of_gibbs_vector, of_each_product, of_angles = enclosure_errors(low[:, :6], high[:, :6])
        error = _error(self.form, of_gibbs_vector, of_each_product)
        steepest = np.abs(self.multipliers[MIXED].reshape(6, 6)[3:6]).sum(axis=1)
        angles = of_angles / self.features.half[3:6] @ steepest
        return np.asarray(2.0 * error * length + error**2 + angles)

    def _states(self, low: Array, high: Array, place: tuple[Array, Array, Array], accelerations: Array) -> Array:
        """States, as shares, near control points: the middle of a coordinate where its control point is inside."""
        angle, rate, corner = place
        ends = np.concatenate([CONTROL[angle], CONTROL[rate]], axis=1)
        levels = np.stack([low[:, :6], (low[:, :6] + high[:, :6]) / 2, high[:, :6]], axis=1)
        values = np.take_along_axis(levels, ends[:, None], axis=1)[:, 0]
        shares = np.zeros((len(low), 18))
        shares[:, :3] = _CORNERS[corner]
        shares[:, _ANGLES_AND_RATES] = _shares(self.features, values)
        shares[:, 12:] = accelerations
        return np.clip(shares, -1.0, 1.0)


def _largest(bend: Array, steep: Array, wide: Array) -> tuple[Array, Array]:
    """Largest bend e^2 + 2 steep e for |e| <= wide, and the e where it is."""
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = np.where(bend < 0.0, -steep / bend, np.inf)
    step = np.where(np.abs(inner) < wide, inner, np.where(steep < 0.0, -wide, wide))
    return bend * step**2 + 2.0 * steep * step, step
