"""Every solver by name: the same small problem, the same optimum; stopped ones return what they have."""

import casadi as ca
import numpy as np
import pytest

from cases.schema import Case
from identification.limits import prove
from planner.families.family import box_middle
from planner.families.fourier import COARSE, FINE, FourierFamily
from planner.search.problem import Constraints
from planner.search.solvers import SOLVERS, Program, multipliers_balance
from planner.search.solving import Stage, Task, run_start, seeds_of


def program() -> Program:
    """Rosenbrock's valley inside a disc, on a line: the optimum lies where the line leaves the disc's inside free."""
    x = ca.MX.sym("x", 3)
    rows = ca.vertcat(x[2] - x[0] - x[1], (x[0] ** 2 + x[1] ** 2) / 2)
    objective = (1 - x[0]) ** 2 + 10 * (x[1] - x[0] ** 2) ** 2 + x[2] ** 2 / 100
    constraints = Constraints(rows, ca.jacobian(rows, x), np.array([0.0, -1.0]), np.array([0.0, 0.5]))
    return Program(x, objective, constraints, np.full(3, -2.0), np.full(3, 2.0))


@pytest.mark.parametrize("name", list(SOLVERS))
def test_it_finds_the_constrained_optimum_and_says_so(name: str):
    reached = SOLVERS[name](program(), np.array([0.1, 0.1, 0.2]), 200, lambda objective: False)
    x = reached.unknowns
    assert reached.converged
    assert x[2] == pytest.approx(x[0] + x[1], abs=1e-4)
    assert x[0] ** 2 + x[1] ** 2 == pytest.approx(1.0, abs=2e-3)
    assert x[:2] == pytest.approx(
        [0.786, 0.618], abs=0.01
    )  # Rosenbrock on the unit disc; the last term moves it little


@pytest.mark.parametrize("name", list(SOLVERS))
def test_a_watch_that_has_seen_enough_stops_it(name: str):
    seen: list[float] = []

    def watch(objective: float) -> bool:
        seen.append(objective)
        return len(seen) >= 3

    reached = SOLVERS[name](program(), np.array([-1.5, 1.5, 0.0]), 200, watch)
    assert not reached.converged
    assert np.isfinite(reached.unknowns).all()
    assert len(seen) <= 5


@pytest.mark.parametrize("name", list(SOLVERS))
@pytest.mark.parametrize("criterion", ["D", "N"])
def test_every_solver_improves_a_motion_within_the_limits(name: str, criterion: str, hexapod_case: Case):
    family = FourierFamily(2, 3.0, 1, *box_middle(hexapod_case), COARSE)
    start = run_start(Task(hexapod_case, 0, family, criterion, name, Stage("few", 15, True), 3))
    assert start.logdet > start.start_logdet
    assert prove(family.motion(start.unknowns), hexapod_case).kept


def test_sqp_goes_on_where_its_approximated_hessian_has_become_useless(hexapod_case: Case):
    """From this start it finds no step after 36 iterations, one iteration before it is done."""
    family = FourierFamily.lasting(3, 3.0, 4, *box_middle(hexapod_case), FINE)
    start = run_start(Task(hexapod_case, 9, family, "D", "sqp", Stage("study", 500, True), 3757552657))
    assert start.converged
    assert start.status == "solve succeeded"


@pytest.mark.slow
def test_slsqp_comes_back_from_far_outside(hexapod_case: Case):
    """From this start its 22nd step passes the limits a hundred times; from there it finds no step within them."""
    family = FourierFamily.lasting(5, 3.0, 4, *box_middle(hexapod_case), FINE)
    start = run_start(Task(hexapod_case, 9, family, "D", "slsqp", Stage("study", 500, True), 3757552657))
    assert start.converged


def nearest_corner(to: tuple[float, float], times: int) -> Program:
    """The point of a square that lies nearest to a point; every side counts several times."""
    x = ca.MX.sym("x", 2)
    rows = ca.repmat(x, times, 1)
    constraints = Constraints(rows, ca.jacobian(rows, x), np.full(2 * times, -1.0), np.full(2 * times, 1.0))
    free = np.full(2, np.inf)
    return Program(x, ca.sumsqr(x - ca.DM(to)), constraints, -free, free)


@pytest.mark.parametrize("times", [1, 3])
@pytest.mark.parametrize(
    ("to", "at", "expected"),
    [
        ((2.0, -3.0), (1.0, -1.0), True),
        ((2.0, 0.5), (1.0, 0.5), True),
        ((0.3, 0.5), (0.3, 0.5), True),
        ((2.0, 0.5), (1.0, 1.0), False),  # the upper side pulls, which constraints cannot
        ((2.0, 0.5), (1.0, 0.4), False),
        ((0.3, 0.5), (1.0, 0.5), False),
        ((2.0, -3.0), (2.0, -3.0), False),  # outside
    ],
)
def test_multipliers_balance_at_an_optimum_and_nowhere_else(
    times: int, to: tuple[float, float], at: tuple[float, float], expected: bool
):
    assert multipliers_balance(nearest_corner(to, times), np.array(at)) is expected


def test_sqp_without_a_step_is_done_where_multipliers_balance(hexapod_case: Case):
    """More limits bind here than there are unknowns: the multipliers of its last quadratic program are not balanced."""
    family = FourierFamily.lasting(2, 3.0, 4, *box_middle(hexapod_case), FINE)
    start = run_start(Task(hexapod_case, 9, family, "D", "sqp", Stage("study", 500, True), 3757552657))
    assert start.converged


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ipopt", "sqp"])
@pytest.mark.parametrize("seed", seeds_of(0, 20))
def test_d_on_order_5_converges_from_each_of_20_random_starts(name: str, seed: int, hexapod_case: Case):
    family = FourierFamily.lasting(5, 3.0, 4, *box_middle(hexapod_case), FINE)
    start = run_start(Task(hexapod_case, 9, family, "D", name, Stage("study", 1000, True, barrier=1e-2), seed))
    assert start.converged
