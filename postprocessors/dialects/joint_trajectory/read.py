"""Reads a ROS 2 `trajectory_msgs/msg/JointTrajectory`: YAML as `ros2 topic echo` and hexcite write it, JSON, scripts.

Between points with position, rate and acceleration `joint_trajectory_controller` interpolates with a quintic polynomial
(ros2_controllers, trajectory.cpp), from where the machine stands to the first point, too: that must be home. Read is
what every reader of YAML takes alike: to some 010 is 8, 1e5 a text, and `no` a truth value.
"""

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from cases.base.errors import Code, ProgramError
from cases.base.text_formats import ascii_text
from cases.schema import Case
from identification.motion.motion import Array
from postprocessors.dialects.joint_trajectory.forms import Embedded, embedded, points_of
from postprocessors.reading import STILL, Grouping, Reading, TimedBlock, program_lines

LARGEST = 1e6  # rad, m and their derivatives: no machine has such numbers
MOST_TIME = 10**9  # seconds, and nanoseconds, of a time
LONGEST_LINE = 4096
AGAIN = "copy it again, or write it again with hexcite post"
SHOWN = 120  # characters of a line that an error repeats: names of seven joints
_WHOLE = r"(?:0|[1-9]\d{0,8})"
_NUMBER = r"([+-]?(?:0|[1-9]\d{0,17})(?:\.\d*(?:[eE][+-]\d{1,3})?)?)"
_TIME = re.compile(rf"  time_from_start: \{{\s*sec:\s*({_WHOLE})\s*,\s*nanosec:\s*({_WHOLE})\s*\}}")
_NO_TEXT = {"yes", "no", "on", "off", "true", "false", "null", "y", "n"}  # without quotes, in any case

_FORM = ", without leading zeros, with an exponent only behind a decimal point, as 1.0e-05"

_Point = tuple[int, Array, float]  # line, position with rate and acceleration, shape (3, joints), and time [s]


def read_joint_trajectory(content: bytes, file: str, case: Case) -> Reading:
    """Reads a message, see `Dialect.read`; its motion begins and ends at rest.

    The recording has no trigger: the whole motion counts as the excitation.
    """
    message = embedded(content, file, case)
    points_of_text = _of_yaml(content, file, case) if message is None else _of_json(message, file, case)
    points = list(_in_order(points_of_text, file))
    home, _ = case.need_motion("a joint trajectory")
    return replace(_grouped(file, points, home).reading(len(points)), start_time=points[0][2])


def _in_order(points_of_text: Sequence[_Point], file: str) -> Iterator[_Point]:
    """The points; raises ProgramError where times do not increase, numbers are too large, or an end moves."""
    before = 0.0
    for k, (line, state, time) in enumerate(points_of_text, 1):
        ends = k in (1, len(points_of_text))
        if np.abs(state).max() > LARGEST or not time > before or (ends and state[1:].any()):
            problem = f"the point at {time:g} s must come after {before:g} s, have numbers below {LARGEST:g}"
            raise ProgramError(
                file=file,
                line=line,
                problem=f"{problem}, and rest if it is the first or last",
                remedy="correct it",
                code=Code.SYNTAX,
            )
        yield line, state, time
        before = time


_PARTS = ("positions", "velocities", "accelerations")


def _of_json(message: Embedded, file: str, case: Case) -> list[_Point]:
    """Points of a message in JSON."""
    chain, _ = case.need_chain("a joint trajectory")
    count, points = len(chain.names), list[_Point]()
    for line, entries in points_of(message, file, case):
        if (trajectory := _of_entries(entries, count)) is None:
            raise ProgramError(
                file=file,
                line=line,
                problem=f"a point that is not {', '.join(_PARTS)} of {count} numbers each and "
                'time_from_start: {"sec": .., "nanosec": ..}, whole numbers',
                remedy="write it so",
                code=Code.SYNTAX,
            )
        points.append((line, *trajectory))
    if not points:
        raise ProgramError(file=file, line=message.line, problem="no point: truncated", remedy=AGAIN, code=Code.DAMAGED)
    return points


def _of_entries(entries: Any, count: int) -> tuple[Array, float] | None:
    """State, shape (3, joints), and time [s] of a point; None where it is no such point."""
    if (
        not isinstance(entries, dict)
        or entries.keys() - {*_PARTS, "time_from_start", "effort"}
        or entries.get("effort")
    ):
        return None
    rows, time = [entries.get(key) for key in _PARTS], entries.get("time_from_start")
    if not isinstance(time, dict) or time.keys() != {"sec", "nanosec"}:
        return None
    if not all(type(v) is int and 0 <= v < MOST_TIME for v in time.values()):
        return None
    for row in rows:
        if not isinstance(row, list) or len(row) != count or not all(type(v) in (int, float) for v in row):
            return None
    if any(abs(v) > LARGEST for row in rows for v in row or ()):
        return None
    return np.array(rows, dtype=float), time["sec"] + time["nanosec"] * 1e-9


def _of_yaml(content: bytes, file: str, case: Case) -> list[_Point]:
    """Points of a message in YAML."""
    chain, _ = case.need_chain("a joint trajectory")
    names, row = r"\s*,\s*".join(map(_name, chain.names)), r",\s*".join([_NUMBER] * len(chain.names))
    forms = [
        (f"joint_names: [{', '.join(chain.names)}]", re.compile(rf"joint_names: \[\s*{names}\s*\]")),
        ("points:", re.compile("points:")),
    ]
    of_a_point = [
        (f"{mark} {key}: [{len(chain.names)} plain numbers]{_FORM}", re.compile(rf"{mark} {key}: \[\s*{row}\s*\]"))
        for mark, key in zip("-  ", _PARTS, strict=True)
    ]
    of_a_point.append(("  time_from_start: {sec: .., nanosec: ..}, whole numbers without leading zeros", _TIME))
    texts = (text.split("#", 1)[0].rstrip() for text in program_lines(content, file, LONGEST_LINE))
    lines = [(number, code) for number, code in enumerate(texts, 1) if code]
    positions: list[tuple[int, tuple[str, ...]]] = []
    for (line, code), (form, pattern) in zip(lines, itertools.chain(forms, itertools.cycle(of_a_point)), strict=False):
        if (match := pattern.fullmatch(code)) is None:
            raise ProgramError(
                file=file,
                line=line,
                problem=f"{code.strip()[:SHOWN]!r} where `{form}` is expected",
                remedy="write it so",
                code=Code.SYNTAX,
            )
        positions.append((line, match.groups()))
    rows = positions[len(forms) :]
    if not rows or len(rows) % len(of_a_point):
        raise ProgramError(
            file=file,
            line=lines[-1][0] if lines else 0,
            problem="no point, or the last is not complete: truncated",
            remedy=AGAIN,
            code=Code.DAMAGED,
        )
    points: list[_Point] = []
    for k in range(0, len(rows), len(of_a_point)):
        *states, (_, (seconds, nanoseconds)) = rows[k : k + len(of_a_point)]
        state = np.array([words for _, words in states], dtype=float)
        points.append((rows[k][0], state, int(seconds) + int(nanoseconds) * 1e-9))
    return points


def _name(name: str) -> str:
    """Pattern of the name of a joint: in quotes, or without where that is a text to every reader."""
    plain = name.lower() not in _NO_TEXT and re.fullmatch(r"[A-Za-z_][\w.-]*", name)
    quoted = rf"'{re.escape(name)}'|\"{re.escape(name)}\"|{re.escape(ascii_text(name))}"
    return f"(?:{quoted}|{re.escape(name)})" if plain else f"(?:{quoted})"


def _grouped(file: str, points: list[_Point], home: Array) -> Grouping:
    """Quintic pieces, and pauses where the machine stands; the trigger is on from the first movement to the last.

    It begins at rest at home; a first point elsewhere is the end of a piece.
    """
    line, state, _ = points[0]
    begin = state.copy()
    if np.abs(state[0] - home).max() > STILL:
        begin[0] = home
    blocks: list[TimedBlock] = []
    for (_, before, start), (place, after, until) in pairwise([(line, begin, 0.0), *points]):
        duration = until - start
        standing = np.array_equal(before, after) and not after[1:].any()
        blocks.append((place, duration, after[0], None if standing else _quintic(before, after, duration)))
    moving = [k for k, (*_, coefficients) in enumerate(blocks) if coefficients is not None]
    motions = Grouping(file)
    motions.stand(begin[0])
    for k, block in enumerate(blocks):
        place, duration, _, coefficients = block
        if k in moving[:1]:
            motions.switch(place, True, at_once=True)
        if coefficients is None:
            motions.pause(place, duration)
        else:
            motions.block(block)
        if k in moving[-1:]:
            motions.switch(place, False, at_once=True)
    return motions


def _quintic(before: Array, after: Array, duration: float) -> Array:
    """Coefficients in p = t / duration, shape (6, n), between positions, rates and accelerations, shapes (3, n)."""
    scale = duration ** np.arange(3)[:, None]
    (p, v, a), (q, w, b) = before * scale, after * scale
    c0, c1, c2 = p, v, a / 2
    d, e, f = q - c0 - c1 - c2, w - c1 - 2 * c2, b - 2 * c2
    return np.array([c0, c1, c2, 10 * d - 4 * e + f / 2, -15 * d + 7 * e - f, 6 * d - 3 * e + f / 2])
