"""A refinement has rows where limits come close at its start; where it comes to exceed others by far it begins anew."""

from dataclasses import replace

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import Criterion
from planner.families.spline import SplineFamily
from planner.search import solving
from planner.search.nlp import NonlinearProgram
from planner.search.record import SolverStatus
from planner.search.solvers import solve
from planner.search.solving import Task, run_start

MODEL = 6
ROOM = 1e-3
UNSEEN = 1.05  # this machine exceeds its limits by less than others do


def without_rows(program: NonlinearProgram, unknowns: np.ndarray, share: float, near: float) -> NonlinearProgram:
    """As if no limit of struts, joints or sensors came close where a refinement begins."""
    before = len(program.rows) - len(program.limits)
    none = [part.choosing(np.zeros_like(part.chosen)) for part in program.rows[before:]]
    return replace(program, rows=(*program.rows[:before], *none))


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, SolverStatus, float]]:
    """Of each run of the solver: number of rows, status, largest share where its result has no row."""
    seen: list[tuple[int, SolverStatus, float]] = []

    def told(program: NonlinearProgram, *given: object) -> tuple[np.ndarray, SolverStatus, int]:
        answer = solve(program, *given)  # type: ignore[arg-type]
        seen.append((len(program.row_bounds[0]), answer[1], program.unseen(answer[0])))
        return answer

    monkeypatch.setattr(solving, "solve", told)
    return seen


def test_what_is_unseen_is_the_largest_share_without_a_row(hexapod_case: Case):
    run = solving._Run(
        Task(hexapod_case, MODEL, SplineFamily.of(hexapod_case, 20, 3.0), Criterion.D, 1), lambda _: False
    )
    unknowns = run.begin()
    blind = without_rows(run.program, unknowns, 0.0, 0.0)
    shares = max(float(np.abs(part.all_values(unknowns)).max()) for part in blind.rows[-len(blind.limits) :])
    assert blind.unseen(unknowns) >= shares > 0.1
    sighted = blind.with_rows_above(unknowns, shares / 2)
    assert sighted.unseen(unknowns) <= shares / 2


def test_a_refinement_comes_back_from_limits_that_it_did_not_see(
    hexapod_case: Case, runs: list[tuple[int, SolverStatus, float]], monkeypatch: pytest.MonkeyPatch
):
    task = Task(hexapod_case, MODEL, SplineFamily.of(hexapod_case, 20, 3.0), Criterion.D, 1)
    explored = run_start(task)
    runs.clear()
    monkeypatch.setattr(NonlinearProgram, "with_rows_near", without_rows)
    monkeypatch.setattr(solving, "UNSEEN", UNSEEN)
    monkeypatch.setattr(solving, "FEW", 0)  # as splines of many intervals
    refined = run_start(replace(task, begin=explored.begin))
    beyond = [k for k, (_, status, _) in enumerate(runs) if status is SolverStatus.BEYOND]
    assert beyond
    assert max(unseen for _, _, unseen in runs) <= UNSEEN
    assert all(runs[k + 1][0] > runs[k][0] for k in beyond)
    assert refined.shrunk > 1.0 - ROOM
    assert refined.record.criterion_value > explored.record.criterion_value
