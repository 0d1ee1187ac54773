"""Timed paths on a controller without look-ahead: a rule measured on LinuxCNC, not a model of its planner.

Over a block of length L such a controller sustains sqrt(a L / 2), a being the acceleration limit along the block, so
that no block takes less than sqrt(2 L / a).
"""

import numpy as np
from numpy.typing import NDArray

from identification.motion import TimedPoints

Array = NDArray[np.float64]


def least_durations(poses: Array, acceleration: Array) -> Array:
    """Shortest durations of straight blocks between poses, shape (k - 1,) [s].

    Args:
        poses: shape (k, 6) [m, rad].
        acceleration: limits of the coordinates, shape (6,).
    """
    return np.asarray(np.sqrt(2.0 * (np.abs(np.diff(poses, axis=0)) / acceleration).max(axis=1)))


def block_limited(points: TimedPoints, acceleration: Array) -> TimedPoints:
    """The same poses, each block as long as written or as long as it needs; smooth between them as `TimedPoints` is."""
    steps = np.maximum(np.diff(points.times), least_durations(points.poses, acceleration))
    return TimedPoints.through(np.concatenate([[0.0], np.cumsum(steps)]), points.poses)
