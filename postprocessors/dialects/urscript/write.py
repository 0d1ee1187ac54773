"""Writes URScript: `movej` with acceleration and speed of the leading joint, without blends, never with a time.

The controller covers a way D of the joint that moves most, the others in proportion, as a trapezoid: it takes
D / v + v / a, or 2 sqrt(D / a) where v is not reached. The ramps of a move with a stated time are not documented.
"""

import re
from collections.abc import Iterator, Sequence

import numpy as np

from cases.base.errors import Code, HexciteError, option
from cases.base.phrases import phrase
from cases.base.units import DEG
from cases.chain import Chain
from cases.controller import UrScript
from cases.schema import Case
from identification.motion.motion import Array, Standstill
from identification.motion.moves import StraightMove
from postprocessors.blocks import Blocks, ToHome, Trigger
from postprocessors.dialects.block_writer import comment_lines, digits, number

DECIMALS = 9  # decimals of angles [rad]
HOME_WITHIN = (
    0.1 * DEG
)  # for the check that the robot stands at home: its actual angles are off by some hundredths [rad]
INDENT = "  "  # to the interpreter, lines in the first column begin and end the program


def write_urscript(program: Blocks, case: Case) -> bytes:
    """The program's text, plain ASCII, see `Dialect.write`: moves from rest to rest, dwells and switches alone."""
    chain, limits = case.need_chain("a URScript program")
    settings = case.need_settings(UrScript, "a URScript program")
    if endless := next((joint.name for joint in chain.joints if joint.kind == "continuous"), None):
        raise HexciteError(
            problem=f"joint {endless} turns without end: movej counts turns, and nobody knows on which "
            "one the robot stands",
            remedy='state it as kind = "revolute" with position_deg',
            code=Code.NOT_SUPPORTED,
        )
    cycle = case.need_controller("a URScript program").cycle
    # of any joint: accelerations that step within a cycle, and reverse in the next, and a speed that is a crawl
    acceleration = float(np.minimum(limits.acceleration, limits.jerk * cycle / 2).min())
    crawl = acceleration, min(HOME_WITHIN, float(limits.rate.min()))
    lines = _statements(program, chain, settings.trigger_output, crawl)
    body = "".join(f"{INDENT}{line}\n" for line in lines)
    return f"def {settings.program_name}():\n{body}end\n".encode("ascii")


def _statements(program: Blocks, chain: Chain, output: int, crawl: tuple[float, float]) -> Iterator[str]:
    """Statements of the blocks; `crawl` are acceleration and speed of the last tenth of a degree to home."""
    at = chain.home
    for block in program:
        match block:
            case str():
                yield from _comments(block)
            case ToHome():
                yield from _stop_unless_at(block.coordinates, chain.names)
                yield from _comments("what is left, at a crawl")
                yield _move(block.coordinates, *crawl)
                at = block.coordinates
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
                    problem=phrase(
                        "urscript_moves",
                        "URScript programs are made of moves from rest to rest, for what servoj makes of a path "
                        "cannot be proven",
                    ),
                    remedy=phrase(
                        "plan_moves", "plan with {family}", family=option("family PointToPoint", "family ptp")
                    ),
                    code=Code.NOT_SUPPORTED,
                )


def _stop_unless_at(home: Array, joints: Sequence[str]) -> Iterator[str]:
    """Statements that stop the program with a message unless each joint stands at its place, within `HOME_WITHIN`."""
    yield from _comments(f"stop unless the robot stands at home, within {HOME_WITHIN / DEG:g} deg")
    yield "standing = get_actual_joint_positions()"
    for k, (joint, angle) in enumerate(zip(joints, home, strict=True)):
        value = number(angle, DECIMALS)
        difference = f"-{value}" if not value.startswith("-") else f"+{value[1:]}"
        name = re.sub(r"[^A-Za-z0-9_]", "?", joint)
        text = f"joint {k + 1}, {name}, does not stand at home, {angle / DEG:.3f} deg: move it there, then start again"
        yield f"if norm(standing[{k}]{difference}) > {number(HOME_WITHIN, DECIMALS)}:"
        yield f'{INDENT}popup("{text}", "not at home", error=True, blocking=True)'
        yield f"{INDENT}halt"
        yield "end"


def _move(end: Array, acceleration: float, speed: float) -> str:
    angles = ", ".join(number(v, DECIMALS) for v in end)
    return f"movej([{angles}], a={digits(acceleration)}, v={digits(speed)}, r=0)"


def _comments(text: str) -> list[str]:
    return [f"# {line}" for line in comment_lines(text)]
