"""Kernels give what CasADi gives, at many vectors at once, and remember the last."""

import casadi as ca
import numpy as np
import pytest

from planner.families.states import Kernel


@pytest.fixture
def kernel() -> Kernel:
    x = ca.SX.sym("x", 3)
    return Kernel(x, ca.vertcat(x[0] * ca.sin(x[1]), 2.0, ca.exp(x[2]) * x[0] ** 2, x[1]))


def test_values_slopes_and_curvature_are_those_of_casadi(kernel: Kernel):
    draw = np.random.default_rng(0)
    at, weights = draw.normal(size=(7, 3)), draw.normal(size=(7, kernel.size))
    w, x = ca.SX.sym("w", kernel.size), kernel.variables
    jacobian = ca.Function("j", [x], [ca.jacobian(kernel.expression, x)])
    hessian = ca.Function("h", [x, w], [ca.hessian(ca.dot(w, kernel.expression), x)[0]])
    values, slopes = kernel.slopes(at)
    bent = kernel.curvature(at, weights)
    for k in range(7):
        expected = [at[k, 0] * np.sin(at[k, 1]), 2.0, np.exp(at[k, 2]) * at[k, 0] ** 2, at[k, 1]]
        assert values[k] == pytest.approx(np.array(expected), abs=1e-14)
        assert slopes[k] == pytest.approx(jacobian(at[k]).full().T, abs=1e-14)
        assert bent[k] == pytest.approx(hessian(at[k], weights[k]).full(), abs=1e-14)
    assert np.array_equal(kernel.values(at), values)


def test_it_remembers_the_last_slopes_and_no_others(kernel: Kernel):
    at = np.random.default_rng(1).normal(size=(2, 3))
    first = kernel.slopes(at)
    assert kernel.slopes(at.copy())[1] is first[1]
    with pytest.raises(ValueError, match="read-only"):
        first[1][0, 0, 0] = 1.0
    before = first[0].copy()
    at[0, 0] += 1.0  # the caller's own array may change
    second = kernel.slopes(at)
    assert second[0][0, 0] != before[0, 0]
    assert np.array_equal(first[0], before)


@pytest.mark.parametrize("count", [0, 1, 5])
def test_any_number_of_vectors_will_do(count: int, kernel: Kernel):
    at = np.zeros((count, 3))
    assert kernel.values(at).shape == (count, 4)
    values, slopes = kernel.slopes(at)
    assert (values.shape, slopes.shape) == ((count, 4), (count, 3, 4))
    assert kernel.curvature(at, np.ones((count, 4))).shape == (count, 3, 3)
