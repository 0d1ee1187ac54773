"""The largest directional derivative over the motion box, proven by branch and bound.

For given angles and angular rates d is convex in x, y and the six accelerations, and depends on nothing else: its
maximum lies at one of their 256 corners. Over a cell of angles and rates d is convex in the features, and these lie in
the hull of control points: the largest value at one of them, plus what the interpolation misses, is an upper bound.
Corners of cells are states of the box: their values are lower bounds. Rounding (1e-12 of d) is not enclosed.

The cell with the largest upper bound is halved first, so that at any moment the largest upper bound of all cells is
proven, however early the search stops.
"""

import heapq
from collections.abc import Callable
from itertools import pairwise, product
from time import process_time

import numpy as np

from cases.base.units import Array, Indices
from planner.bounds.features import CORNER_COORDINATES, CORNERS, GIBBS, PAIRS, PRODUCTS, Features

BATCH = 8  # cells halved at once: calls into NumPy cost as much as the arithmetic of one cell


Bounds = tuple[Array, Array, Array, Indices]
"""Of a function over n cells: upper bounds, shape (n,); values at a point of each, shape (n,); these points, shape
(n, dimensions of the points); and the coordinate of each cell to halve next, shape (n,)."""

Bounding = Callable[[Array, Array], Bounds]
"""Bounds of a function over cells, from their lower to their upper corners, shapes (n, dimensions)."""


Maximum = tuple[float, float, Array]
"""Of a function: a proven upper bound, infinite where nothing is proven; the largest value that was found; and points
with large values, shape (k, dimensions of the points)."""


def maximise(
    bounding: Bounding,
    low: Array,
    high: Array,
    enough: float,
    tolerable: float,
    deadline: float,
) -> Maximum:
    """Halves cells until no upper bound is above `enough`, or until that has become too expensive.

    Once a value above `tolerable` was found, the search ends where the largest upper bound is as near to the largest
    value as `enough` is to `tolerable`.

    Args:
        low: lower corners of the first cells, shape (n, dimensions).
        high: upper corners.
        enough: the upper bound that is wanted.
        tolerable: less than that; points above it are collected, the largest first.
        deadline: `time.process_time()` at which to stop [s].
    """
    heap: list[tuple[float, int, Array, Array, int]] = []
    candidates: list[tuple[float, Array]] = []
    lower, number = -np.inf, 0

    def bound(lows: Array, highs: Array, parents: Array) -> None:
        nonlocal lower, number
        upper, values, points, splits = bounding(lows, highs)
        upper = np.minimum(upper, parents)
        for k in range(len(lows)):
            number += 1  # so that cells with equal bounds have an order
            heapq.heappush(heap, (-float(upper[k]), number, lows[k], highs[k], int(splits[k])))
            lower = max(lower, float(values[k]))
            if values[k] > tolerable:
                candidates.append((float(values[k]), points[k]))

    bound(low, high, np.full(len(low), np.inf))
    while -heap[0][0] > (target := max(enough, lower + enough - tolerable)) and process_time() < deadline:
        batch = [heapq.heappop(heap)]
        while heap and len(batch) < BATCH and -heap[0][0] > target:
            batch.append(heapq.heappop(heap))
        lows, highs, parents = [], [], []
        for upper, _, cell_low, cell_high, split in batch:
            middle = (cell_low[split] + cell_high[split]) / 2
            lower_half, right = cell_high.copy(), cell_low.copy()
            lower_half[split], right[split] = middle, middle
            lows += [cell_low, right]
            highs += [lower_half, cell_high]
            parents += [-upper, -upper]
        bound(np.array(lows), np.array(highs), np.array(parents))
    candidates.sort(key=lambda m: -m[0])
    points = np.array([p for _, p in candidates]) if candidates else np.empty((0, 0))
    return -heap[0][0], lower, points


NODES = np.array(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3, indexing="ij")).reshape(3, 27).T
CONTROL = np.array(np.meshgrid(*[[0, 1, 2]] * 3, indexing="ij")).reshape(3, 27).T
_INTERPOLATION = np.sqrt(2.0)  # norm of the interpolation at -h, 0, h: 1 + max(sin t/sin h - (1-cos t)/(1-cos h))
WIDEST = np.pi / 4  # [rad] of a half width: the enclosure needs less than pi / 2


def control_tables(features: Features, low: Array, high: Array) -> Array:
    """T of the features at the control points of the angles of n cells, shapes (n, 3) [rad] -> (n, 27, 21, 15).

    A function of an angle in the span of 1, cos, sin is a rational quadratic Bezier curve with positive weights over an
    interval of half width h below 90 degrees, here `WIDEST` at most: it stays in the convex hull of its values at both
    ends and of a third control point, f(0) + (f(0) - (f(-h) + f(h)) / 2) / cos h. Gravity, specific and angular
    acceleration in {P} are such functions of each angle; of the others see `enclosure_errors`.
    """
    middle, half = (low + high) / 2, (high - low) / 2
    nodes = middle[:, None] + NODES * half[:, None]
    tables = features.tables(nodes.reshape(-1, 3)).reshape(len(low), 3, 3, 3, -1)
    for axis in range(3):
        tables = np.moveaxis(_to_control(np.moveaxis(tables, 1 + axis, 1), half[:, axis]), 1, 1 + axis)
    return tables.reshape(len(low), 27, 21, 15)


def _to_control(values: Array, half: Array) -> Array:
    """Control points of values at -h, 0, h along axis 1."""
    cosine = np.cos(half).reshape(-1, *[1] * (values.ndim - 2))
    control = values.copy()
    control[:, 1] += (values[:, 1] - (values[:, 0] + values[:, 2]) / 2) / cosine
    return control


def rate_products(low: Array, high: Array) -> Array:
    """Products of the rates at their 27 control points, shapes (n, 3) -> (n, 27, 6).

    The features are polynomials of second degree in each rate, hence in the hull of the control points with (r, r^2) =
    (l, l^2), ((l + u) / 2, l u), (u, u^2).
    """
    single = np.stack([low, (low + high) / 2, high], axis=1)
    square = np.stack([low**2, low * high, high**2], axis=1)
    columns = [
        square[:, CONTROL[:, i], i] if i == j else single[:, CONTROL[:, i], i] * single[:, CONTROL[:, j], j]
        for i, j in PAIRS
    ]
    return np.stack(columns, axis=-1)


def enclosure_errors(low: Array, high: Array) -> tuple[Array, Array]:
    """What control points miss over cells of angles and their rates, shapes (n, 6) [rad, rad/s].

    Features outside the span of 1, cos, sin are interpolated in it at the middle and both ends of an angle; what that
    misses is bounded by Polya's mean value theorem, |f - Pf| <= max|f''' + f'| max|w| with w(t) = t - h sin t / sin h,
    since D (D^2 + 1) is disconjugate there:

    - Gibbs vector: turning by an angle moves it along a straight line, g = k0 + k1 tan(t/2 - t0), and
      |g''' + g'| = 3/4 |k1| sec^4 <= 3 / (4 q^4), q the cosine of half the whole rotation's angle.
    - products of the angular velocity: a harmonic of second order with amplitude a has |f''' + f'| <= 6 a; a is at most
      (pitch'^2 + yaw'^2) / 2 along roll, yaw'^2 / 2 along pitch, 0 along yaw.

    Three angles: g - P1 P2 P3 g = (1 - P1) g + P1 (1 - P2) g + P1 P2 (1 - P3) g, and |P f| <= sqrt(2) max|f|.

    Returns:
        Largest errors: length of that of the Gibbs vector, shape (n,); of each product of the angular velocity, shape
        (n,).
    """
    half = (high[:, :3] - low[:, :3]) / 2
    ratio = np.sinc(half / np.pi)
    t = np.arccos(np.clip(ratio, -1.0, 1.0))  # where w is stationary: cos t = sin h / h
    angles = np.abs(t - np.sin(t) / ratio)
    largest = np.maximum(np.abs(low[:, :3]), np.abs(high[:, :3])) / 2
    q = np.prod(np.cos(largest), axis=1) - np.prod(np.sin(largest), axis=1)  # real part of the quaternion, at least
    chain = angles @ _INTERPOLATION ** np.arange(3)
    with np.errstate(divide="ignore"):
        gibbs = np.where((q > 0.0) & (largest.max(axis=1) < np.pi / 2), 0.75 / q**4 * chain, np.inf)
    square = np.maximum(low[:, 3:] ** 2, high[:, 3:] ** 2)
    along_roll, along_pitch = 3.0 * (square[:, 1] + square[:, 2]), 3.0 * square[:, 2]
    return np.asarray(gibbs), along_roll * angles[:, 0] + _INTERPOLATION * along_pitch * angles[:, 1]


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
