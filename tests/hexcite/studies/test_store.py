"""Rows of a study: none is lost or counted twice, whenever the process is killed, and folders do not mix."""

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from cases.base.errors import FileProblem
from cases.schema import Case
from hexcite.studies import conduct
from hexcite.studies.cell_rows import file_of, keep, read_rows, schema
from hexcite.studies.spec import Spec
from tests.helpers import refused_at


def row(cell: str, seed: int = -1, score: float | None = 1.0) -> dict[str, Any]:
    return {"cell": cell, "noise_seed": seed, "score": score}


def kept(folder: Path, *cells: str) -> list[tuple[str, int]]:
    table = read_rows(file_of(folder, cell) for cell in cells)
    return list(zip(table["cell"].to_pylist(), table["noise_seed"].to_pylist(), strict=True))


def test_rows_are_read_back(tmp_path: Path) -> None:
    assert kept(tmp_path, "a") == []
    keep(file_of(tmp_path, "a"), [row("a"), row("a", 0, None)])
    assert kept(tmp_path, "a", "b") == [("a", -1), ("a", 0)]
    keep(file_of(tmp_path, "b"), [row("b")])
    table = read_rows(file_of(tmp_path, cell) for cell in "ab")
    assert table.schema == schema()
    assert table["score"].to_pylist() == [1.0, None, 1.0]


WRITER = """
import os, signal, sys
from pathlib import Path
import pyarrow.parquet as pq
from hexcite.studies.cell_rows import file_of, keep
folder = Path(sys.argv[1])
for k in range(5):
    keep(file_of(folder, str(k)), [{"cell": str(k), "noise_seed": -1, "score": 1.0}])
write = pq.write_table
def half(table, part):
    write(table, part)
    part.write_bytes(part.read_bytes()[:100])
    os.kill(os.getpid(), signal.SIGKILL)
pq.write_table = half
keep(file_of(folder, "5"), [{"cell": "5", "noise_seed": -1, "score": 1.0}])
"""


def test_a_killed_study_keeps_every_finished_cell_and_goes_on(tmp_path: Path) -> None:
    killed = subprocess.run([sys.executable, "-c", WRITER, str(tmp_path)], timeout=300)
    assert killed.returncode == -signal.SIGKILL
    assert kept(tmp_path, *"012345") == [(str(k), -1) for k in range(5)]
    keep(file_of(tmp_path, "5"), [row("5")])
    assert kept(tmp_path, *"012345") == [(str(k), -1) for k in range(6)]


@pytest.mark.parametrize("other", [{"name": "other", "case": "hexapod"}, {"name": "mine", "case": "mill"}])
def test_studies_do_not_mix(other: dict[str, str], tmp_path: Path, hexapod_case: Case) -> None:
    (tmp_path / "study.json").write_text(json.dumps(other))
    with refused_at(tmp_path, r"holds study .*, not mine of hexapod", FileProblem):
        conduct.study(hexapod_case, Spec(schema_version=1, name="mine"), tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["study.json"]


def test_a_folder_of_somebody_else_is_left_alone(tmp_path: Path, hexapod_case: Case) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(FileProblem, match="not a study"):
        conduct.study(hexapod_case, Spec(schema_version=1, name="mine"), tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_damaged_file_is_named(tmp_path: Path) -> None:
    file = file_of(tmp_path, "a")
    keep(file, [row("a")])
    file.write_bytes(file.read_bytes()[:100])
    with refused_at(file, "is damaged", FileProblem):
        read_rows([file])
