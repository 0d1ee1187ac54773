"""Random programs that are proven, on the real LinuxCNC: where what it executes is not what was proven."""

from pathlib import Path

from cases.base.errors import Code, HexciteError
from cases.schema import Case
from postprocessors.controllers.linuxcnc.session import linuxcnc_missing, run_linuxcnc
from postprocessors.program import Program
from tests.bench.reliability.tally import Tally
from tests.postprocessors.random_programs import CASES, differences, one_after_the_other

TOGETHER = 10  # programs of a session
AXES_EVERY = 3  # one session of so many moves the machine's own axes


def tally_of_executed(seeds: range, _: Path) -> Tally:
    """Random programs on LinuxCNC, some of them in each session; where it is not installed, none."""
    tally = Tally("random programs on LinuxCNC")
    if linuxcnc_missing() is not None:
        return tally
    names = list(CASES)
    for k, first in enumerate(range(seeds.start, seeds.stop, TOGETHER)):
        batch, case = range(first, min(first + TOGETHER, seeds.stop)), CASES[names[k % AXES_EVERY == 0]]
        program = one_after_the_other(batch, case)
        found, failed = _found(program, case)
        if failed:  # of a busy computer, which a second run tells from a defect
            found = _found(program, case)[0]
        proven = "executed as proven by a second run" if failed else "executed as proven"
        tally.counts.update({"executed otherwise" if found else proven: len(batch)})
        for sentence in found:
            tally.defect(first, f"{case.name}: {sentence}\n{program.text}")
    return tally


def _found(program: Program, case: Case) -> tuple[list[str], bool]:
    """What LinuxCNC executes otherwise than proven, and whether it could not execute it as it is asked to."""
    try:
        return differences(program, run_linuxcnc(program, case)), False
    except HexciteError as error:
        return [str(error)], error.code is Code.RUN_FAILED
