"""On a computer that is busy the trigger brackets the standstills in the program's own order."""

from pathlib import Path

import numpy as np
import pytest

from cases.schema import Case
from identification.stretches import windows
from tests.helpers import seeds
from tests.postprocessors.controllers.runs import run_text
from tests.postprocessors.controllers.stuttering import stuttering
from tests.postprocessors.programs import typed

SETTLE, MEASURE = 0.5, 0.8
PLACES = (40, -60, 80, -20)
POSES = "\n".join(
    f"G1 X{x} A{x / 20} F30000\nG4 P{SETTLE}\nM64 P0\nG4 P{MEASURE}\nM65 P0" for x in PLACES
)  # a move, a rest, and the trigger in the second rest


@pytest.mark.slow
@pytest.mark.linuxcnc
@seeds(2)
def test_the_trigger_brackets_standstills_whenever_the_servo_thread_is_stopped(
    seed: int, tmp_path: Path, hexapod_case: Case
) -> None:
    program = tmp_path / "poses.ngc"
    program.write_text(typed(f"{POSES}\nG1 X0 A0"))
    with stuttering(0.1, 0.02, seed) as stops:
        log = run_text(program, hexapod_case)
    assert len(stops) > 10, "the servo thread was not stopped: not a test"
    moving = np.append(np.any(np.diff(log.drives, axis=0) != 0.0, axis=1), False)
    on = windows(log.trigger, 1.0).astype(int)
    assert len(on) == len(PLACES)
    for (start, end), x in zip(on, PLACES, strict=True):
        assert log.poses[start, 0] == pytest.approx(x / 1000, abs=1e-12)
        assert not moving[start - 100 : end].any()
        before = start - 1 - np.flatnonzero(moving[:start])[-1]
        np.testing.assert_allclose([before, end - start], [SETTLE * 1e3, MEASURE * 1e3], atol=4)
