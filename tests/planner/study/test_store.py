"""Rows of a study: none is lost or counted twice, whenever the process is killed, and folders do not mix."""

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest

from cases.basis import KEPT
from cases.errors import FileProblem
from planner.study import store
from planner.study.store import ABOUT, JOURNAL, ROWS, opened, read_rows
from tests.helpers import one_line

SCHEMA = pa.schema([("cell", pa.string()), ("noise_seed", pa.int64()), ("score", pa.float64())])
MINE = {"name": "mine", "case": "hexapod", "case_hash": "0123", KEPT: {"nominal.mass_kg": 33.0}}


def row(cell: str, seed: int = -1, score: float | None = 1.0) -> dict[str, Any]:
    return {"cell": cell, "noise_seed": seed, "score": score}


def held(folder: Path) -> list[tuple[str, int]]:
    table = read_rows(folder, SCHEMA)
    return sorted(zip(table["cell"].to_pylist(), table["noise_seed"].to_pylist(), strict=True))


def test_rows_are_read_back(tmp_path: Path) -> None:
    with opened(tmp_path / "s", SCHEMA, MINE) as study:
        study.add([row("a"), row("a", 0, None)])
        assert held(tmp_path / "s") == [("a", -1), ("a", 0)]  # at once, from the journal
        study.add([row("b")])
    table = read_rows(tmp_path / "s", SCHEMA)
    assert table.schema == SCHEMA
    assert table["score"].to_pylist() == [1.0, None, 1.0]
    assert (tmp_path / "s" / JOURNAL).read_text() == ""  # moved to Parquet


def test_many_rows_are_moved_to_parquet_on_the_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "COMPACT", 10)
    with opened(tmp_path, SCHEMA, MINE) as study:
        for k in range(25):
            study.add([row(str(k))])
        assert len(list((tmp_path / ROWS).glob("*.parquet"))) == 2
        assert len(held(tmp_path)) == 25


WRITER = """
import os, signal, sys
from pathlib import Path
import pyarrow as pa
from cases.basis import KEPT
from planner.study.store import opened
schema = pa.schema([("cell", pa.string()), ("noise_seed", pa.int64()), ("score", pa.float64())])
with opened(Path(sys.argv[1]), schema, ABOUT_IT) as study:
    for k in range(5):
        study.add([{"cell": str(k), "noise_seed": -1, "score": 1.0}])
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_study_keeps_every_row_and_goes_on(tmp_path: Path) -> None:
    killed = subprocess.run(
        [sys.executable, "-c", WRITER.replace("ABOUT_IT", repr(MINE)), str(tmp_path / "s")], timeout=300
    )
    assert killed.returncode == -signal.SIGKILL
    with (tmp_path / "s" / JOURNAL).open("a") as journal:
        journal.write('[{"cell": "half')  # what a death in the middle of a line leaves
    with opened(tmp_path / "s", SCHEMA, MINE) as study:
        study.add([row("5")])
    assert held(tmp_path / "s") == [(str(k), -1) for k in range(6)]


def test_a_death_between_parquet_and_journal_counts_rows_once(tmp_path: Path) -> None:
    with opened(tmp_path, SCHEMA, MINE) as study:
        study.add([row("a"), row("a", 0)])
        journal = (tmp_path / JOURNAL).read_text()
        study.compact()
        (tmp_path / JOURNAL).write_text(journal)
    assert held(tmp_path) == [("a", -1), ("a", 0)]


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"name": "other"}, "holds another study"),
        ({KEPT: {"nominal.mass_kg": 34.0}}, "of case hexapod before nominal.mass_kg was 33, is 34"),
    ],
)
def test_studies_do_not_mix(other: dict[str, Any], words: str, tmp_path: Path) -> None:
    with opened(tmp_path / "s", SCHEMA, MINE) as study:
        study.add([row("a")])
    with (
        pytest.raises(FileProblem, match=words) as caught,
        opened(tmp_path / "s", SCHEMA, MINE | other),
    ):
        pass
    assert one_line(caught.value).startswith(str(tmp_path / "s"))
    assert held(tmp_path / "s") == [("a", -1)]


def test_a_study_goes_on_whatever_of_the_case_it_does_not_use_has_changed(tmp_path: Path) -> None:
    for case_hash in ("0123", "4567"):
        with opened(tmp_path / "s", SCHEMA, MINE | {"case_hash": case_hash}) as study:
            study.add([row(case_hash)])
    assert held(tmp_path / "s") == [("0123", -1), ("4567", -1)]


def test_a_folder_of_somebody_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(FileProblem, match="is not a study of hexcite's"), opened(tmp_path, SCHEMA, MINE):
        pass
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


def test_two_processes_do_not_write_to_one_study(tmp_path: Path) -> None:
    with (
        opened(tmp_path, SCHEMA, MINE),
        pytest.raises(FileProblem, match="another process is at work"),
        opened(tmp_path, SCHEMA, MINE),
    ):
        pass


def test_a_damaged_file_is_named(tmp_path: Path) -> None:
    with opened(tmp_path, SCHEMA, MINE) as study:
        study.add([row("a")])
    (file,) = (tmp_path / ROWS).glob("*.parquet")
    file.write_bytes(file.read_bytes()[:100])
    with pytest.raises(FileProblem, match="is damaged") as caught:
        read_rows(tmp_path, SCHEMA)
    assert one_line(caught.value).startswith(str(file))


def test_what_the_study_is_stands_in_its_folder(tmp_path: Path) -> None:
    with opened(tmp_path, SCHEMA, MINE):
        pass
    assert json.loads((tmp_path / ABOUT).read_text()) == MINE
