"""LinuxCNC's stretch of dense paths: the rule, and the real controller."""

from pathlib import Path

import numpy as np
import pytest

from cases.schema import Case
from identification.hexapod import Hexapod
from identification.motion import TimedPoints
from identification.trajectories.executed import DriveExecution, path_error
from postprocessors.dialects import dialect
from postprocessors.execute.executed_run import windows
from postprocessors.execute.linuxcnc.session import run_linuxcnc
from postprocessors.execute.linuxcnc.stretching import (
    CUT,
    NOTICEABLE,
    linuxcnc_forecast,
    longer_blocks,
    predicted_stretch,
    sufficient_headroom,
    triggered_paths,
)
from postprocessors.execute.virtual import block_durations, largest_cut, run_virtual
from postprocessors.program_file import read_program
from postprocessors.proving.stretches import Timed, stretches
from postprocessors.reading.linuxcnc import read_linuxcnc
from tests.postprocessors.changed_case import changed
from tests.postprocessors.programs import small_excitation, timed, typed

SPEED, STEP = 0.2, 0.01  # [m/s], [s]
LINES = [f"G1 X{1e3 * SPEED * STEP * k:.5f} F{60 / STEP}" for k in range(1, 101)]
EVEN = triggered_paths(read_linuxcnc(typed(f"M64 P0\n{timed(LINES)}\nM65 P0"), "p.ngc"))


def excitation(case: Case, block_ms: float) -> list[TimedPoints]:
    """The same smooth motion, in blocks of another length."""
    dense = changed(case, controller__block_ms=block_ms)
    return triggered_paths(read_linuxcnc(small_excitation(dense, period=2.4), "p.ngc"))


def test_at_even_speed_the_time_of_a_block_follows_the_root_of_its_length(hexapod_case: Case):
    """V = sqrt(a L / 2) with a = 6 m/s^2 and L = 2 mm; the last block brakes from there at a / 2."""
    found = predicted_stretch(EVEN, hexapod_case, 1.0)
    speed = (6 * 2e-3 / 2) ** 0.5
    assert found.expected == pytest.approx(0.2 / speed + speed / 3)
    assert predicted_stretch(EVEN, hexapod_case, 1000.0).factor == pytest.approx(1.0, abs=1e-3)


def test_a_right_angle_between_long_blocks_costs_the_braking_to_the_speed_of_its_corner(hexapod_case: Case):
    """G64 P1 at 3 m/s^2: v = 2 sqrt(a r / sin 45 deg) is taken around it, the rest of the speed is lost to braking."""
    corner = 2 * (3.0 * 1e-3 / np.sqrt(0.5)) ** 0.5
    speed = 0.3
    lines = [f"G1 X60 F{60 / 0.2:.6f}", f"G1 Y60 F{60 / 0.2:.6f}"]
    paths = triggered_paths(read_linuxcnc(typed(f"M64 P0\n{timed(lines)}\nM65 P0"), "p.ngc"))
    expected = 0.4 + speed / 3.0 + (speed - corner) / 3.0  # braking at the end; and at the corner
    assert predicted_stretch(paths, hexapod_case, 1.0).expected == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("headroom", [1.0, 3.0])
def test_the_headroom_that_it_names_is_just_enough(headroom: float, hexapod_case: Case):
    paths = excitation(hexapod_case, 10.0)
    assert predicted_stretch(paths, hexapod_case, headroom).factor > NOTICEABLE
    enough = sufficient_headroom(paths, hexapod_case, headroom)
    assert predicted_stretch(paths, hexapod_case, enough).factor <= NOTICEABLE
    assert predicted_stretch(paths, hexapod_case, enough - 1).factor > NOTICEABLE


def test_the_blocks_that_it_names_keep_the_time_and_stay_as_near_as_it_says(hexapod_case: Case):
    dense = excitation(hexapod_case, 10.0)
    found = longer_blocks(dense, hexapod_case, 6.0)
    (coarse,) = excitation(hexapod_case, 1e3 * found.duration)
    assert predicted_stretch([coarse], hexapod_case, 6.0).factor <= NOTICEABLE * 1.002
    assert found.cut == pytest.approx(largest_cut(coarse.times, coarse.poses), rel=0.1)
    assert found.cut <= CUT


def test_blocks_that_would_leave_the_path_are_no_remedy(hexapod_case: Case):
    """Under the case's own limits only blocks of a fifth of a second keep up, and their corners lie centimetres off."""
    assert longer_blocks(excitation(hexapod_case, 10.0), hexapod_case, 1.0) is None


def test_post_is_told_the_stretch_and_the_remedies(hexapod_case: Case):
    text = small_excitation(hexapod_case, period=2.4)
    reading = read_linuxcnc(text, "p.ngc")
    for headroom, words in (
        (1.0, "longer blocks that do would leave the path by more than 2 mm"),
        (6.0, "ms (controller.block_ms)"),
    ):
        tight = changed(hexapod_case, controller__linuxcnc__acceleration_headroom=headroom)
        forecast = dialect("linuxcnc").load().forecast(reading, tight)
        paths = triggered_paths(reading)
        assert forecast.stretch == predicted_stretch(paths, tight, headroom).factor
        remark = forecast.remarks[0]
        assert f"{forecast.stretch:.2f} times as long" in remark
        assert f"acceleration_headroom = {sufficient_headroom(paths, tight, headroom)}" in remark
        assert words in remark
    assert linuxcnc_forecast(read_linuxcnc(typed("M64 P0\nG1 X5"), "p.ngc"), tight).remarks == ()


def test_blocks_without_a_way_last_as_long_as_written_and_part_the_path():
    times = np.array([0.0, 0.1, 0.2, 0.3])
    poses = np.zeros((4, 6))
    poses[1:3, 0], poses[3, 3] = 0.01, 0.02
    found = block_durations(times, poses, np.full(6, 6.0))
    np.testing.assert_allclose(found, [0.1 + 0.1 / 3, 0.1, 0.1 + 0.2 / 3])


@pytest.mark.linuxcnc
@pytest.mark.usefixtures("rs274")  # skips where LinuxCNC is not installed
def test_linuxcnc_stretches_a_dense_path_as_predicted(tmp_path: Path, hexapod_case: Case):
    program = tmp_path / "p.ngc"
    program.write_text(small_excitation(hexapod_case))
    expected = predicted_stretch(triggered_paths(read_linuxcnc(program.read_text(), "p.ngc")), hexapod_case, 1.0)
    log = run_linuxcnc(program, hexapod_case, headroom=1.0)
    assert expected.factor > 1.5
    assert log.trigger.sum() * log.period == pytest.approx(expected.expected, rel=0.03)
    without = changed(hexapod_case, controller__virtual_look_ahead="block_limited")
    read = read_program(program, without)
    virtual = run_virtual(read.reading, without, read.guarantees)
    assert log.trigger.sum() * log.period == pytest.approx(virtual.excitation, rel=0.05)
    (path,) = (s.points for s in stretches(read.reading) if isinstance(s, Timed))
    real = DriveExecution.of_log(Hexapod.of(without), log.period, log.drives)
    window = windows(log.trigger, log.period)
    assert path_error(path, virtual.execution, virtual.trigger) == pytest.approx(
        path_error(path, real, window), rel=0.25
    )


@pytest.mark.linuxcnc
@pytest.mark.usefixtures("rs274")
@pytest.mark.parametrize("block_ms", [50.0, 120.0])
def test_linuxcnc_stretches_long_blocks_as_predicted_too(block_ms: float, tmp_path: Path, hexapod_case: Case):
    """Their corners are cut by no more than G64 allows, at the price of time."""
    program = tmp_path / "p.ngc"
    program.write_text(small_excitation(changed(hexapod_case, controller__block_ms=block_ms), period=2.4))
    (path,) = triggered_paths(read_linuxcnc(program.read_text(), "p.ngc"))
    expected = predicted_stretch([path], hexapod_case, 1.0)
    log = run_linuxcnc(program, hexapod_case, headroom=1.0)
    assert expected.factor > 1.05
    assert log.trigger.sum() * log.period == pytest.approx(expected.expected, rel=0.03)
