"""Timed paths on a controller without look-ahead: LinuxCNC's way to plan turning blocks (tp.c), measured on 2.9.

Each block is a trapezoid at half the acceleration limit along it, so that no block of length L is faster than
sqrt(a L / 2). While one slows down the next speeds up, for as long as each has room, and only below the speed at which
the corner between them is cut by the tolerance of G64; the slowing down above that speed is time lost. Corners
are rounded by parabolas. Durations agree with LinuxCNC within 1 % for blocks of 10 to 210 ms.
"""

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.motion import TimedPoints
from identification.trajectories.path_timing import RetimedMotion, retime

Array = NDArray[np.float64]

ROUNDED = 1 / 8  # of the change of velocity times the block: how far from its corner a parabola passes
CUT = 1e-3  # [m] G64 P1, as programs of ours have it
NOTHING = 1e-9  # [m, rad] of a block's way


def block_durations(times: Array, poses: Array, acceleration: Array) -> Array:
    """How long straight blocks between poses take, from rest to rest, shape (k - 1,) [s].

    Args:
        times: times at which the poses are wanted, shape (k,) [s].
        poses: shape (k, 6) [m, rad].
        acceleration: limits of the coordinates, shape (6,).
    """
    steps, ways = np.diff(times), np.diff(poses, axis=0)
    linear, turning = (np.linalg.norm(ways[:, axes], axis=1) for axes in (slice(0, 3), slice(3, 6)))
    length = np.where(linear > NOTHING, linear, turning)
    standing = length <= NOTHING
    ways, length = np.where(standing[:, None], 1.0, ways), np.where(standing, 1.0, length)
    slope = 0.5 / (np.abs(ways) / length[:, None] / acceleration).max(axis=1)
    speed = np.minimum(length / steps, np.sqrt(slope * length))
    alone, ramp = length / speed, speed / slope
    room = np.minimum(alone[:-1], alone[1:])
    together = np.minimum(ramp[:-1], np.minimum(np.maximum(ramp[:-1], ramp[1:]), room))
    direction = ways[:, :3] / np.where(linear > NOTHING, linear, np.inf)[:, None]
    bend = np.sqrt(np.maximum(0.0, 1.0 - np.sum(direction[:-1] * direction[1:], axis=1)) / 2)
    bend = np.where(np.minimum(linear[:-1], linear[1:]) > NOTHING, bend, 0.0)
    corner = 2.0 * np.sqrt(np.divide(CUT, slope[:-1] * bend, out=np.full(len(bend), np.inf), where=bend > 0.0))
    together = np.where(standing[:-1] | standing[1:], 0.0, np.minimum(together, corner))
    return np.where(standing, steps, alone + ramp - np.append(together, 0.0))


def largest_cut(times: Array, poses: Array) -> float:
    """How far the origin passes from the corners between blocks, at most [m]; shapes (k,) [s] and (k, 6) [m, rad]."""
    steps = np.diff(times)
    turns = np.diff(np.diff(poses[:, :3], axis=0) / steps[:, None], axis=0)
    return float(np.max(ROUNDED * np.linalg.norm(turns, axis=1) * np.minimum(steps[:-1], steps[1:]), initial=0.0))


def rounded(points: TimedPoints, tolerance: tuple[float, float]) -> TimedPoints:
    """The path with its corners rounded: parabolas from the middle of each block to that of the next.

    Args:
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
        case: its limits of rates and accelerations, of coordinates and struts.
        tolerance: tolerance of corners [m], [rad].

    Raises:
        UntimedPath: no pace keeps the limits.
        CaseError: the case has no machine.
    """
    acceleration = case.need_machine("a run")[2].motion.acceleration
    steps = np.diff(points.times)
    needed = np.maximum(block_durations(points.times, points.poses, acceleration), steps)

    def slowed(times: Array) -> Array:
        block = np.clip(np.searchsorted(points.times, times, side="right") - 1, 0, len(steps) - 1)
        return np.asarray((steps / needed)[block])

    return retime(rounded(points, tolerance), case, slowed=slowed)
