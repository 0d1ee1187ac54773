"""The features describe the regressor exactly, for every model; the enclosure holds every state of a cell."""

import numpy as np
import pytest

from cases.schema import load_case
from identification.estimation.criteria import reference_scaling
from identification.machines.casadi_batch import over_samples
from identification.model.blocks import MODELS
from identification.model.model import identification_model
from planner.bounds.certificate import NODES, control_tables, enclosure_errors, rate_products
from planner.bounds.features import GIBBS, PAIRS, PRODUCTS, Features, box_features
from tests.helpers import seeds

CASE = load_case("hexapod")


def features_of(number: int) -> Features:
    model = identification_model(CASE, number)
    return box_features(CASE, model, reference_scaling(CASE, model))


@pytest.mark.parametrize("number", MODELS)
def test_the_features_give_the_regressor(number: int):
    model = identification_model(CASE, number)
    scaling = reference_scaling(CASE, model)
    features = box_features(CASE, model, scaling)
    shares = np.random.default_rng(number).uniform(-1.0, 1.0, (40, 18))
    states = features.middle + features.half * shares
    expected = over_samples(model.coordinate_regressor, states[:, :6], states[:, 6:12], states[:, 12:])[0] * scaling
    assert np.allclose(features.matrices(shares), expected, rtol=1e-10, atol=1e-12)


def test_the_form_gives_the_directional_derivative():
    features = features_of(9)
    shares = np.random.default_rng(1).uniform(-1.0, 1.0, (30, 18))
    root = np.random.default_rng(2).normal(size=(20, 20))
    inverse = root @ root.T
    y = features.of(shares)
    matrices = features.matrices(shares)
    expected = np.einsum("nki,ij,nkj->n", matrices, inverse, matrices)
    assert np.allclose(np.einsum("nk,kl,nl->n", y, features.form(inverse), y), expected, rtol=1e-9)


@seeds(12)
def test_every_direction_is_largest_at_a_control_point(seed: int):
    """The hull of the control points, widened by the errors, holds every state: no linear functional tells them apart.

    Cells up to 80 degrees wide and rates up to 3 rad/s, far beyond any machine's box.
    """
    draw = np.random.default_rng(seed)
    features = features_of(9)
    middle = np.r_[draw.uniform(-0.5, 0.5, 3), draw.uniform(-2.0, 2.0, 3)]
    half = np.r_[draw.uniform(0.01, 0.7, 3), draw.uniform(0.0, 1.0, 3)]
    low, high = (middle - half)[None], (middle + half)[None]
    tables, at_rates = control_tables(features, low[:, :3], high[:, :3])[0], rate_products(low[:, 3:], high[:, 3:])[0]
    of_gibbs_vector, of_each_product = enclosure_errors(low, high)
    corner = draw.choice([-1.0, 1.0], 8)
    fixed = np.concatenate([np.ones((27, 1)), np.tile(corner, (27, 1)), at_rates], axis=1)
    points = np.einsum("aij,rj->ari", tables, fixed).reshape(-1, PRODUCTS.stop)
    inside = draw.uniform(low, high, (400, 6))
    inside[:100] = np.where(draw.random((100, 6)) < 0.5, low, high)
    products = np.column_stack([inside[:, 3 + i] * inside[:, 3 + j] for i, j in PAIRS])
    s = np.column_stack([np.ones(400), np.tile(corner, (400, 1)), products])
    states = np.einsum("nij,nj->ni", features.tables(inside[:, :3]), s)
    for _ in range(60):
        direction = draw.normal(size=PRODUCTS.stop) / np.abs(points).max(axis=0)
        missed = of_gibbs_vector[0] * np.linalg.norm(direction[GIBBS])
        missed += of_each_product[0] * np.abs(direction[PRODUCTS]).sum()
        assert (states @ direction).max() <= (points @ direction).max() + missed + 1e-9


@pytest.mark.parametrize("half", [0.02, 0.1, 0.35])
def test_what_is_missed_is_small_and_shrinks_with_the_cube_of_the_cell(half: float):
    low, high = np.full((1, 6), -half), np.full((1, 6), half)
    whole, halved = enclosure_errors(low, high)[0][0], enclosure_errors(low / 2, high / 2)[0][0]
    assert 0.0 < whole < 0.5 * half**3
    assert whole / halved == pytest.approx(8.0, rel=0.25)
    assert len(NODES) == 27


def test_an_angle_that_the_gibbs_vector_cannot_describe_has_no_bound():
    low, high = np.full((1, 6), 0.0), np.array([[2.0, 2.0, 2.0, 0.1, 0.1, 0.1]])
    assert np.isinf(enclosure_errors(low, high)[0][0])
