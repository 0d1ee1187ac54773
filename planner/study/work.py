"""What a worker does for one cell: one start of the optimisation, and on request the run and its identifications."""

import math
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cases.errors import HexciteError
from cases.schema import Case
from planner.request import Request
from planner.study.rows import DONE, FAILED, PLANNED


@dataclass(frozen=True, slots=True)
class Job:
    """One cell's work.

    Args:
        case: machine and limits, and a simulated machine where runs are asked for.
        request: what to plan, from one start.
        noise_seeds: of the recordings to identify; none: the plan alone.
    """

    case: Case
    request: Request
    noise_seeds: tuple[int, ...]


def work(job: Job) -> list[dict[str, Any]]:
    """Rows of a cell: of the plan, and of each seed of the noise.

    A plan or run that is refused is a row with its reason: that is a finding, not an accident.
    """
    try:
        row, motion = _plan(job)
    except HexciteError as error:
        return [{"noise_seed": PLANNED, "status": FAILED, "reason": str(error), "seconds": 0.0}]
    if not job.noise_seeds:
        return [row]
    began = time.perf_counter()
    try:
        return [row, *_runs(job, motion, began)]
    except HexciteError as error:
        seconds = (time.perf_counter() - began) / len(job.noise_seeds)
        failure = {"status": FAILED, "reason": str(error), "seconds": seconds}
        return [row, *({"noise_seed": seed} | failure for seed in job.noise_seeds)]


def _plan(job: Job) -> tuple[dict[str, Any], Any]:
    from identification.limits import PROOF_RATE
    from identification.model import identification_model
    from planner.bound import box_bound
    from planner.planning import STAGES, family_of
    from planner.solving import Task, keep_limits, run_start, seeds_of

    began = time.perf_counter()
    request, case = job.request, job.case
    explore, refine = STAGES[request.family]
    (seed,) = seeds_of(request.seed, 1)
    task = Task(
        case, request.model, family_of(request, case), request.criterion, request.solver, explore, seed
    )  # fmt: skip
    first = run_start(task)
    start = run_start(replace(task, stage=refine, family=first.family, unknowns=first.unknowns))
    unknowns, report = keep_limits(case, start.family, start.unknowns, PROOF_RATE)
    bound = box_bound(case, identification_model(case, request.model))
    row = {
        "noise_seed": PLANNED,
        "status": DONE if report.kept else FAILED,
        "reason": None if report.kept else report.violations[0].sentence(),
        "seconds": time.perf_counter() - began,
        "converged": start.converged,
        "iterations": first.iterations + start.iterations,
        "score": start.score if math.isfinite(start.score) else None,
        "logdet": start.logdet,
        "d_efficiency": bound.efficiency(start.logdet),
    }
    return row, start.family.motion(unknowns)


def _runs(job: Job, motion: Any, began: float) -> list[dict[str, Any]]:
    from identification.identify import identify
    from identification.simulate import simulate_recording
    from planner.comparison import truth_rows
    from planner.running import execute
    from postprocessors.dialects import dialect
    from postprocessors.guarantees import KINETIC
    from postprocessors.writing import proven_program

    # Nothing moves but numbers: limits that this controller would leave to nobody are reported by `post`, not here.
    written = proven_program(motion, job.case, dialect("linuxcnc").load(), "study.ngc", ("study",), 1.0, KINETIC)
    with tempfile.TemporaryDirectory(prefix="hexcite-study-") as folder:
        program = Path(folder) / "study.ngc"
        program.write_bytes(written.content)
        run = execute(program, job.case, "virtual", job.noise_seeds[0]).run
    rows = []
    for seed in job.noise_seeds:
        recording = simulate_recording(job.case, run.execution, run.trigger, seed)
        estimate = identify(recording, job.case, job.request.model)
        truth = truth_rows(job.case, estimate)
        half = [v.interval(estimate.freedom)[1] - v.value for v in estimate.physical.values()]
        shares = [r["std"] / v.std for r, v in zip(truth, estimate.physical.values(), strict=True)]
        inside = sum(abs(r["error"]) <= h * s for r, h, s in zip(truth, half, shares, strict=True))
        mass = next(r for r in truth if r["name"] == "m")
        now = time.perf_counter()
        rows.append(
            {
                "noise_seed": seed,
                "status": DONE,
                "seconds": now - began,
                "parameters": len(truth),
                "inside_95": int(inside),
                "worst_error_in_std": float(np.max([abs(r["error"]) / r["std"] for r in truth])),
                "mass_error_kg": mass["error"],
                "mass_std_kg": mass["std"],
            }
        )
        began = now
    return rows
