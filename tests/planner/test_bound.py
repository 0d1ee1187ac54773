"""The information limit of the box: no motion inside passes it, and the algorithm behind it only ever climbs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.loading import load_case
from identification.evaluate import over_samples
from identification.limits import prove
from identification.model import identification_model
from identification.reference import reference_scaling, uniform_states
from planner import bound as bound_module
from planner.bound import GAP, Bound, compute_bound
from planner.fourier import FourierFamily
from planner.problem import mean_information
from tests.postprocessors.changed_case import changed

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 0)
SCALING = reference_scaling(CASE, MODEL)
SIZE = len(MODEL.parameters)


@pytest.fixture(scope="module")
def searched() -> tuple[Bound, np.ndarray]:
    """The bound of model 0, and the inverse information of the design that it ends with."""
    seen: list[np.ndarray] = []
    maximise = bound_module._Search.maximise

    def watched(self, inverse, known, draw):
        seen.append(inverse)
        return maximise(self, inverse, known, draw)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bound_module._Search, "maximise", watched)
        return compute_bound(CASE, MODEL), seen[-1]


def scaled_matrices(count: int, seed: int) -> np.ndarray:
    """Scaled regressors of random states: half of them anywhere in the box, half on its corners."""
    states = uniform_states(CASE, count, seed)
    box, home = CASE.limits.motion, CASE.machine.home.vector
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], (count, 18))
    corners = (home + np.where(signs[:, :6] > 0, box.pose[1], box.pose[0]), signs[:, 6:12] * box.rate)
    corners = (*corners, signs[:, 12:] * box.acceleration)
    both = [np.vstack([a, b]) for a, b in zip(states, corners, strict=True)]
    return over_samples(MODEL.coordinate_regressor, *both)[0] * SCALING


def test_the_search_ends_with_the_gap_that_it_promises(searched: tuple[Bound, np.ndarray]):
    found, inverse = searched
    assert found.parameters == SIZE == 10
    assert SIZE <= found.dmax <= SIZE * (1 + GAP)
    design = -np.linalg.slogdet(inverse)[1]
    assert found.logdet == pytest.approx(design + SIZE * np.log(found.dmax / SIZE))
    assert "estimate" in found.method


@pytest.mark.parametrize("seed", range(3))
def test_no_random_state_has_a_larger_derivative_than_the_one_that_was_found(
    seed: int, searched: tuple[Bound, np.ndarray]
):
    found, inverse = searched
    matrices = scaled_matrices(20_000, seed)
    derivative = np.einsum("nki,ij,nkj->n", matrices, inverse, matrices, optimize=True)
    assert derivative.max() <= found.dmax * (1 + 1e-6)
    assert derivative.max() > 0.5 * SIZE  # the states come near enough for the comparison to mean something


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(4, 40))
@settings(max_examples=30)
def test_no_design_of_states_in_the_box_passes_the_bound(seed: int, count: int, searched: tuple[Bound, np.ndarray]):
    matrices = scaled_matrices(count, seed)
    weights = np.random.default_rng(seed).dirichlet(np.ones(len(matrices)))
    information = np.einsum("n,nki,nkj->ij", weights, matrices, matrices)
    assert np.linalg.slogdet(information)[1] < searched[0].logdet


@pytest.mark.parametrize("seed", range(6))
def test_no_motion_inside_the_limits_passes_the_bound(seed: int, searched: tuple[Bound, np.ndarray]):
    half = np.ptp(CASE.limits.motion.pose, axis=0) / 2
    family = FourierFamily(2 + seed, 3.0, 1, CASE.machine.home.vector, half, 12)
    unknowns = np.random.default_rng(seed).normal(size=family.unknowns * 6)
    unknowns /= prove(family.motion(unknowns), CASE, 1000.0).worst_ratio
    logdet = np.linalg.slogdet(mean_information(MODEL, SCALING, family.motion(unknowns)))[1]
    assert 0.0 < searched[0].efficiency(float(logdet)) < 1.0


def test_efficiency_is_one_at_the_bound_and_counts_parameters():
    some = Bound(3.0, 10.0, 10, "")
    assert some.efficiency(3.0) == 1.0
    assert some.efficiency(3.0 - 10 * np.log(2)) == pytest.approx(0.5)


def test_the_bound_is_the_same_each_time_it_is_computed(searched: tuple[Bound, np.ndarray]):
    assert compute_bound(CASE, MODEL) == searched[0]


def test_more_room_carries_more_information(searched: tuple[Bound, np.ndarray]):
    """In one scaling; without inertia only gravity and accelerations excite the parameters of model 0."""
    case = changed(CASE, limits__motion__acceleration_m_s2=[9.0, 9.0, 9.0], limits__motion__a_deg=[-30.0, 30.0])
    unscaled = 2 * np.log(reference_scaling(case, MODEL) / SCALING).sum()
    assert compute_bound(case, MODEL).logdet - unscaled > searched[0].logdet


@pytest.mark.parametrize("seed", range(4))
def test_a_step_of_the_multiplicative_algorithm_never_loses_information(seed: int, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(bound_module, "WEIGHT_STEPS", 1)
    matrices = scaled_matrices(60, seed)
    products = bound_module._products(matrices)
    weights = np.full(len(matrices), 1.0 / len(matrices))
    before = -np.inf
    for _ in range(40):
        now = np.linalg.slogdet((weights @ products).reshape(SIZE, SIZE))[1]
        assert now >= before - 1e-9
        assert weights.sum() == pytest.approx(1.0)
        assert weights.min() >= 0.0
        before = now
        weights = bound_module._multiplicative(products, weights, SIZE)


def test_derivatives_add_up_to_the_number_of_parameters_under_any_design():
    """Sum w d = trace(F F^-1): the largest derivative is never below it, which is what makes the bound a bound."""
    matrices = scaled_matrices(200, 0)
    weights = np.random.default_rng(0).dirichlet(np.ones(len(matrices)))
    information = np.einsum("n,nki,nkj->ij", weights, matrices, matrices)
    inverse = np.linalg.inv(information)
    search = bound_module._Search(CASE, MODEL, SCALING)
    shares = np.random.default_rng(1).uniform(-1, 1, (50, 18))
    ours = np.einsum("nki,ij,nkj->n", search.matrices(shares), inverse, search.matrices(shares))
    values, gradient = search._derivative(shares, np.linalg.cholesky(inverse))
    assert np.allclose(values, ours, rtol=1e-9)
    h = 1e-6
    moved = shares + h * np.eye(18)[4]
    slope = (search._derivative(moved, np.linalg.cholesky(inverse))[0] - values) / h
    assert np.allclose(gradient[:, 4], slope, rtol=1e-3, atol=1e-3)
    assert weights @ np.einsum("nki,ij,nkj->n", matrices, inverse, matrices) == pytest.approx(SIZE)
