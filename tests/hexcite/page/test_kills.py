"""Killed servers, workers, browsers: what was finished is there, what was not goes, and nothing of the user's does."""

import hashlib
import http.client
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlencode, urlsplit

import pytest

from cases import base
from cases.base.leftovers import in_use
from hexcite.page.arrivals import WAIT, Runs, left_over
from hexcite.page.journal import PLACE, Address, address_of, keep_address
from hexcite.page.stages import MARK

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="other systems do not tell a process of its parent's end"
)

COMMAND = """
import json, os, pathlib, signal, subprocess, sys, time
from hexcite.cli.guest import end_with
word = sys.argv[2]
def end(*_):
    pathlib.Path('ended-' + word).touch()
    sys.exit(130)
signal.signal(signal.SIGINT, end)
own = subprocess.Popen(['sleep', '100'])
pathlib.Path('began-' + word).write_text(f'{os.getpid()} {own.pid}')
end_with(int(sys.argv[1]))
if word == 'look':
    lists = {'odd': ['a doubt of the file'], 'repairs': [], 'changes': [], 'topics': []}
    print(json.dumps({'reads': True, 'unchanged': True, **lists}))
    sys.exit(0)
time.sleep(100)
"""
SERVER = """
import sys
from hexcite.page import jobs
jobs.GUEST = 'stand_in'
from hexcite.cli import main
sys.argv[:] = ['hexcite', 'page', '.', '--no-browser']
main()
"""


class Served(NamedTuple):
    """A server that runs a stand-in for each command, and a browser's cookie."""

    process: subprocess.Popen[str]
    port: int
    token: str

    def ask(self, method: str, place: str, body: Mapping[str, str] | bytes = b"") -> tuple[int, str]:
        """Status and text of an answer; or the place that it leads to."""
        there = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        sent = body if isinstance(body, bytes) else urlencode(body).encode()
        headers = {
            "cookie": f"hexcite-{self.port}={self.token}",
            "origin": f"http://127.0.0.1:{self.port}",
            "content-type": "application/x-www-form-urlencoded",
        }
        there.request(method, place, sent, headers)
        answer = there.getresponse()
        text = answer.read().decode()
        there.close()
        return answer.status, answer.headers.get("location") or text


@contextmanager
def served(root: Path, modules: Path) -> Iterator[Served]:
    environment = {**os.environ, "PYTHONPATH": f"{modules}:{Path(base.__file__).parents[2]}"}
    command = [sys.executable, "-P", "-c", SERVER]
    with subprocess.Popen(
        command, cwd=root, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as process:
        assert process.stdout is not None
        address = urlsplit(process.stdout.readline().split()[-1])
        try:
            yield Served(process, int(address.port or 0), address.query.removeprefix("token="))
        finally:
            process.kill()


@pytest.fixture
def modules(tmp_path: Path) -> Path:
    (tmp_path / "modules").mkdir()
    (tmp_path / "modules" / "stand_in.py").write_text(COMMAND)
    return tmp_path / "modules"


@pytest.fixture
def mill(root: Path, calibrated: Path) -> Path:
    """A folder in which every stage of a machine can begin something."""
    shutil.copytree(calibrated, root, dirs_exist_ok=True, ignore=shutil.ignore_patterns(PLACE))
    return root


def until(condition: Callable[[], object], seconds: float = 30.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def running(process: int) -> bool:
    try:
        return "Z" not in Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False


def content(root: Path) -> dict[str, str]:
    """What is not hidden in a folder, but for the signs of stand-ins."""
    return {
        path.relative_to(root).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in root.rglob("*")
        if path.is_file() and path.parent.name != PLACE and not path.name.startswith((".", "began-", "ended-"))
    }


STAGES = {
    "machine": ("check", {}),
    "plan": ("plan", {"family": "ptp", "duration": "12"}),
    "program": ("program", {"plan": "plan", "dialect": "sinumerik"}),
    "data": ("identify", {"recording": "rec"}),
    "result": ("tare", {"result": "res", "recording": "rec"}),
    "use": ("export", {"result": "res", "to": "c"}),
}


def begun(mill: Path, word: str) -> bool:
    """Whether a worker has written its number and that of its own process; the file is there a moment before."""
    file = mill / f"began-{word}"
    return file.exists() and len(file.read_text().split()) == 2


@pytest.mark.repeats
def test_a_server_that_is_killed_at_any_stage_comes_back_with_what_was_finished(mill: Path, modules: Path):
    finished = content(mill)
    with served(mill, modules) as first:
        assert first.ask("POST", "/m/+mill/do/look", {"recording": "rec"})[0] == 303
        until(lambda: "a doubt of the file" in first.ask("GET", "/m/+mill/data?recording=rec")[1])
        for action, fields in STAGES.values():
            assert first.ask("POST", f"/m/+mill/do/{action}", fields)[0] == 303
        until(lambda: begun(mill, "case") and begun(mill, "plan"))
        workers = [int(pid) for name in ("case", "plan") for pid in (mill / f"began-{name}").read_text().split()]
        first.process.kill()
        first.process.wait()
    until(lambda: (mill / "ended-case").exists() and (mill / "ended-plan").exists())
    os.kill(workers[1], signal.SIGKILL)
    os.kill(workers[3], signal.SIGKILL)
    assert content(mill) == finished
    with served(mill, modules) as second:
        assert (second.port, second.token) == (first.port, first.token)
        for stage in STAGES:
            status, text = second.ask("GET", f"/m/+mill/{stage}")
            assert status == 200
            assert "ended from outside" in text, stage
        assert "a doubt of the file" in second.ask("GET", "/m/+mill/data?recording=rec")[1]
        number = re.search(r'data-job="(\d+)"', second.ask("GET", "/m/+mill/plan")[1])
        assert number
        assert "event: over" in second.ask("GET", f"/jobs/{number[1]}/events")[1]  # of a window that stayed open
    assert content(mill) == finished


def test_a_worker_that_is_killed_or_cancelled_ends_with_its_own_processes(mill: Path, modules: Path):
    finished = content(mill)
    with served(mill, modules) as there:
        for word, action, fields, end in (
            ("identify", "identify", {"recording": "rec"}, "ended from outside"),
            ("tare", "tare", {"result": "res", "recording": "rec"}, "stopped; nothing was written"),
        ):
            stage = there.ask("POST", f"/m/+mill/do/{action}", fields)[1].partition("#")[0]
            until(lambda word=word: begun(mill, word))
            worker, own = map(int, (mill / f"began-{word}").read_text().split())
            if action == "tare":
                number = re.search(r'data-job="(\d+)"', there.ask("GET", stage)[1])
                assert number
                assert there.ask("POST", f"/jobs/{number[1]}/stop")[0] == 303
            else:
                os.kill(worker, signal.SIGKILL)
            until(lambda stage=stage, end=end: end in there.ask("GET", stage)[1])
            assert not running(worker)
            until(lambda own=own: not running(own))
    assert content(mill) == finished


def aged(path: Path) -> None:
    then = time.time() - 100.0
    os.utime(path, (then, then), follow_symlinks=False)


def test_the_next_start_clears_leftovers_and_nothing_of_the_users(root: Path, tmp_path: Path, modules: Path):
    ours = [".plan.abcdefgh.hexcite.part", ".upload.a1b2c3d4.hexcite.part", "mill/.case.toml.abcdefgh.hexcite.part"]
    users = [
        ".notes.part", "incomplete-settings/a.csv", ".data.abcdefgh.part", ".upload-abcdefgh.part", ".x.hexcite.part",
        "a.hexcite.part", ".git/index", "incomplete-abcdefgh/keep.csv",
    ]  # fmt: skip
    for name in (*ours, *users, ".held.abcdefgh.hexcite.part", ".res.abcdefgh.hexcite.old/res/result.json"):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(name)
        aged(root / name)
        aged((root / name).parent)
    aged(root / ".res.abcdefgh.hexcite.old")
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "mine.csv").write_text("mine")
    (root / ".linked.abcdefgh.hexcite.part").symlink_to(outside)
    aged(root / ".linked.abcdefgh.hexcite.part")
    with in_use(root / ".held.abcdefgh.hexcite.part"), served(root, modules) as there:
        name = json.loads(there.ask("POST", "/runs")[1])["name"]
        empty = json.loads(there.ask("POST", "/runs")[1])["name"]
        for file in ("run7-struts.csv", "run7-forces.csv"):
            assert there.ask("PUT", f"/upload/{file}?into={name}", b"1,2\n")[0] == 200
        there.process.kill()
        there.process.wait()
        for run in (name, empty):
            aged(root / run / MARK)
        with served(root, modules):
            until(lambda: (root / "run7-incomplete").is_dir() and not (root / empty).exists())
            until(lambda: not any((root / each).exists() for each in ours))
            until((root / "res" / "result.json").exists)
        assert (root / ".held.abcdefgh.hexcite.part").exists()
    assert sorted(file.name for file in (root / "run7-incomplete").iterdir()) == ["run7-forces.csv", "run7-struts.csv"]
    assert (root / "res" / "result.json").read_text() == ".res.abcdefgh.hexcite.old/res/result.json"
    assert all((root / each).read_text() == each for each in users)
    assert (outside / "mine.csv").read_text() == "mine"


def test_what_comes_just_now_is_no_leftover(root: Path):
    runs = Runs(root)
    name = runs.begin()
    (root / name / "a.csv").write_text("1")
    aged(root / name / MARK)
    assert left_over(root) == []  # another server has it
    assert runs.end(name, ()) == "run"
    name = runs.begin()
    runs.close()
    assert left_over(root) == []  # too young to tell
    assert (root / name).is_dir()


def test_what_came_of_a_browser_that_went_away_is_shown_while_the_server_goes_on(root: Path):
    now = [0.0]
    runs = Runs(root, lambda: now[0])
    gone, coming, empty = runs.begin(), runs.begin(), runs.begin()
    for name in (gone, coming):
        (root / name / "a.csv").write_text("1")
    now[0] = WAIT
    assert runs.give_up(()) == []
    now[0] = WAIT + 1.0
    with runs.arriving(coming):
        assert runs.give_up(()) == ["run-incomplete"]
    assert runs.give_up(()) == []  # something came just now
    assert not (root / empty).exists()
    assert [entry.name for entry in (root / "run-incomplete").iterdir()] == ["a.csv"]
    assert runs.end(coming, ()) == "run"
    runs.close()


def test_an_address_that_others_may_read_is_not_used_again(root: Path):
    keep_address(root, Address(8765, "a-secret-of-twenty-letters"))
    kept = root / PLACE / "address.json"
    assert address_of(root) == (8765, "a-secret-of-twenty-letters")
    assert kept.stat().st_mode & 0o077 == 0
    assert kept.parent.stat().st_mode & 0o077 == 0
    kept.chmod(0o644)
    assert address_of(root).token != "a-secret-of-twenty-letters"
    kept.write_text("{")
    kept.chmod(0o600)
    assert address_of(root).port == 0
