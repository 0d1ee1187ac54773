"""Writes URScript: `movej` with acceleration and speed of the leading joint, without blends, never with a time.

The controller covers a way D of the joint that moves most, the others in proportion, as a trapezoid: it takes
D / v + v / a, or 2 sqrt(D / a) where v is not reached. What ramps a stated time would have is not documented.
"""

import numpy as np

from cases.controller import UrScript
from cases.errors import HexciteError
from cases.schema import Case
from postprocessors.blocks import (
    Array,
    Block,
    Comment,
    Dwell,
    ExactStopMove,
    NeutralProgram,
    ToHome,
    Trigger,
)
from postprocessors.wording import comment_lines, digits, number

DECIMALS = 9  # of angles [rad]
INDENT = "  "  # the interpreter takes lines in the first column for the beginning and the end of the program


def write_urscript(program: NeutralProgram, case: Case) -> bytes:
    """The program, plain ASCII.

    Args:
        program: moves, dwells and trigger; the last must be on its way home.

    Raises:
        HexciteError: a block that `movej` cannot be.
        CaseError: the case has no such chain, or no settings of this dialect.
    """
    settings = case.need_controller("a URScript program").need_urscript(case.name)
    chain, limits = case.need_chain("a URScript program")
    if endless := next((joint.name for joint in chain.joints if joint.kind == "continuous"), None):
        raise HexciteError(
            f"joint {endless} turns without end: movej counts turns, and nobody knows on which one the robot stands; "
            'state it as kind = "revolute" with position_deg'
        )
    writer = _UrScriptWriter(chain.home, settings, float(limits.rate.min()), float(limits.acceleration.min()))
    lines = [*(line for text in program.header for line in _comments(text))]
    for block in program.blocks:
        lines += writer.lines(block)
    body = "".join(f"{INDENT}{line}\n" for line in lines)
    return f"def {settings.program_name}():\n{body}end\n".encode("ascii")


class _UrScriptWriter:
    """Statements, and where the robot stands as it was written."""

    def __init__(self, home: Array, settings: UrScript, slowest: float, gentlest: float) -> None:
        self.at = home
        self.settings = settings
        self.slowest, self.gentlest = slowest, gentlest  # smallest limits of any joint [rad/s, rad/s^2]

    def lines(self, block: Block) -> list[str]:
        match block:
            case Comment():
                return _comments(block.text)
            case ToHome():
                speed, acceleration = block.feed * self.slowest, block.feed * self.gentlest
                return [*_comments("to home"), self.move(block.pose, acceleration, speed)]
            case ExactStopMove():
                return [self.point_to_point(block)]
            case Dwell():
                return [f"sleep({number(block.duration, 6)})"]
            case Trigger():
                return [f"set_standard_digital_out({self.settings.trigger_output}, {block.on})"]
            case _:
                raise HexciteError(
                    "URScript programs are made of moves from rest to rest, for what servoj makes of a path cannot be "
                    "proven; plan with --family ptp"
                )

    def point_to_point(self, block: ExactStopMove) -> str:
        """The trapezoid of the planned duration and largest speed; its acceleration is at most the planned one."""
        law = block.move.profile
        way = float(np.abs(np.round(block.move.end, DECIMALS) - np.round(self.at, DECIMALS)).max())
        acceleration = law.peak_velocity / (law.duration - 1.0 / law.peak_velocity)
        return self.move(block.move.end, acceleration * way, law.peak_velocity * way)

    def move(self, end: Array, acceleration: float, speed: float) -> str:
        self.at = end
        angles = ", ".join(number(v, DECIMALS) for v in end)
        return f"movej([{angles}], a={digits(acceleration)}, v={digits(speed)}, r=0)"


def _comments(text: str) -> list[str]:
    return [f"# {line}" for line in comment_lines(text)]
