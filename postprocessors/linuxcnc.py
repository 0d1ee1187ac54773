"""Writes programs for LinuxCNC: XYZABC in mm and degrees, timed paths as dense G1 in inverse time (G93)."""

import re
import textwrap

import numpy as np

from cases.units import DEG, MINUTE, MM
from postprocessors.program import Array, Block, Dwell, Program, TimedPath, ToHome, Trigger

# 1e-5 mm and 1e-6 degrees: differentiated three times over 10 ms blocks this rounding stays below 0.1 % of the jerk
# limits.
LENGTH_DECIMALS = 5
ANGLE_DECIMALS = 6
FEED_DECIMALS = 6
COMMENT_WIDTH = 100  # a line of the controller holds 252 characters


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


def _lines(block: Block) -> list[str]:
    match block:
        case ToHome():
            feed = _number(block.feed * MINUTE / MM, FEED_DECIMALS)
            return [*_comments("to home"), "G61", f"G94 G1 {_axes(block.pose)} F{feed}"]
        case Dwell():
            return [f"G4 P{_number(block.duration, 6)}"]
        case Trigger():
            # At once: M62 and M63 would wait for a next motion. They break blending, but here the machine stands
            # anyway.
            return ["M64 P0" if block.on else "M65 P0"]
        case TimedPath():
            return _timed(block)


def _timed(path: TimedPath) -> list[str]:
    lines = [*_comments(f"{path.name}: {len(path.times) - 1} blocks, {path.times[-1]:.6f} s"), "G64 P1 Q0", "G93"]
    feeds = MINUTE / np.diff(path.times)
    for pose, feed in zip(path.poses[1:], feeds, strict=True):
        lines.append(f"G1 {_axes(pose)} F{_number(feed, FEED_DECIMALS)}")  # G93 wants F on every line
    # Back to feed per minute; G61 makes whatever follows wait until the path has come to rest.
    return [*lines, "G94", "G61"]


def write_linuxcnc(program: Program) -> str:
    """The program's text."""
    lines = [c for line in program.header for c in _comments(line)]
    lines.append("G17 G21 G40 G49 G54 G80 G90 G91.1 G94")
    for block in program.blocks:
        lines += _lines(block)
    return "\n".join([*lines, "M2"]) + "\n"
