"""Tables in a terminal fold words where it is narrow, never numbers; in a pipe every row is one line."""

import numpy as np
import pytest

from cases.schema import Case
from identification.limit import Limit, LimitCheck, LimitKind, LimitReport, OwnMove, Status
from identification.limit_proof import prove
from identification.motion import StandingPoses
from planner.cli.console import LIMIT_COLUMNS, limit_rows, print_table
from planner.plans import Plan

LIMITS = (
    LimitCheck(Limit(LimitKind.STRUT_ACCELERATION, move=OwnMove.WAY_HOME), "from anywhere, at most", -450.6, -10.0,
               "m/s^2", 45.06, 0.0, Status.ENFORCED, binding=False),
    LimitCheck(Limit(LimitKind.SENSOR_FORCE), "", 1445.0, 4000.0, "N", 0.36125, 0.0, Status.PROVEN),
)  # fmt: skip


def test_a_narrow_terminal_folds_words_only(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")  # rich takes this for a terminal
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.setenv("COLUMNS", "80")
    print_table("Limits", LIMIT_COLUMNS, limit_rows(LIMITS))
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    assert any("~-450.6" in line and "~more than" in line for line in lines)
    assert any("anywhere" in line and "-450.6" not in line for line in lines)


def test_a_pipe_gets_whole_rows(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    monkeypatch.setenv("COLUMNS", "80")
    print_table("Limits", LIMIT_COLUMNS, limit_rows(LIMITS))
    lines = capsys.readouterr().out.splitlines()
    assert sum("way home (from anywhere, at most)" in line and "enforced by controller" in line for line in lines) == 1
    assert any("36.12 %" in line and line.strip().endswith("proven") for line in lines)


def test_a_limit_that_is_exceeded_reads_so_and_strut_lengths_show_both_bounds() -> None:
    """What is used of a strut length is the distance from the middle of both bounds, so both stand there."""
    length, bounds = Limit(LimitKind.STRUT_LENGTH), (650.0, 1460.0)
    strut = LimitCheck(length, "strut 6", 1463.0, 1460.0, "mm", 1.0072, 0.0, Status.PROVEN, bounds=bounds)
    (row,) = limit_rows((strut,))
    assert row == ["strut length (strut 6)", "1463", "650 to 1460", "mm", "100.72 %", "EXCEEDED"]
    middle, half = (650.0 + 1460.0) / 2, (1460.0 - 650.0) / 2
    assert abs(1463.0 - middle) / half == pytest.approx(strut.ratio, abs=1e-3)


def test_a_limit_to_both_sides_reads_so_wherever_it_was_approached(hexapod_case: Case) -> None:
    home = hexapod_case.machine.home.vector
    for side in (-1.0, 1.0):
        away = home + side * np.r_[0.2, np.zeros(5)]
        report = prove(StandingPoses(np.array([home, away])), hexapod_case, 1.0)
        (row,) = (row for row in limit_rows(report.checks) if row[0] == "position (x)")
        assert row[1:4] == [f"{side * 200:g}", "±250", "mm"]
        assert LimitReport.of_json(report.to_json()) == report


def test_predicted_deviations_are_named_in_words(saved_plan: Plan) -> None:
    rows = {words: (std, unit) for words, std, unit in saved_plan.deviation_rows()}
    assert float(rows["mass (m)"][0]) == pytest.approx(saved_plan.predicted_std["m"], rel=0.06)
    assert float(rows["centre of gravity z (zC)"][0]) == pytest.approx(saved_plan.predicted_std["zC"] * 1e3, rel=0.06)
    assert rows["centre of gravity z (zC)"][1] == "mm"
