"""Writes programs for LinuxCNC: XYZABC in mm and degrees.

Point-to-point moves are G1 with exact stop (G61), arcs G2 and G3, timed paths and splines dense G1 in inverse time
(G93).
"""

import re
import textwrap

import numpy as np

from cases.errors import HexciteError
from cases.schema import Case
from cases.units import DEG, MINUTE, MM
from identification.circle import Plane
from postprocessors.execute.linuxcnc.guarantees import ARC_ACROSS, ARC_ALONG
from postprocessors.program import (
    Arc,
    Array,
    Block,
    Comment,
    Dwell,
    PointToPoint,
    Program,
    SplinePath,
    StrutPointToPoint,
    TimedPath,
    ToHome,
    Trigger,
    timed_path,
)

# 1e-5 mm and 1e-6 degrees: differentiated three times over 10 ms blocks this rounding stays below 0.1 % of the jerk
# limits.
LENGTH_DECIMALS = 5
ANGLE_DECIMALS = 6
FEED_DECIMALS = 6
COMMENT_WIDTH = 100  # a line of the controller holds 252 characters
OFFSETS = "coordinate system G54 must be zero: all poses are the machine's own"


def _number(value: float, decimals: int) -> str:
    """Plain decimal notation (the interpreter knows no exponents), without trailing zeros or a negative zero."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def _axes(pose: Array) -> str:
    lengths = [_number(v / MM, LENGTH_DECIMALS) for v in pose[:3]]
    angles = [_number(v / DEG, ANGLE_DECIMALS) for v in pose[3:]]
    return " ".join(f"{letter}{value}" for letter, value in zip("XYZABC", lengths + angles, strict=True))


def _comments(text: str) -> list[str]:
    """Comment lines. LinuxCNC knows no nesting, and reads (MSG, ..) as a command, hence the leading dash."""
    plain = re.sub(r"[^ -~]", "?", text).replace("(", "[").replace(")", "]")
    return [f"(- {line})" for line in textwrap.wrap(plain, COMMENT_WIDTH)]


class _Writer:
    """Keeps what holds from block to block: the last feed mode."""

    def __init__(self, acceleration: Array, block: float) -> None:
        self.acceleration = acceleration  # limits that the controller gets, shape (6,)
        self.block = block

    def lines(self, block: Block, following: Block | None) -> list[str]:
        match block:
            case Comment():
                return _comments(block.text)
            case ToHome():
                return [*_comments("to home"), "G61", f"G94 G1 {_axes(block.pose)} F{_feed(block.feed, linear=True)}"]
            case PointToPoint():
                return [f"G1 {_axes(block.move.end)} F{self.feed_of(block)}"]
            case StrutPointToPoint():
                raise HexciteError("LinuxCNC has no moves straight in the struts; leave out --ptp-struts")
            case Arc():
                return [f"{_PLANES[block.move.plane]} {self.arc(block)}", "G17"]
            case Dwell():
                return [f"G4 P{_number(block.duration, 6)}"]
            case Trigger():
                # On with the first cycle of the motion that follows (M62), where one follows at once; else, and off
                # after the last, at once: M62 and M63 wait for a next motion, and here the machine stands.
                if block.on:
                    return ["M62 P0" if isinstance(following, MOTION) else "M64 P0"]
                return ["M65 P0"]
            case TimedPath():
                return _timed(block)
            case SplinePath():
                return _timed(timed_path(block.name, block.motion, self.block, 1.0))

    def feed_of(self, block: PointToPoint) -> str:
        """The feed that makes a trapezoid under the axis limits take as long as the planned move."""
        way = np.abs(block.move.end - block.move.start)
        moves = way > 0.0
        acceleration = float(np.min(self.acceleration[moves] / way[moves]))
        share = _trapezoid_speed(block.move.duration, acceleration)
        return _feed(share * block.length, linear=bool(way[:3].any()))

    def arc(self, block: Arc) -> str:
        """Centre words are relative to the start; a full circle has no end words, or it would be none at all."""
        move = block.move
        first, second, _ = move.plane.axes
        way = np.abs(move.end - move.start)
        way[[first, second]] = move.length
        moves = way > 0.0
        acceleration = float(np.min(self.acceleration[moves] / way[moves]))
        turning = float(np.sqrt(ARC_ACROSS * acceleration / abs(move.angle)))
        share = min(_trapezoid_speed(move.duration, ARC_ALONG * acceleration), turning)
        words = [f"{'XYZ'[k]}{_number(move.end[k] / MM, LENGTH_DECIMALS)}" for k in sorted((first, second))]
        if abs(abs(move.angle) - 2 * np.pi) < FULL:
            words = []
        words += [f"{c}{_number(v / DEG, ANGLE_DECIMALS)}" for c, v in zip("ABC", move.end_angles, strict=True)]
        start = np.round(move.start[[first, second]] / MM, LENGTH_DECIMALS)  # as the block before has written it
        for k, offset in sorted(zip((first, second), move.centre / MM - start, strict=True)):
            words.append(f"{'IJK'[k]}{_number(offset, LENGTH_DECIMALS)}")
        return f"{'G3' if move.angle > 0.0 else 'G2'} {' '.join(words)} F{_feed(share * move.length, linear=True)}"


MOTION = (ToHome, PointToPoint, Arc, TimedPath, SplinePath)
_PLANES = {Plane.XY: "G17", Plane.ZX: "G18", Plane.YZ: "G19"}
FULL = 1e-9  # [rad] that a full circle may miss: rounding


def _feed(speed: float, linear: bool) -> str:
    """F in mm/min, or in degrees/min where only angles move."""
    return _number(speed * MINUTE / (MM if linear else DEG), FEED_DECIMALS)


def _trapezoid_speed(duration: float, acceleration: float) -> float:
    """Speed v of the trapezoid over the way 1 with 1 / v + v / a = T; without cruise where T is as short as can be."""
    root = max(0.0, (acceleration * duration) ** 2 - 4 * acceleration)
    return float((acceleration * duration - np.sqrt(root)) / 2)


def _timed(path: TimedPath) -> list[str]:
    lines = [*_comments(f"{path.name}: {len(path.times) - 1} blocks, {path.times[-1]:.6f} s"), "G64 P1 Q0", "G93"]
    feeds = MINUTE / np.diff(path.times)
    for pose, feed in zip(path.poses[1:], feeds, strict=True):
        lines.append(f"G1 {_axes(pose)} F{_number(feed, FEED_DECIMALS)}")  # G93 wants F on every line
    # Back to feed per minute; G61 makes whatever follows wait until the path has come to rest.
    return [*lines, "G94", "G61"]


def write_linuxcnc(program: Program, case: Case) -> str:
    """The program's text, plain ASCII.

    Args:
        program: what to do.
        case: its limits are those that the controller is set up with; feeds are chosen for them.

    Raises:
        CaseError: the case has no machine or no controller.
    """
    limits, controller = case.need_machine("a program")[2].motion, case.need_controller("a program")
    timed = any(isinstance(block, TimedPath | SplinePath) for block in program.blocks)
    headroom = controller.linuxcnc.acceleration_headroom if timed else 1.0
    writer = _Writer(headroom * limits.acceleration, controller.block)
    lines = [c for line in (*program.header, OFFSETS) for c in _comments(line)]
    # G92.1 takes back offsets that an operator may have left; G54 itself must be zero, a program cannot know.
    lines += ["G17 G21 G40 G49 G54 G80 G90 G91.1 G94", "G92.1"]
    for k, block in enumerate(program.blocks):
        following = next((b for b in program.blocks[k + 1 :] if not isinstance(b, Comment)), None)
        lines += writer.lines(block, following)
    return "\n".join([*lines, "M2"]) + "\n"
