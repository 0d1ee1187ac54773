"""No body has a negative density: estimates that say so are brought back, as little as possible, and said to be."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import least_squares

from cases.errors import IdentificationError
from identification.estimation import physical as module
from identification.estimation.channel_weights import per_channel
from identification.estimation.estimators import estimate_selected
from identification.estimation.fit import Filtered, Fit, Regression, gauss_markov
from identification.estimation.physical import THINNEST, consistent
from identification.parameters import pseudo_inertia, select
from tests.helpers import one_line
from tests.identification.moving_run import MODEL, NAMES, ONES, A, U, forces, truth_with
from tests.identification.point_masses import PointMasses

Array = np.ndarray
# Nearly a plate: I11 + I22 exceeds I33 by no more than the noise; half of all estimates lie on the wrong side.
PLATE = truth_with(inertia_kg_m2=(1.2, 0.0, 0.0, 0.9, 0.0, 2.0999))


def free(seed: int, truth: Array = PLATE) -> Fit:
    return gauss_markov(Regression(A, forces(seed, truth), NAMES), ONES)


@cache
def bound_seeds() -> list[int]:
    """Seeds whose free estimate belongs to no body, 20 of the first 60."""
    outside = [k for k in range(60) if np.linalg.eigvalsh(pseudo_inertia(free(k).values[:10]))[0] < 0.0]
    return outside[:20]


def bound(seed: int) -> tuple[Fit, tuple[Fit, float, float]]:
    """The seed-th inconsistent estimate, free and consistent with its rise of chi^2 and its probability."""
    seed = bound_seeds()[seed]
    start = free(seed)
    return start, consistent(Regression(A, forces(seed, PLATE), NAMES), start)


@pytest.mark.parametrize("seed", range(5))
def test_the_pseudo_inertia_is_the_second_moment_of_mass(seed: int) -> None:
    """Sum of m (r; 1) (r; 1)^T over point masses."""
    masses = PointMasses.drawn(seed)
    points = np.column_stack([masses.points, np.ones(len(masses.masses))])
    expected = np.einsum("k,ki,kj->ij", masses.masses, points, points)
    np.testing.assert_allclose(pseudo_inertia(np.array(list(masses.parameters.values()))), expected, atol=1e-12)


def test_a_consistent_estimate_is_left_alone() -> None:
    start = free(0, U)
    assert consistent(Regression(A, forces(0), NAMES), start) == (start, 0.0, 1.0)


def by_cholesky(start: Fit, guess: Array) -> tuple[float, Array]:
    """Least rise of chi^2 over J = L L^T (Rucker & Wensing 2022), without semidefinite programming."""
    root = np.linalg.cholesky(np.linalg.inv(start.covariance[:10, :10])).T
    lower = np.tril_indices(4)

    def body(x: Array) -> Array:
        factor = np.zeros((4, 4))
        factor[lower] = x
        second = factor @ factor.T
        sigma = second[:3, :3] + second[3, 3] * THINNEST**2 * np.eye(3)
        inertia = np.trace(sigma) * np.eye(3) - sigma
        return np.r_[second[3, 3], second[:3, 3], inertia[np.triu_indices(3)]]

    values, directions = np.linalg.eigh(pseudo_inertia(guess))
    near = directions @ np.diag(np.maximum(values, 1e-6)) @ directions.T
    result = least_squares(
        lambda x: root @ (body(x) - start.values[:10]),
        np.linalg.cholesky(near)[lower],
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-14,
        x_scale="jac",
    )
    return 2.0 * result.cost, body(result.x)


@pytest.mark.parametrize("seed", range(5))
def test_a_bound_estimate_is_the_nearest_consistent_one(seed: int) -> None:
    start, (result, found, _) = bound(seed)
    rise, body = by_cholesky(start, result.values[:10])
    assert found == pytest.approx(rise, rel=1e-5, abs=1e-6)
    std = np.sqrt(np.diag(start.covariance))
    np.testing.assert_allclose(result.values[:10] / std[:10], body / std[:10], atol=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_chi_squared_rises_by_what_is_said(seed: int) -> None:
    start, (result, told, _) = bound(seed)
    rise = np.sum(result.residuals**2) - np.sum(start.residuals**2)
    assert rise / start.s0**2 == pytest.approx(told, rel=1e-6, abs=1e-8)
    assert told > 0.0


@pytest.mark.parametrize("seed", range(3))
def test_a_bound_body_is_as_thin_as_it_may_be(seed: int) -> None:
    _, (result, *_) = bound(seed)
    body = result.values[:10]
    second = pseudo_inertia(body)
    assert np.linalg.eigvalsh(second)[0] > 0.0
    about_centre = second[:3, :3] / body[0] - np.outer(body[1:4], body[1:4]) / body[0] ** 2
    assert np.sqrt(np.linalg.eigvalsh(about_centre)[0]) == pytest.approx(THINNEST, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("truth", [U, PLATE], ids=["inside", "at the bound"])
def test_the_ellipsoid_of_the_free_estimate_holds_the_truth_at_least_as_often_about_the_consistent_one(truth) -> None:
    inside, bounds = [], 0
    for seed in range(100):
        start = free(seed, truth)
        result, rise, _ = consistent(Regression(A, forces(seed, truth), NAMES), start)
        distance = [(v - truth) @ np.linalg.solve(start.covariance, v - truth) for v in (start.values, result.values)]
        assert distance[1] <= distance[0] + 1e-6
        inside.append(distance[1] / 20 <= stats.f.ppf(0.95, 20, start.freedom))
        bounds += rise > 0.0
    assert np.mean(inside) >= 0.90
    assert (bounds == 0) if truth is U else (25 <= bounds <= 75)


def test_luck_and_wrong_data_are_told_apart() -> None:
    """Bodies at the bound look inconsistent by luck; a body with I33 > I11 + I22 by 50 % never does."""
    assert min(bound(k)[1][2] for k in range(20)) > 1e-3
    impossible = PLATE.copy()
    impossible[NAMES.index("I33")] *= 1.5
    _, rise, p_value = consistent(Regression(A, forces(0, impossible), NAMES), free(0, impossible))
    assert rise > 0.0
    assert p_value < 1e-6


@pytest.mark.parametrize("noise", [10.0, 1000.0])
@pytest.mark.parametrize("seed", range(3))
def test_light_bodies_lost_in_noise_get_a_body_too(noise: float, seed: int) -> None:
    truth = U.copy()
    truth[:10] = list(PointMasses(np.full(6, 0.1), PointMasses.drawn(seed).points * 0.2).parameters.values())
    measured = forces(seed, truth, noise)
    result, *_ = consistent(Regression(A, measured, NAMES), gauss_markov(Regression(A, measured, NAMES), ONES))
    assert np.linalg.eigvalsh(pseudo_inertia(result.values[:10]))[0] > 0.0


def test_what_is_fixed_stays_fixed() -> None:
    known = {"m": 31.83, "xC": 0.0, "k0": 24.0}
    selection = select(MODEL, known)
    for seed in range(10):
        measured = forces(seed, PLATE)
        start = estimate_selected(Regression(A, measured, NAMES), selection, lambda free: gauss_markov(free, ONES))
        values = consistent(Regression(A, measured, NAMES), start)[0].values
        assert (values[0], values[1], values[NAMES.index("k0")]) == (31.83, 0.0, 24.0)
        assert np.linalg.eigvalsh(pseudo_inertia(values[:10]))[0] > 0.0


def test_other_estimators_and_filters_are_served() -> None:
    for start in (
        per_channel(Regression(A, forces(1, PLATE), NAMES)),
        gauss_markov(Regression(A, forces(1, PLATE), NAMES, filtered=Filtered(0.1, 5)), ONES),
    ):
        result, *_ = consistent(Regression(A, forces(1, PLATE), NAMES), start)
        np.testing.assert_allclose(result.residuals, forces(1, PLATE) - A @ result.values)
        assert result.covariance is start.covariance
        assert result.s0 == start.s0


def test_a_solver_that_fails_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "ACCURACIES", (1e-30,))
    with pytest.raises(IdentificationError, match=r"no consistent body.*Clarabel") as caught:
        bound(0)
    one_line(caught.value)


def test_a_model_without_inertia_is_refused() -> None:
    with pytest.raises(IdentificationError, match=r"I11, .*I33 .*; .*models 6 to 9") as caught:
        consistent(Regression(A[:, :, :4], forces(0), NAMES[:4]), free(0))
    one_line(caught.value)


def test_a_sensor_read_the_wrong_way_round_wants_a_negative_mass_and_gets_none() -> None:
    start = free(0, U)
    turned = replace(start, values=-start.values)
    try:
        _, rise, p_value = consistent(Regression(A, -forces(0), NAMES), turned)
    except IdentificationError as error:
        one_line(error)
    else:
        assert rise > 0.0
        assert p_value < 1e-12
