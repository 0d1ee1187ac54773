"""Stretches of neighbours that have something in common, as slices and as windows of time."""

import numpy as np

from cases.base.units import Array, Flags


def stretches(on: Flags) -> list[slice]:
    """One slice for each stretch of neighbours that are on, shape (n,)."""
    edges = np.flatnonzero(np.diff(np.r_[False, on, False].astype(np.int8))).tolist()
    return [slice(first, end) for first, end in zip(edges[::2], edges[1::2], strict=True)]


def off_between(on: Flags) -> bool:
    """Whether a switch, shape (n,), is on at both ends and off between them once, as one that is off in motion."""
    return bool(on[0]) and bool(on[-1]) and len(stretches(on)) == 2


def windows(on: Flags, period: float) -> Array:
    """Start and end of each stretch that is on, of samples at equal steps, shape (k, 2) [s]."""
    return np.array([(part.start, part.stop) for part in stretches(on)], dtype=float).reshape(-1, 2) * period
