"""Solves an excitation problem from many random starts, in parallel processes, and rates what comes out in NumPy.

IPOPT's own word is not taken for it: objective and limits of every result are computed anew from the motion, and a
motion that passes a limit between the samples of the grid is scaled back until it does not.
"""

import os
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import get_context
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.errors import InfeasiblePlan
from cases.schema import Case
from identification.limits import TOLERANCE, LimitReport, prove
from identification.model import identification_model
from identification.reference import reference_scaling
from planner.fourier import FourierFamily
from planner.problem import Problem, build_problem, mean_information, strut_shares

Array = NDArray[np.float64]

START_SHARE = 0.8  # random starts use this share of the tightest limit: significantly different from zero, inside
STRUT_ROUNDS = 5  # rounds of adding the strut limits that came close
NEAR = 0.9  # share of a strut limit from which it counts as close
MARGIN = 1e-3  # of every limit, left for the rounding of program words and for the encoders' view of the motion
QUICK_RATE = 1000.0  # [1/s] for comparing starts; the chosen plan is proven at the full rate
REFINED = 2  # of the starts, the best are refined: one a core of the smallest machine

IPOPT = {
    "hessian_approximation": "limited-memory",  # FACTS: AD's exact Hessian costs 1.7 s an evaluation
    "tol": 1e-4,  # limited-memory IPOPT stalls below; 1e-4 of log det / u is 0.01 % of a standard deviation
    "print_level": 0,
    "sb": "yes",
}


class Stage(NamedTuple):
    """How thoroughly to optimise.

    Args:
        name: for the report.
        density: instants of the grid in one period of the highest harmonic.
        iterations: of IPOPT, at most, in each round.
        struts: whether the strut limits are rows too; else only the final scaling keeps them.
    """

    name: str
    density: int
    iterations: int
    struts: bool


# A coarse look from every start, then the full problem from the best of them: the many local optima differ more than
# what the last iterations bring (measured: 0.7 s against 2 to 9 s a start).
EXPLORE = Stage("explore", 12, 100, False)
REFINE = Stage("refine", 16, 150, True)


@dataclass(frozen=True, slots=True)
class Start:
    """What became of one start.

    Args:
        seed: of the random start.
        stage: the stage it went through.
        start_objective: log det F at its start, reference scaling.
        objective: log det F of the motion scaled into the limits.
        status: the solver's last words.
        iterations: of the solver, all rounds.
        seconds: time spent.
        unknowns: the motion, shape (q * 6,).
    """

    seed: int
    stage: str
    start_objective: float
    objective: float
    status: str
    iterations: int
    seconds: float
    unknowns: Array


@dataclass(frozen=True, slots=True)
class Task:
    """What a worker process needs to run one start.

    Args:
        case: machine and limits.
        model: number of the identification model.
        family: the motions to choose from.
        stage: how thoroughly.
        seed: of the random start.
        unknowns: where to start instead, shape (q * 6,).
    """

    case: Case
    model: int
    family: FourierFamily
    stage: Stage
    seed: int
    unknowns: Array | None = None


def random_start(seed: int, family: FourierFamily, problem: Problem) -> Array:
    """Random unknowns scaled into the limits, shape (q * 6,)."""
    draw = np.random.default_rng(seed).normal(size=family.unknowns * 6)
    rows = ca.Function("rows", [problem.unknowns], [problem.rows])
    worst = max(float(np.abs(rows(draw).full()).max()), float(strut_shares(problem, draw).max()))
    return np.asarray(draw * START_SHARE / worst)


def keep_limits(case: Case, family: FourierFamily, unknowns: Array, rate: float) -> tuple[Array, LimitReport]:
    """Scales unknowns back about home until the motion keeps every limit, less a margin, on a grid of `rate`.

    Raises:
        InfeasiblePlan: scaling does not help; the message names the limit.
    """
    for _ in range(8):
        report = prove(family.motion(unknowns), case, rate)
        if report.worst_ratio <= 1.0 - MARGIN + TOLERANCE:
            return unknowns, report
        unknowns = unknowns * (1.0 - MARGIN) / report.worst_ratio
    worst = max(report.checks, key=lambda c: c.ratio)
    raise InfeasiblePlan(f"no feasible motion: {worst.sentence()}; widen that limit or move home")


def run_start(task: Task) -> Start:
    """Optimises one start through one stage."""
    began = time.perf_counter()
    model = identification_model(task.case, task.model)
    scaling = reference_scaling(task.case, model)
    family = replace(task.family, density=task.stage.density)
    problem = build_problem(task.case, model, family, scaling)
    unknowns = random_start(task.seed, family, problem) if task.unknowns is None else task.unknowns

    def log_det(values: Array) -> float:
        return float(np.linalg.slogdet(mean_information(model, scaling, family.motion(values)))[1])

    start_objective = log_det(unknowns)
    unknowns, status, iterations = _optimise(problem, unknowns, task.stage)
    unknowns, _ = keep_limits(task.case, family, unknowns, QUICK_RATE)
    seconds = time.perf_counter() - began
    name = task.stage.name
    return Start(task.seed, name, start_objective, log_det(unknowns), status, iterations, seconds, unknowns)


def _optimise(problem: Problem, unknowns: Array, stage: Stage) -> tuple[Array, str, int]:
    """IPOPT, again with more strut rows as long as one is passed; unknowns, its last words, iterations."""
    active = np.zeros((18, problem.strut_motion.size2_out(0)), dtype=bool)
    iterations, status = 0, ""
    for _ in range(STRUT_ROUNDS if stage.struts else 1):
        solver = ca.nlpsol(
            "solver",
            "ipopt",
            {"x": problem.unknowns, "f": problem.objective, "g": problem.with_struts(active)},
            {"ipopt": IPOPT | {"max_iter": stage.iterations}, "print_time": False, "show_eval_warnings": False},
        )
        unknowns = solver(x0=unknowns, lbg=-1.0, ubg=1.0)["x"].full()[:, 0]
        stats = solver.stats()
        iterations, status = iterations + stats["iter_count"], str(stats["return_status"])
        shares = strut_shares(problem, unknowns)
        if shares.max() <= 1.0 + 1e-3:
            break
        active |= shares > NEAR
    return unknowns, status, iterations


def seeds_of(seed: int, starts: int) -> list[int]:
    """Seeds of the starts, reproducible from one seed; more starts extend the list."""
    return [int(s.generate_state(1)[0]) for s in np.random.SeedSequence(seed).spawn(starts)]


def optimise(
    case: Case, model: int, family: FourierFamily, seed: int, starts: int, done: Callable[[Start], None]
) -> list[Start]:
    """Explores from all starts, refines the best.

    Args:
        case: machine and limits.
        model: number of the identification model.
        family: the motions to choose from.
        seed: makes everything reproducible.
        starts: number of random starts.
        done: called with each result as it arrives.

    Returns:
        All results of both stages, the best first.

    Raises:
        InfeasiblePlan: no motion keeps the limits.
    """
    explored = _run([Task(case, model, family, EXPLORE, s) for s in seeds_of(seed, starts)], done)
    best = sorted(explored, key=lambda s: -s.objective)[:REFINED]
    refined = _run([Task(case, model, family, REFINE, s.seed, s.unknowns) for s in best], done)
    return sorted(explored + refined, key=lambda s: -s.objective)


def _run(tasks: list[Task], done: Callable[[Start], None]) -> list[Start]:
    """Runs tasks in parallel processes."""
    # Spawned, not forked: MUMPS and threads of a parent do not survive a fork.
    workers = min(len(tasks), os.cpu_count() or 1)
    results = []
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(run_start, task) for task in tasks]
        try:
            for future in as_completed(futures):
                start = future.result()
                done(start)
                results.append(start)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return results
