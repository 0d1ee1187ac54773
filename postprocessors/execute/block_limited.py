"""Timed paths on a controller without look-ahead: a rule measured on LinuxCNC, not a model of its planner.

Over a block of length L such a controller sustains sqrt(a L / 2), a being the acceleration limit along the block, so
that no block takes less than sqrt(2 L / a). It rounds the corners between blocks, by parabolas, as far as it may.
"""

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.motion import TimedPoints
from identification.path_timing import RetimedMotion, retime

Array = NDArray[np.float64]

ROUNDED = 1 / 8  # of the change of velocity times the block: how far from its corner a parabola passes


def least_durations(poses: Array, acceleration: Array) -> Array:
    """Shortest durations of straight blocks between poses, shape (k - 1,) [s].

    Args:
        poses: shape (k, 6) [m, rad].
        acceleration: limits of the coordinates, shape (6,).
    """
    return np.asarray(np.sqrt(2.0 * (np.abs(np.diff(poses, axis=0)) / acceleration).max(axis=1)))


def rounded(points: TimedPoints, tolerance: tuple[float, float]) -> TimedPoints:
    """The path with its corners rounded: parabolas from the middle of each block to that of the next.

    Args:
        points: passed at their times.
        tolerance: how far corners may be cut, of the origin [m] and of the angles [rad].
    """
    steps = np.diff(points.times)[:, None]
    velocities = np.diff(points.poses, axis=0) / steps
    cut = ROUNDED * np.diff(velocities, axis=0) * np.minimum(steps[:-1], steps[1:])
    for axes, allowed in ((slice(0, 3), tolerance[0]), (slice(3, 6), tolerance[1])):
        far = np.linalg.norm(cut[:, axes], axis=1, keepdims=True)
        cut[:, axes] *= np.minimum(1.0, np.divide(allowed, far, out=np.ones_like(far), where=far > 0.0))
    poses = points.poses.copy()
    poses[1:-1] += cut
    return TimedPoints.through(points.times, poses)


def block_limited(points: TimedPoints, case: Case, tolerance: tuple[float, float]) -> RetimedMotion:
    """The rounded path, each block as long as written or as long as it needs, inside the limits of the case.

    Args:
        points: the path as written.
        case: its limits of rates and accelerations, of coordinates and struts.
        tolerance: of corners [m], [rad].

    Raises:
        UntimedPath: no pace keeps the limits.
        CaseError: the case has no machine.
    """
    acceleration = case.need_machine("a run")[2].motion.acceleration
    steps = np.diff(points.times)
    needed = np.maximum(least_durations(points.poses, acceleration), steps)

    def slowed(times: Array) -> Array:
        block = np.clip(np.searchsorted(points.times, times, side="right") - 1, 0, len(steps) - 1)
        return np.asarray((steps / needed)[block])

    return retime(rounded(points, tolerance), case, slowed=slowed)
