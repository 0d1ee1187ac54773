"""`hexcite identify` of files that are too long to be read at once."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from identification.formats import reading
from identification.long import streaming
from tests.identification.long.long_runs import written
from tests.planner.command_line import call


def test_long_files_are_evaluated_in_blocks_from_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = written(tmp_path)
    words = ("identify", file, "--case", "hexapod", "--json")
    short = call(*words, "-o", tmp_path / "short").json()
    monkeypatch.setattr(streaming, "LONG", 1000)
    monkeypatch.setattr(reading, "MOST_NUMBERS", 1000)  # what reads it at once now fails
    long = call(*words, "-o", tmp_path / "long").json()
    assert long["linear"]["values"] == pytest.approx(short["linear"]["values"], rel=1e-5)
    assert long["warnings"] == short["warnings"] == []


@pytest.mark.parametrize(
    "wish", [("--fix", "m=31.9kg", "--drop", "k2", "--drop", "k3"), ("--symmetric", "--terms", "K2")]
)
def test_what_is_known_or_left_out_is_evaluated_in_blocks_from_the_command_line(
    wish: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("identify", written(tmp_path), "--case", "hexapod", *wish, "--json")
    short = call(*words, "-o", tmp_path / "short").json()
    monkeypatch.setattr(streaming, "LONG", 1000)
    monkeypatch.setattr(reading, "MOST_NUMBERS", 1000)
    long = call(*words, "-o", tmp_path / "long").json()
    assert long["linear"]["values"] == pytest.approx(short["linear"]["values"], rel=1e-5)
    assert (long["known"], long["dropped"], long["error_terms"]) == (
        short["known"], short["dropped"], short["error_terms"]
    )  # fmt: skip


def test_what_needs_the_whole_run_says_so_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "LONG", 1000)
    monkeypatch.setattr(reading, "MOST_NUMBERS", 1000)
    words = ("identify", written(tmp_path), "--case", "hexapod", "--estimator", "robust", "-o", tmp_path / "r")
    failed = call(*words)
    assert "holds too much to be read at once" in failed.refusal()
    assert "--estimator gauss-markov, without --prior" in failed.refusal()


def test_several_files_of_one_run_that_are_too_long_together_are_refused_with_the_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Blocks need struts and forces side by side; neither file alone is too long."""
    table = pq.read_table(written(tmp_path))
    struts, forces = tmp_path / "struts.parquet", tmp_path / "forces.parquet"
    pq.write_table(table.drop_columns([f"f{k}_N" for k in range(1, 7)]), struts)
    pq.write_table(table.select(["t_s", *(f"f{k}_N" for k in range(1, 7))]), forces)
    monkeypatch.setattr(streaming, "LONG", 1000)
    monkeypatch.setattr(reading, "MOST_NUMBERS", 35_000)
    refused = call("identify", struts, forces, "--case", "hexapod", "-o", tmp_path / "r").refusal()
    assert "forces.parquet and the files before it hold too much to be read at once" in refused
    assert "put time, struts and forces into one file, which may be of any length" in refused
    assert not (tmp_path / "r").exists()


def test_a_long_run_that_is_not_compared_with_its_program_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    written(tmp_path).rename(folder / "recording.parquet")
    (folder / "recording.json").write_text(json.dumps({"plan_hash": "0123456789abcdef", "case": "hexapod"}))
    words = ("identify", folder, "--case", "hexapod", "--json", "-o", tmp_path / "r")
    monkeypatch.setattr(streaming, "LONG", 1000)
    (note,) = [n for n in call(*words).json()["notes"] if "program" in n]
    assert "--plan compares a run that fits into memory" in note
