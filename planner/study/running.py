"""Runs a study into its folder: what is missing there, and no cell twice."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases.basis import KEPT, study_basis
from cases.schema import Case
from planner.study.spec import Spec, cell_key, request_of, settings_of
from planner.study.store import FAILED, PLANNED, completed, opened, read_rows, schema
from planner.study.tasks import Outcome, run_tasks
from planner.study.work import Job, work

if TYPE_CHECKING:
    from distributed import Client


@dataclass(frozen=True, slots=True)
class Cell:
    """One combination of settings, and the key of its rows."""

    key: str
    settings: dict[str, Any]


def cells_of(spec: Spec, case: Case) -> list[Cell]:
    """Every cell of a study.

    Raises:
        HexciteError: a combination cannot be planned, or there are too many.
    """
    ours, found = version("hexcite"), []
    for settings in settings_of(spec):
        request_of(settings)
        found.append(Cell(cell_key(settings, spec.execute, case, ours), settings))
    return found


def missing(cells: list[Cell], spec: Spec, folder: Path, retry: bool = False) -> list[tuple[Cell, tuple[int, ...]]]:
    """Cells with rows that are not in the folder yet, and the noise seeds of these rows.

    Args:
        cells: of the study.
        spec: of the study.
        folder: of the study.
        retry: whether cells that failed count as missing.

    Raises:
        FileProblem: a file of the study is damaged.
    """
    table = read_rows(folder, schema()) if folder.is_dir() else None
    there: dict[str, set[int]] = {}
    failed: set[str] = set()
    if table is not None:
        columns = (table[name].to_pylist() for name in ("cell", "noise_seed", "status"))
        for key, seed, status in zip(*columns, strict=True):
            there.setdefault(key, set()).add(seed)
            if seed == PLANNED and status == FAILED:
                failed.add(key)
    wanted = range(spec.execute.noise_seeds if spec.execute is not None else 0)
    found = []
    for cell in cells:
        have = there.get(cell.key, set())
        lacking = tuple(seed for seed in wanted if seed not in have)
        if (retry and cell.key in failed) or (cell.key not in failed and (PLANNED not in have or lacking)):
            found.append((cell, lacking))
    return found


def about_study(spec: Spec, case: Case, cells: int) -> dict[str, Any]:
    """What study.json holds."""
    return {
        "schema_version": 1,
        "name": spec.name,
        "case": case.name,
        "case_hash": case.hash,
        KEPT: study_basis(case),
        "case_file": case.origin,
        "version": version("hexcite"),
        "cells": cells,
        "spec": spec.model_dump(mode="json"),
    }


def run_study(
    client: "Client",
    spec: Spec,
    case: Case,
    folder: Path,
    done: Callable[[Outcome], None],
    retry: bool = False,
) -> int:
    """Computes the rows that a study folder lacks, and keeps each as it arrives.

    Args:
        client: of the cluster.
        spec: the study.
        case: machine and limits.
        folder: of the study; continued where it holds rows.
        done: told of each cell.
        retry: whether to try cells again that failed.

    Returns:
        How many cells were computed.

    Raises:
        HexciteError: the folder is another study's, or the cluster is gone; what is done is kept.
    """
    cells = cells_of(spec, case)
    count = 0
    with opened(folder, schema(), about_study(spec, case, len(cells))) as store:
        work_left = missing(cells, spec, folder, retry)
        known = {cell.key: cell for cell, _ in work_left}

        def tasks() -> Iterator[tuple[str, Job]]:
            for cell, seeds in work_left:
                disturbed = spec.execute is not None and spec.execute.disturbed
                yield cell.key, Job(case, request_of(cell.settings), seeds, disturbed)

        for outcome in run_tasks(client, work, tasks(), spec.cells.time_limit_s):
            store.add(_rows(known[outcome.key], outcome, case))
            count += 1
            done(outcome)
    return count


def _rows(cell: Cell, outcome: Outcome, case: Case) -> list[dict[str, Any]]:
    shared = cell.settings | {
        "cell": cell.key,
        "case_hash": case.hash,
        "version": version("hexcite"),
        "tries": outcome.tries,
        "worker": outcome.worker,
    }
    if outcome.reason is not None:
        failure = {"noise_seed": PLANNED, "status": FAILED, "reason": outcome.reason, "seconds": outcome.seconds}
        return [completed(shared | failure)]
    return [completed(shared | row) for row in outcome.value]
