"""Writes programs for LinuxCNC: axes in mm and degrees, the pose of a platform or the joints of a chain.

Point-to-point moves are G1 with exact stop (G61), arcs G2 and G3, timed paths and splines dense G1 in inverse time
(G93). Of a chain there are moves only: paths would be cut where rotary axes turn round.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cases.controller import LinuxCnc
from cases.errors import HexciteError
from cases.schema import Case
from cases.units import MINUTE
from identification.limited_quantities import Box
from identification.motion import Slowed
from identification.trajectories.curves import PolynomialMotion
from identification.trajectories.moves import CircularMove, StraightMove, limits_along
from postprocessors.blocks import Array, Block, Dwell, NeutralProgram, TimedPath, ToHome, Trigger
from postprocessors.execute.linuxcnc.configuration import SERVO_PERIOD
from postprocessors.execute.linuxcnc.stretching import ARC_ACROSS, ARC_ALONG
from postprocessors.wording import (
    FEED_DECIMALS,
    PLANE_WORDS,
    arc_words,
    comment_lines,
    coordinates,
    feed,
    home_feed,
    number,
)
from postprocessors.writing import timed_path

MOTION = (ToHome, StraightMove, CircularMove, TimedPath)
FULL = 1e-9  # [rad] that a full circle may miss: rounding
EQUAL = 1e-9  # [s] of durations: rounding
OFFSETS = "coordinate system G54 must be zero: all poses are the machine's own"


def _comments(text: str) -> list[str]:
    """LinuxCNC knows no nesting, and reads (MSG, ..) as a command, hence the leading dash."""
    lines = comment_lines(text.replace("(", "[").replace(")", "]"))
    return [f"(- {line})" for line in lines]


class _LinuxCncWriter:
    """Words for the axis accelerations that the controller is set up with, and the points of its timed paths.

    Args:
        axes: letters of the coordinates.
        headroom: acceleration limits that the controller gets, as a multiple of these.
        block: duration of a block of a timed path [s].
        chain: whether the axes are the joints of a chain.
    """

    def __init__(self, axes: Sequence[str], limits: Box, headroom: float, block: float, chain: bool) -> None:
        self.axes, self.limits, self.chain = axes, limits, chain
        self.acceleration = headroom * limits.acceleration
        self.block = block

    def words(self, pose: Array) -> str:
        """Coordinates as axis words."""
        return " ".join(a + v for a, v in zip(self.axes, coordinates(pose, self.limits.turns), strict=True))

    def lines(self, block: Block, following: Block | None) -> list[str]:
        match block:
            case str():
                return _comments(block)
            case ToHome():
                return [
                    *_comments("to home"),
                    "G61",
                    f"G94 G1 {self.words(block.pose)} F{home_feed(block, self.limits, self.chain)}",
                ]
            case StraightMove():
                return [f"G1 {self.words(block.end)} F{self.feed_of(block)}"]
            case CircularMove() | TimedPath() if self.chain:
                raise HexciteError(
                    "LinuxCNC cuts corners of paths by degrees where rotary axes turn round; plan with --family ptp"
                )
            case CircularMove():
                return [f"{PLANE_WORDS[block.plane]} {self.arc(block)}", "G17"]
            case Dwell():
                return [f"G4 P{number(block.duration, 6)}"]
            case Trigger():
                # On with the first cycle of the motion that follows (M62), where one follows at once; else, and off
                # after the last, at once: M62 and M63 wait for a next motion, and here the machine stands.
                if block.on:
                    return ["M62 P0" if isinstance(following, MOTION) else "M64 P0"]
                return ["M65 P0"]
            case TimedPath():
                return self.timed(block)

    def feed_of(self, move: StraightMove) -> str:
        """The feed that makes a trapezoid under the axis limits take as long as the planned move."""
        way = np.abs(move.end - move.start)
        (acceleration,) = limits_along(way, self.acceleration)
        share = _trapezoid_speed(move.duration, acceleration)
        linear = bool(way[~self.limits.turns].any())
        length = float(np.linalg.norm(way[~self.limits.turns if linear else self.limits.turns]))
        return feed(share * length, linear)

    def arc(self, move: CircularMove) -> str:
        """A full circle has no end words, or it would be none at all."""
        first, second, _ = move.plane.axes
        way = np.abs(move.end - move.start)
        way[[first, second]] = move.length
        (acceleration,) = limits_along(way, self.acceleration)
        turning = float(np.sqrt(ARC_ACROSS * acceleration / abs(move.angle)))
        share = min(_trapezoid_speed(move.duration, ARC_ALONG * acceleration), turning)
        full = abs(abs(move.angle) - 2 * np.pi) < FULL
        words = arc_words(move, self.axes, coordinates(move.end, self.limits.turns), full)
        return f"{'G3' if move.angle > 0.0 else 'G2'} {words} F{feed(share * move.length, linear=True)}"

    def timed(self, path: TimedPath) -> list[str]:
        """Dense blocks in inverse time."""
        lines = [*_comments(f"{path.name}: {len(path.times) - 1} blocks, {path.times[-1]:.6f} s"), "G64 P1 Q0", "G93"]
        feeds = MINUTE / np.diff(path.times)
        for pose, value in zip(path.poses[1:], feeds, strict=True):
            lines.append(f"G1 {self.words(pose)} F{number(value, FEED_DECIMALS)}")  # G93 wants F on every line
        # Back to feed per minute; G61 makes whatever follows wait until the path has come to rest.
        return [*lines, "G94", "G61"]


def _trapezoid_speed(duration: float, acceleration: float) -> float:
    """Speed v of the trapezoid over the way 1 with 1 / v + v / a = T; without cruise where T is as short as can be."""
    root = max(0.0, (acceleration * duration) ** 2 - 4 * acceleration)
    return float((acceleration * duration - np.sqrt(root)) / 2)


def prepare_linuxcnc(program: NeutralProgram, case: Case) -> NeutralProgram:
    """Paths in blocks of whole cycles: what is over LinuxCNC leaves out (measured on 2.9), and would be too fast."""
    length = case.need_controller("a program").block
    blocks = [_in_cycles(b, length) if isinstance(b, TimedPath) else b for b in program.blocks]
    return replace(program, blocks=tuple(blocks))


def _in_cycles(path: TimedPath, length: float) -> TimedPath:
    """The same path with points at whole cycles, slowed down by as little as that takes.

    Of a spline whose pieces last equally long each begins at such a point.

    Args:
        length: duration of a block of a spline, at most [s].
    """
    if isinstance(path.motion, PolynomialMotion):
        lasting = [piece.duration for piece in path.motion.pieces]
        share = _share_of_cycles(lasting[0] if np.ptp(lasting) < EQUAL else path.motion.duration)
        path = timed_path(path.name, path.motion.slowed(share), length, 1.0)
    else:
        share = _share_of_cycles(path.times[-1])
        path = replace(path, times=path.times / share, motion=Slowed(path.motion, share))
    times = np.unique(np.round(path.times / SERVO_PERIOD)) * SERVO_PERIOD
    if len(times) == len(path.times) and np.allclose(times, path.times, rtol=0.0, atol=EQUAL):
        return path
    return replace(path, times=times, poses=path.motion.at(times).pose)


def _share_of_cycles(duration: float) -> float:
    """Share of the speed, 1 at most, at which something lasts whole cycles."""
    cycles = duration / SERVO_PERIOD
    return float(cycles / np.ceil(cycles - EQUAL / SERVO_PERIOD))


def write_linuxcnc(program: NeutralProgram, case: Case) -> str:
    """The program's text, plain ASCII.

    Args:
        case: its limits are those that the controller is set up with; feeds are chosen for them.

    Raises:
        CaseError: the case has no machine or no controller.
    """
    limits, controller = case.need_motion("a program")[1], case.need_controller("a program")
    timed = case.chain is None and any(isinstance(block, TimedPath) for block in program.blocks)
    headroom = case.need_settings(LinuxCnc, "a program").acceleration_headroom if timed else 1.0
    axes = tuple("XYZABC") if case.chain is None else case.chain.names
    writer = _LinuxCncWriter(axes, limits, headroom, controller.block, case.chain is not None)
    lines = [c for line in (*program.header, OFFSETS) for c in _comments(line)]
    # G92.1 takes back offsets that an operator may have left; G54 itself must be zero, a program cannot know.
    lines += ["G17 G21 G40 G49 G54 G80 G90 G91.1 G94", "G92.1"]
    for k, block in enumerate(program.blocks):
        following = next((b for b in program.blocks[k + 1 :] if not isinstance(b, str)), None)
        lines += writer.lines(block, following)
    return "\n".join([*lines, "M2"]) + "\n"
