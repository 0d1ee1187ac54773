"""Kinematics of serial chains: closed forms, derivatives, and MuJoCo, which nobody here wrote."""

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.base.errors import CaseError
from cases.chain import Chain
from cases.schema import load_case
from cases.sensors import RigidBody
from identification.limits.chain import chain_frames, joint_efforts
from identification.machines.casadi_batch import over_samples
from identification.machines.serial_chain import SerialChain
from identification.model.blocks import MODELS, WRENCH_OFFSETS
from identification.model.model import Model
from identification.model.parameters import body_parameters
from identification.motion.motion import Motion
from tests.helpers import taylor_slope
from tests.plant import Plant
from tests.robots import chain, joint, odd, planar, weighing

CHAINS = {"planar": planar(612.7, 571.6), "odd": odd()}
GRAVITY = (0.3, -0.4, -9.79)
LOAD = RigidBody(
    mass_kg=2.7, centre_of_gravity_mm=(12.0, -34.0, 56.0), inertia_kg_m2=(0.03, 0.002, -0.001, 0.04, 0.003, 0.05)
)


def states(of: Chain, count: int = 50, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    q, rates, accelerations = np.random.default_rng(seed).normal(0.0, 1.5, (3, count, len(of.joints)))
    return q, rates, accelerations


def test_kinematics_need_no_limits_of_motion() -> None:
    """A recording can be evaluated before anyone plans."""
    case = load_case("ur10_wrist")
    assert SerialChain.of(case.model_copy(update={"limits": None})).chain == case.chain
    with pytest.raises(CaseError, match=r"machine\.chain: is missing; the kinematics"):
        SerialChain.of(load_case("hexapod"))


def test_two_links_in_a_plane_end_where_the_textbook_says() -> None:
    first, second = 0.6127, 0.5716
    q, rates, accelerations = states(planar(first * 1e3, second * 1e3))
    found = SerialChain(planar(first * 1e3, second * 1e3)).kinematics(q, rates, accelerations)
    angle, rate, second_rate = (np.cumsum(v, axis=1) for v in (q, rates, accelerations))
    cosine, sine, lengths = np.cos(angle), np.sin(angle), np.array([first, second])
    np.testing.assert_allclose(found.pose[:, 0], cosine @ lengths, atol=1e-14)
    np.testing.assert_allclose(found.pose[:, 1], sine @ lengths, atol=1e-14)
    np.testing.assert_allclose(found.twist[:, 0], -(sine * rate) @ lengths, atol=1e-13)
    np.testing.assert_allclose(found.twist[:, 5], rate[:, 1], atol=1e-14)
    expected = -(sine * second_rate + cosine * rate**2) @ lengths
    np.testing.assert_allclose(found.twist_rate[:, 0], expected, atol=1e-13)
    np.testing.assert_allclose(found.pose[:, [2, 3, 4]], 0.0, atol=1e-15)


@pytest.mark.parametrize("name", CHAINS)
def test_twist_and_twist_rate_are_derivatives_in_time(name: str) -> None:
    serial = SerialChain(CHAINS[name])
    q, rates, accelerations = (v[0] for v in states(CHAINS[name], 1, seed=3))

    def at(t: float) -> list[np.ndarray]:
        path = q + rates * t + accelerations * t**2 / 2.0
        return over_samples(serial.motion, path[None], (rates + accelerations * t)[None], accelerations[None])

    _, rotation, twist, twist_rate = at(0.0)
    turn = rotation[0].reshape(3, 3).T
    spun = np.cross(twist[0, 3:], turn, axisb=0, axisc=0).T.ravel()  # R' = S(omega) R, column by column
    assert taylor_slope(lambda t: at(t)[0], 0.0, twist[0, :3], 1e-2) > 1.9
    assert taylor_slope(lambda t: at(t)[1], 0.0, spun, 1e-2) > 1.9
    assert taylor_slope(lambda t: at(t)[2], 0.0, twist_rate[0], 1e-2) > 1.9


@pytest.mark.parametrize("name", CHAINS)
def test_pose_is_that_of_the_rotation(name: str) -> None:
    serial = SerialChain(CHAINS[name])
    q, still = states(CHAINS[name])[0], np.zeros((50, serial.count))
    position, columns, _, _ = over_samples(serial.motion, q, still, still)
    pose = serial.kinematics(q, still, still).pose
    np.testing.assert_allclose(pose[:, :3], position, atol=1e-15)
    turns = Rotation.from_euler("xyz", pose[:, 3:]).as_matrix()
    np.testing.assert_allclose(turns, columns.reshape(-1, 3, 3).transpose(0, 2, 1), atol=1e-12)


@pytest.mark.parametrize("name", CHAINS)
def test_mujoco_moves_the_sensor_in_the_same_way(name: str) -> None:
    q, rates, accelerations = states(CHAINS[name])
    there = Plant(CHAINS[name], gravity=GRAVITY).read(q, rates, accelerations)
    position, rotation, twist, twist_rate = over_samples(SerialChain(CHAINS[name]).motion, q, rates, accelerations)
    np.testing.assert_allclose(position, there["position"], atol=1e-12)
    np.testing.assert_allclose(rotation.reshape(-1, 3, 3).transpose(0, 2, 1), there["rotation"], atol=1e-12)
    np.testing.assert_allclose(twist, there["twist"], atol=1e-11)
    np.testing.assert_allclose(twist_rate, there["twist_rate"], atol=1e-10)


@pytest.mark.parametrize("name", CHAINS)
def test_mujoco_feels_the_wrench_that_the_regressor_says(name: str) -> None:
    q, rates, accelerations = states(CHAINS[name])
    wrench = Plant(CHAINS[name], LOAD, GRAVITY).read(q, rates, accelerations)["wrench"]
    position, columns, twist, twist_rate = over_samples(SerialChain(CHAINS[name]).motion, q, rates, accelerations)
    model = Model(6, (*MODELS[6][:-1], WRENCH_OFFSETS), np.eye(6), np.array(GRAVITY))
    matrices = over_samples(model.regressor, position, columns, twist, twist_rate)[0]
    known = body_parameters(LOAD)
    u = np.array([known.get(name, 0.0) for name in model.names])
    np.testing.assert_allclose(matrices @ u, wrench, atol=1e-10)


@pytest.mark.parametrize("name", CHAINS)
def test_mujoco_needs_the_same_torques(name: str) -> None:
    """By Newton and Euler for the search, by Lagrange for the proof."""
    chain = weighing(CHAINS[name])
    q, rates, accelerations = states(chain)
    expected = Plant(chain, LOAD, GRAVITY).read(q, rates, accelerations)["torques"]
    q_, v, a = symbols = [ca.SX.sym(v, len(chain.joints)) for v in "qva"]
    torques = ca.Function("torques", symbols, [SerialChain(chain).torques(q_, v, a, GRAVITY, LOAD)])
    np.testing.assert_allclose(over_samples(torques, q, rates, accelerations)[0], expected, rtol=1e-10, atol=1e-9)
    motion = Motion(np.arange(len(q)) * 1.0, q, rates, accelerations, np.zeros_like(q))
    found = {
        label.split(",")[0]: values
        for quantity in joint_efforts(chain_frames(motion, chain), chain, np.array(GRAVITY), [LOAD])
        for label, values in zip(quantity.labels, quantity.values.T, strict=True)
    }
    for k, name in enumerate(chain.names):
        np.testing.assert_allclose(found[name], expected[:, k], rtol=1e-10, atol=1e-9)


def test_without_the_inertia_of_every_link_no_torque_is_limited() -> None:
    chain = weighing(CHAINS["planar"])
    bare = chain.model_copy(update={"joints": (chain.joints[0], CHAINS["planar"].joints[1])})
    assert chain.limits_effort
    assert not bare.limits_effort
    q = np.zeros((3, 2))
    frames = chain_frames(Motion(np.arange(3.0), q, q, q, q), bare)
    assert not list(joint_efforts(frames, bare, np.array(GRAVITY), []))


def test_a_sliding_joint_that_turns_feels_coriolis() -> None:
    """A bead on a rod that turns at 2 rad/s and slides at 0.5 m/s, 0.3 m out: 2 omega v across, omega^2 r inwards."""
    rod = chain(joint("turn"), joint("slide", "prismatic", axis=(1.0, 0.0, 0.0)))
    found = SerialChain(rod).kinematics([[0.0, 0.3]], [[2.0, 0.5]], [[0.0, 0.0]])
    np.testing.assert_allclose(found.twist_rate[0, :3], [-1.2, 2.0, 0.0], atol=1e-14)
