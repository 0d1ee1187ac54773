"""Writes programs for LinuxCNC: axes in mm and degrees, the pose of a platform or the joints of a chain.

Point-to-point moves are G1 with exact stop (G61.1), arcs G2 and G3, timed paths and splines dense G1 in inverse time
(G93). Of a chain there are moves only: paths would be cut where rotary axes turn round.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Array, Slowed
from postprocessors.blocks import Blocks, TimedPath, ToHome, timed_path
from postprocessors.dialects.block_writer import HOME_WITHIN, BlockWriter, comment_lines
from postprocessors.dialects.linuxcnc.promises import SERVO_PERIOD, guarantees_of_linuxcnc
from postprocessors.reading import axis_letters

_PLAIN = str.maketrans("();", "[],")
EQUAL = 1e-9  # [s] tolerance of durations for rounding
LEAST = 2e-8  # [m, rad] least way of a block, above the last decimal of the words
FIRST_CHECK = 101  # number of the first conditional stop
# Axes that a machine lacks have offsets of zero.
ZERO_OFFSETS = (
    "o100 if [[abs[#5221]+abs[#5222]+abs[#5223]+abs[#5224]+abs[#5225]+abs[#5226]+abs[#5230]] gt 0]",
    "(abort,The coordinate system G54 is not zero: places are those of the machine. Set it to zero, then start again)",
    "o100 endif",
)


class _LinuxCncWriter(BlockWriter):
    name, straight, arcs, dwell = "LinuxCNC", "G1", ("G3", "G2"), "G4 P"
    full_ends = False
    no_paths = "cuts corners of paths by degrees where rotary axes turn round"

    def __init__(self, case: Case, timed: bool) -> None:
        axes = axis_letters(case, self.name, "")
        super().__init__(axes, axes, guarantees_of_linuxcnc(case, timed), case)
        self.overdriven = case.need_controller("a program").overdriven

    def comments(self, text: str) -> list[str]:
        """Comment lines: LinuxCNC does not know nesting, and reads (MSG, ..) as a command, hence the leading dash.

        It would look for commands behind the first semicolon of a line, too.
        """
        return [f"(- {line})" for line in comment_lines(text.translate(_PLAIN))]

    def to_home(self, block: ToHome) -> list[str]:
        return [*ZERO_OFFSETS, *super().to_home(block)]

    def before_crawl(self) -> list[str]:
        """The override switched off, where the knob goes beyond 100 %; behind the checks, for M2 alone resets it."""
        return ["M50 P0"] if self.overdriven else []

    def stop_unless(self, axis: str, difference: str, home: str) -> list[str]:
        number, name = FIRST_CHECK + self.axes.index(axis), f"#<_{axis.lower()}>"
        return [
            f"o{number} if [abs[{name}{difference}] gt {HOME_WITHIN:g}]",
            f"(abort,Not at home: {axis} is at {name}. Go to {home} first, then start again)",
            f"o{number} endif",
        ]

    def trigger(self, on: bool, moves_next: bool) -> str:
        """Block that switches on with the first cycle of a motion that follows at once (M62); else, and off, at once.

        M62 and M63 wait for a next motion; after the last, and before a dwell, the machine stands.
        """
        if on:
            return "M62 P0" if moves_next else "M64 P0"
        return "M65 P0"

    def path(self, path: TimedPath) -> list[str]:
        """Dense blocks in inverse time."""
        # Back to feed per minute; G61.1 makes whatever follows wait until the path has come to rest. G61 would stop at
        # corners alone: moves in one direction would run into each other.
        return self.dense(path, ["G64 P1 Q0", "G93"], ["G94", "G61.1"])


def prepare_linuxcnc(program: Blocks, case: Case) -> Blocks:
    """Paths in blocks of whole cycles: LinuxCNC omits the rest (measured on 2.9), and would be too fast."""
    length = case.need_controller("a program").block
    return tuple(_in_cycles(block, length) if isinstance(block, TimedPath) else block for block in program)


def _in_cycles(path: TimedPath, length: float) -> TimedPath:
    """The same path with points at whole cycles, slowed down as little as possible; blocks of splines last `length`.

    Each piece of a spline whose pieces last equally long begins at such a point.
    """
    if isinstance(path.motion, PolynomialMotion):
        lasting = path.motion.durations
        share = _share_of_cycles(lasting[0] if np.ptp(lasting) < EQUAL else path.motion.duration)
        path = timed_path(path.name, path.motion.slowed(share), length, 1.0)
    else:
        share = _share_of_cycles(path.times[-1])
        path = replace(path, times=path.times / share, motion=Slowed(path.motion, share))
    times = np.unique(np.round(path.times / SERVO_PERIOD)) * SERVO_PERIOD
    if len(times) != len(path.times) or not np.allclose(times, path.times, rtol=0.0, atol=EQUAL):
        path = replace(path, times=times, poses=path.motion.at(times).coordinates)
    return with_moving_blocks(path)


def with_moving_blocks(path: TimedPath) -> TimedPath:
    """The same path without points that LinuxCNC cannot tell from those before them.

    It leaves out a block in which nothing moves, and with it its time.
    """
    apart = _apart(path.poses)
    return path if apart.all() else replace(path, times=path.times[apart], poses=path.poses[apart])


def _apart(poses: Array) -> NDArray[np.bool_]:
    """Which points of a path move from those before them, the ends always, shape (k,)."""
    rows = [0]
    for k in range(1, len(poses)):
        if np.any(np.abs(poses[k] - poses[rows[-1]]) > LEAST):
            rows.append(k)
    if rows[-1] != len(poses) - 1:
        rows[-1 if len(rows) > 1 else len(rows) :] = [len(poses) - 1]
    mask = np.zeros(len(poses), dtype=bool)
    mask[rows] = True
    return mask


def _share_of_cycles(duration: float) -> float:
    """Share of the speed, 1 at most, at which something lasts whole cycles."""
    cycles = duration / SERVO_PERIOD
    return float(cycles / np.ceil(cycles - EQUAL / SERVO_PERIOD))


def write_linuxcnc(program: Blocks, case: Case) -> bytes:
    """The program's text, plain ASCII, with feeds for the limits of the controller's set-up; see `Dialect.write`."""
    of_pose = case.need_motion("a program")[1].of_pose
    writer = _LinuxCncWriter(case, of_pose and any(isinstance(block, TimedPath) for block in program))
    # G92.1 cancels offsets of an operator; whether G54 itself is zero is checked.
    start = ["G8 G17 G21 G40 G49 G54 G80 G90 G91.1 G94", "G92.1", "G61.1"]
    return writer.text(program, [], start, ["M2"])
