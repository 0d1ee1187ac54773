"""LinuxCNC as a controller: what is told to it, what it executes, and what remains of it.

Tests marked `linuxcnc` run the real thing. Without an installation they are skipped, unless HEXCITE_REQUIRE_LINUXCNC=1.
"""

import configparser
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.errors import CaseError, ExecutionError, FileProblem
from cases.loading import load_case
from cases.schema import Case
from identification.hexapod import Hexapod
from postprocessors.execute.linuxcnc import configuration, isolation, outcome, running, timing
from postprocessors.execute.linuxcnc.running import linuxcnc_missing, run_linuxcnc
from postprocessors.execute.log import ControllerLog

PROGRAM = """G17 G21 G40 G49 G54 G80 G90 G94
(G4 P99 in a comment is no dwell)
G61
G0 X10 Y5 Z905 A2 B-3 C4
G4 P0.25
G64 P0.01 Q0
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
FIRST_TRIGGERED, FIRST_AFTER = 8, 13  # M62 and M63 act with the next motion
ENDLESS = "G21 G90 G94\nG1 X100 F1\nM2\n"
DWELLS = {5: 0.25, 11: 0.1, 12: 0.1, 14: 0.05}


def changed(case: Case, **keys: Any) -> Case:
    """The case with values at dotted keys (written with `__`) replaced."""
    data = case.model_dump(exclude_none=True)
    for path, value in keys.items():
        *tables, key = path.split("__")
        table = data
        for name in tables:
            table = table[name]
        table[key] = value
    return Case.model_validate(data)


@pytest.fixture(scope="session")
def installed() -> None:
    if (missing := linuxcnc_missing()) is not None:
        if os.environ.get("HEXCITE_REQUIRE_LINUXCNC") == "1":
            pytest.fail(f"HEXCITE_REQUIRE_LINUXCNC=1, but {missing}")
        pytest.skip(missing)


def needs_linuxcnc(test: Callable[..., None]) -> Callable[..., None]:
    marked: Callable[..., None] = pytest.mark.linuxcnc(pytest.mark.usefixtures("installed")(test))
    return marked


@pytest.fixture(scope="module")
def case() -> Case:
    return load_case("hexapod")


@pytest.fixture(scope="module")
def executed(installed: None, case: Case, tmp_path_factory: pytest.TempPathFactory) -> ControllerLog:
    program = tmp_path_factory.mktemp("executed") / "program.ngc"
    program.write_text(PROGRAM)
    return run_linuxcnc(program, case)


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str], Path]:
    def write(text: str) -> Path:
        program = tmp_path / "program.ngc"
        program.write_text(text)
        return program

    return write


@pytest.fixture
def folder() -> Iterator[Path]:
    """A temporary folder that every user can enter, which pytest's own is not."""
    path = Path(tempfile.mkdtemp(prefix="test-linuxcnc-", dir="/tmp"))
    path.chmod(0o755)
    yield path
    shutil.rmtree(path)


# What LinuxCNC does


@needs_linuxcnc
def test_program_runs_to_its_last_pose(executed: ControllerLog, case: Case) -> None:
    assert re.fullmatch(r"LinuxCNC \d+\.\d+\.\d+\S*", executed.controller)
    assert executed.period == 1e-3
    assert case.machine is not None
    np.testing.assert_allclose(executed.poses[[0, -1]], np.tile(case.machine.home.vector, (2, 1)), atol=1e-12)
    np.testing.assert_array_equal(np.unique(executed.lines), [0, 4, 8, 9, 13])


@needs_linuxcnc
def test_struts_are_the_delayed_spline_of_the_kinematics(executed: ControllerLog, case: Case) -> None:
    lengths = Hexapod.of(case).strut_lengths(executed.poses)
    spline = (lengths[:-3] + 4.0 * lengths[1:-2] + lengths[2:-1]) / 6.0
    # LinuxCNC's forward kinematics, on which the first pose rests, stops at 1e-9 mm
    np.testing.assert_allclose(executed.strut_lengths[3:], spline, rtol=0.0, atol=1e-9)
    assert np.ptp(executed.strut_lengths, axis=0).min() > 1e-3


@needs_linuxcnc
def test_trigger_gates_the_motion_between_m62_and_m63(executed: ControllerLog) -> None:
    first = int(np.argmax(executed.lines == FIRST_TRIGGERED))
    after = int(np.argmax(executed.lines == FIRST_AFTER))
    inside = np.zeros(len(executed.lines), dtype=bool)
    inside[first - 1 : after - 1] = True  # the first cycle of a motion shows the line before it
    np.testing.assert_array_equal(executed.trigger, inside)
    moved = np.any(np.diff(executed.poses, axis=0) != 0.0, axis=1)
    assert not moved[first - 3]
    assert moved[first - 2 : first].all()


@needs_linuxcnc
def test_dwells_take_their_time_in_the_controllers_clock(executed: ControllerLog) -> None:
    for before, after, planned in ((4, 8, 0.25), (9, 13, 0.2)):
        start = int(np.flatnonzero(executed.lines == before)[-1]) + 1
        end = int(np.argmax(executed.lines == after)) - 1  # the first cycle of a motion shows the line before it
        assert (end - start) * executed.period == pytest.approx(planned, abs=1e-9)
        np.testing.assert_array_equal(np.ptp(executed.poses[start:end], axis=0), 0.0)


@needs_linuxcnc
def test_motion_does_not_depend_on_the_speedup(write: Callable[[str], Path], case: Case) -> None:
    steps = np.linspace(0.0, 2.0 * np.pi, 51)
    blocks = [f"G1 X{20 * np.sin(s):.6f} Y{20 - 20 * np.cos(s):.6f} B{2 * np.sin(s):.6f} F6000" for s in steps[1:]]
    program = write("\n".join(["G21 G90 G94", "G64 P1 Q0", "G93", *blocks, "G94", "M2", ""]))
    runs = [run_linuxcnc(program, case, speedup=speedup) for speedup in (4.0, 2.0)]
    # On a busy computer the first blocks may come some cycles late; from there on every cycle is the same.
    fast, slow = (run.poses[run.lines > 0][-400:] for run in runs)
    np.testing.assert_array_equal(fast, slow)


@needs_linuxcnc
def test_pose_limits_themselves_are_allowed(write: Callable[[str], Path], case: Case) -> None:
    log = run_linuxcnc(write("G21 G90 G94\nG0 X250 A20\nG0 X-250 A-20\nM2\n"), case)
    np.testing.assert_allclose(np.abs(log.poses[-1, [0, 3]]), [0.25, np.radians(20.0)], atol=1e-12)


@needs_linuxcnc
@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("G21 G90 G94\nG1 X1\nM2\n", 2, "Cannot do g1 with zero feed rate"),
        ("G21 G94 F100\nG1 X2 Y3\nG93\n(again)\nG1 X2 Y3\nG94\nM2\n", 5, "F word missing with inverse time g1 move"),
        ("G21 G90\nG0 X310\nM2\n", 2, "exceed X's positive limit"),
        ("G21 G90 G94\nG64 P1\nG1 X1 F600\nG1 X2\nG1 Y-300.1\nM2\n", 5, "exceed Y's negative limit"),
        ("G21 G90\nG0 X1\n(MSG, M0) m 00\nM2\n", 3, "'(MSG, M0) m 00' waits for an operator; remove M0"),
    ],
)
def test_what_linuxcnc_refuses_is_one_line_with_place_and_reason(
    text: str, line: int, said: str, write: Callable[[str], Path], case: Case
) -> None:
    program = write(text)
    with pytest.raises(ExecutionError, match=re.escape(said)) as caught:
        run_linuxcnc(program, case)
    assert str(caught.value).startswith(f"{program}, line {line}: ")
    assert "\n" not in str(caught.value)


@needs_linuxcnc
def test_unended_program_is_refused(write: Callable[[str], Path], case: Case) -> None:
    with pytest.raises(ExecutionError, match=r"program\.ngc: LinuxCNC cannot read it to its end: File ended"):
        run_linuxcnc(write("G21\n"), case)


@needs_linuxcnc
def test_strut_limits_hold(write: Callable[[str], Path], case: Case) -> None:
    narrow = changed(case, workspace__strut_length_mm=(1000.0, 1100.0))
    with pytest.raises(ExecutionError, match=r"line 2: LinuxCNC stopped: .*joint \d.* limit"):
        run_linuxcnc(write("G21 G90\nG0 X200 Y-100\nM2\n"), narrow)


@needs_linuxcnc
def test_loops_are_refused_where_dwells_stand_between(write: Callable[[str], Path], case: Case) -> None:
    loop = "G21 G90 G94\no1 repeat [2]\nG1 X1 F600\nG4 P0.1\nG1 X0\no1 endrepeat\nM2\n"
    with pytest.raises(ExecutionError, match="line 3: LinuxCNC jumped back"):
        run_linuxcnc(write(loop), case)


@needs_linuxcnc
def test_two_runs_at_the_same_time_do_not_disturb_each_other(tmp_path: Path, case: Case) -> None:
    logs: dict[str, ControllerLog] = {}

    def run(name: str, target: float) -> None:
        program = tmp_path / f"{name}.ngc"
        program.write_text(f"G21 G90\nG0 X{target}\nG4 P5\nG0 Y{target}\nM2\n")
        logs[name] = run_linuxcnc(program, case)

    threads = [threading.Thread(target=run, args=(str(k), 10.0 * k)) for k in (1, 2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k in (1, 2):
        np.testing.assert_allclose(logs[str(k)].poses[-1, :2], 0.01 * k, atol=1e-12)


# What remains of LinuxCNC


def marked_processes(mark: str) -> list[str]:
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            if f"{mark}=".encode() in (entry / "environ").read_bytes():
                found.append((entry / "comm").read_text().strip())
        except OSError:
            continue
    return found


def wait_for(reached: Callable[[], bool], what: str) -> None:
    for _ in range(30_000):
        if reached():
            return
        time.sleep(0.01)
    pytest.fail(f"{what}: not within five minutes")


@needs_linuxcnc
def test_nothing_remains_after_the_time_is_up(
    write: Callable[[str], Path], case: Case, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(isolation, "_MARK", "HEXCITE_TEST_LIMIT")
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    with pytest.raises(ExecutionError, match="near line 2: LinuxCNC was not through in time"):
        run_linuxcnc(write(ENDLESS), case, time_limit=2.0)  # long enough to be seen in motion on a busy computer
    assert marked_processes("HEXCITE_TEST_LIMIT") == []
    assert [path.name for path in folder.iterdir() if path.suffix != ".lock"] == []


@needs_linuxcnc
def test_a_session_that_hangs_is_killed(
    write: Callable[[str], Path], case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "driver.py").write_text("#!/usr/bin/python3\nimport time\ntime.sleep(1e6)\n")
    shutil.copy(running.HERE / "warp.c", tmp_path)
    monkeypatch.setattr(running, "HERE", tmp_path)
    monkeypatch.setattr(isolation, "_MARK", "HEXCITE_TEST_HANG")
    monkeypatch.setattr(running, "START_LIMIT", 3.0)
    with pytest.raises(ExecutionError, match=r"did not end within 3\.1 s and was killed"):
        run_linuxcnc(write(ENDLESS), case, time_limit=0.1)
    assert marked_processes("HEXCITE_TEST_HANG") == []


def test_killed_processes_are_gone_when_the_session_is_over() -> None:
    mark = "HEXCITE_TEST_MANY"
    many = [subprocess.Popen(["sleep", "1000"], env={mark: "1", "PATH": os.environ["PATH"]}) for _ in range(20)]
    try:
        assert marked_processes(mark) == ["sleep"] * 20
        isolation._end_marked(f"{mark}=1")
        assert marked_processes(mark) == []
    finally:
        for process in many:
            process.kill()
            process.wait()


def test_a_process_that_cannot_be_killed_is_named(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(isolation, "GRACE", 0.05)
    monkeypatch.setattr(isolation.signal, "SIGKILL", 0)
    with subprocess.Popen(["sleep", "1000"], env={"HEXCITE_TEST_STAYS": "1", "PATH": os.environ["PATH"]}) as process:
        try:
            wait_for(lambda: marked_processes("HEXCITE_TEST_STAYS") == ["sleep"], "start")
            isolation._end_marked("HEXCITE_TEST_STAYS=1")
        finally:
            process.terminate()
    assert f"did not end within 0.05 s of being killed: sleep ({process.pid})" in caplog.text


SCRIPT = """
import sys, tempfile
from pathlib import Path
from cases.loading import load_case
from postprocessors.execute.linuxcnc import isolation
from postprocessors.execute.linuxcnc.running import run_linuxcnc
program, isolation._MARK, tempfile.tempdir, spaces = sys.argv[1:]
if spaces == "none":
    isolation.namespaces_allowed = lambda: False
log = run_linuxcnc(Path(program), load_case("hexapod"), time_limit=600.0)
print(log.controller, log.trigger.any())
"""


@needs_linuxcnc
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_nothing_keeps_running_when_hexcite_is_ended(
    number: signal.Signals, write: Callable[[str], Path], folder: Path
) -> None:
    if number == signal.SIGKILL and not isolation.namespaces_allowed():
        pytest.skip("only the kernel can end the processes of a killed one, and it allows no namespaces here")
    mark = f"HEXCITE_TEST_{number.name}"
    command = [sys.executable, "-c", SCRIPT, str(write(ENDLESS)), mark, str(folder), "private"]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as process:
        wait_for(lambda: "driver.py" in marked_processes(mark), "start")
        process.send_signal(number)
    wait_for(lambda: marked_processes(mark) == [], "end of all processes")
    if number == signal.SIGINT:
        assert [path.name for path in folder.iterdir() if path.suffix != ".lock"] == []


@needs_linuxcnc
def test_runs_without_namespaces_too(write: Callable[[str], Path], folder: Path) -> None:
    """Inside outer namespaces, where it cannot meet the sessions of other tests."""
    if not isolation.namespaces_allowed():
        pytest.skip("without namespaces all other tests show it")
    user = ["--map-user=65534"] if os.getuid() == 0 else ["--map-current-user"]
    outer = [
        "unshare",
        "--user",
        *user,
        "--pid",
        "--fork",
        "--kill-child",
        "--ipc",
        "--net",
        "--mount-proc",
    ]
    command = [sys.executable, "-c", SCRIPT, str(write(PROGRAM)), "HEXCITE_TEST_PLAIN", str(folder), "none"]
    result = subprocess.run([*outer, *command], capture_output=True, text=True)
    assert result.stdout.startswith("LinuxCNC "), result.stderr
    assert marked_processes("HEXCITE_TEST_PLAIN") == []


def test_does_not_start_beside_somebody_elses_linuxcnc(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(isolation, "namespaces_allowed", lambda: False)
    monkeypatch.setattr(isolation, "_PROCESSES", {Path("/proc/self/comm").read_text().strip()})
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    with pytest.raises(ExecutionError, match="another LinuxCNC is running on this computer"):
        isolation.run_session(folder, [], {}, 1.0)


# What is told to LinuxCNC


def settings(text: str) -> configparser.ConfigParser:
    parser = configparser.ConfigParser()
    parser.read_string(text)
    return parser


def test_axes_have_the_limits_of_the_case_in_millimetres_and_degrees(case: Case) -> None:
    """In the narrower box of dense paths; without one the workspace and the struts limit them."""
    moved = changed(case, machine__home__x_mm=7.0)
    wide = settings(configuration.ini_text(moved, np.full(6, 1.0), 1.0, box=False))
    assert wide.getfloat("AXIS_X", "MAX_LIMIT") == pytest.approx(307.0, abs=2e-6)
    assert wide.getfloat("AXIS_C", "MIN_LIMIT") == pytest.approx(-90.0, abs=2e-6)
    ini = settings(configuration.ini_text(moved, np.full(6, 1.0), 1.0))
    assert ini.getfloat("AXIS_X", "MIN_LIMIT") == pytest.approx(-243.0, abs=2e-6)
    assert ini.getfloat("AXIS_X", "MAX_LIMIT") == pytest.approx(257.0, abs=2e-6)
    assert ini.getfloat("AXIS_X", "MAX_LIMIT") >= 257.0
    assert ini.getfloat("AXIS_Z", "MIN_LIMIT") == pytest.approx(800.0, abs=2e-6)
    assert ini.getfloat("AXIS_C", "MIN_LIMIT") == pytest.approx(-20.0, abs=2e-6)
    assert ini.getfloat("AXIS_Y", "MAX_VELOCITY") == pytest.approx(600.0)
    assert ini.getfloat("AXIS_B", "MAX_VELOCITY") == pytest.approx(60.0)
    assert ini.get("EMCMOT", "SERVO_PERIOD") == "1000000"


@pytest.mark.parametrize("headroom", [1.0, 35.0])
def test_acceleration_limits_are_multiplied_by_the_headroom(headroom: float, case: Case) -> None:
    ini = settings(configuration.ini_text(case, np.full(6, 1.0), headroom))
    assert ini.getfloat("AXIS_Z", "MAX_ACCELERATION") == pytest.approx(6000.0 * headroom)
    assert ini.getfloat("AXIS_A", "MAX_ACCELERATION") == pytest.approx(np.degrees(10.0) * headroom)


@pytest.mark.parametrize(("kind", "axes"), [("LINEAR", "XYZ"), ("ANGULAR", "ABC")])
@pytest.mark.parametrize("quantity", ["VELOCITY", "ACCELERATION"])
def test_limits_of_the_path_bind_after_those_of_all_axes_together(
    kind: str, axes: str, quantity: str, case: Case
) -> None:
    ini = settings(configuration.ini_text(case, np.full(6, 1.0), 1.0))
    together = np.linalg.norm([ini.getfloat(f"AXIS_{axis}", f"MAX_{quantity}") for axis in axes])
    assert ini.getfloat("TRAJ", f"MAX_{kind}_{quantity}") >= together - 1e-9


def test_struts_have_the_range_of_the_workspace_and_start_at_home(case: Case) -> None:
    ini = settings(configuration.ini_text(case, np.linspace(1.0, 1.05, 6), 1.0))
    assert [ini.getfloat(f"JOINT_{k}", "HOME") for k in range(6)] == pytest.approx(np.linspace(1000.0, 1050.0, 6))
    for k in range(6):
        assert ini.getfloat(f"JOINT_{k}", "MIN_LIMIT") == 650.0
        assert ini.getfloat(f"JOINT_{k}", "MAX_LIMIT") == 1550.0


def test_kinematics_has_the_joints_of_the_case(case: Case) -> None:
    assert case.machine is not None
    found = re.findall(r"^setp genhexkins\.(base|platform)\.(\d)\.([xyz]) (\S+)$", configuration.hal_text(case), re.M)
    points = {ring: np.full((6, 3), np.nan) for ring in ("base", "platform")}
    for ring, k, coordinate, value in found:
        points[ring][int(k), "xyz".index(coordinate)] = float(value)
    np.testing.assert_allclose(points["base"], case.machine.base.points * 1e3, atol=1e-9)
    np.testing.assert_allclose(points["platform"], case.machine.platform.points * 1e3, atol=1e-9)


def test_every_channel_is_logged(case: Case) -> None:
    pins = re.findall(r"^net log-(\d+) (\S+) => sampler\.0\.pin\.(\d+)$", configuration.hal_text(case), re.M)
    assert [(int(a), pin, int(b)) for a, pin, b in pins] == [
        (k, pin, k) for k, (_, pin) in enumerate(configuration.CHANNELS)
    ]
    assert f"cfg={configuration.sampler_format()}" in configuration.hal_text(case)
    assert f"SAMPLER = {configuration.sampler_format()}\n" in configuration.ini_text(case, np.full(6, 1.0), 1.0)


def test_a_case_without_a_machine_cannot_be_configured(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="running a program on LinuxCNC needs it"):
        configuration.write_configuration(tmp_path, load_case("ft_wrist"), np.full(6, 1.0), 1.0)


# Dwells and blocks


def test_dwells_are_found_by_line(tmp_path: Path) -> None:
    assert timing.dwells(tmp_path, PROGRAM.split("\n")) == DWELLS


@pytest.mark.parametrize(
    "line", ["G04 P1", "G4 P.5", "G4P1", "g4 P1", " G4 P1", "G4 P1 G0 X1", "G4 P#1", "N5 G4 P1", "G 4 P1"]
)
def test_dwells_in_another_form_are_refused(line: str) -> None:
    with pytest.raises(ExecutionError, match=r"a\.ngc, line 2: dwell .* cannot be timed; write it as G4 P<seconds>"):
        timing.dwells(Path("a.ngc"), ["G21", line])


@pytest.mark.parametrize("line", ["G40", "G43.1", "G49", "G64 P4", "(G4 P1)", "; G4 P1", "G0 X4 (G04)", "G1 X1 F4"])
def test_what_is_no_dwell_is_left_alone(line: str) -> None:
    assert timing.dwells(Path("a.ngc"), [line]) == {}
    assert timing.with_dwells([line], {}, 20.0, 0.002) == [line]


def test_only_dwells_change_in_the_copy_that_is_run() -> None:
    lines = PROGRAM.split("\n")
    copy = timing.with_dwells(lines, DWELLS, 10.0, 0.001)
    assert copy[4] == "G4 P0.026000"
    assert [line for k, line in enumerate(copy, 1) if k not in DWELLS] == [
        line for k, line in enumerate(lines, 1) if k not in DWELLS
    ]


def test_short_blocks_are_run_slower() -> None:
    blocks = ["G94", "G1 X1 F60000", "G93", "G1 X2 F6000 (F60000)", "G1 X3 F3000", "G94 F90000"]
    assert timing.fastest(blocks) == pytest.approx(0.010 / timing.BLOCK)
    assert timing.fastest(["G94", "G1 X1 F60000"]) == np.inf


def log_of(lines: list[int]) -> ControllerLog:
    count = len(lines)
    return ControllerLog(
        "none", 1e-3, np.ones((count, 6)), np.zeros((count, 6)), np.zeros(count, dtype=bool), np.array(lines)
    )


@pytest.mark.parametrize(("cycles", "ok"), [(100, False), (101, True), (130, True), (20142, False)])
def test_a_dwell_is_proven_by_the_cycles_without_motion(cycles: int, ok: bool) -> None:
    log = log_of([1] * 5 + [0] * cycles + [3] * 5)
    problem = timing.dwell_problem(log, {2: 0.1}, 20.0, 0.002, (0, len(log.lines)))
    if ok:
        assert problem is None
    else:
        assert problem is not None
        assert problem.startswith(f"line 2: LinuxCNC dwelt {(cycles - 1) / 1000:.3f} s, must be 0.100 to 20.140 s; ")


def test_dwells_next_to_no_motion_are_proven_within_the_run() -> None:
    log = log_of([0] * 150 + [2] * 5 + [0] * 150)
    assert timing.dwell_problem(log, {1: 0.1, 3: 0.1}, 20.0, 0.002, (40, 265)) is None
    assert "line 1: " in str(timing.dwell_problem(log, {1: 0.1, 3: 0.1}, 20.0, 0.002, (60, 265)))
    assert "line 3: " in str(timing.dwell_problem(log, {1: 0.1, 3: 0.1}, 20.0, 0.002, (40, 245)))


def standing(phases: list[tuple[int, bool]]) -> ControllerLog:
    """Motion in line 1, phases of standstill with the trigger as stated, motion in line 9."""
    count = sum(n for n, _ in phases)
    lines = np.array([1] * 5 + [0] * (count + 1) + [9] * 5)
    trigger = np.array([False] * 5 + [on for n, on in phases for _ in range(n)] + [False] * 6)
    struts = np.ones((len(lines), 6))
    struts[:5] += 0.01 * np.arange(5)[:, None]
    return ControllerLog("none", 1e-3, struts, np.zeros((len(lines), 6)), trigger, lines)


FEW = timing.FEWEST_CYCLES
POSE = ["G1 X1", "G4 P0.1", "M64 P0 (on)", "G4 P0.2", "M65 P0", "", "G4 P0.05", "", "G1 X2"]
POSE_DWELLS = {2: 0.1, 4: 0.2, 7: 0.05}
POSE_SWITCHES = timing.switches(POSE)


def test_switches_are_found_by_line() -> None:
    assert POSE_SWITCHES == {3: True, 5: False}
    assert timing.switches(["m64p0", "M65 P1", "M62 P0", "(M64 P0)", "M65 P00", "M64"]) == {1: True, 5: False}


def test_dwells_are_as_long_in_the_log_as_programmed_each_with_its_trigger() -> None:
    log = standing([(130, False), (204, True), (90, False)])
    found = timing.without_surplus(log, POSE_DWELLS, POSE_SWITCHES, (0, len(log.lines)))
    np.testing.assert_array_equal(np.flatnonzero(found.trigger), 5 + 100 + np.arange(200))
    assert np.count_nonzero(found.lines == 0) == 350 + 1
    assert found.left_out == 30 + 4 + 40 == len(log.lines) - len(found.lines)
    np.testing.assert_array_equal(found.strut_lengths[:6], log.strut_lengths[:6])


def test_what_the_log_does_not_show_as_programmed_stays() -> None:
    for phases in ([(130, False)], [(130, False), (204, True), (90, False), (10, True)]):
        log = standing(phases)
        assert timing.without_surplus(log, POSE_DWELLS, POSE_SWITCHES, (0, len(log.lines))).left_out == 0
    moved = standing([(130, False), (204, True), (90, False)])
    struts = moved.strut_lengths.copy()
    struts[5 + 60] += 1e-6
    creeping = ControllerLog("none", 1e-3, struts, moved.poses, moved.trigger, moved.lines)
    assert timing.without_surplus(creeping, POSE_DWELLS, POSE_SWITCHES, (0, len(moved.lines))).left_out == 4 + 40


def test_a_switch_between_motions_takes_few_cycles_however_late_it_came() -> None:
    for late in (FEW, 60, 700):
        log = standing([(late, True), (FEW, False)])
        found = timing.without_surplus(log, {}, {2: True, 5: False}, (0, len(log.lines)))
        assert (found.trigger.sum(), np.count_nonzero(found.lines == 0)) == (FEW, 2 * FEW + 1)


# Errors without LinuxCNC


def test_missing_installation_is_an_error_with_the_remedy(
    write: Callable[[str], Path], case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(running, "linuxcnc_missing", lambda: "it is not there; install it")
    with pytest.raises(ExecutionError, match=r"program\.ngc: cannot be run: it is not there; install it"):
        run_linuxcnc(write(PROGRAM), case)


@pytest.mark.parametrize("program", ["linuxcnc", "rs274", "gcc"])
def test_what_is_missing_is_named(program: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name, path: None if name == program else f"/usr/bin/{name}")
    assert re.search(rf"{program}.* missing.*; install the package", str(linuxcnc_missing.__wrapped__()))


@needs_linuxcnc
def test_a_program_that_cannot_be_read_is_named(tmp_path: Path, case: Case) -> None:
    with pytest.raises(FileProblem, match=r"none\.ngc: cannot be read"):
        run_linuxcnc(tmp_path / "none.ngc", case)
    (tmp_path / "binary.ngc").write_bytes(b"\xff\xfe")
    with pytest.raises(ExecutionError, match=r"binary\.ngc: is not plain ASCII text"):
        run_linuxcnc(tmp_path / "binary.ngc", case)


REPORT = {"outcome": "done", "version": "2.9.4", "errors": [], "messages": [], "line": 7, "started": 0, "ended": 1}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"outcome": "time limit"}, "p.ngc, near line 7: LinuxCNC was not through in time"),
        ({"outcome": "paused"}, "p.ngc, near line 7: LinuxCNC waits for its operator"),
        (
            {"outcome": "disabled", "errors": ["joint 0\nfollowing error"]},
            "near line 7: LinuxCNC stopped: joint 0 following error",
        ),
        (
            {"outcome": "error", "errors": ["on line 3 broken."]},
            "p.ngc, line 3: LinuxCNC stopped: on line 3 broken; correct",
        ),
        ({"outcome": "error", "line": 0}, "p.ngc: LinuxCNC stopped: it gave no reason"),
    ],
)
def test_reports_of_failure_become_one_line(change: dict[str, Any], said: str, tmp_path: Path) -> None:
    (tmp_path / outcome.REPORT_FILE).write_text(json.dumps(REPORT | change))
    with pytest.raises(ExecutionError, match=re.escape(said)):
        outcome.read_report(Path("p.ngc"), tmp_path)


def test_a_session_without_report_tells_what_linuxcnc_said_last(tmp_path: Path) -> None:
    (tmp_path / isolation.OUTPUT_FILE).write_text("Starting\nRealtime system did not load\n")
    with pytest.raises(ExecutionError, match="said last: Realtime system did not load"):
        outcome.read_report(Path("p.ngc"), tmp_path)


def test_lost_cycles_are_an_error(tmp_path: Path) -> None:
    with pytest.raises(outcome.LostCycles, match=r"3 of 10 cycles were not logged; .* speed-up below 20"):
        outcome.read_log(Path("p.ngc"), tmp_path, REPORT | {"samples": 7, "lost": 3}, 20.0)


@pytest.mark.parametrize("losses", [0, 1, 2, 3])
def test_a_run_that_loses_cycles_is_repeated_more_slowly_and_given_up_in_the_end(
    losses: int, write: Callable[[str], Path], case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    speeds: list[float] = []

    def session(program: Path, lines: list[str], case: Case, headroom: float, timed: bool, speed: float, limit: float):
        speeds.append(speed)
        if len(speeds) <= losses:
            raise outcome.LostCycles(f"{program}: lost at {speed:g}")
        return log_of([0, 2, 2, 0]), (0, 4)

    for name, value in (("linuxcnc_missing", lambda: None), ("preload_works", lambda: True), ("_session", session)):
        monkeypatch.setattr(running, name, value)
    monkeypatch.setattr(running, "check_syntax", lambda *_: None)
    program = write("G21 G90 G94\nG1 X1 F600\nM2\n")
    if losses < 3:
        assert run_linuxcnc(program, case).lines.tolist() == [0, 2, 2, 0]
    else:
        with pytest.raises(ExecutionError, match="lost at 5"):
            run_linuxcnc(program, case)
    assert speeds == [20.0, 10.0, 5.0][: losses + 1]


# The log


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("poses", np.zeros((4, 6)), r"poses has shape \(4, 6\), expected \(5, 6\)"),
        ("strut_lengths", np.array([[1.0] * 6] * 4 + [[np.nan] * 6]), "strut_lengths is not finite in row 5"),
        ("trigger", np.zeros((5, 1), dtype=bool), r"trigger has shape \(5, 1\)"),
        ("lines", np.zeros(0, dtype=int), "holds no cycle"),
        ("period", 0.0, "period is 0.0 s"),
    ],
)
def test_a_log_that_can_be_made_is_whole(name: str, value: Any, said: str) -> None:
    good = log_of([0, 1, 1, 2, 0])
    values = {key: getattr(good, key) for key in ("controller", "period", "strut_lengths", "poses", "trigger", "lines")}
    with pytest.raises(ValueError, match=said):
        ControllerLog(**(values | {name: value}))


def test_a_log_cannot_be_changed() -> None:
    log = log_of([0, 1])
    with pytest.raises(ValueError, match="read-only"):
        log.poses[0, 0] = 1.0
    np.testing.assert_allclose(log.time, [0.0, 1e-3])
