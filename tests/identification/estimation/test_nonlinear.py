"""The non-linear form (18) says what the linear one says, and more where knowledge is not linear."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.errors import IdentificationError
from identification.estimation import physical as solver
from identification.estimation.estimators import estimate_selected
from identification.estimation.fit import Filtered, Regression, gauss_markov
from identification.estimation.force_noise import with_kernel
from identification.estimation.physical import nonlinear
from identification.model import identification_model
from identification.parameters import physical_form, select
from tests.helpers import one_line, paper_poses, taylor_slope
from tests.identification.moving_run import CASE, FORM, MODEL, NAMES, ONES, PHYSICAL, A, U, coverage, forces

Array = np.ndarray
TRUE = FORM.of(U, np.eye(20))[0]


def linear(p: Array) -> Array:
    return FORM.inverse(p)[0].full()[:, 0]


@pytest.mark.parametrize("number", range(10))
def test_it_is_the_inverse_of_the_physical_form(number: int) -> None:
    model = identification_model(CASE, number)
    u = np.random.default_rng(number).uniform(1.0, 2.0, len(model.names))
    form = physical_form(model)
    values, jacobian = (v.full() for v in form.map(u))
    back, inverse = (v.full() for v in form.inverse(values[:, 0]))
    np.testing.assert_allclose(back[:, 0], u, rtol=1e-12)
    np.testing.assert_allclose(inverse @ jacobian, np.eye(len(u)), atol=1e-9)


def test_its_derivative_is_right() -> None:
    direction, jacobian = np.random.default_rng(0).normal(size=20), FORM.inverse(TRUE)[1].full()
    slope = taylor_slope(lambda h: linear(TRUE + h * direction), 0.0, jacobian @ direction, 0.1)
    assert slope == pytest.approx(2.0, abs=0.1)


def test_newton_and_euler_about_the_centre_of_gravity_give_the_same_forces() -> None:
    """(18) by hand: m (a_C - g), I_C alpha + omega x I_C omega + xC x force, carried by the bars."""
    draw = np.random.default_rng(1)
    p = np.r_[30.0, 0.1, -0.05, 0.12, 1.3, 0.1, -0.2, 1.1, 0.05, 0.9, np.zeros(10)]
    centre, inertia = p[1:4], np.array([[p[4], p[5], p[6]], [p[5], p[7], p[8]], [p[6], p[8], p[9]]])
    for _ in range(5):
        turn = Rotation.from_rotvec(draw.normal(size=3)).as_matrix()
        twist, rate = draw.normal(size=(2, 6))
        omega, alpha = turn.T @ twist[3:], turn.T @ rate[3:]
        acceleration = turn.T @ (rate[:3] - CASE.gravity) + np.cross(alpha, centre)
        force = 30.0 * (acceleration + np.cross(omega, np.cross(omega, centre)))
        moment = inertia @ alpha + np.cross(omega, inertia @ omega) + np.cross(centre, force)
        expected = np.linalg.solve(MODEL.structure, np.r_[force, moment])
        found = MODEL.matrices(np.zeros((1, 3)), turn[None], twist[None], rate[None])[0] @ linear(p)
        np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("seed", range(5))
def test_with_all_parameters_free_it_is_the_linear_estimate_propagated(seed: int) -> None:
    weights = np.array([1.0, 2.0, 0.5, 1.0, 4.0, 0.1])
    expected = with_kernel(gauss_markov(regression := Regression(A, forces(seed), NAMES), weights), regression)
    values, covariance = FORM.of(expected.values, expected.covariance)
    found = nonlinear(Regression(A, forces(seed), NAMES), MODEL, weights, {})
    own, spread = FORM.of(found.values, found.covariance)
    np.testing.assert_allclose(own, values, rtol=1e-9)
    np.testing.assert_allclose(np.diag(spread), np.diag(covariance), rtol=1e-9)
    np.testing.assert_allclose(found.values, expected.values, rtol=1e-9)
    np.testing.assert_allclose(np.diag(found.covariance_robust), np.diag(expected.covariance_robust), rtol=1e-7)
    assert (found.s0, found.freedom) == (pytest.approx(expected.s0, rel=1e-9), expected.freedom)


def test_a_static_model_is_served_too() -> None:
    model = identification_model(CASE, 5)
    matrices = model.matrices(*paper_poses(), np.zeros((480, 6)), np.zeros((480, 6)))
    measured = matrices @ U[[0, 1, 2, 3, *range(10, 20)]] + np.random.default_rng(0).normal(size=(480, 6))
    regression = Regression(matrices, measured, model.names)
    expected = gauss_markov(regression, ONES)
    found = nonlinear(regression, model, ONES, {})
    np.testing.assert_allclose(found.values, expected.values, rtol=1e-9)


def test_known_values_that_are_linear_give_the_partial_linear_estimate() -> None:
    known = {"m": 31.0, "xC": 0.0, "yC": 0.0, "zC": 0.1, "IC11": 1.3, "k0": 24.0}
    expected = estimate_selected(
        Regression(A, forces(0), NAMES), select(MODEL, known), lambda free: gauss_markov(free, ONES)
    )
    found = nonlinear(Regression(A, forces(0), NAMES), MODEL, ONES, known)
    np.testing.assert_allclose(found.values, expected.values, rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(found.covariance, expected.covariance, rtol=1e-8, atol=1e-14)
    assert (found.freedom, found.rank) == (expected.freedom, expected.rank)


def test_a_known_central_inertia_without_its_centre_of_gravity_is_the_least_squares_one() -> None:
    """Not linear: no small change along the free parameters lowers chi^2."""
    known = {"IC11": 1.26, "IC22": 1.21, "IC33": 0.91}
    found = nonlinear(Regression(A, forces(0), NAMES), MODEL, ONES, known)
    values, covariance = FORM.of(found.values, found.covariance)
    for name, value in known.items():
        assert values[PHYSICAL.index(name)] == pytest.approx(value, rel=1e-12)
        assert covariance[PHYSICAL.index(name), PHYSICAL.index(name)] == pytest.approx(0.0, abs=1e-15)
    jacobian = A.reshape(-1, 20) @ FORM.inverse(values)[1].full()
    free = [k for k, name in enumerate(PHYSICAL) if name not in known]
    gradient = jacobian[:, free].T @ found.residuals.ravel()
    sizes = np.linalg.norm(jacobian[:, free], axis=0) * np.linalg.norm(found.residuals)
    np.testing.assert_allclose(gradient / sizes, 0.0, atol=1e-10)


def test_intervals_hold_the_truth_in_95_of_100_where_the_problem_is_not_linear() -> None:
    def fit(seed: int):
        return nonlinear(Regression(A, forces(seed), NAMES), MODEL, ONES, {"IC11": 1.26, "IC13": 0.0})

    assert 0.92 <= coverage(fit, U) <= 0.98


def test_a_filter_and_nuisances_are_treated_as_in_the_linear_estimate() -> None:
    late, filtered = np.random.default_rng(2).normal(size=(200, 6, 1)), Filtered(0.1, 5)
    wide = np.dstack([A, late])
    regression = Regression(wide, forces(0), [*NAMES, "delay"], 1, filtered)
    expected = gauss_markov(regression, ONES)
    found = nonlinear(regression, MODEL, ONES, {})
    np.testing.assert_allclose(found.values, expected.values, rtol=1e-8)
    np.testing.assert_allclose(found.covariance, expected.covariance, rtol=1e-8, atol=1e-14)
    assert (found.s0, found.rank) == (pytest.approx(expected.s0), expected.rank)


def test_data_without_noise_give_the_parameters_exactly() -> None:
    found = nonlinear(Regression(A, A @ U, NAMES), MODEL, ONES, {})
    np.testing.assert_allclose(FORM.of(found.values, found.covariance)[0], TRUE, rtol=1e-9, atol=1e-11)


def test_a_search_that_fails_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solver, "STEPS", 1)
    with pytest.raises(IdentificationError, match=r"not become small.*\b1\b"):
        nonlinear(Regression(A, forces(0), NAMES), MODEL, ONES, {})


@pytest.mark.parametrize(
    ("known", "message"),
    [
        ({"mxC": 0.0}, "knows physical parameters, not mxC; fix m, xC"),
        ({"k9": 0.0}, "'k9' is not a parameter here; choose from m, xC"),
        ({"xC": np.inf}, "a known value must be finite"),
        ({"m": -1.0}, "a known mass above zero"),
        (dict.fromkeys(PHYSICAL, 1.0), "all parameters are known"),
    ],
)
def test_what_cannot_be_known_is_said_in_a_line(known, message: str) -> None:
    with pytest.raises(IdentificationError, match=message) as caught:
        nonlinear(Regression(A, forces(0), NAMES), MODEL, ONES, known)
    one_line(caught.value)


def test_parameters_that_a_standstill_does_not_determine_are_named() -> None:
    still = MODEL.matrices(*paper_poses(), np.zeros((480, 6)), np.zeros((480, 6)))
    with pytest.raises(IdentificationError, match=r"rank 14 of 20: IC11, IC12, ") as caught:
        nonlinear(Regression(still, still @ U, NAMES), MODEL, ONES, {})
    one_line(caught.value)
