"""Stretches of neighbours that have something in common, as slices and as windows of time."""

import numpy as np

from cases.base.units import Array, Flags


def stretches(on: Flags) -> list[slice]:
    """One slice for each stretch of neighbours that are on, shape (n,)."""
    edges = np.flatnonzero(np.diff(np.r_[False, on, False].astype(np.int8))).tolist()
    return [slice(first, end) for first, end in zip(edges[::2], edges[1::2], strict=True)]


def windows(on: Flags, period: float) -> Array:
    """Start and end of each stretch that is on, of samples at equal steps, shape (k, 2) [s]."""
    return np.array([(part.start, part.stop) for part in stretches(on)], dtype=float).reshape(-1, 2) * period
