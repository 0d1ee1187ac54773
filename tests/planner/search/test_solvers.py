"""Solvers on programs in NumPy: the optimum of a small one; stopped, it returns the best that is inside the limits."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array

from planner.families.rows import LinearRows
from planner.request import Solver
from planner.search.nlp import NonlinearProgram
from planner.search.record import SolverStatus
from planner.search.solvers import INSIDE, solve
from tests.helpers import few
from tests.planner.search.conftest import Small


@dataclass(frozen=True)
class Disc:
    """x^2 + y^2 over the first two of the unknowns, at most 1."""

    upper: np.ndarray = field(default_factory=lambda: np.array([1.0]))
    pattern: Any = (np.zeros(2, dtype=int), np.arange(2))
    equal: None = None

    def all_values(self, x: np.ndarray) -> np.ndarray:
        return np.array([x[:2] @ x[:2]])

    values = all_values

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        return 2 * x[:2]


class Valley(NonlinearProgram):
    """Rosenbrock's valley inside a disc, on a plane."""

    hessian_pattern = np.triu_indices(3)

    def value(self, x: np.ndarray) -> float:
        return float((1 - x[0]) ** 2 + 10 * (x[1] - x[0] ** 2) ** 2 + x[2] ** 2 / 100)

    def gradient(self, x: np.ndarray) -> np.ndarray:
        slope = 20 * (x[1] - x[0] ** 2)
        return np.array([-2 * (1 - x[0]) - 2 * x[0] * slope, slope, x[2] / 50])

    def hessian(self, x: np.ndarray, factor: float, multipliers: np.ndarray) -> np.ndarray:
        own = np.diag([2 - 40 * (x[1] - x[0] ** 2) + 80 * x[0] ** 2, 20.0, 0.02])
        own[0, 1] = own[1, 0] = -40 * x[0]
        own *= factor
        own[:2, :2] += 2 * multipliers[1] * np.eye(2)
        return own[self.hessian_pattern]


def valley() -> NonlinearProgram:
    plane = LinearRows(
        csr_array(np.array([[-1.0, -1.0, 1.0]])), np.zeros(1, int), np.ones(1, bool), np.ones(1), equal=0.0
    )
    return Valley(None, None, (plane, Disc()), np.full(3, -2.0), np.full(3, 2.0))


def solved(
    start: list[float], iterations: int, watch: Any = lambda objective: False, solver: Solver = Solver.IPOPT
) -> tuple[np.ndarray, SolverStatus, int]:
    return solve(valley(), np.array(start), iterations, watch, solver=solver)


@pytest.mark.parametrize("solver", Solver)
def test_it_finds_the_constrained_optimum_and_says_so(solver: Solver):
    x, status, count = solved([0.1, 0.1, 0.2], 200, solver=solver)
    assert status.converged
    assert x[2] == pytest.approx(x[0] + x[1], abs=1e-5)
    assert x[0] ** 2 + x[1] ** 2 == pytest.approx(1.0, abs=2e-3)
    assert x[:2] == pytest.approx([0.786, 0.618], abs=0.01)  # the last term moves it little
    assert 3 < count < 100


@pytest.mark.parametrize("solver", Solver)
def test_a_watch_that_has_seen_enough_stops_it(solver: Solver):
    seen: list[float] = []

    def watch(objective: float) -> bool:
        seen.append(objective)
        return len(seen) >= 3

    reached, status, _ = solved([-1.5, 1.5, 0.0], 200, watch, solver)
    assert status is SolverStatus.STOPPED
    assert np.isfinite(reached).all()
    assert len(seen) == 3


@pytest.mark.parametrize("solver", Solver)
def test_an_iterate_beyond_what_it_limits_ends_it_at_the_one_before(solver: Solver):
    passed: list[np.ndarray] = []

    def beyond(unknowns: np.ndarray) -> bool:
        passed.append(unknowns.copy())
        return bool(unknowns[0] > 0.4)

    x, status, count = solve(valley(), np.array([0.1, 0.1, 0.2]), 200, lambda objective: False, None, solver, beyond)
    assert status is SolverStatus.BEYOND
    assert not status.converged
    assert 0 < count < 100
    assert [at[0] > 0.4 for at in passed] == [False] * (len(passed) - 1) + [True]
    assert x.tolist() == passed[-2].tolist()


@pytest.mark.first(2)
@pytest.mark.parametrize("iterations", few(8, 3, 15))
def test_out_of_iterations_it_returns_the_best_inside_the_bounds(iterations: int, small: Small):
    """Of all iterates that it passed; the last may be worse, or outside."""
    _, problem, at = small
    passed: list[tuple[float, np.ndarray]] = []

    class Watched(NonlinearProgram):
        def gradient(self, unknowns: np.ndarray) -> np.ndarray:  # asked for once an iterate
            passed.append((self.value(unknowns), unknowns[: len(at)].copy()))
            return super().gradient(unknowns)

    program = problem
    watched = Watched(**{name: getattr(program, name) for name in NonlinearProgram.__dataclass_fields__})
    reached, status, _ = solve(watched, at, iterations, lambda objective: False)
    lower, upper = program.row_bounds

    def outside(unknowns: np.ndarray) -> float:
        rows = program.row_values(unknowns)
        return float(max((lower - rows).max(), (rows - upper).max()))

    inside = [value for value, unknowns in passed if outside(unknowns) < INSIDE]
    if inside and not status.converged:
        assert outside(reached) < INSIDE
        assert program.value(reached) <= min(inside) + 1e-9


@pytest.mark.first(1)
@pytest.mark.parametrize("solver", Solver)
@pytest.mark.parametrize(
    "small",
    few("fourier", "spline", "ptp"),
    indirect=True,
)
def test_it_ends_where_no_more_is_gained(small: Small, solver: Solver):
    _, problem, at = small
    program = replace(problem, convex=True)
    reached, status, count = solve(program, at, 400, lambda objective: False, solver=solver)
    assert status.converged
    assert count < 400
    assert program.outside(reached) < INSIDE
    lower, upper = program.row_bounds
    rows = program.row_values(reached)
    assert max((lower - rows).max(), (rows - upper).max()) < INSIDE
    assert program.value(reached) < program.value(at) - 0.2


@pytest.mark.parametrize("status", SolverStatus)
def test_a_status_is_found_by_its_text_and_as_ipopt_writes_it(status: SolverStatus):
    assert SolverStatus(str(status)) is status
    assert SolverStatus(str(status).title().replace(" ", "_")) is status


def test_a_stage_that_used_its_iterations_is_no_failure():
    assert SolverStatus("Maximum_Iterations_Exceeded").words == "at its iteration limit"
    assert SolverStatus("Solve_Succeeded").words == "converged"


def test_a_search_that_ran_out_of_time_was_not_stopped_by_its_user_alone():
    assert "time limit" in SolverStatus.STOPPED.words


def test_a_problem_of_which_nothing_can_be_computed_is_a_failure_and_no_error():
    """CasADi has no statistics then."""

    class Broken(Valley):
        def hessian(self, x: np.ndarray, factor: float, multipliers: np.ndarray) -> np.ndarray:
            raise np.linalg.LinAlgError("made up")

    plain = valley()
    broken = Broken(None, None, plain.rows, plain.lower, plain.upper)
    x, status, _ = solve(broken, np.array([0.1, 0.1, 0.2]), 10, lambda objective: False, solver=Solver.SQP)
    assert not status.converged
    assert np.isfinite(x).all()


def test_any_other_status_is_a_failure():
    assert SolverStatus("Invalid_Number_Detected") is SolverStatus.FAILED
