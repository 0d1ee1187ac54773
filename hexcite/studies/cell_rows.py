"""The work of a cell, and its rows: one of its plan, one of each identified run, in a Parquet file of the cell."""

import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cases.base.atomic import atomic_file
from cases.base.errors import Code, FileProblem, HexciteError, Interrupted
from cases.controller import ControllerName
from cases.schema import Case
from hexcite.studies.spec import ExecutionSpec
from planner.request import Request

if TYPE_CHECKING:
    import pyarrow as pa

    from planner.plans.plan import Plan

PLANNED = -1  # noise seed of the row that holds the plan itself
DONE, FAILED = "done", "failed"
ROWS = "rows"


def schema() -> "pa.Schema":
    """Columns of the rows and their types."""
    import pyarrow as pa

    text, whole, number = pa.string(), pa.int64(), pa.float64()
    columns = {
        text: "cell case_hash version family criterion solver status reason",
        whole: "noise_seed model order moves knots payload seed iterations parameters inside_95",
        number: "duration_s period_s seconds score logdet d_efficiency worst_error_in_std mass_error_kg mass_std_kg",
        pa.bool_(): "converged equal_start",
    }
    return pa.schema([(name, kind) for kind, names in columns.items() for name in names.split()])


def file_of(folder: Path, cell: str) -> Path:
    """The file of a cell, which is there once the cell is finished."""
    return folder / ROWS / f"{cell}.parquet"


def keep(file: Path, rows: Sequence[dict[str, Any]]) -> None:
    """Writes the rows of one cell: all of them or, if killed here, none."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    with atomic_file(file) as part:
        pq.write_table(pa.Table.from_pylist(list(rows), schema()), part)


def read_rows(files: Iterable[Path]) -> "pa.Table":
    """Rows of those files that are there; FileProblem where one is damaged."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    tables = [schema().empty_table()]
    for file in filter(Path.exists, files):
        try:
            tables.append(pq.read_table(file, schema=schema(), partitioning=None))
        except (OSError, pa.ArrowException) as error:
            raise FileProblem(
                place=file,
                problem=f"is damaged ({error})",
                remedy="delete it, its cell is then computed again",
                code=Code.DAMAGED,
            ) from error
    return pa.concat_tables(tables)


def work(case: Case, request: Request, execute: ExecutionSpec | None = None) -> list[dict[str, Any]]:
    """Rows of a cell; what is refused is a row with its reason, for this is a result and not a failure of the study.

    Args:
        request: request of the plan, with one start.
        execute: how the plan is run and identified; None: the plan alone.
    """
    from planner.plans.making import make
    from planner.search.parallel import run_here, silent

    rows: list[dict[str, Any]] = []
    begin = time.perf_counter()
    try:
        plan = make(request, case, silent, run_here)
        if plan.interrupted:  # no worker of a cluster is; in this process the best until then is not the cell's
            raise Interrupted
        worth = plan.of_motion[1]
        rows.append(
            {
                "noise_seed": PLANNED,
                "status": DONE,
                "seconds": time.perf_counter() - begin,
                "converged": bool(worth.starts) and worth.starts[0].converged,
                "iterations": sum(start.iterations for start in worth.starts),
                "score": worth.criterion_value if np.isfinite(worth.criterion_value) else None,
                "logdet": worth.logdet,
                "d_efficiency": worth.d_efficiency,
            }
        )
        return rows if execute is None else [*rows, *_runs(plan, execute)]
    except HexciteError as error:
        return [*rows, failure(error) | {"noise_seed": 0 if rows else PLANNED}]


def failure(error: HexciteError) -> dict[str, Any]:
    """The row of a cell whose plan is refused."""
    return {"noise_seed": PLANNED, "status": FAILED, "reason": error.typed}


def _runs(plan: "Plan", execute: ExecutionSpec) -> list[dict[str, Any]]:
    from hexcite._run import carried_out
    from hexcite._write import write
    from identification.identify import estimate_parameters
    from identification.limits.limit import KINETIC
    from identification.simulate import circumstances, loaded_truth, simulate_recording, truth_rows

    case = plan.case
    around = circumstances(case, plan.payloads[-1], execute.disturbed)
    simulation = case.need_simulation("a study that executes its plans")
    loaded = simulation.model_copy(update={"parameters": loaded_truth(simulation.parameters, around.weights)})
    truth_case = case.model_copy(update={"simulation": loaded})  # its true parameters include the payload
    # No machine moves: limits that this controller would not enforce are reported by `post`, not here.
    run = carried_out(write(plan, accept=KINETIC), case, ControllerName.VIRTUAL)
    rows = []
    for seed in range(execute.noise_seeds):
        start = time.perf_counter()
        recording = simulate_recording(case, run.execution, run.trigger, seed, around=around)
        estimate = estimate_parameters(recording, case, plan.model)
        truth = truth_rows(truth_case, estimate)
        half = [v.interval(estimate.fit.freedom)[1] - v.value for v in estimate.physical.values()]
        mass = next(r for r in truth if r["name"] == "m")
        rows.append(
            {
                "noise_seed": seed,
                "status": DONE,
                "seconds": time.perf_counter() - start,
                "parameters": len(truth),
                "inside_95": sum(abs(r["error"]) <= h for r, h in zip(truth, half, strict=True)),
                "worst_error_in_std": float(np.max([abs(r["error"]) / r["std"] for r in truth])),
                "mass_error_kg": mass["error"],
                "mass_std_kg": mass["std"],
            }
        )
    return rows
