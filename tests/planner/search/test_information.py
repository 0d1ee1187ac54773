"""Information in CasADi is the information in NumPy, and its gradient is its gradient."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.schema import Case
from identification.evaluate import over_samples
from identification.model import Model, identification_model
from identification.reference import uniform_states
from planner.families.fourier import FourierFamily
from planner.search.information import log_determinant, sample_information
from planner.search.problem import Problem, build_problem, mean_information
from tests.helpers import taylor_slope


@pytest.fixture(scope="module")
def family(hexapod_case: Case) -> FourierFamily:
    half = np.ptp(hexapod_case.limits.motion.pose, axis=0) / 2
    return FourierFamily(3, 3.0, 2, hexapod_case.machine.home.vector, half, 12)


@pytest.fixture(scope="module")
def problem(hexapod_case: Case, model: Model, family: FourierFamily, scaling: np.ndarray) -> Problem:
    return build_problem(hexapod_case, model, family, scaling)


@pytest.mark.parametrize("number", [0, 6, 9])
def test_the_information_of_a_sample_is_its_scaled_regressor_squared(number: int, hexapod_case: Case):
    model = identification_model(hexapod_case, number)
    size = len(model.parameters)
    scaling = np.random.default_rng(1).uniform(0.1, 10.0, size)
    states = uniform_states(hexapod_case, 20, seed=2)
    matrices = over_samples(model.coordinate_regressor, *states)[0] * scaling
    rows, columns = np.triu_indices(size)  # the lower triangle column by column is the upper one row by row
    expected = (matrices.transpose(0, 2, 1) @ matrices)[:, rows, columns]
    assert np.allclose(over_samples(sample_information(model, scaling), *states)[0], expected, rtol=1e-10, atol=1e-9)


@given(size=st.integers(1, 12), seed=st.integers(0, 2**32 - 1))
def test_log_determinant_is_that_of_numpy(size: int, seed: int):
    factor = np.random.default_rng(seed).normal(size=(3 * size, size))
    matrix = factor.T @ factor
    triangle = matrix[np.triu_indices(size)]
    assert float(log_determinant(size)(triangle)) == pytest.approx(np.linalg.slogdet(matrix)[1], rel=1e-8, abs=1e-8)


def test_the_objective_is_the_information_of_the_motion_itself(
    problem: Problem, family: FourierFamily, model: Model, scaling: np.ndarray
):
    """Trigonometric polynomials are integrated by their grid, nearly: the regressor is not polynomial in the angles."""
    unknowns = 0.2 * np.random.default_rng(0).normal(size=family.unknowns * 6)
    value = float(ca.Function("f", [problem.unknowns], [problem.objective("D")])(unknowns))
    logdet = np.linalg.slogdet(mean_information(model, scaling, family.motion(unknowns)))[1]
    assert -20 * value == pytest.approx(logdet, abs=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_the_gradient_of_the_objective_is_its_slope_in_any_direction(problem: Problem, seed: int):
    draw = np.random.default_rng(seed)
    start, direction = (0.2 * draw.normal(size=problem.unknowns.shape[0]) for _ in range(2))
    both = [problem.objective("D"), ca.gradient(problem.objective("D"), problem.unknowns)]
    function = ca.Function("f", [problem.unknowns], both)
    slope = np.array(float(ca.dot(function(start)[1], direction)))
    assert taylor_slope(lambda h: np.array(float(function(start + h * direction)[0])), 0.0, slope, 0.05) > 1.9


def test_the_mean_does_not_depend_on_how_often_a_motion_repeats(
    model: Model, scaling: np.ndarray, family: FourierFamily
):
    from dataclasses import replace

    unknowns = 0.2 * np.random.default_rng(0).normal(size=family.unknowns * 6)
    one, two = (mean_information(model, scaling, replace(family, repeats=n).motion(unknowns)) for n in (1, 2))
    assert np.allclose(one, two, rtol=1e-9, atol=1e-12)


def test_another_scaling_adds_the_same_to_every_motion(model: Model, scaling: np.ndarray, family: FourierFamily):
    draw = np.random.default_rng(0)
    other = scaling * draw.uniform(0.1, 10.0, len(scaling))
    for _ in range(3):
        motion = family.motion(0.2 * draw.normal(size=family.unknowns * 6))
        a, b = (np.linalg.slogdet(mean_information(model, s, motion))[1] for s in (scaling, other))
        assert b - a == pytest.approx(2 * np.log(other / scaling).sum(), abs=1e-8)
