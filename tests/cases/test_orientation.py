"""Conventions of orientations: each against rotations about single axes, written out by hand."""

import numpy as np
import pytest
from numpy.typing import NDArray

from cases.orientation import CONVENTIONS, OF_ANGLES, ROLL_PITCH_YAW, Convention

Matrix = NDArray[np.float64]


def about(axis: str, angle: float) -> Matrix:
    """Rotation about one axis, shape (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    k = "xyz".index(axis)
    turn = np.eye(3)
    i, j = (k + 1) % 3, (k + 2) % 3
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
    return turn


def about_vector(vector: Matrix) -> Matrix:
    """Rodrigues' formula, shape (3, 3)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


TURNS = np.array([[0.3, -0.5, 1.1], [-2.0, 0.4, 2.9], [0.0, 1.2, -0.7]])


@pytest.mark.parametrize("name", [c.name for c in OF_ANGLES if c.form == "angles" and not c.inverse])
def test_angles_turn_about_the_axes_in_their_order(name: str) -> None:
    order, kind = name.split()
    for angles, turn in zip(TURNS, CONVENTIONS[name].matrices(TURNS), strict=True):
        expected = np.eye(3)
        for axis, angle in zip(order, angles, strict=True):
            expected = expected @ about(axis, angle) if kind == "intrinsic" else about(axis, angle) @ expected
        np.testing.assert_allclose(turn, expected, atol=1e-12)


@pytest.mark.parametrize("convention", [c for c in OF_ANGLES if c.inverse], ids=lambda c: c.name)
def test_an_inverse_turns_the_other_way(convention: Convention) -> None:
    other = CONVENTIONS[convention.name.removesuffix(" inverse")]
    np.testing.assert_array_equal(convention.matrices(TURNS), other.matrices(TURNS).transpose(0, 2, 1))
    turns = other.matrices(TURNS)
    np.testing.assert_allclose(convention.matrices(convention.values(turns)), turns, atol=1e-12)


def test_there_are_twelve_orders_about_fixed_and_about_moved_axes_and_all_differ() -> None:
    turns = np.array([convention.matrices(TURNS) for convention in OF_ANGLES])
    assert len(turns) == 26 + 4  # and the inverse of what makers use
    for k, one in enumerate(turns):
        for other in turns[:k]:
            assert np.abs(one - other).max() > 0.1


def test_a_rotation_vector_is_axis_times_angle() -> None:
    expected = [about_vector(vector) for vector in TURNS]
    np.testing.assert_allclose(CONVENTIONS["rotation vector"].matrices(TURNS), expected, atol=1e-12)


def test_a_quaternion_has_its_scalar_first_and_any_norm_and_sign() -> None:
    quaternions = []
    for vector, norm in zip(TURNS, (1.0, -1.0, 0.5), strict=True):
        angle = np.linalg.norm(vector)
        quaternions.append(norm * np.r_[np.cos(angle / 2), np.sin(angle / 2) * vector / angle])
    expected = [about_vector(vector) for vector in TURNS]
    np.testing.assert_allclose(CONVENTIONS["quaternion"].matrices(np.array(quaternions)), expected, atol=1e-12)


def test_a_matrix_is_read_row_by_row_and_its_inverse_is_transposed() -> None:
    turns = ROLL_PITCH_YAW.matrices(TURNS)
    rows = turns.reshape(-1, 9)
    np.testing.assert_array_equal(CONVENTIONS["matrix"].matrices(rows), turns)
    np.testing.assert_array_equal(CONVENTIONS["matrix inverse"].matrices(rows), turns.transpose(0, 2, 1))
