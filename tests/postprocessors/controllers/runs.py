"""A program and logs that tests of LinuxCNC share."""

from pathlib import Path

import numpy as np

from cases.base.errors import ProgramError
from cases.schema import Case
from postprocessors.controllers.executed_run import ControllerLog
from postprocessors.controllers.linuxcnc.session import run_linuxcnc
from postprocessors.program import Program, dialect, read_program
from postprocessors.reading import Reading

PROGRAM = """G17 G21 G40 G49 G54 G80 G90 G94 G92.1
(G4 P99 in a comment is not a dwell)
G61.1
G0 X10 Y5 Z905 A2 B-3 C4
G4 P0.25
(M62 and M63 act with the next motion)
M62 P0
G1 X20 Y0 Z900 A0 B0 C0 F3000
G1 X-20 Y10 Z910 A5 B5 C-5
M63 P0
G4 P0.1
G4 P0.1
G0 X0 Y0 Z900 A0 B0 C0
G4 P0.05
M2
"""


def log_of(lines: list[int]) -> ControllerLog:
    count = len(lines)
    return ControllerLog(
        "none", 1e-3, np.ones((count, 6)), np.zeros((count, 6)), np.zeros(count, dtype=bool), np.array(lines)
    )


def run_text(file: Path, case: Case, **settings) -> ControllerLog:
    """Runs a file on LinuxCNC, also one that the reader refuses: what LinuxCNC itself says of it is tested.

    Of a program that was not read nobody counts the dwells: it has none.
    """
    try:
        program = read_program(file, case)
    except ProgramError:
        assert "G4" not in file.read_text()
        language = dialect("linuxcnc")
        reading = Reading(str(file), (), 0)
        guarantees = language.guarantees(reading, case)
        program = Program(file, language, file.read_bytes(), reading, guarantees, case)
    return run_linuxcnc(program, case, **settings)
