"""Laws that the criteria of Table 4 obey, whatever the machine."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.errors import IdentificationError
from identification.estimation.criteria import Criterion, singular_values
from tests.helpers import one_line

REGRESSOR = np.random.default_rng(0).normal(size=(60, 5))
MORE = np.vstack([REGRESSOR, np.random.default_rng(1).normal(size=(6, 5))])
NAMES = ["m", "mxC", "myC", "mzC", "k0"]


def value(letter: str, regressor: np.ndarray) -> float:
    return Criterion(letter).of_singular_values(singular_values(regressor.T @ regressor, NAMES))


@pytest.mark.parametrize(
    ("letter", "expected"),
    [
        ("A", lambda f, mu: -np.trace(np.linalg.inv(f))),
        ("D", lambda f, mu: np.log(np.linalg.det(f))),
        ("K", lambda f, mu: -mu[0] / mu[-1]),
        ("N", lambda f, mu: mu[-1] ** 2 / mu[0]),
    ],
)
def test_a_criterion_is_the_one_printed_in_table_4(letter: str, expected) -> None:
    mu = np.linalg.svd(REGRESSOR, compute_uv=False)
    assert value(letter, REGRESSOR) == pytest.approx(expected(REGRESSOR.T @ REGRESSOR, mu), rel=1e-10)


@pytest.mark.parametrize("letter", ["A", "D"])
def test_more_measurements_never_lose_information(letter: str) -> None:
    assert value(letter, MORE) > value(letter, REGRESSOR)


@given(factor=st.floats(0.01, 100.0))
def test_condition_does_not_depend_on_the_unit_of_force(factor: float) -> None:
    assert value("K", factor * REGRESSOR) == pytest.approx(value("K", REGRESSOR), rel=1e-9)


@given(copies=st.integers(2, 9))
def test_measuring_everything_again_improves_all_but_the_condition(copies: int) -> None:
    """F becomes c F: A falls with c, D grows by u log c, K stays, N grows with the root of c."""
    again = np.vstack([REGRESSOR] * copies)
    assert value("A", again) == pytest.approx(value("A", REGRESSOR) / copies)
    assert value("D", again) == pytest.approx(value("D", REGRESSOR) + 5 * np.log(copies))
    assert value("K", again) == pytest.approx(value("K", REGRESSOR))
    assert value("N", again) == pytest.approx(value("N", REGRESSOR) * np.sqrt(copies))


def test_d_ranks_motions_the_same_under_any_column_scaling() -> None:
    """Column scaling adds the same constant to log det of every motion."""
    scaling = np.diag([1.0, 10.0, 0.1, 3.0, 7.0])
    gain = value("D", MORE) - value("D", REGRESSOR)
    assert value("D", MORE @ scaling) - value("D", REGRESSOR @ scaling) == pytest.approx(gain)


def test_orthonormal_columns_are_the_ideal_of_k() -> None:
    assert value("K", np.linalg.qr(REGRESSOR)[0]) == pytest.approx(-1.0)


@pytest.mark.parametrize("nothing", range(5))
def test_a_parameter_that_nothing_excites_is_named(nothing: int) -> None:
    silent = REGRESSOR * (np.arange(5) != nothing)
    with pytest.raises(IdentificationError, match=rf"rank 4 of 5: {NAMES[nothing]}\b") as caught:
        singular_values(silent.T @ silent, NAMES)
    one_line(caught.value)


def test_parameters_that_only_their_sum_excites_are_named_together() -> None:
    twins = np.column_stack([REGRESSOR[:, :4], REGRESSOR[:, 1]])
    with pytest.raises(IdentificationError, match="mxC, k0 not determined"):
        singular_values(twins.T @ twins, NAMES)


def test_no_measurement_at_all_determines_nothing() -> None:
    with pytest.raises(IdentificationError, match=r"rank 0 of 5: m, mxC, myC, mzC, k0\b"):
        singular_values(np.zeros((5, 5)), NAMES)
