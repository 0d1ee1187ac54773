"""A study from its file to its answer: cells that are missing in its folder are computed, and the best are named."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from cases.base.atomic import write_text
from cases.base.errors import WITH_OUTPUT, Code, FileProblem, HexciteError, Interrupted, option
from cases.base.file_reading import read_json
from cases.base.folder_kinds import FolderKind
from cases.base.options import default_of, documented
from cases.base.output_places import check_folder
from cases.base.text_formats import json_text
from cases.base.units import as_html
from cases.schema import Case
from hexcite.options import Certificates, Insecure, OneProcess, Scheduler
from hexcite.reports.drawing.chart import Axis, Box, Chart
from hexcite.reports.page import Head, note, page, section, table
from hexcite.studies.cell_rows import FAILED, ROWS, failure, file_of, keep, read_rows, work
from hexcite.studies.cluster import local_client, remote_client, require_dask, run_one_by_one, run_tasks
from hexcite.studies.spec import SETTINGS, CellSettings, Spec, cells_of, command_of, load_spec, request_of
from identification.texts import aligned
from planner.options import Workers
from planner.request import require_workers

if TYPE_CHECKING:
    import pyarrow as pa
    from distributed import Client

ABOUT = "study.json"


GROUPED = [name for name in SETTINGS if name != "seed"]
MOST_REASONS = 20


@dataclass(frozen=True, slots=True)
class SettingsGroup:
    """Cells that differ in their seed only; figures are those of cells that are done, NaN where there are none."""

    settings: CellSettings  # settings that they share
    cells: int  # number of cells
    done: int  # number of plans
    converged: float  # share of these whose solver said so
    best: float  # largest score of the criterion; the larger the better
    median: float  # median score
    efficiencies: tuple[float, ...]  # D-efficiencies of the plans
    seconds: float  # mean time of a cell [s]
    iterations: float  # mean number of iterations of a cell
    inside: float  # share of the 95 % intervals of identified parameters that contain the truth

    @property
    def spread(self) -> float:
        """How much less D-efficient the worst start ends than the best, as a share; NaN of fewer than two."""
        return 1.0 - min(self.efficiencies) / max(self.efficiencies) if len(self.efficiencies) > 1 else np.nan


def groups(rows: "pa.Table") -> list[SettingsGroup]:
    """Groups of cells that differ in their seed only, in the order of their settings."""
    figures = {
        "cell": "count_distinct", "converged": "mean", "iterations": "mean", "seconds": "sum", "parameters": "sum",
        "inside_95": "sum", "score": "list", "d_efficiency": "list",
    }  # fmt: skip
    table = rows.group_by(GROUPED).aggregate(list(figures.items())).sort_by([(name, "ascending") for name in GROUPED])
    result = []
    for row in table.to_pylist():
        scores = [score for score in row["score_list"] if score is not None]
        efficiencies = tuple(value for value in row["d_efficiency_list"] if value is not None)
        cells, intervals = row["cell_count_distinct"], row["parameters_sum"]
        result.append(
            SettingsGroup(
                settings={name: row[name] for name in GROUPED if row[name] is not None},
                cells=cells,
                done=len(efficiencies),
                converged=_number(row["converged_mean"]),
                best=max(scores, default=np.nan),
                median=float(np.median(scores)) if scores else np.nan,
                efficiencies=efficiencies,
                seconds=_number(row["seconds_sum"]) / cells,
                iterations=_number(row["iterations_mean"]),
                inside=row["inside_95_sum"] / intervals if intervals else np.nan,
            )
        )
    return result


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def best_groups(settings_groups: list[SettingsGroup]) -> dict[str, SettingsGroup]:
    """Settings with the best plan for each criterion that has one, in the order of their letters."""
    best: dict[str, SettingsGroup] = {}
    for group in settings_groups:
        letter = group.settings["criterion"]
        if group.done and (letter not in best or group.best > best[letter].best):
            best[letter] = group
    return dict(sorted(best.items()))


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Study:
    """What a study folder holds; each cell is a plan, and runs of it where the study asks for them."""

    folder: Path
    case: Case
    spec: Spec
    cells: int  # number of all of them
    computed: int  # how many were computed now
    rows: "pa.Table"  # rows of plans and of runs, see `hexcite.studies.cell_rows.schema`

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
        solvers = [asdict(summary) for summary in solver_summaries(groups(self.rows))]
        return {"study": str(self.folder), **counts, "best": best, "solvers": solvers}

    def write_page(self) -> Path:
        """Writes the page of the folder, report.html, and returns its path."""
        write_text(self.folder / "report.html", study_page(self))
        return self.folder / "report.html"

    def __repr__(self) -> str:
        """How many cells are done, and the best settings of each criterion."""
        best = [f"{letter}: {group.best:.4g} with {group.settings}" for letter, group in self.best.items()]
        summaries = solver_summaries(groups(self.rows))
        solvers = aligned(SOLVER_COLUMNS, *(s.cells for s in summaries)) if len(summaries) > 1 else []
        first = f"Study {self.folder}: {self.done} of {self.cells} cells done, {self.failed} failed"
        return "\n".join([first, *best, *solvers])

    _repr_html_ = as_html


@documented()
def study(
    case: Case,
    spec: Spec | Path | str,
    folder: Path | str | None = None,
    *,
    workers: Workers = default_of(Workers),
    scheduler: Scheduler = default_of(Scheduler),
    certificates: Certificates = default_of(Certificates),
    insecure: Insecure = default_of(Insecure),
    one_process: OneProcess = default_of(OneProcess),
    progress: Callable[[str], None] = lambda remark: None,
) -> Study:
    """Plans, runs and identifies every cell of a grid of settings; a study that was stopped goes on.

    >>> study = hx.study(hx.load_case("hexapod"), "moves.toml", "study", one_process=True)
    >>> study
    Study study: 1 of 1 cells done, 0 failed
    D: -5... with {'family': 'ptp', 'criterion': 'D', 'model': 9, 'duration_s': 4.0, 'moves': 8, 'payload': 0}

    Args:
        case: machine and limits, and a simulated machine where the study executes its plans.
        spec: TOML file of the study, or a built-in one: paper, validation.
        folder: its folder, continued if it is there; named after case and study unless given.
        OPTIONS
        progress: shows a line at the start and at the end of each cell.

    Raises:
        HexciteError: the study cannot be understood, its folder is another's, Dask is missing.
        Interrupted: Ctrl-C; what is done is kept.
    """
    specification = spec if isinstance(spec, Spec) else load_spec(str(spec))
    case.need_motion("a study")
    if specification.execute is not None:
        case.need_simulation("a study that executes its plans")
    _require_one_place_to_compute(workers, scheduler, one_process)
    place = Path(f"{case.name}-{specification.name}-study") if folder is None else Path(folder)
    cells = cells_of(specification, case)
    _require_own(place, specification, case)
    missing = [cell for cell in cells if not file_of(place, cell).exists()]
    computed = 0
    if missing:
        context: AbstractContextManager[Client | None]
        if one_process:
            context = nullcontext()
        elif scheduler is None:
            context = local_client(workers, specification.cells.memory_GB)
        else:
            context = remote_client(scheduler, None if certificates is None else Path(certificates), insecure)
        try:
            with context as client:
                _write_about(place, specification, case, len(cells))
                progress(f"{len(missing)} of {len(cells)} cells to do, in {place}")
                for _ in _computed(client, {cell: cells[cell] for cell in missing}, place, specification, case):
                    computed += 1
                    progress(f"{computed} of {len(missing)} cells")
        except Interrupted:
            raise Interrupted(f"what is done is kept in {place}, the same command goes on") from None
    return Study(place, case, specification, len(cells), computed, read_rows(file_of(place, cell) for cell in cells))


def _require_one_place_to_compute(workers: int | None, scheduler: str | None, one_process: bool) -> None:
    """Refuses what names two places to compute at, or one that is not there."""
    if one_process and (scheduler is not None or workers is not None):
        raise HexciteError(
            problem=f"{option('one_process')} starts no other, {option('workers')} and {option('scheduler')} do",
            remedy="drop one",
            code=Code.CONTRADICTION,
        )
    if scheduler is not None and workers is not None:
        raise HexciteError(
            problem=f"{option('workers')} counts processes on this computer, {option('scheduler')} names "
            "another cluster",
            remedy="drop one",
            code=Code.CONTRADICTION,
        )
    require_workers(workers)
    if not one_process:
        require_dask()


def _computed(
    client: "Client | None", cells: Mapping[str, CellSettings], folder: Path, spec: Spec, case: Case
) -> Iterator[str]:
    """Cells as they are done, each with its rows in a file; computed here where there is no client."""
    tasks = ((cell, partial(work, case, request_of(settings), spec.execute)) for cell, settings in cells.items())
    answers = run_one_by_one(tasks) if client is None else run_tasks(client, tasks, spec.cells.time_limit_s)
    for cell, answer in answers:
        rows = [failure(answer)] if isinstance(answer, HexciteError) else answer
        keep(file_of(folder, cell), [{**cells[cell], "cell": cell, **_shared(case), **row} for row in rows])
        yield cell


def _shared(case: Case) -> dict[str, str]:
    """What all rows of a study say."""
    return {"case_hash": case.hash, "version": version("hexcite")}


def _write_about(folder: Path, spec: Spec, case: Case, cells: int) -> None:
    """Writes what the study is, and how many cells it has."""
    about = {"schema_version": 1, "name": spec.name, "case": case.name, "case_file": case.origin}
    about |= {**_shared(case), "cells": cells, "spec": spec.model_dump(mode="json")}
    write_text(folder / ABOUT, json_text(about))


def _require_own(folder: Path, spec: Spec, case: Case) -> None:
    """Refuses, before the work starts, a folder of another study or of something else, or that cannot be written."""
    if not (folder / ABOUT).exists():
        check_folder(folder, FolderKind("a study", frozenset({ROWS})), overwrite=True)
        return
    record = read_json(folder / ABOUT, "hexcite study")
    if (record.get("name"), record.get("case")) != (spec.name, case.name):
        words = f"holds study {record.get('name')} of case {record.get('case')}, not {spec.name} of {case.name}"
        raise FileProblem(
            place=folder, problem=words, remedy=f"choose another place{WITH_OUTPUT}", code=Code.OTHER_SOURCE
        )


def study_page(of: Study) -> str:
    """The page of a study: the best settings, a table of all, and the D-efficiency of their plans."""
    spec, case, rows = of.spec, of.case, of.rows
    summaries = groups(rows)
    outcomes = zip(rows["status"].to_pylist(), rows["reason"].to_pylist(), strict=True)
    failures = Counter(str(reason) for status, reason in outcomes if status == FAILED)
    best = [
        note(f"Criterion {letter}, best {group.best:.4g}: {command_of(group.settings, case.origin)}")
        for letter, group in best_groups(summaries).items()
    ]
    varied = [name for name in GROUPED if len({group.settings.get(name) for group in summaries}) > 1]
    spread: list[Box] = []
    cells_of_table = []
    for group in summaries:
        texts = [str(group.settings.get(name, "-")) for name in varied]
        spread.append(Box(tuple(group.efficiencies), ", ".join(texts)))
        shares = [percent(share) for share in (group.converged, group.spread, group.inside)]
        numbers = group.best, group.median, group.iterations, group.seconds
        figures = [f"{number:.4g}" if np.isfinite(number) else "-" for number in numbers]
        cells_of_table.append((*texts, str(group.cells), str(group.done), *figures, *shares))
    columns = (*varied, "cells", "done", "best", "median", "iterations", "s a cell", "converged", "spread", "coverage")
    words = (
        "Larger is better: A is minus the trace, K minus the condition, in the reference scaling. Spread: how much "
        "less D-efficient the worst start ends than the best."
    )
    caption = "D-efficiency of the plans of each setting, over their seeds."
    chart = Chart("spread", caption, tuple(spread), y=Axis("D-efficiency"))
    verdict = f"{of.done} of {of.cells} cells are done, {of.failed} failed."
    return page(
        f"Study {spec.name}: {case.name}",
        Head(verdict, of.done == of.cells, case.name, (("study", spec.name),)),
        f"{len(rows)} rows of {of.cells} cells; a cell is one start of an optimisation, and what it gave.",
        (("case", f"{case.name} (hash {case.hash})"), ("hexcite", version("hexcite"))),
        [f"{count} rows failed: {reason}" for reason, count in failures.most_common(MOST_REASONS)],
        section("Best settings", *(best or [note("No cell is done yet.")]), note(words)),
        *solver_sections(summaries),
        section("Settings", table(columns, cells_of_table, left=len(varied)), chart),
    )


def percent(share: float) -> str:
    """A share in per cent, or a dash where there is none."""
    return f"{100 * share:.1f} %" if np.isfinite(share) else "-"


SOLVER_COLUMNS = ("solver", "start values", "plans", "failed", "converged", "iterations", "s a cell", "of the best")


@dataclass(frozen=True, slots=True)
class SolverSummary:
    """How a solver does from one kind of start values, over all other settings."""

    solver: str
    start: str  # random or equal
    plans: int  # number of plans
    failed: int  # number of cells without one
    converged: float  # share of the plans whose solver said so
    iterations: float  # mean of their groups
    seconds: float  # mean time of a cell [s]
    reached: float  # median over settings of its median D-efficiency over the best that any solver or start found there

    @property
    def cells(self) -> tuple[str, ...]:
        """Its row in a table."""
        figures = str(self.plans), str(self.failed), percent(self.converged), f"{self.iterations:.0f}"
        return self.solver, self.start, *figures, f"{self.seconds:.1f}", percent(self.reached)


def solver_summaries(settings_groups: list[SettingsGroup]) -> list[SolverSummary]:
    """One for each solver and kind of start values, in the order of their names."""
    keys = "solver", "equal_start"
    best: dict[tuple[object, ...], float] = {}
    for group in settings_groups:
        rest = _without(group.settings, keys)
        best[rest] = max(best.get(rest, 0.0), *group.efficiencies, 0.0)
    kinds: dict[tuple[str, bool], list[SettingsGroup]] = {}
    for group in settings_groups:
        kinds.setdefault(
            (str(group.settings.get("solver", "by default")), bool(group.settings.get("equal_start"))), []
        ).append(group)
    summaries = []
    for (solver, equal), several in sorted(kinds.items()):
        done = [group for group in several if group.done]
        plans = sum(group.done for group in done)
        reached = [float(np.median(g.efficiencies)) / best[_without(g.settings, keys)] for g in done]
        summaries.append(
            SolverSummary(
                solver,
                "equal" if equal else "random",
                plans,
                sum(group.cells for group in several) - plans,
                sum(group.converged * group.done for group in done) / plans if plans else np.nan,
                float(np.mean([group.iterations for group in done])) if done else np.nan,
                float(np.mean([group.seconds for group in done])) if done else np.nan,
                float(np.median(reached)) if done else np.nan,
            )
        )
    return summaries


def _without(settings: CellSettings, names: tuple[str, ...]) -> tuple[object, ...]:
    return tuple((name, value) for name, value in settings.items() if name not in names)


def solver_sections(settings_groups: list[SettingsGroup]) -> list[Markup]:
    """The section that compares solvers and start values, where a study has several."""
    summaries = solver_summaries(settings_groups)
    if len(summaries) < 2:
        return []
    rows = [s.cells for s in summaries]
    words = (
        "Of the best: the median D-efficiency of its starts over the best that any solver found with the same other "
        "settings, the median of these. The paper compares such solvers of MATLAB."
    )
    return [section("Solvers and start values", table(SOLVER_COLUMNS, rows, left=2), note(words))]
