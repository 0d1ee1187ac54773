"""Proves a timed path: everywhere roughly, finely wherever it could come to matter."""

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.limits import (
    PROOF_RATE,
    Limited,
    LimitReport,
    of_coordinates,
    of_mechanics,
    prove_at,
    shares_at,
    worst_of,
)
from identification.motion import Trajectory

Array = NDArray[np.float64]

FINE, ROUGH, ROUGH_RATE = 100, 10, 4000.0
"""Most instants in a block, and a second: a few show a polynomial of degree 5 but for some per cent."""

NEAR_LIMIT, WORST_BLOCKS = 0.9, 30
"""Looked at finely are blocks that use this share of any limit, and as many that use most of each."""


def prove_path(motion: Trajectory, times: Array, case: Case, offset: float, in_box: bool) -> LimitReport:
    """Checks every limit of a timed path, at most at 10 kHz and at a hundred instants a block.

    Slow programs need no finer grid. Blocks that stay far from a limit, and from what the path reaches elsewhere, are
    judged by a tenth of that: those of the coordinates and those of the mechanics, which rarely come near together.

    Args:
        times: ends of its blocks, shape (k,), from 0 [s].
        offset: start of the path on the clock that the report uses [s].
        in_box: whether it must keep the pose box of `[limits.motion]`.

    Raises:
        CaseError: the case has no machine.
    """
    reports = []
    for limited in (of_coordinates, of_mechanics):
        instants = _telling_instants(motion, times, case, in_box, limited)
        reports.append(prove_at(motion, case, instants, offset, in_box, limited))
    return worst_of(reports)


def _telling_instants(motion: Trajectory, times: Array, case: Case, in_box: bool, limited: Limited) -> Array:
    """Instants among which lie the worst of each limit and all that is near one, shape (n,) [s]."""
    rough, starts = _grid(times, ROUGH, ROUGH_RATE)
    shares = np.maximum.reduceat(shares_at(motion, case, rough, in_box, limited), starts, axis=0)
    blocks = np.asarray((shares >= NEAR_LIMIT).any(axis=1))
    blocks[np.argsort(shares, axis=0)[-WORST_BLOCKS:]] = True
    fine, starts = _grid(times, FINE, PROOF_RATE)
    counts = np.diff(np.append(starts, len(fine) - 1))
    chosen = np.append(np.repeat(blocks, counts), True)
    chosen[np.append(starts[1:], len(fine) - 1)[blocks]] = True  # both ends of a block belong to it
    return np.asarray(fine[chosen])


def _grid(times: Array, most: int, rate: float) -> tuple[Array, NDArray[np.int64]]:
    """Instants at a rate [1/s], but at most `most` a block, and the index of the first of each block."""
    steps = np.diff(times)
    counts = np.clip(np.ceil(steps * rate - 1e-9), 1, most).astype(np.int64)
    starts = np.cumsum(counts) - counts
    share = (np.arange(counts.sum()) - np.repeat(starts, counts)) / np.repeat(counts, counts)
    return np.append(np.repeat(times[:-1], counts) + share * np.repeat(steps, counts), times[-1]), starts
