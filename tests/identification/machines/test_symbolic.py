"""Evaluating a CasADi function over many samples gives, for each, what CasADi gives for one.

Orientations agree with SciPy's and with the laws of rotations.
"""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cases.schema import load_case
from identification.machines.casadi_batch import CHUNK, PART, over_samples
from identification.machines.hexapod import Hexapod
from identification.machines.rotations import gibbs, rate_matrix, rotation, rpy
from identification.model.model import identification_model

X, Y = ca.SX.sym("x", 3), ca.SX.sym("y", 2)
MATRIX = ca.Function("matrix", [X, Y], [ca.densify(X @ Y.T), X + ca.vertcat(Y, 0)])


@pytest.mark.parametrize("count", [1, 2, CHUNK - 1, CHUNK, CHUNK + 1, 2 * CHUNK + 7])
def test_every_sample_is_evaluated_on_its_own(count: int) -> None:
    draw = np.random.default_rng(count)
    x, y = draw.normal(size=(count, 3)), draw.normal(size=(count, 2))
    outer, total = over_samples(MATRIX, x, y)
    np.testing.assert_allclose(outer, x[:, :, None] * y[:, None, :], rtol=1e-15)
    np.testing.assert_allclose(total, x + np.pad(y, ((0, 0), (0, 1))), rtol=1e-15)


def test_memory_order_and_number_type_of_the_arguments_do_not_matter() -> None:
    x, y = np.arange(12).reshape(4, 3), np.arange(8.0).reshape(2, 4).T
    np.testing.assert_array_equal(over_samples(MATRIX, x, y)[0], x[:, :, None] * y[:, None, :])
    np.testing.assert_array_equal(over_samples(MATRIX, x.tolist(), y[:, :])[0], x[:, :, None] * y[:, None, :])


def test_arguments_are_left_as_they_are() -> None:
    x, y = np.ones((5, 3)), np.full((5, 2), 2.0)
    over_samples(MATRIX, x, y)[0][:] = 7.0
    assert np.all(x == 1.0)
    assert np.all(y == 2.0)


@pytest.mark.parametrize(("x", "y", "says"), [
    ((4, 2), (4, 2), r"matrix: input 0 has shape \(4, 2\), expected \(4, 3\)"),
    ((4, 3), (5, 2), r"matrix: input 1 has shape \(5, 2\), expected \(4, 2\)"),
    ((4, 3), (8,), r"matrix: input 1 has shape \(8,\), expected \(4, 2\)"),
])  # fmt: skip
def test_wrong_shapes_are_refused_before_casadi_reads_beyond_them(x: tuple, y: tuple, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        over_samples(MATRIX, np.zeros(x), np.zeros(y))


def test_many_samples_are_evaluated_as_few_are() -> None:
    """Instruction by instruction in NumPy, or by CasADi's interpreter: the same functions, to rounding."""
    case = load_case("hexapod")
    hexapod, model = Hexapod.of(case), identification_model(case, 9)
    draw, count = np.random.default_rng(0), PART + 1001
    pose = hexapod.home + 0.02 * draw.normal(size=(count, 6))
    rates, accelerations, u = draw.normal(size=(count, 6)), draw.normal(size=(count, 6)), draw.normal(size=(count, 20))
    for function, arguments in (
        (hexapod.inverse_jacobian, (pose,)),
        (hexapod.jacobian_drift, (pose, rates)),
        (hexapod.newton_step, (pose, 1e-3 * rates)),
        (hexapod.joint_cosines, (pose,)),
        (hexapod.strut_motion, (pose, rates, accelerations)),
        (model.coordinate_regressor, (pose, rates, accelerations)),
        (model.pose_forces, (pose, rates, accelerations, u)),
    ):
        many = over_samples(function, *arguments)
        pieces = [slice(k, k + CHUNK) for k in range(0, count, CHUNK)]
        few = zip(*(over_samples(function, *(a[p] for a in arguments)) for p in pieces), strict=True)
        for one, other in zip(many, few, strict=True):
            np.testing.assert_allclose(one, np.concatenate(other), rtol=1e-13, atol=1e-13)


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
