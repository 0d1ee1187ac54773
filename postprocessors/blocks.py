"""The neutral program: the blocks for a controller, before any dialect; motions as polynomial pieces.

Pieces are exact where a motion consists of such; else their deviation is computed under two laws of time.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Array, Joined, Slowed, Standstill, Trajectory
from identification.motion.moves import CircularMove, StraightMove


@dataclass(frozen=True, slots=True)
class ToHome:
    """The start, at home: the program stops with a message unless the machine stands there within a tolerance.

    What is left of the tolerance is taken out at a crawl. A language that cannot ask where the machine stands has no
    words for this block; its operator must see to it.
    """

    coordinates: Array  # at home, shape (k,) [m or rad]
    # most that the crawl may use: along the path of the origin [m/s]; of a chain the share of the limits of its joints
    feed: float


@dataclass(frozen=True, slots=True)
class TimedPath:
    """Poses to be passed at given times, from rest at the pose before to rest at the last."""

    name: str  # purpose
    times: Array  # shape (k,), increasing, the first 0 [s]
    poses: Array  # coordinates, one row a time, the first is where the machine stands [m, rad]
    motion: Trajectory  # motion through them, on the clock of `times`, for dialects that can carry more than points


@dataclass(frozen=True, slots=True)
class Trigger:
    """The recording's trigger, switched while the machine stands."""

    on: bool


@dataclass(frozen=True, slots=True)
class Trace:
    """The controller's own recorder, started or stopped while the machine stands."""

    on: bool


Block = str | ToHome | StraightMove | CircularMove | TimedPath | Standstill | Trigger | Trace
"""Text is a remark for people: dialects wrap it and replace characters that their controller cannot read.

Moves and arcs go from rest to rest, with an exact stop at their end. Controllers know feeds, not durations: a dialect
writes the feed that makes its controller's own time law, under the limits of the case, take as long as planned.
"""


Blocks = tuple[Block, ...]
"""A program; the texts before its first other block are its header: its origin and the limits of its proof."""


CHECKS = 16  # instants inside a piece at which it is compared
FINEST = 64  # largest number of subdivisions of a piece


def block_motions(program: Blocks) -> Iterator[tuple[Trajectory, bool]]:
    """Motion of each block that takes time, and whether the trigger is on; omits the first move, to home."""
    on = False
    for block in program:
        if isinstance(block, Trigger):
            on = block.on
        elif not isinstance(block, str | ToHome | Trace):
            motion = block.motion if isinstance(block, TimedPath) else block
            if motion.duration > 0.0:
                yield motion, on


def traced(program: Blocks) -> Blocks:
    """A program that starts the controller's recorder before the trigger goes on, and stops it after it went off.

    Where the machine stands before and after, this is recorded too.
    """
    switches = [k for k, block in enumerate(program) if isinstance(block, Trigger)]
    first, last = switches[0], switches[-1] + 1
    first -= isinstance(program[first - 1], Standstill)
    last = last + 1 if last < len(program) and isinstance(program[last], Standstill) else len(program)
    return (*program[:first], Trace(True), *program[first:last], Trace(False), *program[last:])


def knots(motion: Trajectory) -> Array:
    """Instants at which a motion changes from one polynomial to the next, shape (k,) [s]; else its ends."""
    if isinstance(motion, PolynomialMotion):
        return motion.times
    if isinstance(motion, StraightMove):
        return np.unique(np.concatenate([[0.0], np.cumsum([s for s in motion.profile.lengths if s > 1e-9])]))
    if isinstance(motion, Slowed):
        return knots(motion.motion) / motion.speed
    if isinstance(motion, Joined):
        parts = [start + knots(part)[:-1] for start, part in zip(motion.starts, motion.parts, strict=False)]
        return np.append(np.concatenate(parts), motion.duration)
    return np.array([0.0, motion.duration])


def divided(ends: Array, longest: float, fewest: int = 1, finer: int = 1) -> Array:
    """Instants that divide each interval between ends, shape (k,) [s], into the fewest equal ones of a length.

    Args:
        longest: duration of an interval, at most [s].
        fewest: least number of intervals between two ends.
        finer: factor of these numbers.
    """
    counts = np.ceil(np.diff(ends) / longest - 1e-9).astype(int).clip(fewest) * finer
    parts = (np.linspace(a, b, n, endpoint=False) for a, b, n in zip(ends, ends[1:], counts, strict=False))
    return np.append(np.concatenate([*parts]), ends[-1])


def pieces(motion: Trajectory, degree: int, longest: float, tolerance: tuple[float, float]) -> PolynomialMotion:
    """Polynomials that share pose and rates with the motion at their ends; with degree 5 the accelerations too.

    They are exact for a motion of polynomials of that degree.

    Args:
        degree: 3 or 5.
        longest: duration of a piece, at most [s].
        tolerance: allowed deviation of positions [m] and angles [rad].

    Raises:
        ValueError: no subdivision is within the tolerance.
    """
    base = knots(motion)
    times = divided(base, longest)
    if isinstance(motion, PolynomialMotion) and not motion.table[degree + 1 :].any() and len(times) == len(base):
        return PolynomialMotion(motion.table[: degree + 1], motion.durations)
    finer = 1
    while finer <= FINEST:
        spline = _hermite(motion, divided(base, longest, finer=finer), degree)
        position, angle = even_deviation(spline, motion)
        if position <= tolerance[0] and angle <= tolerance[1]:
            return spline
        finer *= 2
    raise ValueError(f"polynomials of degree {degree} stay {position * 1e3:.2g} mm off the motion")


def _hermite(motion: Trajectory, times: Array, degree: int) -> PolynomialMotion:
    at, steps = motion.at(times), np.diff(times)[:, None]
    p, v, a = at.coordinates[:-1], at.rates[:-1] * steps, at.accelerations[:-1] * steps**2
    way, w, b = at.coordinates[1:] - p, at.rates[1:] * steps, at.accelerations[1:] * steps**2
    if degree == 3:
        shares = np.stack([p, v, 3 * way - 2 * v - w, v + w - 2 * way])
    else:
        d, e, f = way - v - a / 2, w - v - a, b - a
        shares = np.stack([p, v, a / 2, 10 * d - 4 * e + f / 2, -15 * d + 7 * e - f, 6 * d - 3 * e + f / 2])
    table = shares / steps ** np.arange(degree + 1)[:, None, None]
    return PolynomialMotion(table, steps[:, 0])


def even_deviation(spline: PolynomialMotion, motion: Trajectory) -> tuple[float, float]:
    """Largest distance from a motion at the same instant, positions [m] and angles [rad]."""
    t = _within(spline, np.linspace(0.0, 1.0, CHECKS + 1))
    return _distance(spline.at(t).coordinates, motion, t)


def path_speed_deviation(spline: PolynomialMotion, motion: Trajectory) -> tuple[float, float]:
    """The same where the origin passes each piece at constant speed along its path, in the time planned for it."""
    p, even = np.linspace(0.0, 1.0, 8 * CHECKS + 1), np.linspace(0.0, 1.0, CHECKS + 1)
    origins = spline.at(_within(spline, p)).coordinates[:, :3].reshape(len(spline.durations), len(p), 3)
    ways = np.cumsum(np.linalg.norm(np.diff(origins, axis=1, prepend=origins[:, :1]), axis=2), axis=1)
    shares = [way / way[-1] if way[-1] > 1e-12 else p for way in ways]
    positions = np.array([np.interp(even, share, p) for share in shares])
    return _distance(spline.at(_within(spline, positions)).coordinates, motion, _within(spline, even))


def _within(spline: PolynomialMotion, shares: Array) -> Array:
    """Instants at shares of each piece's duration, one after the other [s]; shape (m,), or (pieces, m)."""
    return np.asarray((spline.times[:-1, None] + np.diff(spline.times)[:, None] * shares).ravel())


def _distance(poses: Array, motion: Trajectory, t: Array) -> tuple[float, float]:
    off = poses - motion.at(np.minimum(t, motion.duration)).coordinates
    return float(np.linalg.norm(off[:, :3], axis=1).max()), float(np.abs(off[:, 3:]).max())


def timed_path(name: str, trajectory: Trajectory, block: float, speed: float) -> TimedPath:
    """A trajectory as equally timed poses; of a spline the ends of its pieces are among them.

    Args:
        block: duration of a block at full speed, at most [s].
        speed: share of the planned speed; 0.1 takes ten times as long.
    """
    knots = trajectory.times if isinstance(trajectory, PolynomialMotion) else np.array([0.0, trajectory.duration])
    times = divided(knots, block, 1 if len(knots) > 2 else 2)
    motion = trajectory if speed == 1.0 else Slowed(trajectory, speed)
    return TimedPath(name, times / speed, trajectory.at(times).coordinates, motion)
