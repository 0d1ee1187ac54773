"""The tighter bound: its proof encloses every state, and no closed motion inside the limits passes it."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from identification.model import identification_model
from identification.reference import reference_scaling
from planner.bound import compute_bound
from planner.bounds.features import box_features
from planner.bounds.moments import combined, motion_moments
from planner.bounds.tight import TightDesign, climb, tight_design
from planner.bounds.tight_certificate import TightDerivative, first_tight_cells
from tests.planner.bounds.test_moments import CASE, FAMILIES

MODEL = identification_model(CASE, 0)
SCALING = reference_scaling(CASE, MODEL)
FEATURES = box_features(CASE, MODEL, SCALING)
ALL = identification_model(CASE, 9)
ALL_FEATURES = box_features(CASE, ALL, reference_scaling(CASE, ALL))
PLACES = [3, 4, 5, 9, 10, 11]


@pytest.fixture(scope="module")
def found() -> TightDesign:
    return tight_design(CASE, FEATURES, 0.05, time.monotonic() + 60, rounds=3)


def bound_of(found: TightDesign) -> float:
    return found.logdet + 10 * np.log(found.dmax / 10)


def test_it_is_proven_and_above_the_best_design_that_was_found(found: TightDesign):
    assert found.certified
    assert found.dmax == found.proven >= 10
    assert found.attained <= bound_of(found)


def test_it_is_far_below_the_bound_of_the_box(found: TightDesign):
    assert bound_of(found) < compute_bound(CASE, MODEL).logdet - 0.3


@given(seed=st.integers(0, 2**32 - 1), make=st.sampled_from(FAMILIES))
@settings(max_examples=12, derandomize=True, deadline=None)
def test_no_closed_motion_inside_the_limits_passes_it(seed: int, make, found: TightDesign):
    motion = make(seed)
    states = np.hstack([motion.pose, motion.rates, motion.accelerations])
    matrices = FEATURES.matrices((states - FEATURES.middle) / FEATURES.half)
    information = np.einsum("nki,nkj->ij", matrices, matrices, optimize=True) / len(matrices)
    assert np.linalg.slogdet(information)[1] < bound_of(found)


def random_derivative(seed: int) -> TightDerivative:
    draw = np.random.default_rng(seed)
    root = draw.normal(size=(20, 25))
    moments = motion_moments(CASE, ALL_FEATURES)
    of_equal = 0.3 * draw.normal(size=len(moments.equal))
    multipliers = combined(moments, of_equal, draw.uniform(0.0, 2.0, len(moments.at_most)))
    return TightDerivative(ALL_FEATURES, ALL_FEATURES.form(root @ root.T / 25), multipliers)


@pytest.mark.parametrize("seed", range(10))
def test_upper_bounds_are_above_every_state_of_their_cell(seed: int):
    draw = np.random.default_rng(seed)
    derivative = random_derivative(seed)
    low, high = first_tight_cells(ALL_FEATURES)
    first, second = draw.uniform(low[0], high[0], (2, 4, 12))
    low, high = np.minimum(first, second), np.maximum(first, second)
    low[2:], high[2:] = (low[2:] + high[2:]) / 2, (low[2:] + high[2:]) / 2 + 0.02  # small ones too
    answer = derivative(low, high)
    for k in range(4):
        inside = draw.uniform(low[k], high[k], (4000, 12))
        edge = draw.random((4000, 12)) < 0.5
        inside = np.where(edge, np.where(draw.random((4000, 12)) < 0.5, low[k], high[k]), inside)
        shares = draw.choice([-1.0, 1.0], (4000, 18))
        shares[:, PLACES] = (inside[:, :6] - ALL_FEATURES.middle[PLACES]) / ALL_FEATURES.half[PLACES]
        shares[:, 12:] = inside[:, 6:]
        assert derivative.at(shares).max() <= answer.upper[k] + 1e-9
        assert derivative.at(answer.point[k][None])[0] == pytest.approx(answer.lower[k])
    assert np.all(answer.lower <= answer.upper + 1e-9)
    gap = answer.upper - answer.lower
    assert gap[2:].max() < 0.1 * gap[:2].max() + 0.5  # and not by much where cells are small


def test_a_climb_ends_no_lower_than_it_began():
    derivative = random_derivative(3)
    draw = np.random.default_rng(0)
    known = draw.uniform(-1.0, 1.0, (20, 18))
    states, values = climb(derivative, known, draw)
    assert values.max() >= derivative.at(known).max()
    assert np.allclose(derivative.at(states), values)
    assert np.abs(states).max() <= 1.0


def test_without_time_for_the_proof_it_is_an_estimate():
    hasty = tight_design(CASE, FEATURES, 0.01, time.monotonic(), rounds=1)
    assert not hasty.certified
    assert hasty.proven >= hasty.dmax
