"""Second derivatives of the criteria: those that automatic differentiation finds for the same functions."""

import casadi as ca
import numpy as np
import pytest

from planner.search.curvature import curvature, curvature_function
from planner.search.objective import objective

SIZE = 6


def lower(information: np.ndarray) -> np.ndarray:
    row, column = (np.array(index) for index in ca.Sparsity.lower(len(information)).get_triplet())
    return information[row, column]


def information(seed: int) -> np.ndarray:
    rows = np.random.default_rng(seed).normal(size=(20, SIZE))
    return rows.T @ rows / 20


def automatic(letter: str, at: np.ndarray, halvings: int) -> np.ndarray:
    function = objective(letter, len(at), halvings)
    triangle = ca.SX.sym("triangle", len(lower(at)))
    return np.asarray(ca.Function("second", [triangle], [ca.hessian(function(triangle), triangle)[0]])(lower(at)))


@pytest.mark.parametrize(("letter", "halvings"), [("A", 0), ("D", 0), ("K", 1), ("K", 5), ("N", 1), ("N", 5)])
def test_they_are_those_of_automatic_differentiation(letter: str, halvings: int):
    at = information(3)
    expected = automatic(letter, at, halvings)
    assert curvature(letter, at, halvings) == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    as_function = curvature_function(letter, SIZE, halvings)(lower(at)).full()
    assert as_function == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("letter", "ADKN")
def test_where_eigenvalues_meet_they_are_the_limit_of_those_nearby(letter: str):
    together, apart = np.diag([1.0, 1.0, 1.0, 2.0, 2.0, 3.0]), np.diag([1.0, 1.001, 0.999, 2.0, 2.002, 3.0])
    expected = curvature(letter, apart, 1)
    assert curvature(letter, together, 1) == pytest.approx(expected, abs=0.02 * np.abs(expected).max())


@pytest.mark.parametrize("at", [np.diag([1.0, 1.0, -1.0]), np.full((3, 3), np.nan), np.zeros((3, 3))])
def test_information_that_is_not_positive_definite_has_none(at: np.ndarray):
    assert np.isnan(curvature("K", at, 1)).all()
