"""What a worker does for one cell: one start of the optimisation, and on request the run and its identifications."""

import math
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cases.errors import HexciteError
from cases.schema import Case
from planner.request import Request
from planner.study.rows import DONE, FAILED, PLANNED

if TYPE_CHECKING:
    from identification.loaded import Circumstances


@dataclass(frozen=True, slots=True)
class Job:
    """One cell's work.

    Args:
        case: machine and limits, and a simulated machine where runs are asked for.
        request: what to plan, from one start.
        noise_seeds: of the recordings to identify; none: the plan alone.
        disturbed: whether the simulated machine vibrates, ripples and errs with the pose.
    """

    case: Case
    request: Request
    noise_seeds: tuple[int, ...]
    disturbed: bool = False


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
    from planner.planning import make
    from planner.search.parallel import Listener, run_here

    began = time.perf_counter()
    silent = Listener(lambda start: None, lambda news: None)
    plan = make(job.request, job.case, job.request.case_file, silent, run_here)
    row = {
        "noise_seed": PLANNED,
        "status": DONE,
        "seconds": time.perf_counter() - began,
        "converged": bool(plan.starts) and plan.starts[0].converged,
        "iterations": sum(start.iterations for start in plan.starts),
        "score": plan.score if math.isfinite(plan.score) else None,
        "logdet": plan.logdet,
        "d_efficiency": plan.d_efficiency,
    }
    return row, plan.motion


def _runs(job: Job, motion: Any, began: float) -> list[dict[str, Any]]:
    from identification.identify import identify
    from identification.loaded import circumstances
    from identification.simulate import simulate_recording
    from planner.comparison.truth import truth_rows
    from planner.runs.running import execute
    from postprocessors.dialects import dialect
    from postprocessors.proving.guarantees import KINETIC
    from postprocessors.writing import proven_program

    around = circumstances(job.case, job.request.payload, job.disturbed)
    truth_case = _loaded_case(job.case, around)
    # Nothing moves but numbers: limits that this controller would leave to nobody are reported by `post`, not here.
    written = proven_program(motion, job.case, dialect("linuxcnc").load(), "study.ngc", ("study",), 1.0, KINETIC)
    with tempfile.TemporaryDirectory(prefix="hexcite-study-") as folder:
        program = Path(folder) / "study.ngc"
        program.write_bytes(written.content)
        run = execute(program, job.case, "virtual", job.noise_seeds[0], around).run
    rows = []
    for seed in job.noise_seeds:
        recording = simulate_recording(job.case, run.execution, run.trigger, seed, around=around)
        estimate = identify(recording, job.case, job.request.model)
        truth = truth_rows(truth_case, estimate)
        half = [v.interval(estimate.freedom)[1] - v.value for v in estimate.physical.values()]
        inside = sum(abs(r["error"]) <= h for r, h in zip(truth, half, strict=True))
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


def _loaded_case(case: Case, around: "Circumstances") -> Case:
    """The case whose true parameters include what is mounted."""
    from identification.loaded import loaded_truth

    simulation = case.need_simulation("a study that executes its plans")
    truth = loaded_truth(simulation.parameters, around.weights)
    return case.model_copy(update={"simulation": simulation.model_copy(update={"parameters": truth})})
