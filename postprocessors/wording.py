"""How numbers, poses and comments are written by dialects whose words look alike."""

import re
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from math import floor, log10

import numpy as np

from cases.units import DEG, MINUTE, MM
from identification.trajectories.circle import CircularMove, Plane
from identification.trajectories.profile import StraightMove
from postprocessors.program import Array

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


def coordinates(pose: Array) -> list[str]:
    """The six numbers of a pose, shape (6,) [m, rad], in mm and degrees."""
    lengths = [number(v / MM, LENGTH_DECIMALS) for v in pose[:3]]
    return lengths + [number(v / DEG, ANGLE_DECIMALS) for v in pose[3:]]


def arc_words(move: CircularMove, names: Sequence[str], values: Sequence[str], full: bool = False) -> str:
    """Coordinates of an arc's end and two of I, J, K: the centre relative to the start, as the block before wrote it.

    Args:
        move: the arc.
        names: of the six coordinates.
        values: of the six coordinates at its end.
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


def as_written(move: StraightMove) -> StraightMove:
    """The move between its ends as their words say them; itself where that is no move any more."""
    units = np.repeat([MM, DEG], 3)
    start, end = (np.array([float(word) for word in coordinates(pose)]) * units for pose in (move.start, move.end))
    return replace(move, start=start, end=end) if np.any(start != end) else move
