"""How numbers, poses and comments are written by dialects whose words look alike."""

import re
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from math import floor, log10

import numpy as np
from numpy.typing import NDArray

from cases.units import DEG, MINUTE, MM
from identification.limited_quantities import Box
from identification.trajectories.moves import CircularMove, Plane, StraightMove
from identification.trajectories.profile import limits_along
from postprocessors.blocks import Arc, Array, ExactStopMove
from postprocessors.proving.guarantees import Guarantees

# 1e-5 mm and 1e-6 degrees: differentiated three times over 10 ms blocks this rounding stays below 0.1 % of the jerk
# limits.
LENGTH_DECIMALS = 5
ANGLE_DECIMALS = 6
FEED_DECIMALS = 6
FEED_DIGITS = 10
COMMENT_WIDTH = 120
PLANE_WORDS = {Plane.XY: "G17", Plane.ZX: "G18", Plane.YZ: "G19"}


def number(value: float, decimals: int) -> str:
    """Plain decimal notation, without exponent, trailing zeros or a negative zero."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "", "-") else text


POSE_TURNS = (False, False, False, True, True, True)


def coordinates(pose: Array, turns: Sequence[bool] | NDArray[np.bool_] = POSE_TURNS) -> list[str]:
    """Coordinates [m, rad] in mm and degrees; those of a pose, or whatever `turns` says are angles."""
    return [
        number(v / DEG, ANGLE_DECIMALS) if angle else number(v / MM, LENGTH_DECIMALS)
        for v, angle in zip(pose, turns, strict=True)
    ]


def arc_words(move: CircularMove, names: Sequence[str], values: Sequence[str], full: bool = False) -> str:
    """Coordinates of an arc's end and two of I, J, K: the centre relative to the start, as the block before wrote it.

    Args:
        full: leave out where the circle ends in its plane, as LinuxCNC wants it of a full one.
    """
    axes = move.plane.axes[:2]
    ends = [names[k] + values[k] for k in (*(() if full else sorted(axes)), 3, 4, 5)]
    offsets = move.centre / MM - np.round(move.start[list(axes)] / MM, LENGTH_DECIMALS)
    centre = ["IJK"[k] + number(offset, LENGTH_DECIMALS) for k, offset in sorted(zip(axes, offsets, strict=True))]
    return " ".join([*ends, *centre])


def feed(speed: float, linear: bool) -> str:
    """F in mm/min, or in degrees/min where only angles move; ten digits, also where X, Y, Z hardly move."""
    return digits(speed * MINUTE / (MM if linear else DEG))


def digits(value: float) -> str:
    """A number that is not negative with ten digits, or six decimals where those are more."""
    places = FEED_DIGITS - 1 - floor(log10(value)) if value > 0.0 else 0
    return number(value, max(FEED_DECIMALS, places))


def comment_lines(text: str) -> list[str]:
    """What a comment says, plain ASCII, in lines that every controller takes."""
    return textwrap.wrap(re.sub(r"[^ -~]", "?", text), COMMENT_WIDTH)


def comments(text: str) -> list[str]:
    """Comment lines behind a semicolon, without quotes."""
    return [f"; {line}" for line in comment_lines(text.replace('"', "?"))]


def as_written(move: StraightMove, turns: Sequence[bool] | NDArray[np.bool_] = POSE_TURNS) -> StraightMove:
    """The move between its ends as their words say them; itself where that is not a move any more."""
    units = np.where(turns, DEG, MM)
    start, end = (
        np.array([float(word) for word in coordinates(pose, turns)]) * units for pose in (move.start, move.end)
    )
    return replace(move, start=start, end=end) if np.any(start != end) else move


NO_SLOWER = 1e-9
HALVINGS = 80  # of the interval of the feed: down to its last bit


def feed_of(block: ExactStopMove | Arc, limits: Box, guarantees: Guarantees, linear: bool = True) -> float:
    """Feed of a move along X, Y, Z [m/s], or along the angles [rad/s].

    The largest that the move can reach where even that takes longer than planned.

    Args:
        block: the move, with its planned duration.
        limits: limits that the controller is set up with.
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
    return high * float(np.linalg.norm(way[limits.turns != linear]))


def written_feed(block: ExactStopMove, limits: Box, guarantees: Guarantees) -> tuple[bool, str]:
    """Whether F counts X, Y, Z, and F, of the way as written: where these hardly move, rounding is much of it.

    Args:
        block: the move, with its planned duration.
        limits: limits that the controller is set up with.
    """
    written = as_written(block.move, limits.turns)
    way = (written.end - written.start)[~limits.turns]
    linear = bool(np.any(np.round(way / MM, LENGTH_DECIMALS) != 0.0))
    return linear, feed(feed_of(ExactStopMove(written), limits, guarantees, linear), linear)
