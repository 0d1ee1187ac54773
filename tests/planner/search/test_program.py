"""The non-linear program: exact derivatives for every family and criterion, and the information of the motion."""

from dataclasses import replace

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import reference_scaling
from identification.model.model import Model, identification_model
from planner.noise import mean_information
from planner.search.nlp import NonlinearProgram, regressor_kernel
from tests.helpers import taylor_slope
from tests.planner.search.conftest import Small

LETTERS = [("D", 0), ("A", 0), ("K", 2), ("N", 1)]
STEP = 2e-3


def direction(seed: int, unknowns: np.ndarray) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=len(unknowns))


def table(program: NonlinearProgram, unknowns: np.ndarray) -> np.ndarray:
    """All derivatives of the rows, shape (R, n)."""
    dense = np.zeros((len(program.row_bounds[0]), program.unknowns))
    np.add.at(dense, program.pattern, program.row_slopes(unknowns))
    return dense


def square(program: NonlinearProgram, unknowns: np.ndarray, factor: float, multipliers: np.ndarray) -> np.ndarray:
    """The second derivative as a whole matrix, shape (n, n)."""
    dense = np.zeros((program.unknowns,) * 2)
    dense[program.hessian_pattern] = program.hessian(unknowns, factor, multipliers)
    return np.asarray(dense + dense.T - np.diag(np.diag(dense)))


@pytest.mark.parametrize(("letter", "halvings"), LETTERS)
def test_the_gradient_is_the_slope_of_the_criterion(letter: str, halvings: int, small: Small):
    _, problem, at = small
    program = replace(problem, letter=letter, halvings=halvings)
    along = direction(1, at)
    slope = np.array([program.gradient(at) @ along])
    assert taylor_slope(lambda h: np.array([program.value(at + h * along)]), 0.0, slope, STEP) == pytest.approx(
        2.0, abs=0.15
    )


def test_the_jacobian_is_the_slope_of_every_row(small: Small):
    _, problem, at = small
    program, along = problem, direction(2, at)
    assert len(program.row_values(at)) == len(program.row_bounds[0]) == len(program.row_bounds[1])
    jacobian = table(program, at)
    assert taylor_slope(lambda h: program.row_values(at + h * along), 0.0, jacobian @ along, STEP) == pytest.approx(
        2.0, abs=0.1
    )


@pytest.mark.first(8)
@pytest.mark.parametrize(("letter", "halvings"), LETTERS)
def test_the_hessian_is_the_slope_of_the_lagrangians_gradient(letter: str, halvings: int, small: Small):
    _, problem, at = small
    program = replace(problem, letter=letter, halvings=halvings)
    multipliers = np.random.default_rng(3).normal(size=len(program.row_bounds[0]))
    along, factor = direction(4, at), 0.7
    hessian = square(program, at, factor, multipliers)

    def gradient(h: float) -> np.ndarray:
        place = at + h * along
        return factor * program.gradient(place) + multipliers @ table(program, place)

    assert taylor_slope(gradient, 0.0, hessian @ along, STEP / 4) == pytest.approx(2.0, abs=0.15)


def test_a_hessian_without_the_criterion_is_that_of_the_rows_alone(small: Small):
    _, problem, at = small
    program, none = problem, np.zeros(len(problem.row_bounds[0]))
    multipliers = np.random.default_rng(3).normal(size=len(none))
    both = program.hessian(at, 0.7, multipliers)
    parts = program.hessian(at, 0.7, none) + program.hessian(at, 0.0, multipliers)
    assert both == pytest.approx(parts, abs=1e-9 * np.abs(both).max())


def test_a_convex_program_leaves_out_what_makes_d_more_concave(small: Small):
    """Along the states F = A^T A of a linear A would bend upwards alone: log det bends downwards by that."""
    family, problem, at = small
    exact = problem
    convex = replace(exact, convex=True)
    none = np.zeros(len(exact.row_bounds[0]))
    whole, kept = (square(program, at, 1.0, none) for program in (exact, convex))
    scale = np.abs(whole).max()
    assert np.linalg.eigvalsh(kept).min() > -1e-9 * scale
    left_out = np.linalg.eigvalsh(whole - kept)
    if family.name == "ptp" or getattr(family, "free", None):  # times may gain on each other: nearly so
        assert left_out.sum() < 0.0
    else:
        assert left_out.max() < 1e-3 * np.abs(left_out).max()


def test_its_information_is_the_time_average_over_the_motion(small: Small, hexapod_case: Case):
    family, problem, at = small
    model = identification_model(hexapod_case, 5)
    fine = mean_information(model, reference_scaling(hexapod_case, model), family.motion(at), 20_000.0)
    assert problem.information(at) == pytest.approx(fine, abs=2e-3 * np.abs(fine).max())
    logdet = np.linalg.slogdet(fine)[1]
    assert problem.value(at) == pytest.approx(-logdet / len(fine), abs=5e-3)


def test_what_is_known_adds_to_the_information_and_to_its_slopes(small: Small):
    _, problem, at = small
    root = np.random.default_rng(6).normal(size=(problem.size,) * 2)
    known, along = root @ root.T, direction(7, at)
    program = replace(problem, known=known)
    assert program.information(at) == pytest.approx(problem.information(at) + known)
    logdet = np.linalg.slogdet(problem.information(at) + known)[1]
    assert program.value(at) == pytest.approx(-logdet / problem.size)
    slope, none = np.array([program.gradient(at) @ along]), np.zeros(len(program.row_bounds[0]))
    assert taylor_slope(lambda h: np.array([program.value(at + h * along)]), 0.0, slope, STEP) == pytest.approx(
        2.0, abs=0.15
    )
    curved = square(program, at, 1.0, none) @ along
    assert taylor_slope(lambda h: program.gradient(at + h * along), 0.0, curved, STEP / 4) == pytest.approx(
        2.0, abs=0.15
    )


def test_with_weights_it_is_that_of_the_weighted_model(small: Small, model: Model):
    """The whitening of the noise enters through the model alone."""
    _, problem, at = small
    whitened = replace(model, whitening=2.0 * np.eye(6))
    plain, other = (regressor_kernel(m, np.ones(len(model.names))) for m in (model, whitened))
    states = problem.states.at(at).reshape(-1, 19)
    assert other.values(states) == pytest.approx(2.0 * plain.values(states), rel=1e-12)
