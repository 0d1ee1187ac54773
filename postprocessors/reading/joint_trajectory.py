"""Reads a ROS 2 `trajectory_msgs/msg/JointTrajectory` in YAML, in the layout that `ros2 topic echo` and hexcite write.

Between points with position, rate and acceleration `joint_trajectory_controller` interpolates with a quintic polynomial
(ros2_controllers, trajectory.cpp). It reaches the first point from wherever the machine stands.
"""

import re
from itertools import pairwise
from typing import NoReturn

import numpy as np

from cases.errors import ProgramError
from cases.schema import Case
from identification.motion import Array
from postprocessors.reading import Grouping, Reading, TimedBlock, program_lines

LARGEST = 1e6  # rad, m and their derivatives: no machine has such numbers
LONGEST_LINE = 4096
_KEYS = ("positions", "velocities", "accelerations", "time_from_start")
_LIST = re.compile(r"\[([^\[\]]*)\]$")
_TIME = re.compile(r"\{\s*sec:\s*(\d+)\s*,\s*nanosec:\s*(\d+)\s*\}$")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


def read_joint_trajectory(content: bytes, file: str, case: Case) -> Reading:
    """Reads a message, see `Language.read`; its motion begins and ends at rest.

    The recording has no trigger: the whole motion counts as the excitation.
    """
    chain, _ = case.need_chain("a joint trajectory")
    reader = _Reader(file, program_lines(content, file, LONGEST_LINE))
    names, points = reader.message()
    if names != list(chain.names):
        reader.fail(reader.named, f"joints {', '.join(names)} are not those of the case, {', '.join(chain.names)}")
    return _grouped(reader, points).reading(len(points))


_Point = tuple[int, Array, float]  # line, position with rate and acceleration, shape (3, joints), and time [s]


class _Reader:
    """Lines of the message, one key each; positions of what is wrong."""

    def __init__(self, file: str, lines: list[str]) -> None:
        self.file, self.named = file, 0
        self.lines = [
            (number, code) for number, text in enumerate(lines, 1) if (code := text.split("#", 1)[0].rstrip()).strip()
        ]

    def fail(self, line: int, problem: str) -> NoReturn:
        raise ProgramError(self.file, line, 0, problem)

    def message(self) -> tuple[list[str], list[_Point]]:
        if len(self.lines) < 3:
            self.fail(0, "has no joint_names and points; is this a JointTrajectory?")
        (self.named, first), (place, second), *rest = self.lines
        names = [name.strip().strip("'\"") for name in self.list_of(self.named, first, "joint_names: ")]
        if second != "points:":
            self.fail(place, f"{second.strip()[:24]!r} where `points:` is expected; write joint_names, then points")
        if len(rest) % len(_KEYS):
            self.fail(rest[-1][0], f"the last point is not complete; a point has {', '.join(_KEYS)}")
        groups = [rest[k : k + len(_KEYS)] for k in range(0, len(rest), len(_KEYS))]
        return names, [self.point(group, len(names)) for group in groups]

    def point(self, group: list[tuple[int, str]], count: int) -> _Point:
        rows = []
        for mark, key, (line, code) in zip("-  ", _KEYS[:3], group, strict=False):
            words = self.list_of(line, code, f"{mark} {key}: ")
            if len(words) != count:
                self.fail(line, f"{key} has {len(words)} numbers for {count} joints; correct it")
            rows.append([self.number(line, word.strip()) for word in words])
        line, code = group[3]
        time = _TIME.match(code.removeprefix("  time_from_start: ")) if code.startswith("  time_from_start: ") else None
        if time is None or int(time[2]) >= 10**9:
            self.fail(line, "expected `  time_from_start: {sec: .., nanosec: ..}` with less than 10^9 nanoseconds")
        return (group[0][0], np.array(rows), int(time[1]) + int(time[2]) * 1e-9)

    def list_of(self, line: int, code: str, start: str) -> list[str]:
        match = _LIST.match(code.removeprefix(start)) if code.startswith(start) else None
        if match is None:
            self.fail(line, f"{code.strip()[:24]!r} where `{start}[..]` is expected; write the keys in this order")
        return match[1].split(",")

    def number(self, line: int, word: str) -> float:
        if not _NUMBER.fullmatch(word) or abs(float(word)) > LARGEST:
            self.fail(line, f"{word[:24]!r} is not a plain number below {LARGEST:g}; correct it")
        return float(word)


def _grouped(reader: _Reader, points: list[_Point]) -> Grouping:
    """Quintic pieces, and pauses where the machine stands; the trigger is on from the first movement to the last."""
    (line, state, time), (end, final, _) = points[0], points[-1]
    if not time > 0.0:
        reader.fail(line, "the first point is at 0 s, to which the controller would jump; give it some time")
    for place, values, verb in ((line, state, "begins"), (end, final, "ends")):
        if values[1:].any():
            reader.fail(place, f"the motion {verb} with a velocity or acceleration; it must be at rest there")
    blocks: list[TimedBlock] = []
    for (_, before, start), (place, after, until) in pairwise(points):
        duration = until - start
        if not duration > 0.0:
            reader.fail(place, f"time_from_start {until:g} s is not after the point before; correct it")
        standing = np.array_equal(before, after) and not after[1:].any()
        blocks.append((place, duration, after[0], None if standing else _quintic(before, after, duration)))
    moving = [k for k, (*_, coefficients) in enumerate(blocks) if coefficients is not None]
    motions = Grouping(reader.file)
    motions.stand(state[0])
    motions.pause(line, time)
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
