"""Tables in a terminal fold words where it is narrow, never numbers; in a pipe every row is one line."""

import pytest

from planner.cli.console import LIMIT_COLUMNS, limit_rows, print_table

LIMITS = {
    "strut": {"at": "strut acceleration, way home (from anywhere, at most)", "worst": -450.6, "limit": -10.0,
              "unit": "m/s^2", "ratio": 45.06, "status": "enforced by controller"},
    "force": {"at": "sensor force", "worst": 1445.0, "limit": 4000.0, "unit": "N", "ratio": 0.36125,
              "status": "proven"},
}  # fmt: skip


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
    strut = {"at": "strut length (strut 6)", "worst": 1463.0, "limit": 1460.0, "bounds": [650.0, 1460.0], "unit": "mm",
             "ratio": 1.0072, "status": "proven"}  # fmt: skip
    (row,) = limit_rows({"strut length": strut})
    assert row == ["strut length (strut 6)", "1463", "650 to 1460", "mm", "100.72 %", "EXCEEDED"]
    middle, half = (650.0 + 1460.0) / 2, (1460.0 - 650.0) / 2
    assert abs(1463.0 - middle) / half == pytest.approx(strut["ratio"], abs=1e-3)
