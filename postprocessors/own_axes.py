"""Writes programs of a machine whose axes are its joints, for SINUMERIK and TwinCAT CNC: moves between exact stops.

No transformation is active. F counts X, Y, Z where they move, else the rotary axes; FGROUP states each change, and on
SINUMERIK FGREF states that a degree counts like 1 mm. Paths are not written: what a controller makes of them where
rotary axes turn is known for none of them.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cases.chain import Chain
from cases.errors import HexciteError
from cases.schema import Case
from cases.units import DEG, MINUTE, MM
from identification.limited_quantities import Box
from postprocessors.blocks import Array, Block, Comment, Dwell, ExactStopMove, NeutralProgram, ToHome, Trigger
from postprocessors.proving.guarantees import Guarantees, sinumerik_guarantees, twincat_guarantees
from postprocessors.reading import Reading, axis_letters
from postprocessors.wording import comments, coordinates, digits, number, written_feed

MM_A_DEGREE = 180.0 / np.pi  # [mm] radius at which a degree is a way of 1 mm: FGREF


class _Words(NamedTuple):
    """How a controller writes what both have."""

    name: str  # its name, for messages
    move: str  # the word of a straight move with exact stop
    group: Callable[[str], str]  # command that names the axes whose way F counts
    dwell: str  # the word before the seconds of a pause
    trigger: Callable[[bool], str]  # block that switches the trigger on or off


class _Writer:
    """Keeps what holds from block to block: which axes the feed counts."""

    def __init__(self, words: _Words, chain: Chain, limits: Box, guarantees: Guarantees) -> None:
        self.words, self.limits, self.guarantees = words, limits, guarantees
        self.axes = chain.names
        self.counted: tuple[str, ...] = ()

    def pose(self, pose: Array) -> str:
        return " ".join(a + v for a, v in zip(self.axes, coordinates(pose, self.limits.turns), strict=True))

    def group(self, *turning: bool) -> list[str]:
        """The command that makes F count axes that slide (False) or turn (True), where it does not yet."""
        names = tuple(a for a, turns in zip(self.axes, self.limits.turns, strict=True) if bool(turns) in turning)
        if names == self.counted:
            return []
        self.counted = names
        return [self.words.group(",".join(names))]

    def lines(self, block: Block) -> list[str]:
        match block:
            case Comment():
                return comments(block.text)
            case ToHome():  # from anywhere: a feed that is safe in mm and in degrees
                safe = block.feed * float((self.limits.rate / np.where(self.limits.turns, DEG, MM)).min()) * MINUTE
                move = f"{self.words.move} {self.pose(block.pose)} F{digits(safe)}"
                return [*comments("to home"), *self.group(False, True), move]
            case ExactStopMove():
                linear, feed = written_feed(block, self.limits, self.guarantees)
                return [*self.group(not linear), f"{self.words.move} {self.pose(block.move.end)} F{feed}"]
            case Dwell():
                return [f"{self.words.dwell}{number(block.duration, 6)}"]
            case Trigger():
                return [self.words.trigger(block.on)]
        raise HexciteError(
            f"{self.words.name} programs in the machine's own axes are made of moves from rest to rest; plan with "
            "--family ptp"
        )


def write_sinumerik_axes(program: NeutralProgram, case: Case) -> bytes:
    """The program's text for SINUMERIK 840D sl / ONE, plain ASCII.

    Args:
        case: gives the chain, its limits and the controller's settings.

    Raises:
        CaseError: the case lacks the settings of this dialect.
        ProgramError: a joint is not an axis of this controller.
        HexciteError: the program holds paths.
    """
    chain, limits = case.need_chain("a program")
    settings = case.need_controller("a SINUMERIK program").need_sinumerik_axes(case.name)
    letters = axis_letters(chain, "SINUMERIK", settings.program_name, endless=False)
    words = _Words(
        "SINUMERIK", "G1", lambda names: f"FGROUP({names})", "G4 F",
        lambda on: f"DO $A_OUT[{settings.trigger_output}]={int(on)}",
    )  # fmt: skip
    writer = _Writer(words, chain, limits, sinumerik_guarantees(Reading("", (), 0), case))
    lines = [f"%_N_{settings.program_name}_MPF", ";$PATH=/_N_MPF_DIR"]
    lines += [c for line in program.header for c in comments(line)]
    lines += ["G17 G90 G94 G710 G40 G500", "TRAFOOF", "SOFT FFWON DYNNORM", "COMPOF G60"]
    turning = (a for a, turns in zip(letters, limits.turns, strict=True) if turns)
    lines += [f"FGREF[{a}]={number(MM_A_DEGREE, 6)}" for a in turning]
    for block in program.blocks:
        lines += writer.lines(block)
    return ("\n".join([*lines, "M30"]) + "\n").encode("ascii")


def write_twincat_axes(program: NeutralProgram, case: Case) -> bytes:
    """The program's text for TwinCAT CNC (TF5200) and other ISG kernels, plain ASCII; see `write_sinumerik_axes`."""
    chain, limits = case.need_chain("a program")
    settings = case.need_controller("a TwinCAT program").need_twincat_axes(case.name)
    axis_letters(chain, "TwinCAT", settings.program_name, endless=False)
    words = _Words(
        "TwinCAT", "G01 G60", lambda names: f"#FGROUP [{names}]", "G04 ",
        lambda on: f"M{settings.trigger_on_m if on else settings.trigger_off_m}",
    )  # fmt: skip
    writer = _Writer(words, chain, limits, twincat_guarantees(Reading("", (), 0), case))
    lines = [f"%{settings.program_name}", *(c for line in program.header for c in comments(line))]
    lines += ["G71 G90 G17 G94", f"#SLOPE [TYPE={settings.slope}]", "#TRAFO OFF"]
    for block in program.blocks:
        lines += writer.lines(block)
    return ("\n".join([*lines, "M30"]) + "\n").encode("ascii")
