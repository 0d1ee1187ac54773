"""The cells of a study, which of them its folder misses, and the work of one."""

import math
import time
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cases.basis import KEPT, study_basis
from cases.controller import ControllerName
from cases.errors import HexciteError
from cases.schema import Case, fingerprint
from identification.model import full_model
from planner.request import Request
from planner.study import (
    DONE,
    FAILED,
    PLANNED,
    CellSettings,
    ExecutionSpec,
    Spec,
    read_rows,
    request_of,
    settings_of,
)

if TYPE_CHECKING:
    from planner.plans import Plan


def work(case: Case, request: Request, noise_seeds: tuple[int, ...], disturbed: bool = False) -> list[dict[str, Any]]:
    """Rows of a cell: of the plan, and of each seed of the noise.

    A plan or run that is refused is a row with its reason: this is a result, not a failure of the study.

    Args:
        request: request of the plan, with one start.
        noise_seeds: noise seeds of the recordings to identify; none: the plan alone.
    """
    try:
        row, plan = _plan(case, request)
    except HexciteError as error:
        return [failure(error)]
    if not noise_seeds:
        return [row]
    start = time.perf_counter()
    try:
        return [row, *_runs(plan, noise_seeds, disturbed)]
    except HexciteError as error:
        seconds = (time.perf_counter() - start) / len(noise_seeds)
        return [row, *(failure(error) | {"noise_seed": seed, "seconds": seconds} for seed in noise_seeds)]


def failure(error: HexciteError) -> dict[str, Any]:
    """The row of a cell whose plan is refused."""
    return {"noise_seed": PLANNED, "status": FAILED, "reason": error.typed, "seconds": 0.0}


def _plan(case: Case, request: Request) -> tuple[dict[str, Any], "Plan"]:
    from planner.planning import make
    from planner.search.parallel import run_here, silent

    begin = time.perf_counter()
    plan = make(request, case, silent, run_here)
    worth = plan.of_motion[1]
    row = {
        "noise_seed": PLANNED,
        "status": DONE,
        "seconds": time.perf_counter() - begin,
        "converged": bool(worth.starts) and worth.starts[0].converged,
        "iterations": sum(start.iterations for start in worth.starts),
        "score": worth.criterion_value if math.isfinite(worth.criterion_value) else None,
        "logdet": worth.logdet,
        "d_efficiency": worth.d_efficiency,
    }
    return row, plan


def _runs(plan: "Plan", noise_seeds: tuple[int, ...], disturbed: bool) -> list[dict[str, Any]]:
    from identification.identify import estimate_parameters
    from identification.limit import KINETIC
    from identification.simulate import circumstances, loaded_truth, simulate_recording, truth_rows
    from planner.execution import carried_out
    from planner.plan_program import write

    start, case = time.perf_counter(), plan.case
    around = circumstances(case, plan.payloads[-1], disturbed)
    simulation = case.need_simulation("a study that executes its plans")
    loaded = simulation.model_copy(update={"parameters": loaded_truth(simulation.parameters, around.weights)})
    truth_case = case.model_copy(update={"simulation": loaded})  # its true parameters include the payload
    # No machine moves: limits that this controller would not enforce are reported by `post`, not here.
    run = carried_out(write(plan, accept=KINETIC), case, ControllerName.VIRTUAL)
    rows = []
    for seed in noise_seeds:
        recording = simulate_recording(case, run.execution, run.trigger, seed, around=around)
        estimate = estimate_parameters(recording, case, plan.model)
        truth = truth_rows(truth_case, estimate)
        half = [v.interval(estimate.fit.freedom)[1] - v.value for v in estimate.physical.values()]
        inside = sum(abs(r["error"]) <= h for r, h in zip(truth, half, strict=True))
        mass = next(r for r in truth if r["name"] == "m")
        now = time.perf_counter()
        rows.append(
            {
                "noise_seed": seed,
                "status": DONE,
                "seconds": now - start,
                "parameters": len(truth),
                "inside_95": int(inside),
                "worst_error_in_std": float(np.max([abs(r["error"]) / r["std"] for r in truth])),
                "mass_error_kg": mass["error"],
                "mass_std_kg": mass["std"],
            }
        )
        start = now
    return rows


def cell_key(settings: CellSettings, execute: ExecutionSpec | None, case: Case, version: str) -> str:
    """Key of a cell's rows: 16 hexadecimal digits of settings, execution, version and case.

    Only the used part of the case counts; the settings of the controller where it runs the plans.
    """
    executed = None if execute is None else [execute.on, execute.disturbed, case.controller_hash]
    content = [settings, executed, fingerprint(study_basis(case)), version]
    return fingerprint(content)


def cells_of(spec: Spec, case: Case) -> dict[str, CellSettings]:
    """Settings of each cell, by the key of its rows; HexciteError where one cannot be planned, or for too many."""
    ours, cells = version("hexcite"), dict[str, CellSettings]()
    for choice in settings_of(spec):
        settings = {"model": full_model(case)} | choice
        request_of(settings)
        cells[cell_key(settings, spec.execute, case, ours)] = settings
    return cells


def missing(cells: Iterable[str], spec: Spec, folder: Path) -> dict[str, tuple[int, ...]]:
    """Cells with rows that are not in the folder yet, and noise seeds of these rows; failed cells are not missing."""
    there: set[tuple[str, int]] = set()
    failed: set[str] = set()
    if folder.is_dir():
        table = read_rows(folder)
        columns = (table[name].to_pylist() for name in ("cell", "noise_seed", "status"))
        for key, seed, status in zip(*columns, strict=True):
            there.add((key, seed))
            if seed == PLANNED and status == FAILED:
                failed.add(key)
    seeds = range(spec.execute.noise_seeds if spec.execute is not None else 0)
    gaps = {cell: tuple(seed for seed in seeds if (cell, seed) not in there) for cell in cells if cell not in failed}
    return {cell: rest for cell, rest in gaps.items() if rest or (cell, PLANNED) not in there}


def about_study(spec: Spec, case: Case, cells: int) -> dict[str, Any]:
    """Entries of study.json."""
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
