"""Writes URScript: `movej` with acceleration and speed of the leading joint, without blends, never with a time.

The controller covers a way D of the joint that moves most, the others in proportion, as a trapezoid: it takes
D / v + v / a, or 2 sqrt(D / a) where v is not reached. The ramps of a move with a stated time are not documented.
"""

from collections.abc import Iterator

import numpy as np

from cases.controller import UrScript
from cases.errors import HexciteError
from cases.schema import Case
from identification.motion import Array, Standstill
from identification.trajectories.moves import StraightMove
from postprocessors.block_writer import comment_lines, digits, number
from postprocessors.blocks import Blocks, ToHome, Trigger

DECIMALS = 9  # decimals of angles [rad]
INDENT = "  "  # to the interpreter, lines in the first column begin and end the program


def write_urscript(program: Blocks, case: Case) -> bytes:
    """The program's text, plain ASCII, see `Dialect.write`: moves from rest to rest, dwells and switches alone."""
    settings = case.need_settings(UrScript, "a URScript program")
    chain, limits = case.need_chain("a URScript program")
    if endless := next((joint.name for joint in chain.joints if joint.kind == "continuous"), None):
        raise HexciteError(
            f"joint {endless} turns without end: movej counts turns, and nobody knows on which one the robot stands; "
            'state it as kind = "revolute" with position_deg'
        )
    speeds = float(limits.rate.min()), float(limits.acceleration.min())  # smallest limits of any joint
    lines = _statements(program, chain.home, settings.trigger_output, speeds)
    body = "".join(f"{INDENT}{line}\n" for line in lines)
    return f"def {settings.program_name}():\n{body}end\n".encode("ascii")


def _statements(program: Blocks, at: Array, output: int, speeds: tuple[float, float]) -> Iterator[str]:
    """Statements of the blocks from where the robot stands; the first move uses its share of speed and acceleration."""
    for block in program:
        match block:
            case str():
                yield from _comments(block)
            case ToHome():
                yield from _comments("to home")
                yield _move(block.pose, block.feed * speeds[1], block.feed * speeds[0])
                at = block.pose
            case StraightMove():  # a trapezoid of the planned duration and speed, no steeper than planned
                law, end = block.profile, block.end
                way = float(np.abs(np.round(end, DECIMALS) - np.round(at, DECIMALS)).max())
                acceleration = law.peak_velocity / (law.duration - 1.0 / law.peak_velocity)
                yield _move(end, acceleration * way, law.peak_velocity * way)
                at = end
            case Standstill():
                yield f"sleep({number(block.duration, 6)})"
            case Trigger():
                yield f"set_standard_digital_out({output}, {block.on})"
            case _:
                raise HexciteError(
                    "URScript programs are made of moves from rest to rest, for what servoj makes of a path cannot be "
                    "proven; plan with --family ptp"
                )


def _move(end: Array, acceleration: float, speed: float) -> str:
    angles = ", ".join(number(v, DECIMALS) for v in end)
    return f"movej([{angles}], a={digits(acceleration)}, v={digits(speed)}, r=0)"


def _comments(text: str) -> list[str]:
    return [f"# {line}" for line in comment_lines(text)]
