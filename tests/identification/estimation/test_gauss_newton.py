"""Gauss-Newton finds minima, and says so when it does not."""

import numpy as np
import pytest

from cases.errors import IdentificationError
from identification.estimation.priors import STEPS, gauss_newton

Array = np.ndarray
MATRIX = np.random.default_rng(0).normal(size=(9, 3))
RIGHT = np.random.default_rng(1).normal(size=9)


def rosenbrock(x: Array) -> tuple[Array, Array]:
    return np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]]), np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]])


def test_a_linear_problem_takes_one_step_and_one_to_see_it() -> None:
    found, steps = gauss_newton(lambda x: (MATRIX @ x - RIGHT, MATRIX), np.full(3, 100.0), 1e-10)
    assert steps == 2
    np.testing.assert_allclose(found, np.linalg.lstsq(MATRIX, RIGHT)[0], rtol=1e-10)


def test_it_finds_the_end_of_a_curved_valley() -> None:
    found, _ = gauss_newton(rosenbrock, np.array([-1.2, 1.0]), 1e-12)
    np.testing.assert_allclose(found, [1.0, 1.0], rtol=1e-12)


def test_it_halves_steps_that_go_too_far() -> None:
    """Atan has its root at 0, and full steps from beyond 1.39 run away from it."""
    found, _ = gauss_newton(lambda x: (np.arctan(x), np.diag(1.0 / (1.0 + x**2))), np.array([3.0]), 1e-12)
    np.testing.assert_allclose(found, 0.0, atol=1e-12)


def test_what_nothing_determines_stays_where_it_was() -> None:
    matrix = MATRIX * [1.0, 0.0, 1.0]
    found, _ = gauss_newton(lambda x: (matrix @ x - RIGHT, matrix), np.array([1.0, 7.0, 1.0]), 1e-10)
    assert found[1] == 7.0


def test_failures_are_told() -> None:
    with pytest.raises(IdentificationError, match=rf"not become small.*\b{STEPS}\b"):
        gauss_newton(lambda x: (x**2, np.diag(2.0 * x)), np.array([1.0]), 1e-40)
    with pytest.raises(IdentificationError, match=r"no step lowers chi\^2"):
        gauss_newton(lambda x: (MATRIX @ x - RIGHT, -MATRIX), np.zeros(3), 1e-10)
    with pytest.raises(IdentificationError, match=r"no finite value.*start"):
        gauss_newton(lambda x: (np.array([np.nan]), np.eye(1)), np.zeros(1), 1e-10)
