"""LinuxCNC's stretch of dense paths: the rule, and the real controller."""

from pathlib import Path

import pytest

from cases.schema import Case
from identification.executed import StrutExecution
from identification.hexapod import Hexapod
from identification.path import path_error
from postprocessors.dialects import dialect
from postprocessors.execute.executed_run import windows
from postprocessors.execute.linuxcnc.running import run_linuxcnc
from postprocessors.execute.linuxcnc.stretching import linuxcnc_forecast, predicted_stretch
from postprocessors.execute.virtual import run_virtual
from postprocessors.files import read_program
from postprocessors.reading.linuxcnc import read_linuxcnc
from postprocessors.stretches import Timed, stretches
from tests.postprocessors.changed_case import changed
from tests.postprocessors.programs import small_excitation, timed, typed

SPEED, STEP = 0.2, 0.01  # [m/s], [s]
LINES = [f"G1 X{1e3 * SPEED * STEP * k:.5f} F{60 / STEP}" for k in range(1, 101)]
EVEN = read_linuxcnc(typed(f"M64 P0\n{timed(LINES)}\nM65 P0"), "p.ngc")


def test_at_even_speed_the_time_of_a_block_follows_the_root_of_its_length(hexapod_case: Case):
    """V = sqrt(a L / 2) with a = 6 m/s^2 and L = 2 mm."""
    found = predicted_stretch(EVEN, hexapod_case, 1.0)
    assert found.factor == pytest.approx(SPEED / (6 * 2e-3 / 2) ** 0.5)
    assert predicted_stretch(EVEN, hexapod_case, 100.0).factor == 1.0


@pytest.mark.parametrize("headroom", [1.0, 3.0])
def test_the_remedies_that_it_names_are_just_enough(headroom: float, hexapod_case: Case):
    found = predicted_stretch(EVEN, hexapod_case, headroom)
    assert predicted_stretch(EVEN, hexapod_case, found.headroom * 1.001).factor == 1.0
    assert predicted_stretch(EVEN, hexapod_case, found.headroom * 0.99).factor > 1.0
    assert found.block == pytest.approx(2 * SPEED / (headroom * 6))  # dt >= 2 v / a


def test_post_is_told_the_stretch_and_the_remedy(hexapod_case: Case):
    tight = changed(hexapod_case, controller__linuxcnc__acceleration_headroom=1.0)
    forecast = dialect("linuxcnc").load().forecast(EVEN, tight)
    assert forecast.stretch == pytest.approx(2.582, rel=1e-3)
    (remark,) = forecast.remarks
    assert "2.58 times as long" in remark
    assert "blocks of 67 ms" in remark
    assert "acceleration_headroom = 7" in remark
    assert linuxcnc_forecast(read_linuxcnc(typed("M64 P0\nG1 X5"), "p.ngc"), tight).remarks == ()


@pytest.mark.linuxcnc
@pytest.mark.usefixtures("rs274")  # skips where LinuxCNC is not installed
def test_linuxcnc_stretches_a_dense_path_as_predicted(tmp_path: Path, hexapod_case: Case):
    program = tmp_path / "p.ngc"
    program.write_text(small_excitation(hexapod_case))
    expected = predicted_stretch(read_linuxcnc(program.read_text(), "p.ngc"), hexapod_case, 1.0)
    log = run_linuxcnc(program, hexapod_case, headroom=1.0)
    assert expected.factor > 1.5
    assert log.trigger.sum() * log.period / 1.2 == pytest.approx(expected.factor, rel=0.1)
    without = changed(hexapod_case, controller__virtual_look_ahead="block_limited")
    read = read_program(program, without)
    virtual = run_virtual(read.reading, without, read.guarantees)
    assert log.trigger.sum() * log.period == pytest.approx(virtual.excitation, rel=0.05)
    (path,) = (s.points for s in stretches(read.reading) if isinstance(s, Timed))
    real = StrutExecution.of_log(Hexapod.of(without), log.period, log.strut_lengths)
    window = windows(log.trigger, log.period)
    assert path_error(path, virtual.execution, virtual.trigger) == pytest.approx(
        path_error(path, real, window), rel=0.25
    )
