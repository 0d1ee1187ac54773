"""Orientations agree with SciPy's and with the laws of rotations."""

import casadi as ca
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from identification.pose import gibbs, rate_matrix, rotation, rpy

HALF_TURN = np.pi
angle = st.floats(-HALF_TURN, HALF_TURN)
pitch = st.floats(-1.5, 1.5)  # [rad] short of the singularity of roll-pitch-yaw at 90 degrees
component = st.floats(-10.0, 10.0)
vector = st.tuples(component, component, component)


def value(expression: ca.SX) -> np.ndarray:
    return ca.evalf(expression).full()


def turn_of(angles: tuple[float, float, float]) -> np.ndarray:
    return value(rotation(ca.SX(angles)))


@given(roll=angle, pitch=pitch, yaw=angle)
def test_rotation_is_orthonormal_and_proper(roll: float, pitch: float, yaw: float) -> None:
    turn = turn_of((roll, pitch, yaw))
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-14)
    assert abs(np.linalg.det(turn) - 1.0) < 1e-14


@given(roll=angle, pitch=pitch, yaw=angle)
def test_rotation_turns_about_the_fixed_axes_x_then_y_then_z(roll: float, pitch: float, yaw: float) -> None:
    expected = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_matrix()
    np.testing.assert_allclose(turn_of((roll, pitch, yaw)), expected, atol=1e-14)


@given(roll=angle, pitch=pitch, yaw=angle)
def test_angles_survive_the_way_through_the_rotation_matrix(roll: float, pitch: float, yaw: float) -> None:
    back = value(rpy(ca.SX(turn_of((roll, pitch, yaw)))))[:, 0]
    turned = (back - [roll, pitch, yaw] + HALF_TURN) % (2 * HALF_TURN) - HALF_TURN  # -180 and 180 degrees are one angle
    np.testing.assert_allclose(turned, 0.0, atol=1e-12)


@given(axis=vector.filter(lambda a: np.linalg.norm(a) > 1e-3), turned=st.floats(0.0, 3.0))
def test_gibbs_vector_is_the_axis_times_the_tangent_of_half_the_angle(axis: tuple, turned: float) -> None:
    unit = np.array(axis) / np.linalg.norm(axis)
    turn = Rotation.from_rotvec(turned * unit).as_matrix()
    np.testing.assert_allclose(value(gibbs(ca.SX(turn)))[:, 0], np.tan(turned / 2) * unit, rtol=1e-11, atol=1e-13)


def test_rate_matrix_is_the_one_printed_in_39() -> None:
    phi, theta, psi = 0.3, -0.7, 1.1
    c, s = np.cos, np.sin
    printed = [
        [c(theta) * c(psi), -s(psi), 0.0],
        [c(theta) * s(psi), c(psi), 0.0],
        [-s(theta), 0.0, 1.0],
    ]
    np.testing.assert_allclose(value(rate_matrix(ca.SX([phi, theta, psi]))), printed, atol=1e-15)
