"""Ctrl-C at any moment of planning: what was found is kept, and where nothing was, one line says so."""

import fcntl
import os
import signal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from cases.base.errors import Interrupted
from cases.schema import Case
from hexcite.cli import ctrl_c_raises
from planner.families.settings import family_class
from planner.plans import making as planning
from planner.plans.plan import Plan
from planner.request import Request
from planner.search.parallel import Listener, Outcome, Schedule, silent
from tests.hexcite.command_line import call


@dataclass(frozen=True)
class Found:
    """A stand-in for a plan."""

    interrupted: bool = False


def ctrl_c() -> None:
    signal.raise_signal(signal.SIGINT)


def planned(make: Callable, family: str, case: Case, monkeypatch: pytest.MonkeyPatch) -> Plan:
    """What comes of a plan that is made by a stand-in, as under the command line."""
    monkeypatch.setattr(planning, "make", make)
    with ctrl_c_raises():
        return planning.make_until_ctrl_c(Request(family_class(family)()), case, silent)


def test_ctrl_c_after_the_search_loses_nothing(hexapod_case: Case, monkeypatch: pytest.MonkeyPatch):
    """While a motion is proven and rated, which is not a search that could be stopped."""

    def make(*_: object) -> Found:
        ctrl_c()
        return Found()

    assert planned(make, "ptp", hexapod_case, monkeypatch).interrupted


def test_ctrl_c_before_a_search_keeps_it_from_beginning(hexapod_case: Case, monkeypatch: pytest.MonkeyPatch):
    told: list[Outcome] = []

    def make(request: Request, case: Case, listener: Listener, run: Callable, began: float | None) -> Found:
        ctrl_c()
        told.append(run(Schedule.of([object()]), listener))  # type: ignore[list-item]  # no task: it would fail
        return Found()

    planned(make, "fourier", hexapod_case, monkeypatch)
    assert told == [([], True)]


def test_without_ctrl_c_a_plan_is_what_it_is(hexapod_case: Case, monkeypatch: pytest.MonkeyPatch):
    assert not planned(lambda *_: Found(), "spline", hexapod_case, monkeypatch).interrupted
    assert planned(lambda *_: Found(True), "spline", hexapod_case, monkeypatch).interrupted


@pytest.mark.parametrize(("family", "times"), [("manual", 1), ("ptp", 2)])
def test_a_second_ctrl_c_gives_up_and_where_nothing_is_searched_the_first(
    family: str, times: int, hexapod_case: Case, monkeypatch: pytest.MonkeyPatch
):
    def make(*_: object) -> Found:
        for _time in range(times):
            ctrl_c()
        return Found()

    with pytest.raises(Interrupted):
        planned(make, family, hexapod_case, monkeypatch)


def test_ctrl_c_while_a_plan_is_written_lets_it_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    from planner.plans import plan as plans

    write = plans.motion_csv

    def interrupted(*arguments: object) -> str:
        ctrl_c()
        return write(*arguments)

    monkeypatch.setattr(plans, "motion_csv", interrupted)
    steps = tmp_path / "steps.toml"
    steps.write_text('title = "t"\nsteps = [{x_mm = 50.0}, {circle = "YZ", radius_mm = 40.0}, {a_deg = 10.0}]')
    words = ("plan", "hexapod", "--family", "manual", "--sequence", steps, "--model", 0, "-o", tmp_path / "p", "--json")
    assert call(*words).json()["plan"] == str(tmp_path / "p")
    assert (tmp_path / "p" / "report.html").is_file()


def manual(folder: Path) -> tuple[object, ...]:
    """A plan that is made without a search."""
    steps = folder.with_suffix(".toml")
    steps.write_text('title = "t"\nsteps = [{x_mm = 50.0}, {circle = "YZ", radius_mm = 40.0}, {a_deg = 10.0}]')
    return "plan", "hexapod", "--family", "manual", "--sequence", steps, "--model", 0, "-o", folder


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_command_that_is_asked_to_end_leaves_nothing_half_written(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    from planner.plans import plan as plans

    usual = signal.signal(number, signal.SIG_DFL)  # where tests run behind nohup, SIGHUP is ignored, and stays so
    monkeypatch.setattr(plans, "motion_csv", lambda *_: signal.raise_signal(number))
    (inner := tmp_path / "inner").mkdir()
    try:
        answer = call(*manual(inner / "p"))
    finally:
        signal.signal(number, usual)
    assert (answer.code, answer.err.splitlines()[-1]) == (130, "hexcite: interrupted; nothing was written")
    assert [file.name for file in inner.iterdir()] == ["p.toml"]


def test_an_interrupted_command_says_what_stands_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    from hexcite.cli import console

    monkeypatch.setattr(console, "answered", lambda *_: signal.raise_signal(signal.SIGTERM))
    answer = call(*manual(tmp_path / "p"))
    assert (answer.code, answer.err.splitlines()[-1]) == (130, f"hexcite: interrupted; {tmp_path / 'p'} stands there")
    assert (tmp_path / "p" / "plan.json").is_file()


def test_what_killed_commands_left_goes_with_the_next_one(tmp_path: Path):
    """But not what another command writes just now, nor what is of another name."""
    old, used, other = (tmp_path / name for name in (".p.1.hexcite.part", ".p.2.hexcite.part", ".pp.3.hexcite.part"))
    for place in (old, used, other):
        place.mkdir()
        (place / "plan.json").write_text("{")
        os.utime(place, (0, 0))
    (young := tmp_path / ".p.4.hexcite.part").mkdir()
    handle = os.open(used, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        assert call(*manual(tmp_path / "p")).code == 0
    finally:
        os.close(handle)
    assert not old.exists()
    assert used.is_dir()
    assert other.is_dir()
    assert young.is_dir()
    assert (tmp_path / "p" / "plan.json").is_file()
