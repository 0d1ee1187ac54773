"""Section 5: which parameters a run determines, alone or only together."""

import numpy as np
import pytest

from cases.schema import load_case
from identification.criteria import analyse
from identification.model import identification_model
from tests.helpers import paper_poses

CASE = load_case("hexapod")
PLACES, TURNS = paper_poses()
STILL = np.zeros((len(PLACES), 6))
DRAW = np.random.default_rng(0)


def at_rest(number: int) -> np.ndarray:
    return identification_model(CASE, number).matrices(PLACES, TURNS, STILL, STILL)


def moving(number: int) -> np.ndarray:
    twist, rate = DRAW.normal(size=STILL.shape), 3.0 * DRAW.normal(size=STILL.shape)
    return identification_model(CASE, number).matrices(PLACES, TURNS, twist, rate)


def names(number: int) -> list[str]:
    return identification_model(CASE, number).names


@pytest.mark.parametrize("number", [0, 1, 2, 4, 5])
def test_the_static_models_of_table_2_are_identifiable_at_the_480_poses(number: int) -> None:
    found = analyse(at_rest(number), names(number))
    assert found.rank == len(found.names)


def test_model_3_is_not() -> None:
    """R^T g holds gravity's effect on mass and first moment: four directions are hidden among them and K3."""
    assert analyse(at_rest(3), names(3)).rank == len(names(3)) - 4


def test_inertia_is_hidden_at_rest_and_seen_in_motion() -> None:
    assert analyse(at_rest(9), names(9)).rank == len(names(9)) - 6
    assert analyse(moving(9), names(9)).rank == len(names(9))


def test_r_and_correlation_are_what_they_are_called() -> None:
    matrices = moving(9)
    found = analyse(matrices, names(9))
    matrix = matrices.reshape(-1, 20)
    scaled = matrix / np.linalg.norm(matrix, axis=0)
    np.testing.assert_allclose(found.r.T @ found.r, scaled.T @ scaled, atol=1e-12)
    np.testing.assert_allclose(found.correlation, np.corrcoef(matrix.T), atol=1e-12)
    np.testing.assert_allclose(found.condition, np.linalg.cond(scaled), rtol=1e-9)


def test_mass_and_orientation_errors_are_the_most_correlated_static_parameters() -> None:
    """Figure 3, centre: what the paper warns of in model 5."""
    pairs = {frozenset(pair[:2]) for pair in analyse(at_rest(5), names(5)).strongest(3)}
    assert pairs & {
        frozenset(("m", "k2")),
        frozenset(("mzC", "k3")),
        frozenset(("mxC", "k3")),
        frozenset(("myC", "k3")),
    }
