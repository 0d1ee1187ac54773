"""The information limit of the box: no motion passes it, and its certificate holds against independent search."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.schema import load_case
from identification.estimation.criteria import reference_scaling, uniform_states
from identification.limits.proof import prove
from identification.machines.casadi_batch import over_samples
from identification.model.model import identification_model
from planner.bounds.bound import GAP, Bound, compute_bound
from planner.bounds.certificate import box_bounds, first_cells
from planner.bounds.design import Design, improved_weights, optimal_design
from planner.bounds.features import box_features
from planner.families.fourier import FourierFamily
from planner.noise import mean_information
from tests.helpers import examples, seeds
from tests.postprocessors.changed_case import changed

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 6)  # with inertia: rates count
SCALING = reference_scaling(CASE, MODEL)
SIZE = len(MODEL.parameters)
FEATURES = box_features(CASE, MODEL, SCALING)


@pytest.fixture(scope="module")
def found() -> Bound:
    return compute_bound(CASE, MODEL)


@pytest.fixture(scope="module")
def design() -> Design:
    return optimal_design(FEATURES, GAP, time.process_time() + 60)


def scaled_matrices(count: int, seed: int) -> np.ndarray:
    """Scaled regressors of random states: half of them anywhere in the box, half on its corners, edges and middles."""
    states = uniform_states(CASE, count, seed)
    box, home = CASE.limits.motion, CASE.machine.home.vector
    signs = np.random.default_rng(seed).choice([-1.0, 0.0, 1.0], (count, 18))
    pose = np.where(signs[:, :6] > 0, box.coordinates[1], box.coordinates[0]) * np.abs(signs[:, :6])
    corners = (home + pose, signs[:, 6:12] * box.rate, signs[:, 12:] * box.acceleration)
    both = [np.vstack([a, b]) for a, b in zip(states, corners, strict=True)]
    return over_samples(MODEL.coordinate_regressor, *both)[0] * SCALING


def inverse_of(design: Design) -> np.ndarray:
    matrices = FEATURES.matrices(design.states)
    return np.linalg.inv(np.einsum("n,nki,nkj->ij", design.weights, matrices, matrices))


def test_the_proof_ends_with_the_gap_that_it_promises(found: Bound, design: Design):
    assert found.certified
    assert found.parameters == SIZE == 16
    assert SIZE <= found.dmax <= SIZE * (1 + GAP) * (1 + 1e-9)
    assert found.design_logdet == pytest.approx(-np.linalg.slogdet(inverse_of(design))[1])
    assert found.logdet == pytest.approx(found.design_logdet + SIZE * np.log(found.dmax / SIZE))


@seeds(3)
def test_no_random_state_has_a_larger_derivative_than_what_was_proven(seed: int, design: Design):
    matrices = scaled_matrices(20_000, seed)
    derivative = np.einsum("nki,ij,nkj->n", matrices, inverse_of(design), matrices, optimize=True)
    assert derivative.max() <= design.dmax
    assert derivative.max() > 0.5 * SIZE  # the states come near enough for the comparison to mean something


def test_climbing_from_many_starts_never_passes_what_was_proven(design: Design):
    """Coordinate by coordinate, with the derivative computed from the regressor and not from the features."""
    inverse = inverse_of(design)
    draw = np.random.default_rng(0)
    shares = draw.choice([-1.0, 1.0], (300, 18)) * np.r_[np.ones(3), draw.random(3), np.ones(12)]

    def derivative(shares: np.ndarray) -> np.ndarray:
        states = FEATURES.middle + FEATURES.half * shares
        matrices = over_samples(MODEL.coordinate_regressor, states[:, :6], states[:, 6:12], states[:, 12:])[0] * SCALING
        return np.einsum("nki,ij,nkj->n", matrices, inverse, matrices, optimize=True)

    value = derivative(shares)
    for _ in range(3):
        for k in [0, 1, *range(3, 6), *range(9, 18)]:
            for level in (-1.0, -0.5, 0.0, 0.5, 1.0):
                moved = shares.copy()
                moved[:, k] = level
                new = derivative(moved)
                better = new > value
                shares[better], value[better] = moved[better], new[better]
    assert value.max() <= design.dmax
    assert value.max() > 0.999 * SIZE


def test_the_enclosure_is_above_every_state_of_its_cell(design: Design):
    """Upper bounds over random small cells against states inside; lower bounds against the state that they name."""
    form = FEATURES.form(inverse_of(design))
    draw = np.random.default_rng(3)
    low, high = first_cells(FEATURES)
    first, second = (draw.uniform(low[0], high[0], (6, 6)) for _ in range(2))
    low, high = np.minimum(first, second), np.maximum(first, second)
    upper, lower, points, _ = box_bounds(FEATURES, form, low, high)
    for k in range(6):
        shares = draw.choice([-1.0, 1.0], (3000, 18))
        inside = draw.uniform(low[k], high[k], (3000, 6))
        coordinates = [3, 4, 5, 9, 10, 11]
        shares[:, coordinates] = (inside - FEATURES.middle[coordinates]) / FEATURES.half[coordinates]
        y = FEATURES.of(shares)
        assert np.einsum("nk,kl,nl->n", y, form, y).max() <= upper[k]
        y = FEATURES.of(points[k][None])[0]
        assert y @ form @ y == pytest.approx(lower[k], rel=1e-9)
    assert np.all(lower <= upper)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(4, 40))
@settings(max_examples=examples(10))
def test_no_design_of_states_in_the_box_passes_the_bound(seed: int, count: int, found: Bound):
    matrices = scaled_matrices(count, seed)
    weights = np.random.default_rng(seed).dirichlet(np.ones(len(matrices)))
    information = np.einsum("n,nki,nkj->ij", weights, matrices, matrices)
    assert np.linalg.slogdet(information)[1] < found.logdet


@seeds(6)
def test_no_motion_inside_the_limits_passes_the_bound(seed: int, found: Bound):
    half = np.ptp(CASE.limits.motion.coordinates, axis=0) / 2
    family = FourierFamily(2 + seed, 3.0, 1, CASE.machine.home.vector, half)
    unknowns = np.random.default_rng(seed).normal(size=family.unknowns * 6)
    unknowns /= prove(family.motion(unknowns), CASE, 1000.0).worst_ratio
    logdet = np.linalg.slogdet(mean_information(MODEL, SCALING, family.motion(unknowns)))[1]
    assert 0.0 < found.efficiency(float(logdet)) < 1.0


def test_efficiency_is_one_at_the_bound_and_counts_parameters():
    some = Bound(3.0, 10.0, 10, "", True, 3.0)
    assert some.efficiency(3.0) == 1.0
    assert some.efficiency(3.0 - 10 * np.log(2)) == pytest.approx(0.5)


def test_the_bound_is_the_same_each_time_it_is_computed(found: Bound):
    assert compute_bound(CASE, MODEL) == found


@pytest.mark.repeats
def test_more_room_carries_more_information(found: Bound):
    """In one scaling."""
    case = changed(CASE, limits__motion__acceleration_m_s2=[9.0, 9.0, 9.0], limits__motion__a_deg=[-30.0, 30.0])
    unscaled = 2 * np.log(reference_scaling(case, MODEL) / SCALING).sum()
    assert compute_bound(case, MODEL).logdet - unscaled > found.logdet


def test_without_time_the_answer_calls_itself_an_estimate():
    hasty = compute_bound(CASE, MODEL, time_limit=1e-9)
    assert not hasty.certified
    assert hasty.label == "an estimate"
    assert "estimate" in hasty.method
    assert hasty.design_logdet <= hasty.logdet


@seeds(4)
def test_a_step_of_the_multiplicative_algorithm_never_loses_information(seed: int):
    matrices = scaled_matrices(60, seed)
    products = np.einsum("nki,nkj->nij", matrices, matrices).reshape(len(matrices), -1)
    weights = np.full(len(matrices), 1.0 / len(matrices))
    before = -np.inf
    for _ in range(40):
        now = np.linalg.slogdet((weights @ products).reshape(SIZE, SIZE))[1]
        assert now >= before - 1e-9
        assert weights.sum() == pytest.approx(1.0)
        assert weights.min() >= 0.0
        before = now
        weights = improved_weights(products, weights, SIZE, 0.0, steps=1)


def test_derivatives_add_up_to_the_number_of_parameters_under_any_design():
    """Sum w d = trace(F F^-1): the largest derivative is never below it, which is what makes the bound a bound."""
    matrices = scaled_matrices(200, 0)
    weights = np.random.default_rng(0).dirichlet(np.ones(len(matrices)))
    inverse = np.linalg.inv(np.einsum("n,nki,nkj->ij", weights, matrices, matrices))
    assert weights @ np.einsum("nki,ij,nkj->n", matrices, inverse, matrices) == pytest.approx(SIZE)
