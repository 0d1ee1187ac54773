"""A command that is killed or interrupted leaves a whole folder or none, and the next one works."""

import os
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest

from tests.hexcite.command_line import PROGRAM, call
from tests.hexcite.json_answer import one_json_object

SEARCHED = 5.0
QUICK = ("plan", "hexapod", "--family", "fourier", "--order", "2", "--model", "0", "--starts", "1", "--json")


def start(*arguments: object) -> subprocess.Popen:
    command = [PROGRAM, *map(str, arguments)]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )  # fmt: skip


def signal_when(process: subprocess.Popen, there: list[str], folder: Path, what: signal.Signals) -> tuple[str, str]:
    """Sends a signal to a command and its workers as soon as files that match appear in a folder."""
    running = True
    while not any(any(folder.glob(pattern)) for pattern in there):
        assert running, process.communicate()
        running = process.poll() is None  # before the next look: its last act may be the files
        time.sleep(0.002)
    if running:
        os.killpg(process.pid, what)
    return process.communicate(timeout=300)


def whole(folder: Path, file: str, others: list[str]) -> bool:
    """Whether a folder is complete; false where there is none."""
    if not folder.exists():
        return False
    one_json_object((folder / file).read_text(encoding="utf-8"))
    assert all((folder / name).exists() for name in others)
    return True


@pytest.mark.slow
def test_a_plan_that_is_killed_while_it_is_written_is_whole_or_absent(cache: Path, tmp_path: Path):
    moment = [".plan.*.part/plan.json", "plan"]
    signal_when(start(*QUICK, "-o", tmp_path / "plan"), moment, tmp_path, signal.SIGKILL)
    whole(tmp_path / "plan", "plan.json", ["motion.csv", "report.html"])


@pytest.mark.slow
def test_a_result_that_is_killed_while_it_is_written_is_whole_or_absent(
    chain: dict[str, Any], shared: Path, tmp_path: Path
):
    identify = ("identify", shared / "recording", "-o", tmp_path / "result", "--json")
    signal_when(start(*identify), [".result.*.part/result.json", "result"], tmp_path, signal.SIGKILL)
    whole(tmp_path / "result", "result.json", ["report.html"])
    call(*identify).json()
    assert whole(tmp_path / "result", "result.json", ["report.html"])


def workers(session: int) -> list[float]:
    """Processor time that each process of a session, but for its first, has used so far [s]."""
    times = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:  # gone
            continue
        if int(fields[3]) == session != int(entry.name) and fields[0] != "Z":
            times.append((int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK"))
    return times


def searching(folder: Path) -> subprocess.Popen:
    """A plan of many starts whose workers have done SEARCHED seconds of work: on a busy computer they begin late."""
    many = ("plan", "hexapod", "--family", "fourier", "--order", "2", "--model", "0", "--starts", "400")
    process = start(*many, "-o", folder / "plan")
    assert process.stdout.readline().startswith("Planning for hexapod")
    while sum(workers(process.pid)) < SEARCHED:
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)
    return process


def interrupted(times: int, folder: Path) -> subprocess.Popen:
    """A search that gets Ctrl-C, as its workers do."""
    process = searching(folder)
    for _ in range(times):
        os.killpg(process.pid, signal.SIGINT)
        time.sleep(0.05)  # two at once would be one
    return process


@pytest.mark.slow
def test_workers_of_a_plan_that_is_killed_end_with_it(cache: Path, tmp_path: Path):
    process = searching(tmp_path)
    process.kill()
    for _ in range(30_000):
        if not workers(process.pid):
            break
        time.sleep(0.01)
    else:
        os.killpg(process.pid, signal.SIGKILL)
        pytest.fail("workers are left behind")
    process.communicate(timeout=300)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_ctrl_c_ends_the_search_and_keeps_the_best_plan_so_far(cache: Path, tmp_path: Path):
    process = interrupted(1, tmp_path)
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0
    assert all(line.startswith("searching: ") for line in err.splitlines())  # on a busy computer it says how it gets on
    assert "stopped by Ctrl-C" in out
    assert whole(tmp_path / "plan", "plan.json", ["motion.csv", "report.html"])
    plan = one_json_object((tmp_path / "plan" / "plan.json").read_text(encoding="utf-8"))
    assert plan["interrupted"]
    assert plan["status"] == "proven"
    assert 0 < len(plan["starts"]) < 400


@pytest.mark.slow
def test_a_second_ctrl_c_gives_up_in_one_line_and_leaves_nothing(cache: Path, tmp_path: Path):
    process = interrupted(2, tmp_path)
    _, err = process.communicate(timeout=300)
    assert process.returncode == 130
    assert err.splitlines()[-1] == "hexcite: interrupted; nothing was written"
    assert list(tmp_path.iterdir()) == []
