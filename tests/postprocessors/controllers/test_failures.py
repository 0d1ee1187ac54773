"""Runs on LinuxCNC that fail: one line each, with the remedy."""

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cases.base.errors import HexciteError
from cases.schema import Case
from postprocessors.controllers.linuxcnc import isolation, session
from postprocessors.controllers.linuxcnc.session import linuxcnc_missing
from tests.postprocessors.controllers.runs import PROGRAM, log_of, run_text


def test_missing_installation_is_an_error_with_the_remedy(
    write: Callable[[str], Path], hexapod_case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session, "linuxcnc_missing", lambda: "it is not there; install it")
    with pytest.raises(HexciteError, match=r"program\.ngc: .*not there; install it"):
        run_text(write(PROGRAM), hexapod_case)


@pytest.mark.parametrize("program", ["linuxcnc", "halcmd", "gcc"])
def test_what_is_missing_is_named(program: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name, path: None if name == program else f"/usr/bin/{name}")
    assert re.search(rf"{program}.* missing.*; install the package", str(linuxcnc_missing.__wrapped__()))


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
    (tmp_path / session.REPORT_FILE).write_text(json.dumps(REPORT | change))
    with pytest.raises(HexciteError, match=re.escape(said)):
        session.read_report(Path("p.ngc"), tmp_path)


def test_a_session_without_report_tells_what_linuxcnc_said_last(tmp_path: Path) -> None:
    (tmp_path / isolation.OUTPUT_FILE).write_text("Starting\nRealtime system did not load\n")
    with pytest.raises(HexciteError, match="said last: Realtime system"):
        session.read_report(Path("p.ngc"), tmp_path)


def test_lost_cycles_are_a_problem_of_a_run() -> None:
    problem = session.lost_cycles(REPORT | {"samples": 7, "lost": 3}, 20.0)
    assert re.match(r"3 of 10 cycles .*speed-up below 20", problem)
    assert session.lost_cycles(REPORT | {"samples": 7, "lost": 0}, 20.0) is None


@pytest.mark.parametrize("losses", [0, 1, 2, 3])
def test_a_run_that_loses_cycles_is_repeated_more_slowly_and_given_up_in_the_end(
    losses: int, write: Callable[[str], Path], hexapod_case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    speeds: list[float] = []

    def pretended(job: session.Job, speed: float, limit: float, override: float):
        speeds.append(speed)
        report = REPORT | {"samples": 4, "lost": int(len(speeds) <= losses), "started": 0, "ended": 4}
        return log_of([0, 2, 2, 0]), report

    for name, value in (
        ("linuxcnc_missing", lambda: None),
        ("preload_works", lambda: True),
        ("one_session", pretended),
    ):
        monkeypatch.setattr(session, name, value)
    program = write("G21 G90 G94\nG1 X1 F600\nM2\n")
    if losses < 3:
        assert run_text(program, hexapod_case).lines.tolist() == [0, 2, 2, 0]
    else:
        with pytest.raises(HexciteError, match=r"\b1 of 5 cycles .*speed-up below 5"):
            run_text(program, hexapod_case)
    assert speeds == [20.0, 10.0, 5.0][: losses + 1]
