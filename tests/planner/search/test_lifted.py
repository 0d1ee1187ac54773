"""The lifted problem: its second derivatives are those of its Lagrangian, its optimum that of the problem itself."""

import casadi as ca
import numpy as np
import pytest

from cases.schema import Case
from identification.limits import prove
from identification.model import identification_model
from identification.reference import reference_scaling
from planner.families.family import Family, box_middle
from planner.families.fourier import COARSE, FourierFamily
from planner.families.ptp import PointToPointFamily
from planner.families.spline import SplineFamily
from planner.search.lifted import Lifted, lifted
from planner.search.problem import Problem, build_problem
from planner.search.solving import Stage, Task, random_start, run_start
from tests.helpers import taylor_slope

MODEL = 5


def families(case: Case) -> list[Family]:
    return [
        SplineFamily.of(case, 20, 3.0),
        FourierFamily(2, 3.0, 1, *box_middle(case), COARSE),
        PointToPointFamily.of(case, 8, 3.0),
    ]


@pytest.fixture(scope="module", params=["spline, K", "spline, D", "fourier, A", "ptp, N"])
def chosen(request: pytest.FixtureRequest) -> tuple[str, str]:
    name, letter = request.param.split(", ")
    return name, letter


@pytest.fixture(scope="module")
def letter(chosen: tuple[str, str]) -> str:
    return chosen[1]


@pytest.fixture(scope="module")
def problem(chosen: tuple[str, str], hexapod_case: Case) -> tuple[Problem, np.ndarray]:
    model = identification_model(hexapod_case, MODEL)
    family = next(family for family in families(hexapod_case) if family.name == chosen[0])
    problem = build_problem(hexapod_case, model, family, reference_scaling(hexapod_case, model))
    return problem, random_start(4, family, problem)


@pytest.fixture(scope="module")
def raised(problem: tuple[Problem, np.ndarray], letter: str) -> Lifted:
    active = problem[0].held_from_the_start()
    active[:, ::3] = True  # lengths, joints and singularity too
    return lifted(problem[0], active, letter, 2, 1e-2)


def test_the_hessian_is_the_derivative_of_the_lagrangians_gradient(problem: tuple[Problem, np.ndarray], raised: Lifted):
    program = raised.program
    rows = program.constraints.rows
    weights = np.random.default_rng(1).normal(size=rows.shape[0])
    lagrangian = 0.7 * program.objective + ca.dot(rows, ca.DM(weights))
    gradient = ca.Function("gradient", [program.unknowns], [ca.gradient(lagrangian, program.unknowns)])
    assert program.hessian is not None
    at = raised.start(problem[1])
    upper = program.hessian(at, np.zeros(0), 0.7, weights)
    hessian = ca.triu2symm(upper).full()
    direction = np.random.default_rng(2).normal(size=len(at))
    direction[problem[0].unknowns.shape[0] :] *= 1e-3  # information stays positive definite

    def along(h: float) -> np.ndarray:
        return gradient(at + h * direction).full()[:, 0]

    assert taylor_slope(along, 0.0, hessian @ direction, 1e-3) == pytest.approx(2.0, abs=0.1)


def test_rows_have_their_exact_derivatives(problem: tuple[Problem, np.ndarray], raised: Lifted):
    program = raised.program
    rows = ca.Function("rows", [program.unknowns], [program.constraints.rows, program.constraints.jacobian])
    at = raised.start(problem[1])
    direction = np.random.default_rng(3).normal(size=len(at))
    value, slope = rows(at)
    assert np.abs(value.full()[-len(at) + len(problem[1]) :]).max() < 1e-12  # the information is that of the motion

    def along(h: float) -> np.ndarray:
        return rows(at + h * direction)[0].full()[:, 0]

    assert taylor_slope(along, 0.0, slope.full() @ direction, 1e-3) == pytest.approx(2.0, abs=0.1)


def test_exact_second_derivatives_find_at_least_what_approximated_ones_find(
    hexapod_case: Case,
):
    family = families(hexapod_case)[0]
    task = Task(hexapod_case, MODEL, family, "D", "ipopt", Stage("refine", 500, True, barrier=1e-2), 4)
    exact = run_start(task)
    approximated = run_start(Task(hexapod_case, MODEL, family, "D", "ipopt", Stage("refine", 120, True), 4))
    assert exact.converged
    assert exact.logdet > approximated.logdet - 0.01 * 20
    assert prove(family.motion(exact.unknowns), hexapod_case).kept
