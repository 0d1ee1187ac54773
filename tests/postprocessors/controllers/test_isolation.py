"""What remains of LinuxCNC when a run is over, and what it does not touch: nothing."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from cases.base.errors import HexciteError
from cases.schema import Case
from postprocessors.controllers.linuxcnc import isolation, session
from tests.helpers import tells
from tests.postprocessors.controllers.runs import PROGRAM, run_text

ENDLESS = "G21 G90 G94\nG1 X100 F1\nM2\n"


@pytest.fixture
def folder() -> Iterator[Path]:
    """A temporary folder that every user can enter, which pytest's own is not."""
    path = Path(tempfile.mkdtemp(prefix="test-linuxcnc-", dir="/tmp"))
    path.chmod(0o755)
    yield path
    shutil.rmtree(path)


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
    for _ in range(3000):
        if reached():
            return
        time.sleep(0.1)  # all processes of the computer are looked at each time
    pytest.fail(f"{what}: not within five minutes")


@pytest.mark.slow
@pytest.mark.linuxcnc
def test_nothing_remains_after_the_time_is_up(
    write: Callable[[str], Path], hexapod_case: Case, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(isolation, "MARK", "HEXCITE_TEST_LIMIT")
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    with pytest.raises(HexciteError, match=r"line 2: .*not through in time"):
        run_text(write(ENDLESS), hexapod_case, time_limit=2.0)  # long enough to be seen in motion on a busy computer
    assert marked_processes("HEXCITE_TEST_LIMIT") == []
    assert [path.name for path in folder.iterdir() if path.suffix != ".lock"] == []


@pytest.mark.slow
@pytest.mark.linuxcnc
def test_a_session_that_hangs_is_killed(
    write: Callable[[str], Path], hexapod_case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "driver.py").write_text("#!/usr/bin/python3\nimport time\ntime.sleep(1e6)\n")
    shutil.copy(session.HERE / "warp.c", tmp_path)
    monkeypatch.setattr(session, "HERE", tmp_path)
    monkeypatch.setattr(isolation, "MARK", "HEXCITE_TEST_HANG")
    monkeypatch.setattr(session, "START_LIMIT", 3.0)
    with pytest.raises(HexciteError, match=r"within 3\.1 s .*killed"):
        run_text(write(ENDLESS), hexapod_case, time_limit=0.1)
    assert marked_processes("HEXCITE_TEST_HANG") == []


def test_killed_processes_are_gone_when_the_session_is_over() -> None:
    mark = "HEXCITE_TEST_MANY"
    many = [subprocess.Popen(["sleep", "1000"], env={mark: "1", "PATH": os.environ["PATH"]}) for _ in range(20)]
    try:
        wait_for(lambda: marked_processes(mark) == ["sleep"] * 20, "start")
        isolation.end_marked(f"{mark}=1")
        assert marked_processes(mark) == []
    finally:
        for process in many:
            process.kill()
            process.wait()


def test_a_process_that_cannot_be_killed_is_named(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(isolation, "GRACE", 0.05)
    monkeypatch.setattr(signal, "SIGKILL", 0)
    with subprocess.Popen(["sleep", "1000"], env={"HEXCITE_TEST_STAYS": "1", "PATH": os.environ["PATH"]}) as process:
        try:
            wait_for(lambda: marked_processes("HEXCITE_TEST_STAYS") == ["sleep"], "start")
            isolation.end_marked("HEXCITE_TEST_STAYS=1")
        finally:
            process.terminate()
    assert tells(caplog.text, "within 0.05 s", f"sleep ({process.pid})")


SCRIPT = """
import signal, sys, tempfile
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's job in the background inherits that it is ignored
from pathlib import Path
from cases.schema import load_case
from postprocessors.controllers.linuxcnc import isolation
from tests.postprocessors.controllers.runs import run_text
program, isolation.MARK, tempfile.tempdir, spaces = sys.argv[1:]
if spaces == "none":
    isolation.namespaces_allowed = lambda: False
log = run_text(Path(program), load_case("hexapod"), time_limit=600.0)
print(log.controller, log.trigger.any())
"""


@pytest.mark.slow
@pytest.mark.linuxcnc
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


@pytest.mark.slow
@pytest.mark.linuxcnc
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
    monkeypatch.setattr(isolation, "PROCESSES", {Path("/proc/self/comm").read_text().strip()})
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    with pytest.raises(HexciteError, match=r"another LinuxCNC .*process \d+\).*; end it.*unshare --user"):
        isolation.run_session(folder, [], {}, 1.0)


def test_a_process_that_has_ended_runs_no_more_though_nobody_has_asked_for_its_end() -> None:
    with subprocess.Popen(["sleep", "1000"]) as process:
        wait_for(lambda: isolation.running().get(process.pid) == "sleep", "start")
        process.kill()
        wait_for(lambda: process.pid not in isolation.running(), "end")
        assert (Path("/proc") / str(process.pid)).exists()
