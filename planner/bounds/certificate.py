"""The largest directional derivative over the motion box, proven.

For given angles and angular rates d is convex in x, y and the six accelerations, and depends on nothing else: its
maximum lies at one of their 256 corners. Over a cell of angles and rates d is convex in the features, and these lie in
the hull of the control points of `planner.bounds.branch`: the largest value at a control point, plus what the
interpolation misses, is an upper bound. Corners of cells are states of the box: their values are lower bounds.
Rounding (1e-12 of d) is not enclosed.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from planner.bounds.branch import WIDEST, Bounded, enclose
from planner.bounds.features import CORNER_COORDINATES, CORNERS, GIBBS, PRODUCTS, Features

Array = NDArray[np.float64]

_SIGNS = np.array(list(product([-1.0, 1.0], repeat=CORNERS))).T  # (8, 256)
_UPPER = np.triu_indices(CORNERS)
_SIGN_PRODUCTS = _SIGNS[_UPPER[0]] * _SIGNS[_UPPER[1]] * np.where(_UPPER[0] == _UPPER[1], 1.0, 2.0)[:, None]
_VARYING = slice(1, 1 + CORNERS)  # columns of T that belong to the corners; the others are the constant and the rates
_FIXED = [0, *range(1 + CORNERS, 15)]


def first_cells(features: Features) -> tuple[Array, Array]:
    """Cells of roll, pitch, yaw and their rates that cover the box, small enough for the enclosure; shapes (n, 6).

    The features do not change where all rates change their sign: negative yaw rates need no cell.
    """
    low, high = features.middle[[3, 4, 5, 9, 10, 11]], features.half[[3, 4, 5, 9, 10, 11]]
    low, high = low - high, low + high
    low[5] = 0.0
    grids = []
    for k in range(6):
        pieces = int(np.ceil((high[k] - low[k]) / (2 * WIDEST))) if k < 3 else 1
        edges = np.linspace(low[k], high[k], pieces + 1)
        grids.append(list(pairwise(edges)))
    cells = np.array(list(product(*grids)))
    return cells[:, :, 0], cells[:, :, 1]


@dataclass(frozen=True)
class BoxDerivative:
    """Bounds of d over cells of angles and angular rates; see `planner.bounds.branch.Bounding`."""

    features: Features
    form: Array  # Q of the design

    @cached_property
    def _error_norms(self) -> tuple[float, float]:
        """Length in Q of a unit error of the Gibbs vector, and of all products of the angular velocity at once."""
        gibbs = float(np.sqrt(max(0.0, np.linalg.eigvalsh(self.form[GIBBS, GIBBS])[-1])))
        return gibbs, float(np.sqrt(np.maximum(np.diag(self.form)[PRODUCTS], 0.0)).sum())

    def error(self, gibbs_error: Array, product_error: Array) -> Array:
        """Length in Q of what the enclosure misses, shape (n,)."""
        of_gibbs, of_products = self._error_norms
        with np.errstate(invalid="ignore"):  # 0 * inf: a model without orientation misses nothing
            return np.asarray(np.nan_to_num(of_gibbs * gibbs_error, posinf=np.inf) + of_products * product_error)

    def __call__(self, low: Array, high: Array) -> Bounded:
        """Bounds over cells, shapes (n, 6) [rad, rad/s]."""
        control = enclose(self.features, low, high)
        values = self._values(control.tables, control.products)  # (n, 3^6, 256)
        count = len(low)
        place = values.reshape(count, -1).argmax(axis=1)
        control_point, corner = np.divmod(place, values.shape[2])
        error = self.error(control.gibbs_error, control.product_error)
        largest = values[np.arange(count), control_point, corner]
        upper = (np.sqrt(np.maximum(largest, 0.0)) + error) ** 2
        grid = values.reshape(count, *[3] * 6, -1)
        split = np.array(
            [
                _split(grid[k][..., corner[k]], int(control_point[k]), upper[k] - largest[k], high[k] - low[k])
                for k in range(count)
            ]
        )
        at_corners = grid[:, ::2, ::2, ::2, ::2, ::2, ::2].reshape(count, -1)
        best = at_corners.argmax(axis=1)
        return Bounded(upper, at_corners[np.arange(count), best], self._states(low, high, best), split)

    def _values(self, tables: Array, products: Array) -> Array:
        """The derivative at all control points: constant, linear and quadratic part in the signs of the corner."""
        forms = np.swapaxes(tables, -1, -2) @ (self.form @ tables)  # (n, 27, 15, 15)
        fixed = np.concatenate([np.ones((*products.shape[:2], 1)), products], axis=-1)  # (n, 27, 7)
        of_fixed = forms[:, :, _FIXED]
        linear = np.einsum("nrk,nakv->narv", fixed, of_fixed[..., _VARYING], optimize=True)
        constant = np.einsum("nrk,nakl,nrl->nar", fixed, of_fixed[..., _FIXED], fixed, optimize=True)
        quadratic = forms[:, :, _VARYING, _VARYING][:, :, _UPPER[0], _UPPER[1]] @ _SIGN_PRODUCTS
        values = 2.0 * (linear @ _SIGNS) + constant[..., None] + quadratic[:, :, None, :]
        return np.asarray(values.reshape(len(tables), 27 * 27, -1))

    def _states(self, low: Array, high: Array, best: NDArray[np.intp]) -> Array:
        """States, as shares of the half widths, of corners of cells numbered as in `grid`."""
        ends, corner = np.divmod(best, _SIGNS.shape[1])
        upper_end = (ends[:, None] >> np.arange(5, -1, -1)) & 1
        shares = np.zeros((len(low), 18))
        shares[:, CORNER_COORDINATES] = _SIGNS[:, corner].T
        coordinates = [3, 4, 5, 9, 10, 11]
        values = np.where(upper_end == 1, high, low)
        shares[:, coordinates] = (values - self.features.middle[coordinates]) / self.features.half[coordinates]
        return np.clip(shares, -1.0, 1.0)


def _split(values: Array, place: int, error: float, width: Array) -> int:
    """The coordinate to halve: the one whose control point stands out most, or the widest angle if more is missed."""
    index = np.array(np.unravel_index(place, values.shape))
    excess = np.zeros(6)
    for k in np.flatnonzero(index == 1):
        ends = [values[tuple(np.where(np.arange(6) == k, end, index))] for end in (0, 2)]
        excess[k] = values.flat[place] - sum(ends) / 2
    if excess.max() <= 0.0 or not excess.max() >= error / 3:
        return int(width[:3].argmax())
    return int(excess.argmax())
