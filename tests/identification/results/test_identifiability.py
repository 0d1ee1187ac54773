"""Section 5: which parameters a run determines, alone or only together."""

import numpy as np
import pytest

import hexcite as hx
from cases.base.errors import HexciteError
from cases.base.units import DEG
from cases.schema import load_case
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.results.identifiability import Identifiability, analysed, models_of, of_models
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, one_line, paper_poses
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
PLACES, TURNS = paper_poses()
STILL = np.zeros((len(PLACES), 6))
DRAW = np.random.default_rng(0)


def at_rest(number: int) -> Identifiability:
    model = identification_model(CASE, number)
    return analysed(model.matrices(PLACES, TURNS, STILL, STILL), model.names, number)


def matrices_in_motion(number: int) -> np.ndarray:
    twist, rate = DRAW.normal(size=STILL.shape), 3.0 * DRAW.normal(size=STILL.shape)
    return identification_model(CASE, number).matrices(PLACES, TURNS, twist, rate)


def moving(number: int) -> Identifiability:
    return analysed(matrices_in_motion(number), identification_model(CASE, number).names, number)


@pytest.mark.parametrize("number", [0, 1, 2, 4, 5])
def test_the_static_models_of_table_2_are_identifiable_at_the_480_poses(number: int) -> None:
    found = at_rest(number)
    assert (found.determined, found.rank) == (True, len(found.names))
    assert found.below_zero == ()


def test_model_3_is_not() -> None:
    """R^T g holds gravity's effect on mass and first moment: four directions are hidden among them and K3."""
    found = at_rest(3)
    assert (found.determined, found.rank) == (False, len(found.names) - 4)
    ((together, combinations),) = found.alike
    assert combinations == 4
    assert set(together) == {"m", "mxC", "myC", "mzC", *(f"K3_{k}{axis}" for k in range(1, 7) for axis in "xyz")}
    assert len(found.below_zero) == 4
    assert set(found.below_zero) < set(together)  # the last of those that make the same forces, in the order of (17)
    assert "cannot be told apart" in found.words


def test_motion_tells_model_3_apart_where_inertia_belongs_to_it() -> None:
    """Section 5: it becomes identifiable for dynamic excitations when expanded by an inertia model."""
    assert not at_rest(10).determined
    assert moving(10).determined


def test_inertia_is_hidden_at_rest_and_seen_in_motion() -> None:
    found = at_rest(9)
    assert found.alike == ((("I11", "I12", "I13", "I22", "I23", "I33"), 6),)
    assert found.rank == len(found.names) - 6
    assert moving(9).determined


def test_r_and_correlation_are_what_they_are_called() -> None:
    matrices = matrices_in_motion(9)
    found = analysed(matrices, identification_model(CASE, 9).names, 9)
    matrix = matrices.reshape(-1, 20)
    scaled = matrix / np.linalg.norm(matrix, axis=0)  # (26)
    assert not np.tril(found.r, -1).any()
    np.testing.assert_allclose(found.r.T @ found.r, scaled.T @ scaled, atol=1e-12)
    np.testing.assert_allclose(found.correlation, np.corrcoef(matrix.T), atol=1e-12)
    np.testing.assert_allclose(found.condition, np.linalg.cond(scaled), rtol=1e-9)
    assert found.zero == pytest.approx(len(matrix) * np.finfo(float).eps * np.abs(np.diag(found.r)).max())


def test_mass_and_orientation_errors_are_the_most_correlated_static_parameters() -> None:
    """Figure 3, centre: what the paper warns of in model 5."""
    found = at_rest(5)
    assert {frozenset(pair[:2]) for pair in found.nearly_alike} == {frozenset(("m", "k2")), frozenset(("mzC", "k3"))}
    assert moving(9).nearly_alike == []  # which motion tells apart


def test_models_that_are_looked_at_together_are_those_one_by_one() -> None:
    models = models_of(CASE)
    assert list(models) == list(range(11))
    for found in of_models(models, lambda model: model.matrices(PLACES, TURNS, STILL, STILL)):
        alone = at_rest(found.model)
        assert (found.names, found.alike) == (alone.names, alone.alike)
        np.testing.assert_allclose(found.correlation, alone.correlation, atol=1e-12)


def test_poses_and_a_recording_at_them_say_the_same() -> None:
    home, _ = CASE.need_motion("the test")
    away = np.random.default_rng(1).uniform(-1.0, 1.0, (5, 6)) * [0.2, 0.2, 0.05, 15 * DEG, 15 * DEG, 15 * DEG]
    poses = home + away
    before = hx.identifiability(poses, 5, CASE)
    assert before.rows == 30
    twice = np.repeat(poses, 2, axis=0)
    np.testing.assert_allclose(before.correlation, hx.identifiability(twice, 5, CASE).correlation, atol=1e-12)
    assert not hx.identifiability(poses, 3, CASE).determined


def test_a_recording_and_its_result_say_which_models_it_carries() -> None:
    execution = PoseExecution(Hexapod.of(CASE), Harmonic(duration=2.0))
    run = simulate_recording(CASE, execution, np.array([[0.15, 1.85]]), 0, "run.csv")
    found = hx.identifiability(run, case=CASE)
    assert (found.model, found.determined) == (9, True)
    result = hx.identify(run, CASE)
    again = hx.identifiability(result)
    np.testing.assert_allclose(again.correlation, found.correlation, atol=1e-2)  # which knows the delay
    assert again.condition == pytest.approx(result.record.condition, rel=0.05)


def test_poses_need_a_case_and_as_many_coordinates_as_it_has() -> None:
    with pytest.raises(HexciteError, match="give its case") as caught:
        hx.identifiability(np.zeros((3, 6)))
    one_line(caught.value)
    with pytest.raises(HexciteError, match=r"4 coordinates.*hexapod has 6") as caught:
        hx.identifiability(np.zeros((3, 4)), case=CASE)
    one_line(caught.value)
