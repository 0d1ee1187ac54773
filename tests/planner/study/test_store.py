"""Rows of a study: none is lost or counted twice, whenever the process is killed, and folders do not mix."""

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from cases.basis import KEPT
from cases.errors import FileProblem
from planner.study import ABOUT, ROWS, check_study, keep, open_study, read_rows, schema
from tests.helpers import one_line

MINE = {"name": "mine", "case": "hexapod", "case_hash": "0123", KEPT: {"nominal.mass_kg": 33.0}}


def row(cell: str, seed: int = -1, score: float | None = 1.0) -> dict[str, Any]:
    return {"cell": cell, "noise_seed": seed, "score": score}


def held(folder: Path) -> list[tuple[str, int]]:
    table = read_rows(folder)
    return sorted(zip(table["cell"].to_pylist(), table["noise_seed"].to_pylist(), strict=True))


def test_rows_are_read_back(tmp_path: Path) -> None:
    assert len(read_rows(tmp_path)) == 0
    open_study(tmp_path / "s", MINE)
    keep(tmp_path / "s", "a", [row("a"), row("a", 0, None)])
    assert held(tmp_path / "s") == [("a", -1), ("a", 0)]
    keep(tmp_path / "s", "b", [row("b")])
    table = read_rows(tmp_path / "s")
    assert table.schema == schema()
    assert table["score"].to_pylist() == [1.0, None, 1.0]


WRITER = """
import os, signal, sys
from pathlib import Path
import pyarrow.parquet as pq
from planner.study import keep
for k in range(5):
    keep(Path(sys.argv[1]), str(k), [{"cell": str(k), "noise_seed": -1, "score": 1.0}])
write = pq.write_table
def half(table, part):
    write(table, part)
    part.write_bytes(part.read_bytes()[:100])
    os.kill(os.getpid(), signal.SIGKILL)
pq.write_table = half
keep(Path(sys.argv[1]), "5", [{"cell": "5", "noise_seed": -1, "score": 1.0}])
"""


def test_a_killed_study_keeps_every_finished_cell_and_goes_on(tmp_path: Path) -> None:
    open_study(tmp_path / "s", MINE)
    killed = subprocess.run([sys.executable, "-c", WRITER, str(tmp_path / "s")], timeout=300)
    assert killed.returncode == -signal.SIGKILL
    assert held(tmp_path / "s") == [(str(k), -1) for k in range(5)]
    open_study(tmp_path / "s", MINE)
    keep(tmp_path / "s", "5", [row("5")])
    assert held(tmp_path / "s") == [(str(k), -1) for k in range(6)]


def test_a_cell_with_more_seeds_of_the_noise_counts_its_plan_once(tmp_path: Path) -> None:
    open_study(tmp_path, MINE)
    keep(tmp_path, "a-0", [row("a"), row("a", 0)])
    keep(tmp_path, "a-1", [row("a"), row("a", 1)])
    assert held(tmp_path) == [("a", -1), ("a", 0), ("a", 1)]


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"name": "other"}, "holds another study"),
        ({KEPT: {"nominal.mass_kg": 34.0}}, "of case hexapod before nominal.mass_kg was 33, is 34"),
    ],
)
def test_studies_do_not_mix(other: dict[str, Any], words: str, tmp_path: Path) -> None:
    open_study(tmp_path / "s", MINE)
    keep(tmp_path / "s", "a", [row("a")])
    with pytest.raises(FileProblem, match=words) as caught:
        check_study(tmp_path / "s", MINE | other)
    assert one_line(caught.value).startswith(str(tmp_path / "s"))
    assert held(tmp_path / "s") == [("a", -1)]


def test_a_study_goes_on_whatever_of_the_case_it_does_not_use_has_changed(tmp_path: Path) -> None:
    for case_hash in ("0123", "4567"):
        about = MINE | {"case_hash": case_hash}
        check_study(tmp_path / "s", about)
        open_study(tmp_path / "s", about)
        keep(tmp_path / "s", case_hash, [row(case_hash)])
    assert held(tmp_path / "s") == [("0123", -1), ("4567", -1)]


def test_a_folder_of_somebody_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(FileProblem, match="not a study"):
        check_study(tmp_path, MINE)
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_damaged_file_is_named(tmp_path: Path) -> None:
    open_study(tmp_path, MINE)
    keep(tmp_path, "a", [row("a")])
    (file,) = (tmp_path / ROWS).glob("*.parquet")
    file.write_bytes(file.read_bytes()[:100])
    with pytest.raises(FileProblem, match="is damaged") as caught:
        read_rows(tmp_path)
    assert one_line(caught.value).startswith(str(file))


def test_what_the_study_is_stands_in_its_folder(tmp_path: Path) -> None:
    open_study(tmp_path, MINE)
    assert json.loads((tmp_path / ABOUT).read_text()) == MINE
