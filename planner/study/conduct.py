"""A study from its file to its answer: cells that are missing in its folder are computed, and the best are named."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases.errors import FileProblem, HexciteError, Interrupted
from cases.files import check_folder, json_text, read_json, write_text
from cases.schema import Case
from cases.units import as_html
from planner.request import require_workers
from planner.study import Spec, cells_of, load_spec, request_of
from planner.study.cluster import local_client, remote_client, require_dask, run_tasks
from planner.study.rows import FAILED, ROWS, failure, file_of, keep, read_rows, work
from planner.study.summary import SettingsGroup, best_groups, groups, study_page

if TYPE_CHECKING:
    import pyarrow as pa

ABOUT = "study.json"


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Study:
    """What a study folder holds; each cell is a plan, and runs of it where the study asks for them."""

    folder: Path
    case: Case
    spec: Spec
    cells: int  # number of all of them
    computed: int  # how many were computed now
    rows: "pa.Table"  # rows of plans and of runs, see `planner.study.rows.schema`

    @property
    def best(self) -> dict[str, SettingsGroup]:
        """The best settings of each criterion."""
        return best_groups(groups(self.rows))

    @property
    def failed(self) -> int:
        """How many cells have a plan or a run that was refused."""
        import pyarrow.compute as pc

        return len(self.rows.filter(pc.field("status") == FAILED)["cell"].unique())

    @property
    def done(self) -> int:
        """How many cells have their plan, and their runs."""
        return len(self.rows["cell"].unique()) - self.failed

    def to_json(self) -> dict[str, Any]:
        """Entries for programs."""
        counts = {name: getattr(self, name) for name in ("cells", "computed", "done", "failed")}
        best = {letter: {**group.settings, "score": group.best} for letter, group in self.best.items()}
        return {"study": str(self.folder), **counts, "best": best}

    def write_page(self) -> Path:
        """Writes the page of the folder, report.html, and returns its path."""
        write_text(self.folder / "report.html", study_page(self.spec, self.case, self.cells, self.rows))
        return self.folder / "report.html"

    def __repr__(self) -> str:
        """How many cells are done, and the best settings of each criterion."""
        best = [f"{letter}: {group.best:.4g} with {group.settings}" for letter, group in self.best.items()]
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
        HexciteError: the study cannot be understood, its folder is another's, Dask is missing.
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
    _require_own(place, asked, case)
    missing = [cell for cell in cells if not file_of(place, cell).exists()]
    computed = 0
    if missing:
        context = local_client(workers, asked.cells.memory_GB) if scheduler is None else remote_client(scheduler)
        try:
            with context as client:
                shared = {"case_hash": case.hash, "version": version("hexcite")}
                about = {"schema_version": 1, "name": asked.name, "case": case.name, "case_file": case.origin}
                about |= {**shared, "cells": len(cells), "spec": asked.model_dump(mode="json")}
                write_text(place / ABOUT, json_text(about))
                progress(f"{len(missing)} of {len(cells)} cells to do, in {place}")
                tasks = ((cell, partial(work, case, request_of(cells[cell]), asked.execute)) for cell in missing)
                for cell, answer in run_tasks(client, tasks, asked.cells.time_limit_s):
                    rows = [failure(answer)] if isinstance(answer, HexciteError) else answer
                    keep(file_of(place, cell), [{**cells[cell], "cell": cell, **shared, **row} for row in rows])
                    computed += 1
                    progress(f"{computed} of {len(missing)} cells")
        except Interrupted:
            raise Interrupted(f"what is done is kept in {place}, the same command goes on") from None
    return Study(place, case, asked, len(cells), computed, read_rows(file_of(place, cell) for cell in cells))


def _require_own(folder: Path, spec: Spec, case: Case) -> None:
    """Refuses, before the work starts, a folder of another study or of something else, or that cannot be written."""
    if not (folder / ABOUT).exists():
        check_folder(folder, ("a study", frozenset({ROWS})), overwrite=True)
        return
    record = read_json(folder / ABOUT, "hexcite study")
    if (record.get("name"), record.get("case")) != (spec.name, case.name):
        words = f"holds study {record.get('name')} of case {record.get('case')}, not {spec.name} of {case.name}"
        raise FileProblem(folder, words, "choose another place with -o")
