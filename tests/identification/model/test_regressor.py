"""The regressor (17)-(22) against Newton's law for every point mass of a body, for all ten models of Table 2."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.schema import load_case
from identification.machines.casadi_batch import over_samples
from identification.model.model import identification_model, regressors
from identification.motion.motion import Standstill, Trajectory
from tests.helpers import HOME, Harmonic
from tests.identification.point_masses import PointMasses, wrench_of_bars
from tests.simulated_machine import kinematics_of_coordinates

CASE = load_case("hexapod")
BARS = CASE.sensor_frame.bars
BODY = PointMasses.drawn(seed=0)
TIMES = np.array([0.3, 1.1, 2.6])
TILTED = Standstill(HOME + np.array([0.1, -0.2, 0.05, 0.3, -0.25, 0.4]), 3.0)


def forces_of(number: int, u: dict[str, float], trajectory: Trajectory, t: np.ndarray) -> np.ndarray:
    model = identification_model(CASE, number)
    now = trajectory.at(t)
    matrices = over_samples(model.coordinate_regressor, now.coordinates, now.rates, now.accelerations)[0]
    return matrices @ [u[name] for name in model.names]


def drawn_parameters(number: int) -> dict[str, float]:
    draw = np.random.default_rng(number)
    return {n: draw.normal() * 10 for n in identification_model(CASE, number).names} | BODY.parameters


def deformation(u: dict[str, float], pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """f_K by (12)-(15), with the signs of (22): force and moment on the platform, and forces at the sensors."""
    turn = Rotation.from_euler("xyz", pose[3:])
    vector = turn.as_rotvec()
    angle = np.linalg.norm(vector)
    phi = np.tan(angle / 2) * vector / angle
    gravity = turn.as_matrix().T @ CASE.gravity
    x, y = pose[:2]
    k0, k1, k2, k3 = (u.get(f"k{k}", 0.0) for k in range(4))
    wrench = np.array(
        [k0 * x - k2 * phi[1], k0 * y + k2 * phi[0], 0.0, k1 * y + k3 * phi[0], -k1 * x + k3 * phi[1], 0.0]
    )
    at_sensors = np.zeros(6)
    for k in range(6):
        at_sensors[k] += sum(u.get(f"K1_{k + 1}{axis}", 0.0) * pose[i] for i, axis in enumerate("xy"))
        at_sensors[k] += sum(u.get(f"K3_{k + 1}{axis}", 0.0) * gravity[i] for i, axis in enumerate("xyz"))
        at_sensors[k] += sum(u.get(f"K4_{k + 1}{axis}", 0.0) * phi[i] for i, axis in enumerate("xyz"))
    return wrench, at_sensors


@pytest.mark.parametrize(
    ("number", "trajectory"),
    [(n, TILTED) for n in range(6)] + [(n, Harmonic(seed=n)) for n in range(6, 10)],
)
def test_sensors_carry_what_moves_every_mass_of_the_body(number: int, trajectory: Trajectory) -> None:
    u = drawn_parameters(number)
    offsets = np.array([u[f"f_q0_{k}"] for k in range(1, 7)])
    for t, forces in zip(TIMES, forces_of(number, u, trajectory, TIMES), strict=True):
        deforming, at_sensors = deformation(u, trajectory.at(np.array([t])).coordinates[0])
        expected = BODY.wrench(trajectory, t, CASE.gravity) + deforming
        np.testing.assert_allclose(wrench_of_bars(BARS, forces - offsets - at_sensors), expected, atol=2e-6)


@pytest.mark.parametrize("number", range(10))
def test_both_forms_of_the_regressor_are_one(number: int) -> None:
    now, model = Harmonic(seed=1).at(TIMES), identification_model(CASE, number)
    planned = over_samples(model.coordinate_regressor, now.coordinates, now.rates, now.accelerations)[0]
    kinematics = kinematics_of_coordinates(now.coordinates, now.rates, now.accelerations)
    np.testing.assert_allclose(regressors(model, kinematics), planned, atol=1e-11)


def test_two_bodies_together_weigh_the_sum_of_their_parameters() -> None:
    other = PointMasses.drawn(seed=1)
    joined = PointMasses(np.r_[BODY.masses, other.masses], np.vstack([BODY.points, other.points]))
    silent = dict.fromkeys(identification_model(CASE, 6).names, 0.0)
    one, two, both = (forces_of(6, silent | b.parameters, Harmonic(), TIMES) for b in (BODY, other, joined))
    np.testing.assert_allclose(one + two, both, rtol=1e-9, atol=1e-9)


def test_inertia_carries_nothing_at_rest() -> None:
    u = dict.fromkeys(identification_model(CASE, 6).names, 0.0) | {"I11": 1.0, "I12": 0.3, "I33": 2.0}
    assert np.all(forces_of(6, u, TILTED, TIMES) == 0.0)
    assert np.abs(forces_of(6, u, Harmonic(), TIMES)).max() > 1e-3


def test_free_fall_is_weightless() -> None:
    """A platform that falls with g carries no weight: mass and first moment enter as acceleration less gravity."""
    model = identification_model(CASE, 0)
    falling = np.r_[CASE.gravity, np.zeros(3)]
    turn = Rotation.from_euler("xyz", [[0.2, 0.1, -0.3]]).as_matrix()
    matrix = model.matrices(np.zeros((1, 3)), turn, np.zeros((1, 6)), falling[None])
    np.testing.assert_allclose(matrix[0, :, :4], 0.0, atol=1e-13)
