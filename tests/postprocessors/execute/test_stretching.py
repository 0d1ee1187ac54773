"""LinuxCNC's stretch of dense paths: the rule, and the real controller."""

from pathlib import Path

import numpy as np
import pytest

from cases.errors import ProgramError
from cases.schema import Case
from identification.motion import TimedPoints
from identification.trajectories.curves import polynomials_of
from identification.trajectories.moves import StraightMove, unit_profile
from postprocessors.dialects import Program, dialect
from postprocessors.execute.linuxcnc.stretching import (
    NOTICEABLE,
    block_durations,
    expected_duration,
    linuxcnc_forecast,
    predicted_stretch,
    sufficient_headroom,
    triggered_paths,
)
from postprocessors.writing import proven_program
from tests.helpers import one_line
from tests.postprocessors.changed_case import changed
from tests.postprocessors.execute.runs import run_text
from tests.postprocessors.programs import HOME, proof, read_linuxcnc, small_excitation, timed, typed

SPEED, STEP = 0.2, 0.01  # [m/s], [s]
LINES = [f"G1 X{1e3 * SPEED * STEP * k:.5f} F{60 / STEP}" for k in range(1, 101)]
EVEN = triggered_paths(read_linuxcnc(typed(f"M64 P0\n{timed(LINES)}\nM65 P0"), "p.ngc"))


def excitation(case: Case, block_ms: float) -> list[TimedPoints]:
    """The same smooth motion, in blocks of another length."""
    dense = changed(case, controller__block_ms=block_ms)
    return triggered_paths(read_linuxcnc(small_excitation(dense, period=2.4), "p.ngc"))


def test_at_even_speed_the_time_of_a_block_follows_the_root_of_its_length(hexapod_case: Case):
    """V = sqrt(a L / 2) with a = 6 m/s^2 and L = 2 mm; the last block brakes from there at a / 2."""
    found = expected_duration(EVEN, hexapod_case, 1.0)
    speed = (6 * 2e-3 / 2) ** 0.5
    assert found == pytest.approx(0.2 / speed + speed / 3)
    assert predicted_stretch(EVEN, hexapod_case, 1000.0) == pytest.approx(1.0, abs=1e-3)


def test_a_right_angle_between_long_blocks_costs_the_braking_to_the_speed_of_its_corner(hexapod_case: Case):
    """G64 P1 at 3 m/s^2: v = 2 sqrt(a r / sin 45 deg) is taken around it, the rest of the speed is lost to braking."""
    corner = 2 * (3.0 * 1e-3 / np.sqrt(0.5)) ** 0.5
    speed = 0.3
    lines = [f"G1 X60 F{60 / 0.2:.6f}", f"G1 Y60 F{60 / 0.2:.6f}"]
    paths = triggered_paths(read_linuxcnc(typed(f"M64 P0\n{timed(lines)}\nM65 P0"), "p.ngc"))
    expected = 0.4 + speed / 3.0 + (speed - corner) / 3.0  # braking at the end; and at the corner
    assert expected_duration(paths, hexapod_case, 1.0) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("headroom", [1.0, 3.0])
def test_the_headroom_that_it_names_is_just_enough(headroom: float, hexapod_case: Case):
    paths = excitation(hexapod_case, 10.0)
    assert predicted_stretch(paths, hexapod_case, headroom) > NOTICEABLE
    enough = sufficient_headroom(paths, hexapod_case, headroom)
    assert predicted_stretch(paths, hexapod_case, enough) <= NOTICEABLE
    assert predicted_stretch(paths, hexapod_case, enough - 1) > NOTICEABLE


def test_post_is_told_the_stretch_and_the_remedies(hexapod_case: Case):
    text = small_excitation(hexapod_case, period=2.4)
    reading = read_linuxcnc(text, "p.ngc")
    for headroom in (1.0, 6.0):
        tight = changed(hexapod_case, controller__linuxcnc__acceleration_headroom=headroom)
        stretch, (remark, *_) = dialect("linuxcnc").forecast(reading, tight)
        paths = triggered_paths(reading)
        assert stretch == predicted_stretch(paths, tight, headroom)
        assert f"{stretch:.2f} times as long" in remark
        assert f"acceleration_headroom = {sufficient_headroom(paths, tight, headroom)}" in remark
        assert "--family ptp" in remark
    assert linuxcnc_forecast(read_linuxcnc(typed("M64 P0\nG1 X5"), "p.ngc"), tight)[1] == ()


def test_blocks_without_a_way_last_as_long_as_written_and_part_the_path():
    times = np.array([0.0, 0.1, 0.2, 0.3])
    poses = np.zeros((4, 6))
    poses[1:3, 0], poses[3, 3] = 0.01, 0.02
    found = block_durations(times, poses, np.full(6, 6.0))
    np.testing.assert_allclose(found, [0.1 + 0.1 / 3, 0.1, 0.1 + 0.2 / 3])


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
    (path,) = triggered_paths(jerky(hexapod_case).reading)
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
    for words in ("9.5 ms", "whole cycles of LinuxCNC (1 ms)", "controller.block_ms"):
        assert words in line


@pytest.mark.linuxcnc
@pytest.mark.usefixtures("rs274")
def test_linuxcnc_keeps_the_time_of_whole_cycles(tmp_path: Path, hexapod_case: Case):
    written = jerky(hexapod_case)
    (tmp_path / "p.ngc").write_bytes(written.content)
    log = run_text(tmp_path / "p.ngc", hexapod_case)
    assert 0.9995 < log.trigger.sum() * log.period / written.proof.excitation < 1.005  # a cycle at each stop


@pytest.mark.linuxcnc
@pytest.mark.usefixtures("rs274")  # skips where LinuxCNC is not installed
def test_linuxcnc_stretches_a_dense_path_as_predicted(tmp_path: Path, hexapod_case: Case):
    program = tmp_path / "p.ngc"
    program.write_text(small_excitation(hexapod_case))
    paths = triggered_paths(read_linuxcnc(program.read_text(), "p.ngc"))
    log = run_text(program, changed(hexapod_case, controller__linuxcnc__acceleration_headroom=1.0))
    assert predicted_stretch(paths, hexapod_case, 1.0) > 1.5
    assert log.trigger.sum() * log.period == pytest.approx(expected_duration(paths, hexapod_case, 1.0), rel=0.03)


@pytest.mark.slow
@pytest.mark.linuxcnc
@pytest.mark.usefixtures("rs274")
@pytest.mark.parametrize("block_ms", [50.0, 120.0])
def test_linuxcnc_stretches_long_blocks_as_predicted_too(block_ms: float, tmp_path: Path, hexapod_case: Case):
    """Their corners are cut by no more than G64 allows, at the price of time."""
    program = tmp_path / "p.ngc"
    program.write_text(small_excitation(changed(hexapod_case, controller__block_ms=block_ms), period=2.4))
    (path,) = triggered_paths(read_linuxcnc(program.read_text(), "p.ngc"))
    log = run_text(program, changed(hexapod_case, controller__linuxcnc__acceleration_headroom=1.0))
    assert predicted_stretch([path], hexapod_case, 1.0) > 1.05
    assert log.trigger.sum() * log.period == pytest.approx(expected_duration([path], hexapod_case, 1.0), rel=0.03)
