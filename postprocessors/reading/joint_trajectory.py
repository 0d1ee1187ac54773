"""Reads a ROS 2 `trajectory_msgs/msg/JointTrajectory` in YAML, in the layout that `ros2 topic echo` and hexcite write.

Between points with position, rate and acceleration `joint_trajectory_controller` interpolates with a quintic polynomial
(ros2_controllers, trajectory.cpp). It reaches the first point from wherever the machine stands.
"""

import re
from itertools import pairwise

import numpy as np

from cases.errors import ProgramError
from cases.schema import Case
from identification.motion import Array
from postprocessors.reading import NUMBER, Grouping, Reading, TimedBlock, program_lines

LARGEST = 1e6  # rad, m and their derivatives: no machine has such numbers
LONGEST_LINE = 4096
_KEYS = ("positions", "velocities", "accelerations", "time_from_start")
_LIST = re.compile(r"\[([^\[\]]*)\]$")
_TIME = re.compile(r"  time_from_start: \{\s*sec:\s*(\d+)\s*,\s*nanosec:\s*(\d+)\s*\}$")
_NUMBER = re.compile(rf"{NUMBER}(?:[eE][+-]?\d+)?")


_Point = tuple[int, Array, float]  # line, position with rate and acceleration, shape (3, joints), and time [s]


def read_joint_trajectory(content: bytes, file: str, case: Case) -> Reading:
    """Reads a message, see `Dialect.read`; its motion begins and ends at rest.

    The recording has no trigger: the whole motion counts as the excitation.
    """
    chain, _ = case.need_chain("a joint trajectory")
    texts = (text.split("#", 1)[0].rstrip() for text in program_lines(content, file, LONGEST_LINE))
    lines = [(number, code) for number, code in enumerate(texts, 1) if code]
    if len(lines) < 3:
        raise ProgramError(file, 0, 0, "has no joint_names and points; is this a JointTrajectory?")
    (line, first), (place, second), *rest = lines
    names = [name.strip().strip("'\"") for name in _list_of((file, line, 0), first, "joint_names: ")]
    if second != "points:":
        problem = f"{second.strip()[:24]!r} where `points:` is expected; write joint_names, then points"
        raise ProgramError(file, place, 0, problem)
    if len(rest) % len(_KEYS):
        problem = f"the last point is not complete; a point has {', '.join(_KEYS)}"
        raise ProgramError(file, rest[-1][0], 0, problem)
    groups = [rest[k : k + len(_KEYS)] for k in range(0, len(rest), len(_KEYS))]
    points = [_point(group, len(names), file) for group in groups]
    if names != list(chain.names):
        problem = f"joints {', '.join(names)} are not those of the case, {', '.join(chain.names)}"
        raise ProgramError(file, line, 0, problem)
    return _grouped(file, points).reading(len(points))


def _point(group: list[tuple[int, str]], count: int, file: str) -> _Point:
    rows = []
    for mark, key, (line, code) in zip("-  ", _KEYS[:3], group, strict=False):
        words = _list_of((file, line, 0), code, f"{mark} {key}: ")
        if len(words) != count:
            raise ProgramError(file, line, 0, f"{key} has {len(words)} numbers for {count} joints; correct it")
        for word in map(str.strip, words):
            if not _NUMBER.fullmatch(word) or abs(float(word)) > LARGEST:
                problem = f"{word[:24]!r} is not a plain number below {LARGEST:g}; correct it"
                raise ProgramError(file, line, 0, problem)
        rows.append([float(word) for word in words])
    line, code = group[3]
    time = _TIME.match(code)
    if time is None or int(time[2]) >= 10**9:
        problem = "expected `  time_from_start: {sec: .., nanosec: ..}` with less than 10^9 nanoseconds"
        raise ProgramError(file, line, 0, problem)
    return group[0][0], np.array(rows), int(time[1]) + int(time[2]) * 1e-9


def _list_of(place: tuple[str, int, int], code: str, start: str) -> list[str]:
    match = _LIST.match(code.removeprefix(start)) if code.startswith(start) else None
    if match is None:
        problem = f"{code.strip()[:24]!r} where `{start}[..]` is expected; write the keys in this order"
        raise ProgramError(*place, problem)
    return match[1].split(",")


def _grouped(file: str, points: list[_Point]) -> Grouping:
    """Quintic pieces, and pauses where the machine stands; the trigger is on from the first movement to the last."""
    (line, state, time), (end, final, _) = points[0], points[-1]
    if not time > 0.0:
        raise ProgramError(
            file, line, 0, "the first point is at 0 s, to which the controller would jump; give it some time"
        )
    for place, values, verb in ((line, state, "begins"), (end, final, "ends")):
        if values[1:].any():
            raise ProgramError(
                file, place, 0, f"the motion {verb} with a velocity or acceleration; it must be at rest there"
            )
    blocks: list[TimedBlock] = []
    for (_, before, start), (place, after, until) in pairwise(points):
        duration = until - start
        if not duration > 0.0:
            raise ProgramError(file, place, 0, f"time_from_start {until:g} s is not after the point before; correct it")
        standing = np.array_equal(before, after) and not after[1:].any()
        blocks.append((place, duration, after[0], None if standing else _quintic(before, after, duration)))
    moving = [k for k, (*_, coefficients) in enumerate(blocks) if coefficients is not None]
    motions = Grouping(file)
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
