"""Platform motion from strut motion, (8) and (9), against the motion of the platform itself."""

import numpy as np

from cases.schema import load_case
from identification.machines.casadi_batch import over_samples
from identification.machines.hexapod import Hexapod
from tests.helpers import HOME, Harmonic, seeds
from tests.simulated_machine import kinematics_of_coordinates

CASE = load_case("hexapod")
HEXAPOD = Hexapod.of(CASE)
TIMES = np.linspace(0.0, 3.0, 200)


@seeds(3)
def test_strut_motion_determines_platform_motion(seed: int) -> None:
    motion = Harmonic(seed=seed).at(TIMES)
    struts = over_samples(HEXAPOD.strut_motion, motion.coordinates, motion.rates, motion.accelerations)
    found = HEXAPOD.kinematics(*struts)
    expected = kinematics_of_coordinates(motion.coordinates, motion.rates, motion.accelerations)
    np.testing.assert_allclose(found.pose, motion.coordinates, atol=1e-10)
    np.testing.assert_allclose(found.twist, expected.twist, atol=1e-9)
    np.testing.assert_allclose(found.twist_rate, expected.twist_rate, atol=1e-8)


def test_j_hex_maps_strut_velocities_of_finite_differences_to_the_twist() -> None:
    step = 1e-5
    before, now, after = (Harmonic(seed=4).at(TIMES + k * step) for k in (-1, 0, 1))
    velocities = (HEXAPOD.strut_lengths(after.coordinates) - HEXAPOD.strut_lengths(before.coordinates)) / (2 * step)
    found = HEXAPOD.kinematics(HEXAPOD.strut_lengths(now.coordinates), velocities, np.zeros((len(TIMES), 6)))
    expected = kinematics_of_coordinates(now.coordinates, now.rates, now.accelerations).twist
    np.testing.assert_allclose(found.twist, expected, atol=1e-8)


def test_a_jacobian_column_is_what_the_platform_does_when_one_strut_grows() -> None:
    pose, step = Harmonic(seed=5).at([1.0]).coordinates, 1e-6
    lengths = HEXAPOD.strut_lengths(pose)
    jacobian = np.linalg.inv(over_samples(HEXAPOD.inverse_jacobian, pose)[1][0])
    positions = HEXAPOD.poses(lengths + step * np.eye(6))[:, :3] - HEXAPOD.poses(lengths - step * np.eye(6))[:, :3]
    np.testing.assert_allclose(positions / (2 * step), jacobian[:3].T, atol=1e-7)


def test_a_platform_that_turns_evenly_has_struts_that_accelerate() -> None:
    """Without the drift term of (9) an even turn about z would show a false angular acceleration."""
    rates = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 2.0]])
    struts = over_samples(HEXAPOD.strut_motion, HOME[None], rates, np.zeros((1, 6)))
    assert np.abs(struts[2]).max() > 0.1
    np.testing.assert_allclose(HEXAPOD.kinematics(*struts).twist_rate, 0.0, atol=1e-10)
