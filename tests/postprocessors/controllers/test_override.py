"""An operator's feed override on the real LinuxCNC: programs that switch it off run as proven, others are faster."""

from collections.abc import Callable

import numpy as np
import pytest

from cases.schema import Case
from postprocessors.controllers.executed_run import ControllerLog
from postprocessors.controllers.linuxcnc.session import run_linuxcnc
from postprocessors.program import Program, dialect
from tests.helpers import few
from tests.postprocessors.controllers.test_start import there_and_back
from tests.postprocessors.edited import path

pytestmark = pytest.mark.linuxcnc
TURNED = 1.2


def dense_path(case: Case) -> Program:
    """Half a second of a smooth path in timed blocks."""
    return program_of(path("linuxcnc"), case)


def program_of(text: str, case: Case) -> Program:
    language, content = dialect("linuxcnc"), text.encode("ascii")
    reading = language.read(content, "p.ngc", case)
    return Program(there_and_back(case).path, language, content, reading, language.guarantees(reading, case), case)


def moving(log: ControllerLog) -> float:
    """Time from the first to the last motion [s]."""
    rows = np.flatnonzero(np.any(np.diff(log.poses, axis=0) != 0.0, axis=1))
    return float(rows[-1] - rows[0]) * log.period


@pytest.mark.parametrize("made", few(there_and_back, dense_path))
def test_an_override_does_not_make_a_program_faster_unless_it_leaves_the_knob_on(
    made: Callable[[Case], Program], hexapod_case: Case
) -> None:
    """The knob of the machine goes to 120 %; below 100 % one that is on slows down."""
    program = made(hexapod_case)
    assert "\nM50 P0\n" in program.text
    knob_on = program_of(program.text.replace("M50 P0\n", ""), hexapod_case)
    usual, turned = run_linuxcnc(program, hexapod_case), run_linuxcnc(program, hexapod_case, override=TURNED)
    assert moving(turned) == pytest.approx(moving(usual), abs=2.1 * usual.period)
    faster = run_linuxcnc(knob_on, hexapod_case, override=TURNED)
    assert moving(faster) < moving(usual) / (1.0 + 0.7 * (TURNED - 1.0)), "the override did nothing: not a test"
    told = ["override above 100 %" in " ".join(p.proof.remarks) for p in (program, knob_on)]
    assert told == [False, True]
