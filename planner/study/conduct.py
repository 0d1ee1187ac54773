"""A study from its file to its answer: cells that are missing in its folder are computed, and the best are named."""

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from cases.errors import HexciteError, Interrupted
from cases.files import read_json, write_text
from cases.schema import Case
from cases.units import as_html
from planner.request import require_workers
from planner.study import ABOUT, DONE, PLANNED, Spec, check_study, keep, load_spec, open_study, read_rows, request_of
from planner.study.cluster import local_client, remote_client, require_dask, run_tasks
from planner.study.study_run import about_study, cells_of, failure, missing, work
from planner.study.summary import SettingsGroup, best_groups, groups, study_page


@dataclass(frozen=True, slots=True, repr=False)
class Study:
    """What a study folder holds; each cell is a plan, and runs of it where the study asks for them."""

    folder: Path
    cells: int  # number of all of them
    computed: int  # how many were computed now
    done: int
    failed: int
    rows: int  # rows of plans and of runs
    seconds: float  # time that it took now [s]
    overhead: float | None  # time x cores over the time in cells; None where none was computed
    best: dict[str, SettingsGroup]  # criterion -> its best settings

    def to_json(self) -> dict[str, Any]:
        """Entries for programs."""
        figures = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "folder"}
        best = {letter: {**group.settings, "score": group.best} for letter, group in self.best.items()}
        return {"study": str(self.folder), **figures, "best": best}

    def write_page(self) -> Path:
        """Writes the page of the folder, report.html, and returns its path."""
        page = study_page(read_json(self.folder / ABOUT, "hexcite study"), read_rows(self.folder))
        write_text(self.folder / "report.html", page)
        return self.folder / "report.html"

    def __repr__(self) -> str:
        """How many cells are done, and the best settings of each criterion."""
        best = [f"{letter}: {group.best:.4g} with {group.settings}" for letter, group in sorted(self.best.items())]
        return "\n".join([f"Study {self.folder}: {self.done} of {self.cells} cells done, {self.failed} failed", *best])

    _repr_html_ = as_html


def study(
    case: Case,
    spec: Spec | Path | str,
    folder: Path | str | None = None,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[str], None] = lambda remark: None,
) -> Study:
    """Plans, runs and identifies every cell of a grid of settings; a study that was stopped goes on.

        hx.study(hx.load_case("hexapod"), "paper", "study", workers=4)

    Args:
        case: machine and limits, and a simulated machine where the study executes its plans.
        spec: TOML file of the study, or a built-in one: paper, validation.
        folder: its folder, continued if it is there; named after case and study unless given.
        workers: processes on this computer; one a core unless given.
        scheduler: a running Dask scheduler instead, tcp://host:port.
        progress: shows a line at the start and at the end of each cell.

    Raises:
        HexciteError: the study cannot be understood, its folder is another's, Dask is missing or the cluster is lost.
        Interrupted: Ctrl-C; what is done is kept.
    """
    asked = spec if isinstance(spec, Spec) else load_spec(str(spec))
    case.need_motion("a study")
    if asked.execute is not None:
        case.need_simulation("a study that executes its plans")
    if scheduler is not None and workers is not None:
        raise HexciteError("--workers counts processes on this computer, --scheduler names another cluster; drop one")
    require_workers(workers)
    require_dask()
    place = Path(f"{case.name}-{asked.name}-study") if folder is None else Path(folder)
    cells = cells_of(asked, case)
    about = about_study(asked, case, len(cells))
    check_study(place, about)
    open_cells = missing(cells, asked, place)
    disturbed = asked.execute is not None and asked.execute.disturbed
    start, busy, computed, threads = time.perf_counter(), 0.0, 0, workers or os.cpu_count() or 1
    if open_cells or not (place / ABOUT).exists():
        context = local_client(workers, asked.cells.memory_GB) if scheduler is None else remote_client(scheduler)
        try:
            with context as client:
                start = time.perf_counter()
                threads = sum(client.nthreads().values())
                open_study(place, about)
                progress(f"{len(open_cells)} of {len(cells)} cells to do, in {place}")
                tasks = (
                    (key, partial(work, case, request_of(cells[key]), seeds, disturbed))
                    for key, seeds in open_cells.items()
                )
                for key, answer, cell_s in run_tasks(client, tasks, asked.cells.time_limit_s):
                    failed, seeds = isinstance(answer, HexciteError), open_cells[key]
                    shared = {**cells[key], "cell": key, "case_hash": case.hash, "version": version("hexcite")}
                    rows = [shared | row for row in ([failure(answer)] if failed else answer)]
                    keep(place, f"{key}-{seeds[0]}" if seeds else key, rows)  # not from 0: more noise extends a study
                    computed, busy = computed + 1, busy + cell_s
                    progress(f"{computed} of {len(open_cells)} cells{', the last one failed' if failed else ''}")
        except Interrupted:
            raise Interrupted(f"what is done is kept in {place}, the same command goes on") from None
    seconds = time.perf_counter() - start
    table = read_rows(place)
    statuses = zip(table["status"].to_pylist(), table["noise_seed"].to_pylist(), strict=True)
    plans = [status for status, seed in statuses if seed == PLANNED]
    done = plans.count(DONE)
    return Study(
        folder=place,
        cells=len(cells),
        computed=computed,
        done=done,
        failed=len(plans) - done,
        rows=len(table),
        seconds=seconds,
        overhead=seconds * threads / busy if busy else None,
        best=best_groups(groups(table)),
    )
