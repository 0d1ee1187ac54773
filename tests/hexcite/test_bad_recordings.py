"""Recordings that cannot be used, through the command line: file, row or column, value and remedy in one line."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import hexcite as hx
from tests.helpers import tells
from tests.hexcite.command_line import call, refused

Rows = list[list[str]]


@pytest.fixture
def rows(chain: dict[str, Any], shared: Path) -> Rows:
    """Header and the first 700 rows of a good recording."""
    lines = (shared / "recording" / "recording.csv").read_text().splitlines()[:701]
    return [line.replace('"', "").split(",") for line in lines]


def column(rows: Rows, name: str) -> int:
    return rows[0].index(name)


def without(name: str) -> Callable[[Rows], Rows]:
    return lambda rows: [[v for k, v in enumerate(row) if k != column(rows, name)] for row in rows]


def with_value(line: int, name: str, value: str) -> Callable[[Rows], Rows]:
    def change(rows: Rows) -> Rows:
        rows[line - 1][column(rows, name)] = value
        return rows

    return change


def backwards(rows: Rows) -> Rows:
    k = column(rows, "t_s")
    rows[400][k] = rows[398][k]
    return rows


def constant(rows: Rows) -> Rows:
    first = [column(rows, "l1_mm") + k for k in range(6)]
    return [rows[0], *([rows[1][k] if k in first else v for k, v in enumerate(row)] for row in rows[1:])]


def all_on(rows: Rows) -> Rows:
    k = column(rows, "trigger")
    return [rows[0], *([*row[:k], "1", *row[k + 1 :]] for row in rows[1:])]


def emptied(rows: Rows, name: str) -> Rows:
    k = column(rows, name)
    return [rows[0], *([*row[:k], "", *row[k + 1 :]] for row in rows[1:])]


DAMAGE: dict[str, tuple[Callable[[Rows], Rows], tuple[str, ...]]] = {
    "a missing column": (without("l3_mm"), ("l3_mm", "is missing", "add it or map its name")),
    "no forces": (lambda r: [row[:7] for row in r], ("f1_N", "no forces")),
    "text in a number": (with_value(17, "f2_N", "strong"), ("line 17", "f2_N", "'strong'", "correct")),
    "nothing in a column": (lambda r: emptied(r, "f2_N"), ("line 2", "f2_N", "more than 30 %")),
    "a decimal comma": (with_value(17, "f2_N", '"1,5"'), ("line 17", "f2_N", "'1,5'")),
    "time that runs backwards": (backwards, ("line 401", "t_s", "must increase")),
    "a rate that changes": (lambda r: r[:400] + r[400::2], ("t_s", "step of 2 ms", "at one rate")),
    "a row that is too short": (
        lambda r: [*r[:50], r[50][:5], *r[51:]],
        ("line 51", "expected 14 columns, got 5", "correct"),
    ),
    "no rows": (lambda r: r[:1], ("no rows", "record or export")),
    "a constant pose": (lambda r: constant(all_on(r)), ("pose is constant", "record the excitation")),
    "too few samples for the filter": (lambda r: all_on(r)[:150], ("149 samples", "filter")),
    "fewer standstills than unknowns": (lambda r: without("t_s")(r)[:3], ("not determined|rank|fewer|unknowns",)),
}


def at_length(what: str) -> object:
    """Of a run that does not move all causes are looked for."""
    return pytest.param(what, marks=pytest.mark.repeats) if what == "a constant pose" else what


@pytest.mark.parametrize("what", [at_length(what) for what in DAMAGE])
def test_a_damaged_recording_is_refused(what: str, rows: Rows, tmp_path: Path):
    damage, words = DAMAGE[what]
    file = tmp_path / "run.csv"
    file.write_text("".join(",".join(row) + "\n" for row in damage(rows)))
    line = refused("identify", file, "--case", "hexapod", "-o", tmp_path / "result", "--json")
    assert str(file) in line
    for word in words:
        assert any(w in line for w in word.split("|")), line
    assert not (tmp_path / "result").exists()


@pytest.mark.repeats
def test_a_run_with_gaps_and_nothing_in_some_rows_is_identified(shared: Path, chain: dict[str, Any], tmp_path: Path):
    """What is left of the run is enough: the answer says which rows it is without, and how much of the motion."""
    lines = (shared / "recording" / "recording.csv").read_text().splitlines()
    middle = len(lines) // 2
    lines[middle : middle + 20] = [line.rsplit(",", 3)[0] + ",,nan,1" for line in lines[middle : middle + 20]]
    del lines[middle + 1000 : middle + 1100]
    file = tmp_path / "run.csv"
    file.write_text("\n".join(lines) + "\n")
    found = call("identify", file, "--case", "hexapod", "-o", tmp_path / "result", "--json").json()
    warnings = " / ".join(found["warnings"])
    assert tells(warnings, f"lines {middle + 1} to {middle + 20}: ", "f5_N, f6_N", "left out")
    assert tells(warnings, f"line {middle + 1000}: 100 samples", "no filter")
    assert tells(warnings, " %", "left out")
    sound = chain["identify"]["parameters"]
    for name, value in found["parameters"].items():
        assert abs(value["value"] - sound[name]["value"]) < 3.0 * sound[name]["std_robust"], name


@pytest.mark.parametrize("content", [b"", b"\x00\x01\x02" * 50, b"\xff\xfe\x00a", b"just words\n", b"\n\n\n"])
def test_a_file_that_is_no_recording_is_refused(content: bytes, tmp_path: Path):
    (tmp_path / "run.csv").write_bytes(content)
    assert "run.csv" in refused("identify", tmp_path / "run.csv", "--case", "hexapod", "-o", tmp_path / "result")


def test_a_folder_without_a_recording_is_refused(tmp_path: Path):
    assert "recording.csv" in refused("identify", tmp_path, "--case", "hexapod", "-o", tmp_path / "result")


@pytest.mark.parametrize("command", ["identify", "load"])
def test_a_recording_that_is_not_there_is_named_as_such(command: str, tmp_path: Path):
    if command == "identify":
        line = refused("identify", tmp_path / "absent", "-o", tmp_path / "result")
    else:
        with pytest.raises(hx.HexciteError) as caught:
            hx.Recording.load(tmp_path / "absent")
        line = str(caught.value)
    assert "absent" in line
    assert "No such file" in line
