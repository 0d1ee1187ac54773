"""Section 5: which parameters a run determines, alone or only together."""

import numpy as np
import pytest

from cases.schema import load_case
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


def scaled(matrices: np.ndarray) -> np.ndarray:
    matrix = matrices.reshape(-1, matrices.shape[2])
    return matrix / np.linalg.norm(matrix, axis=0)  # (26)


def rank(matrices: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(scaled(matrices)))


@pytest.mark.parametrize("number", [0, 1, 2, 4, 5])
def test_the_static_models_of_table_2_are_identifiable_at_the_480_poses(number: int) -> None:
    assert rank(at_rest(number)) == len(names(number))


def test_model_3_is_not() -> None:
    """R^T g holds gravity's effect on mass and first moment: four directions are hidden among them and K3."""
    assert rank(at_rest(3)) == len(names(3)) - 4


def test_inertia_is_hidden_at_rest_and_seen_in_motion() -> None:
    columns = [k for k, name in enumerate(names(9)) if not name.startswith("I")]
    assert not at_rest(9)[:, :, [k for k in range(len(names(9))) if k not in columns]].any()
    assert rank(at_rest(9)[:, :, columns]) == len(names(9)) - 6
    assert rank(moving(9)) == len(names(9))


def test_mass_and_orientation_errors_are_the_most_correlated_static_parameters() -> None:
    """Figure 3, centre: what the paper warns of in model 5."""
    matrices, all_names = at_rest(5), names(5)
    upper = np.triu(np.abs(np.nan_to_num(np.corrcoef(matrices.reshape(-1, len(all_names)).T))), 1)
    order = np.argsort(-upper, axis=None)[:3]
    pairs = {frozenset(all_names[k] for k in np.unravel_index(int(place), upper.shape)) for place in order}
    assert pairs & {
        frozenset(("m", "k2")),
        frozenset(("mzC", "k3")),
        frozenset(("mxC", "k3")),
        frozenset(("myC", "k3")),
    }
