"""The models of Table 2: their parameters, and the symmetries that a rigid body must have."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.base.errors import IdentificationError
from cases.schema import Case, load_case
from identification.model.blocks import MODELS
from identification.model.model import identification_model
from tests.helpers import one_line, paper_poses
from tests.identification.point_masses import PointMasses, wrench_of_bars

CASE = load_case("hexapod")
STILL = np.zeros((480, 6))
TABLE_2 = dict(enumerate([10, 22, 12, 30, 30, 14, 16, 18, 36, 20, 36]))  # the last: model 3 with inertia


@pytest.mark.parametrize("number", TABLE_2)
def test_a_model_has_as_many_parameters_as_table_2_says(number: int) -> None:
    model = identification_model(CASE, number)
    assert len(model.names) == len(set(model.names)) == TABLE_2[number]
    assert model.matrices(*paper_poses(), STILL, STILL).shape == (480, 6, TABLE_2[number])


def test_table_2_has_ten_models_beside_which_there_is_model_3_with_inertia() -> None:
    assert set(MODELS) == set(TABLE_2)


@pytest.mark.parametrize("number", [-1, 11])
def test_another_number_is_answered_with_the_choices(number: int) -> None:
    with pytest.raises(IdentificationError, match=rf"model {number}\b.*choose 0, 1, 2, 3, 4, 5, 6, 7, 8, 9") as caught:
        identification_model(CASE, number)
    one_line(caught.value)


@pytest.mark.parametrize("number", TABLE_2)
def test_static_models_stand_on_inclinations_and_dynamic_ones_on_motion(number: int) -> None:
    assert identification_model(CASE, number).needs_motion == (number >= 6)


@pytest.mark.parametrize("number", TABLE_2)
def test_only_models_with_position_factors_need_the_position(number: int) -> None:
    """Columns change when the platform is carried elsewhere without turning, or they do not."""
    model, turn = identification_model(CASE, number), paper_poses()[1][:1]
    here, there = (model.matrices([p], turn, STILL[:1], STILL[:1]) for p in ([0, 0, 0.9], [0.1, -0.2, 0.8]))
    assert model.needs_position == (not np.array_equal(here, there))


def test_bars_carry_the_weight_upwards() -> None:
    """The bars' forces add up to m g against gravity, at the centre of gravity, however the platform tilts."""
    body, model = PointMasses.drawn(seed=3), identification_model(CASE, 0)
    positions, turns = paper_poses()
    u = np.r_[list(body.parameters.values())[:4], np.zeros(6)]
    centre = body.masses @ body.points / body.masses.sum()
    for turn, forces in zip(
        turns[:24], model.matrices(positions[:24], turns[:24], STILL[:24], STILL[:24]) @ u, strict=True
    ):
        wrench = wrench_of_bars(CASE.sensor_frame.bars, forces)
        np.testing.assert_allclose(turn @ wrench[:3], [0.0, 0.0, body.masses.sum() * 9.81], atol=1e-10)
        np.testing.assert_allclose(wrench[3:], np.cross(centre, wrench[:3]), atol=1e-10)


@pytest.mark.parametrize(("sense", "sign"), [("load_on_sensor", 1.0), ("sensor_on_load", -1.0)])
def test_a_transducer_reads_the_pull_of_the_load_or_the_push_of_its_support(
    wrist_case: Case, sense: str, sign: float
) -> None:
    transducer = wrist_case.sensor_frame.transducer.model_copy(update={"sense": sense})
    frame = wrist_case.sensor_frame.model_copy(update={"transducer": transducer})
    model = identification_model(wrist_case.model_copy(update={"sensor_frame": frame}), 0)
    mass, centre = 0.932, np.array([0.01, -0.02, 0.044])
    turn = Rotation.from_euler("xyz", [0.4, -0.3, 1.0]).as_matrix()
    reading = (
        model.matrices(np.zeros((1, 3)), turn[None], STILL[:1], STILL[:1])[0] @ np.r_[mass, mass * centre, np.zeros(6)]
    )
    pull = mass * turn.T @ wrist_case.gravity
    np.testing.assert_allclose(reading, sign * np.r_[pull, np.cross(centre, pull)], atol=1e-12)


def test_turning_frame_body_and_platform_axes_together_changes_no_reading() -> None:
    """The axes of {P} are a choice: with P' = P Q everything given in {P} turns by Q^T and R becomes R Q."""
    turn = Rotation.from_euler("xyz", [0.5, -1.1, 2.0]).as_matrix()
    body, draw = PointMasses.drawn(seed=4), np.random.default_rng(5)
    turned_body = PointMasses(body.masses, body.points @ turn)
    model = identification_model(CASE, 6)
    turned = replace(model, structure=np.kron(np.eye(2), turn.T) @ model.structure)
    twists, rates = draw.normal(size=(2, 480, 6))
    positions, rotations = paper_poses()
    u, turned_u = (np.r_[list(b.parameters.values()), np.zeros(6)] for b in (body, turned_body))
    before = model.matrices(positions, rotations, twists, rates) @ u
    after = turned.matrices(positions, rotations @ turn, twists, rates) @ turned_u
    np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-9)


def test_gravity_factors_of_the_rotation_matrix_cannot_be_told_from_mass_at_rest() -> None:
    """Section 5: model 3 is not identifiable; its factors of R^T g hold the columns of mass and first moment."""
    matrix = identification_model(CASE, 3).matrices(*paper_poses(), STILL, STILL).reshape(-1, 30)
    assert np.linalg.matrix_rank(matrix / np.linalg.norm(matrix, axis=0)) == 30 - 4


@pytest.mark.parametrize("number", [0, 1, 2, 4, 5])
def test_the_other_static_models_are_identifiable_from_the_480_poses(number: int) -> None:
    count = TABLE_2[number]
    matrix = identification_model(CASE, number).matrices(*paper_poses(), STILL, STILL).reshape(-1, count)
    assert np.linalg.matrix_rank(matrix / np.linalg.norm(matrix, axis=0)) == count
