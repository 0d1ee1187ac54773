"""One QR keeps all that a regression says about its unknowns."""

import numpy as np
import pytest

from cases.base.errors import IdentificationError
from identification.estimation.fit import (
    Filtered,
    Regression,
    compress,
    degrees_of_freedom,
    determined,
    inverse_root,
)
from tests.helpers import one_line
from tests.identification.moving_run import NAMES, A, U, forces

WEIGHTS = np.array([1.0, 2.0, 0.5, 1.0, 4.0, 0.1])


def test_chi_squared_is_that_of_the_full_problem_everywhere() -> None:
    measured, draw = forces(0), np.random.default_rng(1)
    root, right, rest = compress(Regression(A, measured, NAMES), WEIGHTS)
    for u in (U, np.zeros(20), U + draw.normal(size=20)):
        direct = np.sum(WEIGHTS * (measured - A @ u) ** 2)
        assert np.sum((right - root @ u) ** 2) + rest == pytest.approx(direct, rel=1e-12)
    assert root.shape == (20, 20)


def test_its_inverse_root_is_a_root_of_the_inverse_whatever_the_units() -> None:
    root = np.random.default_rng(2).normal(size=(8, 4)) * [1.0, 1e6, 1e-6, 30.0]
    inverse = inverse_root(root) @ inverse_root(root).T
    np.testing.assert_allclose(inverse @ root.T @ root, np.eye(4), atol=1e-9 * 1e12)
    np.testing.assert_allclose(root @ inverse @ root.T @ root, root, rtol=1e-9)


def test_what_nothing_excites_is_named() -> None:
    root = np.triu(np.ones((3, 3)))
    assert determined(root, ["m", "k0", "k1"], 60)[0] == 3
    root[:, 1] = 2.0 * root[:, 0]
    with pytest.raises(IdentificationError, match=r"rank 2 of 3: m, k0\b") as caught:
        determined(root, ["m", "k0", "k1"], 60)
    one_line(caught.value)


def test_too_few_forces_are_refused() -> None:
    with pytest.raises(IdentificationError, match=r"3 samples.* 18 forces.* 20 unknowns") as caught:
        compress(Regression(A[:3], forces(0)[:3], NAMES), WEIGHTS)
    one_line(caught.value)
    with pytest.raises(IdentificationError, match=r"24 forces, 12 .*independent.* 20 unknowns") as caught:
        degrees_of_freedom(24, 20, Filtered(0.1, 5))
    one_line(caught.value)
