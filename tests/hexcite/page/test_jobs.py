"""Commands run in processes of their own: as many at once as there is room, stopped on demand, and with the server."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from hexcite.page import jobs
from hexcite.page.drawing import curve
from hexcite.page.jobs import Job, Jobs

COMMAND = """
import json, pathlib, signal, sys, time
def end(*_):
    pathlib.Path(sys.argv[2] + '.best').write_text('kept')
    print(json.dumps({'kept': True}))
    sys.exit(0)
signal.signal(signal.SIGINT, signal.SIG_IGN if sys.argv[2].startswith('deaf') else end)
print(json.dumps({'line': 'start 1 of 2', 'best': 0.25}), file=sys.stderr, flush=True)
print('hexcite: a warning', file=sys.stderr, flush=True)
if sys.argv[2] == 'refused':
    print(json.dumps({'error': {'code': 'missing'}}))
    sys.exit(1)
pathlib.Path(sys.argv[2]).write_text('began')
time.sleep(0.3 if sys.argv[2].startswith('short') else 60)
"""


@pytest.fixture
def stand_in(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A command that tells its progress and waits, in place of hexcite's."""
    folder = tmp_path / "modules"
    folder.mkdir()
    (folder / "stand_in.py").write_text(COMMAND)
    monkeypatch.setenv("PYTHONPATH", str(folder))
    monkeypatch.setattr(jobs, "GUEST", "stand_in")


def job(name: str, search: bool = True) -> Job:
    return Job("hexapod", "plan", (name,), output=f"{name}.best", search=search)


async def until(condition: Callable[[], object]) -> None:
    async with asyncio.timeout(30):
        while not condition():
            await asyncio.sleep(0.02)


def run(root: Path, story: Callable[[Jobs], Awaitable[None]], cores: int = 2) -> None:
    async def whole() -> None:
        there = Jobs(root, cores)
        try:
            await story(there)
        finally:
            await there.close()

    asyncio.run(whole())


@pytest.mark.usefixtures("stand_in")
def test_a_search_that_is_stopped_keeps_its_best(root: Path):
    async def story(there: Jobs) -> None:
        search = job("search")
        there.start(search)
        await until(lambda: (root / "search").exists())
        await until(lambda: search.progress)
        assert search.progress[0]["best"] == 0.25
        assert 0.0 <= search.progress[0]["at"] < 30.0
        await until(lambda: search.messages)  # another stream than progress
        assert search.messages == ["a warning"]
        there.stop(search)
        await until(lambda: search.over)
        assert (search.state, search.answer) == ("done", {"kept": True})

    run(root, story)


@pytest.mark.usefixtures("stand_in")
def test_what_does_not_end_is_killed_at_the_second_word(root: Path):
    async def story(there: Jobs) -> None:
        deaf = job("deaf")
        there.start(deaf)
        await until(lambda: (root / "deaf").exists())
        there.stop(deaf)
        await asyncio.sleep(0.2)
        assert deaf.state == "stopping"
        there.stop(deaf)
        await until(lambda: deaf.over)
        assert deaf.state == "stopped"

    run(root, story)


@pytest.mark.usefixtures("stand_in")
def test_no_more_run_at_once_than_there_is_room_for(root: Path):
    async def story(there: Jobs) -> None:
        all_jobs = [job(f"short{k}") for k in range(4)]
        for each in all_jobs:
            there.start(each)
        assert there.outputs == {f"short{k}.best" for k in range(4)}
        there.stop(all_jobs[3])
        most = 0
        while not all(each.over for each in all_jobs):
            most = max(most, sum(each.state == "running" for each in all_jobs))
            await asyncio.sleep(0.01)
        assert most == 2
        assert [each.state for each in all_jobs] == ["done", "done", "done", "stopped"]
        assert there.outputs == set()
        assert not (root / "short3").exists()

    run(root, story)


@pytest.mark.usefixtures("stand_in")
def test_a_refusal_keeps_its_words_and_has_no_answer(root: Path):
    async def story(there: Jobs) -> None:
        refused = job("refused")
        there.start(refused)
        await until(lambda: refused.over)
        assert (refused.state, refused.messages, refused.answer) == ("failed", ["a warning"], None)

    run(root, story)


@pytest.mark.usefixtures("stand_in")
def test_the_end_of_the_server_lets_searches_write_what_they_have(root: Path):
    search = job("search")

    async def story(there: Jobs) -> None:
        there.start(search)
        await until(lambda: (root / "search").exists())

    run(root, story)
    assert search.state == "done"
    assert (root / "search.best").read_text() == "kept"


PARENT = """
import os, subprocess, sys, threading, time
child = subprocess.Popen([sys.executable, '-c', sys.argv[1], str(os.getpid())], start_new_session=True)
for _ in range(8):
    threading.Thread(target=time.sleep, args=(60.0,)).start()
print(child.pid, flush=True)
"""
CHILD = """
import signal, sys, time
from pathlib import Path
from hexcite.cli.guest import end_with
told = []
signal.signal(signal.SIGINT, lambda *_: told.append(time.monotonic()))
end_with(int(sys.argv[1]))
Path('began').touch()
while not told or time.monotonic() - told[0] < 0.5:
    time.sleep(0.02)
Path('ended.part').write_text(str(len(told)))
Path('ended.part').rename('ended')
"""


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not tell a process that its parent has ended")
def test_a_command_is_interrupted_once_by_the_end_of_a_server_that_is_killed_with_all_its_threads(root: Path):
    environment = {**os.environ, "PYTHONPATH": str(Path(jobs.__file__).parents[2])}
    with subprocess.Popen(
        [sys.executable, "-c", PARENT, CHILD], cwd=root, env=environment, stdout=subprocess.PIPE, text=True
    ) as parent:
        for name in ("began", "ended"):
            deadline = time.monotonic() + 30.0
            while not (root / name).exists():
                assert time.monotonic() < deadline, name
                time.sleep(0.02)
            if name == "began":
                parent.send_signal(signal.SIGKILL)
    assert (root / "ended").read_text() == "1"


def test_the_curve_rises_with_the_best():
    assert curve([{"at": 1.0, "best": None}], 2.0, "best") == ""
    drawn = curve([{"at": 1.0, "best": 0.2}, {"at": 2.0, "best": 0.4}], 4.0, "<best>")
    assert "0.4<" in drawn
    assert "&lt;best&gt;" in drawn
    points = drawn.split('points="')[1].split('"')[0].split()
    heights = [float(point.split(",")[1]) for point in points]
    assert heights == sorted(heights, reverse=True)
    assert heights[0] > heights[-1]


def test_what_writes_the_case_ends_before_another_command_of_the_machine_begins(root: Path, stand_in: None):
    async def story(there: Jobs) -> None:
        writing, reading = Job("+mill", "data", ("short",), writes=True), Job("+mill", "data", ("short-2",))
        elsewhere = Job("hexapod", "data", ("short-3",))
        for each in (writing, reading, elsewhere):
            there.start(each)
        await until(lambda: elsewhere.state != "waiting" and writing.state == "running")
        assert reading.state == "waiting"
        await until(lambda: reading.over)
        assert writing.over
        assert reading.began >= (writing.ended or 0.0)

    run(root, story)
