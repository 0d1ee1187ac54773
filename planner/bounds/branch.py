"""Branch and bound: a proven maximum over a box, for any function that knows an upper bound over sub-boxes.

The cell with the largest upper bound is halved first, so that at any moment the largest upper bound of all cells is
proven, however early the search stops.
"""

import heapq
from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic, process_time
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BATCH = 8  # cells halved at once: calls into NumPy cost as much as the arithmetic of one cell
REPORT = 0.5  # [s] between two words on progress


class Bounded(NamedTuple):
    """What is known of cells, one row each."""

    upper: Array  # no point of the cell has a larger value, shape (n,)
    lower: Array  # value at the point below, shape (n,)
    point: Array  # a point of the cell, shape (n, dimensions of the points)
    split: NDArray[np.intp]  # the coordinate of the cell to halve next, shape (n,)


class Bounding(Protocol):
    """Bounds of a function over cells."""

    def __call__(self, low: Array, high: Array) -> Bounded:
        """Bounds over cells from `low` to `high`, shapes (n, dimensions)."""
        ...


@dataclass(frozen=True, slots=True)
class Maximum:
    """What branch and bound found."""

    upper: float  # proven: no value is larger
    lower: float  # the largest value that was met
    points: Array  # points with values above what was tolerable, the largest first, shape (k, dimensions)
    cells: int  # bounded


def maximise(
    bounding: Bounding,
    low: Array,
    high: Array,
    enough: float,
    tolerable: float,
    deadline: float,
    progress: Callable[[str], None] = lambda _: None,
) -> Maximum:
    """Halves cells until no upper bound is above `enough`, or until that has become too expensive.

    Once a value above `tolerable` was met, the search ends where the largest upper bound is as near to the largest
    value as `enough` is to `tolerable`.

    Args:
        low: lower corners of the first cells, shape (n, dimensions).
        high: upper corners.
        enough: the upper bound that is wanted.
        tolerable: less than that; points above it are collected.
        deadline: `time.process_time()` at which to stop [s].
        progress: told the gap now and then.
    """
    heap: list[tuple[float, int, Array, Array, int]] = []
    met: list[tuple[float, Array]] = []
    lower, cells, told = -np.inf, 0, monotonic()

    def bound(lows: Array, highs: Array, parents: Array) -> None:
        nonlocal lower, cells
        found = bounding(lows, highs)
        upper = np.minimum(found.upper, parents)
        for k in range(len(lows)):
            cells += 1
            heapq.heappush(heap, (-float(upper[k]), cells, lows[k], highs[k], int(found.split[k])))
            lower = max(lower, float(found.lower[k]))
            if found.lower[k] > tolerable:
                met.append((float(found.lower[k]), found.point[k]))

    bound(low, high, np.full(len(low), np.inf))
    while -heap[0][0] > (wanted := max(enough, lower + enough - tolerable)) and process_time() < deadline:
        batch = [heapq.heappop(heap)]
        while heap and len(batch) < BATCH and -heap[0][0] > wanted:
            batch.append(heapq.heappop(heap))
        lows, highs, parents = [], [], []
        for upper, _, cell_low, cell_high, split in batch:
            middle = (cell_low[split] + cell_high[split]) / 2
            left, right = cell_high.copy(), cell_low.copy()
            left[split], right[split] = middle, middle
            lows += [cell_low, right]
            highs += [left, cell_high]
            parents += [-upper, -upper]
        bound(np.array(lows), np.array(highs), np.array(parents))
        if monotonic() - told > REPORT:
            told = monotonic()
            progress(f"largest value between {lower:.4f} and {-heap[0][0]:.4f}, {len(heap)} cells open")
    met.sort(key=lambda m: -m[0])
    points = np.array([p for _, p in met]) if met else np.empty((0, 0))
    return Maximum(-heap[0][0], lower, points, cells)
