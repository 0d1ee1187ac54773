"""The paper's study of criteria, orders and solvers (section 7)."""

import os
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

from cases.loading import load_case
from cases.schema import Case
from identification.criteria import CRITERIA
from planner.cli.console import print_table
from planner.families.family import box_middle
from planner.families.fourier import FINE, FourierFamily
from planner.request import SOLVER_NAMES
from planner.search.solving import Failed, Stage, Start, Task, run_safely, seeds_of

PERIOD = 3.0  # [s]
PERIODS = 4
ORDERS = range(1, 8)  # order 1 with run-in and run-out
STARTS = 2  # of each cell, the same for every criterion and solver
MANY = 20  # of D and order 5
MANY_SOLVERS = ("ipopt", "sqp")
WHOLE = Stage("study", 1000, True, barrier=1e-2)  # from random starts
MOST_SECONDS = 60.0  # of processor time a start; what is stopped then counts as not converged, with what it has reached


class Key(NamedTuple):
    """A cell of the study."""

    criterion: str
    order: int
    solver: str
    starts: int


class Timed(NamedTuple):
    """What came of a start, in how much processor time [s], and whether that was all that it was given."""

    result: Start | Failed
    seconds: float
    stopped: bool


@dataclass(frozen=True, slots=True)
class Cell:
    """What came of the starts of one criterion, order and solver."""

    key: Key
    results: tuple[Timed, ...]

    @property
    def row(self) -> list[str]:
        """As a row of the table."""
        done = [(r.result, r.seconds) for r in self.results if isinstance(r.result, Start)]
        converged = sum(r.converged for r, _ in done)
        words = [self.key.criterion, str(self.key.order), self.key.solver, f"{converged} of {len(self.results)}"]
        words.append(str(sum(r.stopped for r in self.results) or ""))
        if not done:
            return [*words, "-", "-", "-"]
        iterations, seconds = np.median([(r.iterations, s) for r, s in done], axis=0)
        return [*words, f"{iterations:.0f}", f"{seconds:.1f} s", f"{max(r.score for r, _ in done):.4g}"]


def study_keys() -> list[Key]:
    """All cells, and that of which more starts are wanted."""
    many = [Key("D", 5, solver, MANY) for solver in MANY_SOLVERS]
    return many + [Key(c, n, s, STARTS) for c in CRITERIA for n in ORDERS for s in SOLVER_NAMES]


def tasks_of(case: Case, key: Key) -> list[Task]:
    """The starts of a cell, from random motions to the full problem with every limit."""
    family = FourierFamily.lasting(key.order, PERIOD, PERIODS, *box_middle(case), FINE)
    return [Task(case, 9, family, key.criterion, key.solver, WHOLE, seed) for seed in seeds_of(0, key.starts)]


def timed(task: Task) -> Timed:
    """Runs a start until it is done or its processor time is over."""
    began = time.process_time()
    stopped = False

    def watch(objective: float) -> bool:
        nonlocal stopped
        stopped = stopped or time.process_time() - began > MOST_SECONDS
        return stopped

    result = run_safely(task, watch)
    return Timed(result, time.process_time() - began, stopped)


def studied(case: Case, keys: list[Key]) -> Iterator[Cell]:
    """Cells as they are done, in their order; no core waits for the slowest start of a cell."""
    pool = ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn"))
    with pool:
        waiting = [(key, [pool.submit(timed, task) for task in tasks_of(case, key)]) for key in keys]
        for key, futures in waiting:
            yield Cell(key, tuple(future.result() for future in futures))


def paper_study() -> None:
    """Prints the table of section 7: criteria x orders x solvers from the same starts."""
    began = time.perf_counter()
    rows = [cell.row for cell in studied(load_case("hexapod"), study_keys())]
    minutes = (time.perf_counter() - began) / 60.0
    columns = ("criterion", "order", "solver", "converged", "out of time", "iterations", "CPU time", "reached")
    title = (
        f"Section 7's study, model 9, period {PERIOD:g} s, {PERIODS} periods, {STARTS} starts a cell, at most "
        f"{WHOLE.iterations} iterations a round and {MOST_SECONDS:g} s a start; wanted of D, 5: 20 of 20; "
        f"{minutes:.0f} min in all"
    )
    print_table(title, columns, rows)
