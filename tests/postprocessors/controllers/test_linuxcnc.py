"""What the real LinuxCNC executes."""

import re
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import HexciteError
from cases.schema import Case
from identification.machines.hexapod import Hexapod
from postprocessors.controllers.executed_run import ControllerLog
from tests.postprocessors.changed_case import changed
from tests.postprocessors.controllers.runs import PROGRAM, run_text
from tests.postprocessors.programs import typed

FIRST_TRIGGERED, FIRST_AFTER = 8, 13  # M62 and M63 act with the next motion


@pytest.fixture(scope="module")
def executed(hexapod_case: Case, tmp_path_factory: pytest.TempPathFactory) -> ControllerLog:
    program = tmp_path_factory.mktemp("executed") / "program.ngc"
    program.write_text(PROGRAM)
    return run_text(program, hexapod_case)


@pytest.mark.linuxcnc
def test_program_runs_to_its_last_pose(executed: ControllerLog, hexapod_case: Case) -> None:
    assert re.fullmatch(r"LinuxCNC \d+\.\d+\.\d+\S*", executed.controller)
    assert executed.period == 1e-3
    assert hexapod_case.machine is not None
    np.testing.assert_allclose(executed.poses[[0, -1]], np.tile(hexapod_case.machine.home.vector, (2, 1)), atol=1e-12)
    np.testing.assert_array_equal(np.unique(executed.lines), [0, 4, 8, 9, 13])


@pytest.mark.linuxcnc
def test_struts_are_the_delayed_spline_of_the_kinematics(executed: ControllerLog, hexapod_case: Case) -> None:
    lengths = Hexapod.of(hexapod_case).strut_lengths(executed.poses)
    spline = (lengths[:-3] + 4.0 * lengths[1:-2] + lengths[2:-1]) / 6.0
    # LinuxCNC's forward kinematics, on which the first pose rests, stops at 1e-9 mm
    np.testing.assert_allclose(executed.drives[3:], spline, rtol=0.0, atol=1e-9)
    assert np.ptp(executed.drives, axis=0).min() > 1e-3


@pytest.mark.linuxcnc
def test_trigger_gates_the_motion_between_m62_and_m63(executed: ControllerLog) -> None:
    first = int(np.argmax(executed.lines == FIRST_TRIGGERED))
    after = int(np.argmax(executed.lines == FIRST_AFTER))
    inside = np.zeros(len(executed.lines), dtype=bool)
    inside[first - 1 : after - 1] = True  # the first cycle of a motion shows the line before it
    np.testing.assert_array_equal(executed.trigger, inside)
    moved = np.any(np.diff(executed.poses, axis=0) != 0.0, axis=1)
    assert not moved[first - 3]
    assert moved[first - 2 : first].all()


@pytest.mark.linuxcnc
def test_dwells_take_their_time_in_the_controllers_clock(executed: ControllerLog) -> None:
    for before, after, planned in ((4, 8, 0.25), (9, 13, 0.2)):
        start = int(np.flatnonzero(executed.lines == before)[-1]) + 1
        end = int(np.argmax(executed.lines == after)) - 1  # the first cycle of a motion shows the line before it
        assert (end - start) * executed.period == pytest.approx(planned, abs=1e-9)
        np.testing.assert_array_equal(np.ptp(executed.poses[start:end], axis=0), 0.0)


@pytest.mark.slow
@pytest.mark.linuxcnc
def test_motion_does_not_depend_on_the_speedup(write: Callable[[str], Path], hexapod_case: Case) -> None:
    steps = np.linspace(0.0, 2.0 * np.pi, 51)
    blocks = [f"G1 X{20 * np.sin(s):.6f} Y{20 - 20 * np.cos(s):.6f} B{2 * np.sin(s):.6f} F6000" for s in steps[1:]]
    program = write("\n".join(["G21 G90 G94", "G64 P1 Q0", "G93", *blocks, "G94", "M2", ""]))
    runs = [run_text(program, hexapod_case, speedup=speedup) for speedup in (4.0, 2.0)]
    # On a busy computer the first blocks may come some cycles late; from there on every cycle is the same.
    fast, slow = (run.poses[run.lines > 0][-400:] for run in runs)
    np.testing.assert_array_equal(fast, slow)


@pytest.mark.linuxcnc
def test_pose_limits_themselves_are_allowed(write: Callable[[str], Path], hexapod_case: Case) -> None:
    log = run_text(write("G21 G90 G94\nG0 X250 A20\nG0 X-250 A-20\nM2\n"), hexapod_case)
    np.testing.assert_allclose(np.abs(log.poses[-1, [0, 3]]), [0.25, np.radians(20.0)], atol=1e-12)


@pytest.mark.first(3)
@pytest.mark.linuxcnc
@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        ("G21 G90 G94\nG1 X1\nM2\n", "", "Cannot do g1 with zero feed rate"),
        ("G21 G94 F100\nG1 X2 Y3\nG93\n(again)\nG1 X2 Y3\nG94\nM2\n", "", "F word missing with inverse time g1 move"),
        ("G21 G90\nG0 X310\nM2\n", ", line 2", "exceed X's positive limit"),
        ("G21 G90 G94\nG64 P1\nG1 X1 F600\nG1 X2\nG1 Y-300.1\nM2\n", ", line 5", "exceed Y's negative limit"),
        ("G21 G90\nG0 X1\n(MSG, M0) m 00\nM2\n", ", near line 2", "waits for its operator; remove the pause"),
        ("G21\n", "", "File ended with no percent sign or program end"),
    ],
)
def test_what_linuxcnc_refuses_is_one_line_with_place_and_reason(
    text: str, place: str, said: str, write: Callable[[str], Path], hexapod_case: Case
) -> None:
    program = write(text)
    with pytest.raises(HexciteError, match=re.escape(said)) as caught:
        run_text(program, hexapod_case)
    assert str(caught.value).startswith(f"{program}{place}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.linuxcnc
def test_strut_limits_hold(write: Callable[[str], Path], hexapod_case: Case) -> None:
    narrow = changed(hexapod_case, workspace__strut_length_mm=(1000.0, 1100.0))
    with pytest.raises(HexciteError, match=r"line 2: .*stopped: .*joint \d.* limit"):
        run_text(write("G21 G90\nG0 X200 Y-100\nM2\n"), narrow)


@pytest.mark.slow
@pytest.mark.linuxcnc
def test_two_runs_at_the_same_time_do_not_disturb_each_other(tmp_path: Path, hexapod_case: Case) -> None:
    logs: dict[str, ControllerLog] = {}

    def run(name: str, target: float) -> None:
        program = tmp_path / f"{name}.ngc"
        program.write_text(typed(f"G0 X{target}\nG4 P5\nG0 Y{target}"))
        logs[name] = run_text(program, hexapod_case)

    threads = [threading.Thread(target=run, args=(str(k), 10.0 * k)) for k in (1, 2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k in (1, 2):
        np.testing.assert_allclose(logs[str(k)].poses[-1, :2], 0.01 * k, atol=1e-12)
