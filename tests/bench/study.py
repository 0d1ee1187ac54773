"""What a study costs beside its cells: overhead, memory, and the time to read and draw many rows."""

import operator
import os
import resource
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from cases.schema import load_case
from hexcite.studies.cell_rows import DONE, PLANNED, file_of, keep, read_rows
from hexcite.studies.cluster import local_client, run_tasks
from hexcite.studies.conduct import Study, study, study_page
from hexcite.studies.spec import Cells, Grid, Spec

CELLS = 200
ROWS, PART = 100_000, 100
TASKS = 2_000


def study_rows() -> list[list[str]]:
    """Rows of the table of figures: what, measured, wanted."""
    return [*_overhead(), *_many_rows()]


def _overhead() -> list[list[str]]:
    case = load_case("hexapod")
    grid = Grid(order=[2], duration_s=[3.0], criterion=["D", "A"], seed=list(range(CELLS // 2)))
    spec = Spec(schema_version=1, name="bench", grid=grid, cells=Cells(time_limit_s=120.0))
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        rows = study(case, spec, Path(folder) / "study").rows
        seconds, threads = time.perf_counter() - began, os.cpu_count() or 1
    with local_client(None, 2.0) as client:
        began = time.perf_counter()
        count = sum(1 for _ in run_tasks(client, ((str(k), partial(operator.neg, k)) for k in range(TASKS)), 60.0))
        task = (time.perf_counter() - began) / count
    overhead = seconds * threads / pc.sum(rows["seconds"]).as_py()
    return [
        [f"study of {CELLS} cells: time x cores / time in cells", f"{overhead:.3f}", "1.15 or less"],
        ["cores busy with cells", f"{100 / overhead:.0f} %", "over 90 %"],
        ["overhead of one task", f"{task * 1e3:.1f} ms", "-"],
        ["memory of client and scheduler at most", f"{_memory():.0f} MB", "-"],
    ]


def _memory() -> float:
    """Largest resident memory of this process [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _many_rows() -> list[list[str]]:
    """Made-up rows of the right shape: only their number matters here."""

    draw = np.random.default_rng(0)
    case = load_case("hexapod")
    spec = Spec(schema_version=1, name="many", grid=Grid())
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "study"
        rows = [
            {
                "cell": str(k), "noise_seed": PLANNED, "family": "fourier", "criterion": "ADKN"[k % 4],
                "model": 9, "duration_s": 12.0, "order": 2 + k % 6,
                "period_s": 3.0 + k % 5, "seed": k, "status": DONE, "converged": True, "iterations": 100,
                "score": float(draw.normal()), "seconds": 2.0,
            }
            for k in range(ROWS)
        ]  # fmt: skip
        files = [file_of(folder, str(part)) for part in range(0, ROWS, PART)]
        for part, file in zip(range(0, ROWS, PART), files, strict=True):
            keep(file, rows[part : part + PART])
        began = time.perf_counter()
        table: pa.Table = read_rows(files)
        page = study_page(Study(Path("study"), case, spec, ROWS, ROWS, table))
        seconds = time.perf_counter() - began
    assert len(table) == ROWS
    return [[f"{ROWS} rows read and drawn ({len(page) / 1e6:.1f} MB page)", f"{seconds:.1f} s", "10 s or less"]]
