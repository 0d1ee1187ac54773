"""Timed blocks last whole cycles of LinuxCNC, and the real controller keeps their time."""

from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import ProgramError
from cases.schema import Case
from identification.motion.moves import StraightMove, unit_profile
from postprocessors.program import Program, dialect
from postprocessors.reading import Timed
from postprocessors.writing import proven_program
from tests.helpers import one_line, polynomials_of
from tests.postprocessors.controllers.runs import run_text
from tests.postprocessors.programs import HOME, proof, timed, typed

SEGMENT = 92.3e-3  # [s] whole blocks of 10 ms do not fill it


def jerky(case: Case) -> Program:
    """There and back in pieces that last no whole cycles, at 60 % of the tightest limit."""
    far = HOME + np.r_[0.02, -0.015, 0.01, 0.03, -0.02, 0.03]
    moves = [StraightMove(a, b, unit_profile(SEGMENT, 0.0, 0.0)) for a, b in ((HOME, far), (far, HOME))]
    motion = polynomials_of(moves * 4)
    accepted = ("acceleration", "jerk", "strut acceleration", "sensor force", "strut velocity")
    return proven_program(motion, case, dialect("linuxcnc"), "p.ngc", (), accepted=accepted)


def test_blocks_last_whole_cycles_and_pieces_begin_at_points(hexapod_case: Case):
    """LinuxCNC leaves out what is over; without points at its steps the jerk between points would be too large."""
    (path,) = [s.points for s in jerky(hexapod_case).reading.stretches if isinstance(s, Timed) and s.trigger]
    cycles = path.times / 1e-3
    assert cycles == pytest.approx(np.round(cycles), abs=1e-3)
    assert path.duration == pytest.approx(32 * 93e-3, abs=1e-6)
    assert set(np.round(cycles)) >= set(range(0, 32 * 93 + 1, 93))
    assert np.diff(path.times).max() <= 10e-3 + 1e-9


def test_a_block_of_parts_of_a_cycle_is_refused(hexapod_case: Case):
    """One of 9.5 ms would be driven in 9 ms, faster than it was proven."""
    text = typed(f"M64 P0\n{timed(['G1 X0.1 F6000', f'G1 X0.2 F{60 / 9.5e-3:.6f}'])}\nM65 P0")
    with pytest.raises(ProgramError) as caught:
        proof(text, hexapod_case)
    line = one_line(caught.value)
    for words in ("9.5 ms", "LinuxCNC keeps times of 1 to 250 ms in whole cycles", "controller.block_ms"):
        assert words in line


@pytest.mark.linuxcnc
@pytest.mark.usefixtures("rs274")
def test_linuxcnc_keeps_the_time_of_whole_cycles(tmp_path: Path, hexapod_case: Case):
    written = jerky(hexapod_case)
    (tmp_path / "p.ngc").write_bytes(written.content)
    log = run_text(tmp_path / "p.ngc", hexapod_case)
    assert 0.9995 < log.trigger.sum() * log.period / written.proof.excitation < 1.005  # a cycle at each stop
