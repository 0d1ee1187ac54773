"""From a planned motion to a program's text that has been read back and proven; nothing else leaves this module."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cases.errors import HexciteError, ProgramError
from cases.schema import Case
from cases.units import DEG, MM
from identification.motion import Trajectory
from postprocessors.linuxcnc import write_linuxcnc
from postprocessors.program import Program, excitation_program
from postprocessors.proof import ProgramProof, prove_program
from postprocessors.reading.linuxcnc import read_linuxcnc
from postprocessors.reading.words import Reading
from postprocessors.stretches import Timed, stretches

# The last decimal of the words, doubled: what is read back must be what was planned, up to rounding.
ROUNDING = np.r_[np.full(3, 1e-5 * MM), np.full(3, 1e-6 * DEG)]


class Dialect(NamedTuple):
    """A controller's language: suffix of its files, its writer, and a reader that shares nothing with the writer."""

    suffix: str
    write: Callable[[Program], str]
    read: Callable[[str, str], Reading]


DIALECTS = {"linuxcnc": Dialect(".ngc", write_linuxcnc, read_linuxcnc)}


def dialect(name: str) -> Dialect:
    """The dialect of a name.

    Raises:
        HexciteError: unknown; the message lists the known ones.
    """
    if name not in DIALECTS:
        raise HexciteError(f"dialect {name!r} is unknown; choose {', '.join(DIALECTS)}")
    return DIALECTS[name]


def dialect_of_file(file: str) -> Dialect:
    """The dialect that a program's file name says.

    Raises:
        ProgramError: no dialect has this suffix.
    """
    for known in DIALECTS.values():
        if file.endswith(known.suffix):
            return known
    suffixes = ", ".join(d.suffix for d in DIALECTS.values())
    raise ProgramError(file, 0, 0, f"the suffix names no controller; programs end in {suffixes}")


def proven_text(
    trajectory: Trajectory, case: Case, language: Dialect, file: str, header: tuple[str, ...], speed: float = 1.0
) -> tuple[str, ProgramProof]:
    """Writes a program and proves its text.

    Args:
        trajectory: the excitation, from rest to rest.
        case: machine, limits, controller.
        language: the controller's.
        file: name of the program, for messages.
        header: comment lines.
        speed: share of the planned speed, above 0 and at most 1.

    Returns:
        The text and its proof, which holds.

    Raises:
        ProgramError: the text, as read back, is not the planned motion or passes a limit.
        CaseError: the case has no machine or no controller.
    """
    program = excitation_program(trajectory, case, header, speed)
    text = language.write(program)
    reading = language.read(text, file)
    proof = prove_program(reading, case)
    proof.require()
    _require_same(program, reading, case)
    return text, proof


def _require_same(program: Program, reading: Reading, case: Case) -> None:
    """The timed paths of the text are those of the program, point by point and instant by instant."""
    read = [s for s in stretches(reading, case) if isinstance(s, Timed)]
    if len(read) != len(program.paths):
        raise ProgramError(
            reading.file, 0, 0, f"{len(read)} paths where {len(program.paths)} were written; report this"
        )
    for path, stretch in zip(program.paths, read, strict=True):
        same = len(path.times) == len(stretch.points.times)
        same = same and bool(np.all(np.abs(path.poses - stretch.points.poses) <= ROUNDING))
        # F has 6 decimals: 1e-10 of 10 ms a block
        same = same and bool(np.allclose(path.times, stretch.points.times, rtol=1e-7, atol=1e-9))
        if not same:
            raise ProgramError(
                reading.file, stretch.lines[0], 0, f"path {path.name!r} reads back differently; report this"
            )
