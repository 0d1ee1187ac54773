"""Sensors in struts against Lagrange's equations by automatic differentiation, and what can be told from what."""

import casadi as ca
import numpy as np
import pytest

from cases.schema import load_case
from identification.machines.hexapod import Hexapod
from identification.machines.rotations import rotation, twist, twist_rate
from identification.model.blocks import FIRST_MOMENT, INERTIA, MASS, State
from identification.model.strut_sensors import moving_struts, structure, strut_blocks

CASE = load_case("hexapod")
HEXAPOD = Hexapod.of(CASE)
GRAVITY = np.array([0.3, -0.2, -9.8])
BODY = np.array([21.0, 1.3, -0.8, 4.1, 1.1, 0.05, -0.03, 1.3, 0.02, 0.9])  # m, first moments, inertia about {P}
MU, H, K, D = 3.1, 1.2, 2.3, 2.7
CB, CP = 0.8, 0.5


def states(count: int) -> list[np.ndarray]:
    """Poses around home with rates and accelerations of a quick machine, each a row of 18."""
    draw = np.random.default_rng(4)
    size = np.r_[0.05, 0.05, 0.05, 0.2, 0.2, 0.2, [0.8] * 3, [1.5] * 3, [8.0] * 3, [15.0] * 3]
    middle = np.r_[HEXAPOD.home, np.zeros(12)]
    return list(middle + draw.uniform(-1.0, 1.0, (count, 18)) * size)


def columns(at_drive: bool, each: bool = False, viscous: bool = False, coulomb: bool = False) -> ca.Function:
    """(pose, rates, accelerations) -> what the body's ten and the struts' parameters do to the sensors."""
    pose, rates, accelerations = (ca.SX.sym(n, 6) for n in ("q", "v", "a"))
    turn = rotation(pose[3:])
    moved, rate = twist(pose, rates), twist_rate(pose, rates, accelerations)
    specific = turn.T @ (rate[:3] - ca.DM(GRAVITY))
    none = ca.SX.zeros(1)
    state = State(none, none, none, turn.T @ ca.DM(GRAVITY), specific, turn.T @ moved[3:], turn.T @ rate[3:])
    state = moving_struts(state, HEXAPOD, pose[:3], turn, moved, rate, GRAVITY)
    blocks = (MASS, FIRST_MOMENT, INERTIA, *strut_blocks(at_drive, each, viscous, coulomb))
    wrenches = ca.horzcat(*(b.columns(state) for b in blocks))
    return ca.Function("columns", [pose, rates, accelerations], [ca.solve(structure(state), wrenches)])


def lagrange(above: float, first_above: float) -> ca.Function:
    """Forces of sensors between the lower part of each rod and an upper part of some mass and first moment.

    Twelve coordinates: the pose, and by how much each lower part has moved away from the platform.
    """
    q, v, a = (ca.SX.sym(n, 12) for n in ("q", "v", "a"))
    pose, slip = q[:6], q[6:]
    turn = rotation(pose[3:])
    omega = turn.T @ twist(pose, v[:6])[3:]
    inertia = ca.vertcat(
        ca.horzcat(BODY[4], BODY[5], BODY[6]),
        ca.horzcat(BODY[5], BODY[7], BODY[8]),
        ca.horzcat(BODY[6], BODY[8], BODY[9]),
    )
    first = ca.DM(BODY[1:4])
    speed = turn.T @ v[:3]
    energy = BODY[0] * ca.dot(speed, speed) / 2 + ca.dot(speed, ca.cross(omega, first)) + omega.T @ inertia @ omega / 2
    height = -ca.dot(ca.DM(GRAVITY), BODY[0] * pose[:3] + turn @ first)
    lost = ca.SX(0)
    lengths = []
    for k in range(6):
        strut = pose[:3] + turn @ ca.DM(HEXAPOD.platform[k]) - ca.DM(HEXAPOD.base[k])
        length = ca.norm_2(strut)
        n = strut / length
        joint = ca.DM(HEXAPOD.base[k]) + strut
        turning, moving = ca.jtimes(n, pose, v[:6]), ca.jtimes(joint, pose, v[:6])
        lower = moving - v[6 + k] * n - slip[k] * turning  # of the point that is P where nothing has slipped
        parts = ((MU - above, H - first_above, lower, joint - slip[k] * n), (above, first_above, moving, joint))
        for mass, moment, point, place in parts:
            energy += mass * ca.dot(point, point) / 2 - moment * ca.dot(point, turning)
            height += -ca.dot(ca.DM(GRAVITY), mass * place - moment * n)
        energy += K * ca.dot(turning, turning) / 2
        height += -ca.dot(ca.DM(GRAVITY), D * n)
        spin = ca.cross(n, turning)
        joint_rate = spin - turn @ omega
        lost += CB * ca.dot(spin, spin) / 2 + CP * ca.dot(joint_rate, joint_rate) / 2
        lengths.append(length)
    momentum = ca.jacobian(energy, v).T
    change = ca.jtimes(momentum, q, v) + ca.jtimes(momentum, v, a)
    generalised = change - ca.jacobian(energy, q).T + ca.jacobian(height, q).T + ca.jacobian(lost, v).T
    at_drives = ca.solve(ca.jacobian(ca.vertcat(*lengths), pose).T, generalised[:6])
    sensors = generalised[6:] + at_drives
    return ca.Function("lagrange", [q, v, a], [at_drives, sensors])


def of_lagrange(state: np.ndarray, above: float, first_above: float) -> tuple[np.ndarray, np.ndarray]:
    """Forces of the drives and of the sensors."""
    parts = [np.r_[state[6 * k : 6 * k + 6], np.zeros(6)] for k in range(3)]
    drives, sensors = lagrange(above, first_above)(*parts)
    return drives.full()[:, 0], sensors.full()[:, 0]


def lumped() -> np.ndarray:
    """The body with the rods' masses in its platform joints."""
    total = BODY.copy()
    for p in HEXAPOD.platform:
        square = p @ p * np.eye(3) - np.outer(p, p)
        total += MU * np.r_[1.0, p, square[0, 0], square[0, 1], square[0, 2], square[1, 1], square[1, 2], square[2, 2]]
    return total


def test_a_sensor_at_the_drive_feels_the_platform_with_the_rods_as_lagrange_says() -> None:
    matrix = columns(True, viscous=True)
    for state in states(20):
        drives, _ = of_lagrange(state, 0.0, 0.0)
        found = matrix(state[:6], state[6:12], state[12:]).full() @ np.r_[lumped(), H, K, D, CB, CP]
        np.testing.assert_allclose(found, drives, rtol=0.0, atol=1e-9 * np.abs(drives).max())


def test_a_sensor_at_the_platform_feels_rods_only_across_as_lagrange_says() -> None:
    matrix = columns(False, viscous=True)
    for state in states(20):
        _, sensors = of_lagrange(state, 0.0, 0.0)
        found = matrix(state[:6], state[6:12], state[12:]).full() @ np.r_[BODY, MU, H, K, D, CB, CP]
        np.testing.assert_allclose(found, sensors, rtol=0.0, atol=1e-9 * np.abs(sensors).max())


@pytest.mark.parametrize(("at_drive", "each", "count"), [(True, False, 13), (False, False, 14), (True, True, 28)])
def test_every_parameter_can_be_told_from_motion(at_drive: bool, each: bool, count: int) -> None:
    matrix = columns(at_drive, each)
    stacked = np.vstack([matrix(s[:6], s[6:12], s[12:]).full() for s in states(200)])
    scaled = stacked / np.linalg.norm(stacked, axis=0)
    assert scaled.shape[1] == count
    assert np.linalg.matrix_rank(scaled, tol=1e-9) == count


def test_coulomb_friction_is_viscous_friction_of_unit_size_at_every_speed() -> None:
    """Half the speed, half the viscous friction and the same Coulomb friction, away from rest."""
    viscous, coulomb = columns(True, viscous=True), columns(True, coulomb=True)
    for state in states(3):
        fast, slow = (state[:6], state[6:12], np.zeros(6)), (state[:6], state[6:12] / 2, np.zeros(6))
        np.testing.assert_allclose(viscous(*slow).full()[:, 13:], viscous(*fast).full()[:, 13:] / 2, atol=1e-12)
        np.testing.assert_allclose(coulomb(*slow).full()[:, 13:], coulomb(*fast).full()[:, 13:], rtol=1e-3, atol=1e-3)
