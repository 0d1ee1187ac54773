"""Criteria as functions of an information matrix: NumPy's own values, and two derivatives of them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.search.objective import Local, criterion_at
from tests.helpers import seeds, taylor_slope

SIZE = 6
LETTERS = [("A", 0), ("D", 0), ("K", 1), ("K", 4), ("N", 1), ("N", 4)]


def information(seed: int, size: int = SIZE) -> np.ndarray:
    rows = np.random.default_rng(seed).normal(size=(3 * size + 2, size))
    return rows.T @ rows / len(rows)


def symmetric(seed: int) -> np.ndarray:
    matrix = np.random.default_rng(seed).normal(size=(SIZE, SIZE))
    return matrix + matrix.T


def second(local: Local, along: np.ndarray) -> float:
    """Second derivative along a symmetric direction, as Lewis and Sendov state it."""
    turned = local.vectors.T @ along @ local.vectors
    main = np.diag(turned)
    apart = turned - np.diag(main)
    return float(main @ local.second @ main + (local.quotients * apart**2).sum())


@given(seed=st.integers(0, 2**32 - 1), size=st.integers(1, 10))
def test_a_and_d_are_trace_and_log_det_of_numpy(seed: int, size: int):
    at = information(seed, size)
    assert criterion_at("D", at).value == pytest.approx(-np.linalg.slogdet(at)[1] / size, rel=1e-9, abs=1e-9)
    trace = np.trace(np.linalg.inv(at)) / size
    assert criterion_at("A", at).value == pytest.approx(np.log(trace), rel=1e-8, abs=1e-8)


@given(seed=st.integers(0, 2**32 - 1), halvings=st.integers(0, 9))
def test_k_and_n_approach_singular_values_from_one_side_as_fast_as_they_promise(seed: int, halvings: int):
    at = information(seed)
    mu = np.sqrt(np.linalg.eigvalsh(at)[::-1])
    slack = np.log(SIZE) / 2.0 ** (halvings + 1) / 2
    for letter, exact, parts in (("K", mu[0] / mu[-1], 2), ("N", mu[0] / mu[-1] ** 2, 3)):
        value = criterion_at(letter, at, halvings).value
        assert np.log(exact) - 1e-9 <= value <= np.log(exact) + parts * slack + 1e-9


@pytest.mark.parametrize(("letter", "halvings"), LETTERS)
@seeds(3)
def test_first_and_second_derivatives_are_those_of_the_value(letter: str, halvings: int, seed: int):
    at, along = information(seed), 0.05 * symmetric(seed)
    local = criterion_at(letter, at, halvings)

    def value(h: float) -> np.ndarray:
        return np.array([criterion_at(letter, at + h * along, halvings).value])

    def slope(h: float) -> np.ndarray:
        return np.array([(criterion_at(letter, at + h * along, halvings).slope * along).sum()])

    assert taylor_slope(value, 0.0, slope(0.0), 0.1) == pytest.approx(2.0, abs=0.15)
    assert taylor_slope(slope, 0.0, np.array([second(local, along)]), 0.02) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("letter", "ADKN")
def test_where_eigenvalues_meet_derivatives_are_the_limit_of_those_nearby(letter: str):
    together, apart = np.diag([1.0, 1.0, 1.0, 2.0, 2.0, 3.0]), np.diag([1.0, 1.001, 0.999, 2.0, 2.002, 3.0])
    along = symmetric(1)
    expected = second(criterion_at(letter, apart, 1), along)
    assert second(criterion_at(letter, together, 1), along) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("at", [np.diag([1.0, 1.0, -1.0]), np.full((3, 3), np.nan), np.zeros((3, 3))])
@pytest.mark.parametrize("letter", "ADKN")
def test_information_that_is_not_positive_definite_has_no_value(letter: str, at: np.ndarray):
    local = criterion_at(letter, at, 1)
    assert np.isnan(local.value)
    assert np.isnan(local.first).all()
