"""The largest directional derivative over the motion box, proven.

For given angles and angular rates d is convex in x, y and the six accelerations, and depends on nothing else: its
maximum lies at one of their 256 corners. Over a cell of angles and rates d is convex in the features, and these lie in
the hull of the control points of `planner.bounds.branch`: the largest value at a control point, plus what the
interpolation misses, is an upper bound. Corners of cells are states of the box: their values are lower bounds.
Rounding (1e-12 of d) is not enclosed.
"""

from itertools import pairwise, product

import numpy as np

from cases.units import Array
from planner.bounds.branch import WIDEST, Bounds, control_tables, enclosure_errors, rate_products
from planner.bounds.features import CORNER_COORDINATES, CORNERS, GIBBS, PRODUCTS, Features

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
    upper = (np.sqrt(np.maximum(largest, 0.0)) + _error(form, *enclosure_errors(low, high))) ** 2
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
    ends_of_cells = np.where(upper_end == 1, high, low) - features.middle[_ANGLES_AND_RATES]
    shares[:, _ANGLES_AND_RATES] = ends_of_cells / features.half[_ANGLES_AND_RATES]
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
