"""Writes a ROS 2 `trajectory_msgs/msg/JointTrajectory` as YAML: points with position, rate and acceleration.

`joint_trajectory_controller` joins such points by quintic pieces and checks no limit. Points stand where the pieces of
the motion begin and end, and between them as close as the case's blocks: pieces up to the fifth power are exact.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cases.base.errors import Code, ProgramError
from cases.base.text_formats import ascii_text
from cases.schema import Case
from identification.motion.motion import Array, Joined, Slowed, Standstill, Trajectory
from identification.motion.moves import StraightMove
from postprocessors.blocks import Blocks, block_motions, divided, knots
from postprocessors.dialects.block_writer import comment_lines, header_of
from postprocessors.reading import Reading, Still, Timed

DECIMALS = 12  # of rad, m and their derivatives: in pieces of 2 ms this rounding makes jerks of 0.008 rad/s^3
NANOSECOND = 1e-9  # [s] to which the message states times; states are those at the times as stated
SAME = 1e-7  # [rad, m] tolerance between points of a motion that is not a polynomial
CLOSEST = 2e-3  # [s] least distance of points
FIRST = 3.0  # [s] time of the first point, home: the controller goes there from where the machine stands, at any speed


def write_joint_trajectory(program: Blocks, case: Case) -> bytes:
    """The message, plain ASCII, see `Dialect.write`; `controller.block_ms` is the distance of points."""
    chain, _ = case.need_chain("a joint trajectory")
    controller = case.need_controller("a joint trajectory")
    lines = [f"# {line}" for text in header_of(program) for line in comment_lines(text)]
    names = ", ".join(map(ascii_text, chain.names))
    lines += [f"joint_names: [{names}]", "points:"]
    motion = _motion(program, case)
    instants, at_rest = _instants(motion, controller.block)
    as_written = np.round(instants / NANOSECOND) * NANOSECOND
    points = motion.at(np.where(at_rest, instants, as_written))
    for t, *values in zip(as_written + FIRST, points.coordinates, points.rates, points.accelerations, strict=True):
        for mark, name, row in zip("-  ", ("positions", "velocities", "accelerations"), values, strict=True):
            lines.append(f"{mark} {name}: [{', '.join(_number(v) for v in row)}]")
        seconds, nanoseconds = divmod(round(float(t) * 1e9), 10**9)
        lines.append(f"  time_from_start: {{sec: {seconds}, nanosec: {nanoseconds}}}")
    return ("\n".join(lines) + "\n").encode("ascii")


def require_same_trajectory(program: Blocks, reading: Reading, case: Case) -> None:
    """Raises ProgramError unless the message, as read back, is the program's motion, at its points and between them."""
    motion, clock = _motion(program, case), -FIRST
    for part in reading.stretches:
        if isinstance(part, Still):
            clock += part.duration
            continue
        assert isinstance(part, Timed)
        times = part.points.times
        t = np.sort(np.append(times, (times[1:] + times[:-1]) / 2))
        planned = motion.at(np.clip(t + clock, 0.0, motion.duration)).coordinates
        if not np.all(np.abs(part.points.at(t).coordinates - planned) <= SAME):
            raise ProgramError(
                file=reading.file,
                line=part.lines[0],
                problem="the motion reads back differently",
                remedy="report this",
                code=Code.INTERNAL,
            )
        clock += part.points.duration
    if abs(clock - motion.duration) > SAME:
        raise ProgramError(
            file=reading.file,
            problem=f"lasts {clock:.6f} s of {motion.duration:.6f} s",
            remedy="report this",
            code=Code.INTERNAL,
        )


def _motion(program: Blocks, case: Case) -> Joined:
    """The whole motion from home, where it stands at first; the message has no place for the trigger.

    It is without phases that have no room between two points: a point that was left out where the jerk changes would
    make the pieces beside it exceed its limit.
    """
    home, _ = case.need_motion("a joint trajectory")
    settled = Standstill(home, case.need_controller("a joint trajectory").settle_s)
    return Joined(tuple(map(_with_room, (settled, *(motion for motion, _ in block_motions(program))))))


def _with_room(motion: Trajectory) -> Trajectory:
    if isinstance(motion, StraightMove):
        return replace(motion, profile=motion.profile.without_short_phases(CLOSEST))
    if isinstance(motion, Slowed):
        return Slowed(_with_room(motion.motion), motion.speed)
    if isinstance(motion, Standstill):
        return Standstill(motion.coordinates, max(motion.duration, CLOSEST))
    return motion


def _instants(motion: Joined, step: float) -> tuple[Array, NDArray[np.bool_]]:
    """Ends of all pieces, and instants between them [s], none within a standstill; and which are ends of parts, (n,).

    There, between one part and the next, the machine stands.
    """
    instants, at_rest = [0.0], [True]
    for part, start in zip(motion.parts, motion.starts, strict=False):
        ends, longest = [0.0], part.duration
        if not isinstance(part, Standstill):
            longest = max(step, 2 * CLOSEST)  # halves have room, too
            for t in knots(part)[1:-1]:
                if min(t - ends[-1], part.duration - t) >= CLOSEST:
                    ends.append(float(t))
        instants += (start + divided(np.array([*ends, part.duration]), longest)[1:]).tolist()
        at_rest += [False] * (len(instants) - len(at_rest) - 1) + [True]
    return np.array(instants), np.array(at_rest)


def _number(value: float) -> str:
    return f"{round(float(value), DECIMALS) + 0.0:.{DECIMALS}f}"
