"""Reads a ROS 2 `trajectory_msgs/msg/JointTrajectory` in YAML, in the layout that `ros2 topic echo` and hexcite write.

Between points with position, rate and acceleration `joint_trajectory_controller` interpolates with a quintic polynomial
(ros2_controllers, trajectory.cpp), from where the machine stands to the first point, too: that must be home. Read is
what every reader of YAML takes alike: to some 010 is 8, 1e5 a text, and `no` a truth value.
"""

import itertools
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np

from cases.base.errors import Code, ProgramError
from cases.base.files import ascii_text
from cases.schema import Case
from identification.motion.motion import Array
from postprocessors.reading import STILL, Grouping, Reading, TimedBlock, program_lines

LARGEST = 1e6  # rad, m and their derivatives: no machine has such numbers
LONGEST_LINE = 4096
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
    chain, _ = case.need_chain("a joint trajectory")
    names, row = r"\s*,\s*".join(map(_name, chain.names)), r",\s*".join([_NUMBER] * len(chain.names))
    forms = [
        (f"joint_names: [{', '.join(chain.names)}]", re.compile(rf"joint_names: \[\s*{names}\s*\]")),
        ("points:", re.compile("points:")),
    ]
    of_a_point = [
        (f"{mark} {key}: [{len(chain.names)} plain numbers]{_FORM}", re.compile(rf"{mark} {key}: \[\s*{row}\s*\]"))
        for mark, key in zip("-  ", ("positions", "velocities", "accelerations"), strict=True)
    ]
    of_a_point.append(("  time_from_start: {sec: .., nanosec: ..}, whole numbers without leading zeros", _TIME))
    texts = (text.split("#", 1)[0].rstrip() for text in program_lines(content, file, LONGEST_LINE))
    lines = [(number, code) for number, code in enumerate(texts, 1) if code]
    found: list[tuple[int, tuple[str, ...]]] = []
    for (line, code), (form, pattern) in zip(lines, itertools.chain(forms, itertools.cycle(of_a_point)), strict=False):
        if (match := pattern.fullmatch(code)) is None:
            raise ProgramError(
                file=file,
                line=line,
                problem=f"{code.strip()[:SHOWN]!r} where `{form}` is expected",
                remedy="write it so",
                code=Code.SYNTAX,
            )
        found.append((line, match.groups()))
    rows = found[len(forms) :]
    if not rows or len(rows) % len(of_a_point):
        raise ProgramError(
            file=file,
            line=lines[-1][0] if lines else 0,
            problem="no point, or the last is not complete: truncated",
            code=Code.DAMAGED,
        )
    points: list[_Point] = []
    for k in range(0, len(rows), len(of_a_point)):
        *states, (_, (seconds, nanoseconds)) = rows[k : k + len(of_a_point)]
        state, time = np.array([words for _, words in states], dtype=float), int(seconds) + int(nanoseconds) * 1e-9
        before, ends = points[-1][2] if points else 0.0, k == 0 or k + len(of_a_point) == len(rows)
        if np.abs(state).max() > LARGEST or not time > before or (ends and state[1:].any()):
            problem = f"the point at {time:g} s must come after {before:g} s, have numbers below {LARGEST:g}"
            raise ProgramError(
                file=file,
                line=rows[k][0],
                problem=f"{problem}, and rest if it is the first or last",
                remedy="correct it",
                code=Code.SYNTAX,
            )
        points.append((rows[k][0], state, time))
    home, _ = case.need_motion("a joint trajectory")
    return replace(_grouped(file, points, home).reading(len(points)), start_time=points[0][2])


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
