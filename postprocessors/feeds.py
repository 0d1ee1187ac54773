"""The feed that makes a controller's own time law take as long as planned."""

from dataclasses import replace

import numpy as np

from cases.machine import MotionLimits
from cases.units import MM
from identification.trajectories.profile import Profile, StraightMove, TimeLaw, limits_along
from postprocessors.program import Arc, Array, PointToPoint
from postprocessors.proving.guarantees import Guarantees
from postprocessors.proving.predicted import strut_move
from postprocessors.wording import LENGTH_DECIMALS, as_written, feed

NO_SLOWER = 1e-9
HALVINGS = 80  # of the interval of the feed: down to its last bit
STRUT_HALVINGS, SLOWEST = 24, 1e-2  # of moves straight in the struts; the slowest feed, as a share of the planned one
INSTANTS = 129  # at which such a move is compared with the limits
UNDER = 1e-3  # what it stays below them: the proof looks at other instants


def feed_of(block: PointToPoint | Arc, limits: MotionLimits, guarantees: Guarantees, linear: bool = True) -> float:
    """Feed of a move along X, Y, Z [m/s], or along the angles [rad/s].

    The largest that the move can reach where even that takes longer than planned.

    Args:
        block: the move, with its planned duration.
        limits: that the controller is set up with.
        guarantees: give its time law.
        linear: whether the feed counts X, Y, Z.
    """
    move = block.move
    way = np.abs(move.end - move.start)
    if isinstance(block, Arc):
        way[list(block.move.plane.axes[:2])] = block.move.length
    velocity, acceleration, jerk = limits_along(way, limits.rate, limits.acceleration, limits.jerk)

    def duration(speed: float) -> float:
        if isinstance(block, Arc):
            return guarantees.arc_law(speed, acceleration, jerk, abs(block.move.angle)).duration
        return guarantees.law(speed, acceleration, jerk).duration

    low, high = min(velocity, 1.0 / move.duration), velocity  # below the mean speed it takes longer for certain
    if duration(high) * (1.0 + NO_SLOWER) >= move.duration:
        low = high  # as fast as it can be: the peak is a flat optimum, no feed of its own belongs to it
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if duration(middle) > move.duration else (low, middle)
    if isinstance(block, Arc):
        return high * block.move.length
    return high * float(np.linalg.norm(way[:3] if linear else way[3:]))


def written_feed(block: PointToPoint, limits: MotionLimits, guarantees: Guarantees) -> tuple[bool, str]:
    """Whether F counts X, Y, Z, and F, of the way as written: where these hardly move, rounding is much of it.

    Args:
        block: the move, with its planned duration.
        limits: that the controller is set up with.
        guarantees: give its time law.
    """
    written = as_written(block.move)
    linear = bool(np.any(np.round((written.end - written.start)[:3] / MM, LENGTH_DECIMALS) != 0.0))
    return linear, feed(feed_of(PointToPoint(written), limits, guarantees, linear), linear)


def strut_feed_of(move: StraightMove, limits: MotionLimits, guarantees: Guarantees) -> float | None:
    """Feed of a move straight in the struts, as a share of its way per second; None for a rapid.

    The largest at which it lasts as long as planned, or longer, and stays within the limits of rates and accelerations
    of the coordinates, which no controller keeps there; within those of the rates alone where a slower feed does not
    lessen the accelerations (a law without jerk limit).

    Args:
        move: the planned one, between the same poses.
        limits: of the coordinates.
        guarantees: give drives and time law.

    Raises:
        NoStrutMove: the platform cannot follow its struts, or the drives are not known.
    """
    path = strut_move(move.start, move.end, None, guarantees)
    drives = guarantees.drives
    assert drives is not None
    if drives.rapid:
        return None
    way = path.strut_way
    _, first, _, _ = path.along(np.linspace(0.0, 1.0, INSTANTS))
    steady = float(np.min(limits.rate / np.maximum(np.abs(first).max(axis=0), 1e-12)))
    fastest = (1.0 - UNDER) * min(steady, drives.velocity / way)

    def law(feed: float) -> TimeLaw:
        return guarantees.law(feed, drives.acceleration / way, drives.jerk / way)

    def lasts(feed: float) -> bool:
        return law(feed).duration * (1.0 + NO_SLOWER) >= move.duration

    def fits(feed: float) -> bool:
        motion = replace(path, profile=law(feed)).at(_instants(law(feed)))
        return lasts(feed) and bool(np.all(np.abs(motion.accelerations) <= (1.0 - UNDER) * limits.acceleration))

    low, high = min(fastest, SLOWEST / move.duration), fastest
    good = fits if fits(low) else lasts
    if good(high):
        return high
    for _ in range(STRUT_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if good(middle) else (low, middle)
    return low


def _instants(law: TimeLaw) -> Array:
    """Instants that show the largest accelerations: of seven segments they are where one of them ends."""
    even = np.linspace(0.0, law.duration, INSTANTS)
    if not isinstance(law, Profile):
        return even
    return np.append(even, np.cumsum(law.lengths[:-1]))
