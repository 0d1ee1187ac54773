"""What a worker does for one cell: one start of the optimisation, and on request the run and its identifications."""

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cases.errors import HexciteError
from cases.schema import Case
from planner.request import Request
from planner.study.store import DONE, FAILED, PLANNED

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
        row, plan = _plan(job)
    except HexciteError as error:
        return [{"noise_seed": PLANNED, "status": FAILED, "reason": str(error), "seconds": 0.0}]
    if not job.noise_seeds:
        return [row]
    began = time.perf_counter()
    try:
        return [row, *_runs(job, plan, began)]
    except HexciteError as error:
        seconds = (time.perf_counter() - began) / len(job.noise_seeds)
        failure = {"status": FAILED, "reason": str(error), "seconds": seconds}
        return [row, *({"noise_seed": seed} | failure for seed in job.noise_seeds)]


def _plan(job: Job) -> tuple[dict[str, Any], Any]:
    from planner.planning import make
    from planner.search.parallel import Listener, run_here

    began = time.perf_counter()
    silent = Listener(lambda start: None, lambda news: None)
    plan = make(job.request, job.case, silent, run_here)
    worth = plan.of_motion[1]
    row = {
        "noise_seed": PLANNED,
        "status": DONE,
        "seconds": time.perf_counter() - began,
        "converged": bool(worth.search.starts) and worth.search.starts[0].converged,
        "iterations": sum(start.iterations for start in worth.search.starts),
        "score": worth.score if math.isfinite(worth.score) else None,
        "logdet": worth.logdet,
        "d_efficiency": worth.d_efficiency,
    }
    return row, plan


def _runs(job: Job, plan: Any, began: float) -> list[dict[str, Any]]:
    from identification.identify import identify
    from identification.loaded import circumstances
    from identification.simulate import simulate_recording
    from planner.comparison.truth import truth_rows
    from planner.runs.running import execute
    from planner.runs.writing import write
    from postprocessors.proving.guarantees import KINETIC

    around = circumstances(job.case, job.request.payload, job.disturbed)
    truth_case = _loaded_case(job.case, around)
    # Nothing moves but numbers: limits that this controller would leave to nobody are reported by `post`, not here.
    run = execute(write(plan, accept=KINETIC), job.case, "virtual", job.noise_seeds[0], around).run
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
