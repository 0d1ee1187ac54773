"""Writes a ROS 2 `trajectory_msgs/msg/JointTrajectory` as YAML: points with position, rate and acceleration.

`joint_trajectory_controller` joins such points by quintic pieces and checks no limit. Points stand where the pieces of
the motion begin and end, and between them as close as the case's blocks: pieces up to the fifth power are exact.
"""

import numpy as np

from cases.errors import ProgramError
from cases.schema import Case
from identification.motion import Array, Joined, Standstill
from postprocessors.block_writer import comment_lines, header_of
from postprocessors.blocks import Blocks, block_motions, divided, knots
from postprocessors.reading import Reading, Still, Timed

DECIMALS = 9  # decimals of rad, m and their derivatives
SAME = 1e-7  # [rad, m] tolerance between points of a motion that is not a polynomial
CLOSEST = 2e-3  # [s] least distance of points: rounding of closer ones makes jerks
FIRST = 0.02  # [s] time of the first point: at 0 the controller would jump to it


def write_joint_trajectory(program: Blocks, case: Case) -> bytes:
    """The message, plain ASCII, see `Dialect.write`; `controller.block_ms` is the distance of points."""
    chain, _ = case.need_chain("a joint trajectory")
    controller = case.need_controller("a joint trajectory")
    lines = [f"# {line}" for text in header_of(program) for line in comment_lines(text)]
    lines += [f"joint_names: [{', '.join(chain.names)}]", "points:"]
    motion = _motion(program)
    points = motion.at(_instants(motion, controller.block))
    for t, *values in zip(points.t + FIRST, points.pose, points.rates, points.accelerations, strict=True):
        for mark, name, row in zip("-  ", ("positions", "velocities", "accelerations"), values, strict=True):
            lines.append(f"{mark} {name}: [{', '.join(_number(v) for v in row)}]")
        seconds, nanoseconds = divmod(round(float(t) * 1e9), 10**9)
        lines.append(f"  time_from_start: {{sec: {seconds}, nanosec: {nanoseconds}}}")
    return ("\n".join(lines) + "\n").encode("ascii")


def require_same_trajectory(program: Blocks, reading: Reading, case: Case) -> None:
    """Raises ProgramError unless the message, as read back, is the program's motion, at its points and between them."""
    motion, clock = _motion(program), -FIRST
    for part in reading.stretches:
        if isinstance(part, Still):
            clock += part.duration
            continue
        assert isinstance(part, Timed)
        times = part.points.times
        t = np.sort(np.append(times, (times[1:] + times[:-1]) / 2))
        planned = motion.at(np.clip(t + clock, 0.0, motion.duration)).pose
        if not np.all(np.abs(part.points.at(t).pose - planned) <= SAME):
            raise ProgramError(reading.file, part.lines[0], 0, "the motion reads back differently; report this")
        clock += part.points.duration
    if abs(clock - motion.duration) > SAME:
        raise ProgramError(reading.file, 0, 0, f"lasts {clock:.6f} s of {motion.duration:.6f} s; report this")


def _motion(program: Blocks) -> Joined:
    """The whole motion: the message has no place for the trigger."""
    return Joined(tuple(motion for motion, _ in block_motions(program)))


def _instants(motion: Joined, step: float) -> Array:
    """Ends of all pieces, and instants between them, shape (n,) [s]; none within a standstill."""
    instants = [np.zeros(1)]
    for part, start in zip(motion.parts, motion.starts, strict=False):
        ends = [0.0]
        if not isinstance(part, Standstill):  # without those that are too close to another one
            ends += [t for t in knots(part)[1:-1] if min(t - ends[-1], part.duration - t) >= CLOSEST]
        longest = part.duration if isinstance(part, Standstill) else step
        instants.append(start + divided(np.array([*ends, part.duration]), longest)[1:])
    return np.concatenate(instants)


def _number(value: float) -> str:
    return f"{round(float(value), DECIMALS) + 0.0:.{DECIMALS}f}"
