"""Random programs that are proven, on the real LinuxCNC: where what it executes is not what was proven."""

from pathlib import Path

from cases.base.errors import HexciteError
from postprocessors.controllers.linuxcnc.session import linuxcnc_missing, run_linuxcnc
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
        try:
            found = differences(program, run_linuxcnc(program, case))
        except HexciteError as error:
            found = [str(error)]
        tally.counts.update({"executed as proven" if not found else "executed otherwise": len(batch)})
        for sentence in found:
            tally.defect(first, f"{case.name}: {sentence}\n{program.text}")
    return tally
