"""Clearances of a chain: MuJoCo's distances of capsules and boxes, and the search's balls on the safe side."""

import casadi as ca
import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.chain import Chain
from cases.machine import KeepOut, Tool
from identification.evaluate import over_samples
from identification.limited_chain import body_clearances
from identification.motion import Motion
from identification.serial_chain import SerialChain
from tests.chains import ROBOT
from tests.robots import odd

TABLE = KeepOut(name="table", x_mm=(-400.0, 300.0), y_mm=(-900.0, -350.0), z_mm=(-50.0, 700.0))


def bodied(of: Chain) -> Chain:
    """The chain with a capsule on each link, from its joint to the next, a tool, a pedestal and a table."""
    joints = []
    for k, joint in enumerate(of.joints):
        following = (*of.joints, of.sensor)[k + 1].origin_mm
        to = following if np.linalg.norm(following) > 20.0 else (0.0, 30.0, 60.0)
        joints.append(
            joint.model_copy(update={"bodies": (Tool(name=f"link {k + 1}", to_mm=to, radius_mm=40.0 + 5 * k),)})
        )
    tool = (Tool(name="tool", from_mm=(0.0, 0.0, 10.0), to_mm=(30.0, 0.0, 180.0), radius_mm=35.0),)
    base = (Tool(name="pedestal", to_mm=(0.0, 0.0, 150.0), radius_mm=90.0),)
    return of.model_copy(update={"joints": tuple(joints), "tool": tool, "base": base, "keep_out": (TABLE,)})


CHAINS = {"robot": bodied(ROBOT.chain), "odd": bodied(odd())}


def states(chain: Chain, count: int = 60) -> np.ndarray:
    size = np.where([joint.turns for joint in chain.joints], 1.5, 0.15)
    return chain.home + np.random.default_rng(0).normal(size=(count, len(chain.joints))) * size


def found(chain: Chain, q: np.ndarray) -> dict[str, np.ndarray]:
    still = np.zeros_like(q)
    motion = Motion(np.arange(len(q)) * 1.0, q, still, still, still)
    return {
        f"{quantity.name} ({label})": values
        for quantity in body_clearances(motion, chain)
        for label, values in zip(quantity.labels, quantity.values.T, strict=True)
    }


def in_mujoco(chain: Chain) -> mujoco.MjModel:
    def capsule(body: Tool) -> str:
        ends = " ".join(repr(float(v)) for v in body.axis.ravel())
        return f'<geom name="{body.name}" type="capsule" fromto="{ends}" size="{body.radius_mm / 1e3}" mass="0.1"/>'

    def frame(of: object) -> str:
        turn = Rotation.from_euler("xyz", of.rpy).as_quat(scalar_first=True)
        return f'pos="{" ".join(map(repr, map(float, of.origin)))}" quat="{" ".join(map(repr, map(float, turn)))}"'

    text = f"<body {frame(chain.sensor)}>{''.join(map(capsule, chain.tool))}</body>"
    for joint in reversed(chain.joints):
        kind, axis = ("hinge" if joint.turns else "slide"), " ".join(map(str, joint.axis))
        own = f'<joint type="{kind}" axis="{axis}"/>'
        text = f"<body {frame(joint)}>{own}{''.join(map(capsule, joint.bodies))}{text}</body>"
    boxes = ""
    for box in chain.keep_out:
        middle, half = box.corners.mean(axis=0), np.diff(box.corners, axis=0)[0] / 2
        boxes += (
            f'<geom name="{box.name}" type="box" pos="{" ".join(map(str, middle))}" size="{" ".join(map(str, half))}"/>'
        )
    world = f"<worldbody>{''.join(map(capsule, chain.base))}{boxes}{text}</worldbody>"
    return mujoco.MjModel.from_xml_string(f'<mujoco><compiler angle="radian"/>{world}</mujoco>')


@pytest.mark.parametrize("name", CHAINS)
def test_mujoco_measures_the_same_distances_between_links(name: str) -> None:
    chain, q = CHAINS[name], states(CHAINS[name])
    distances = {k: v for k, v in found(chain, q).items() if k.startswith("distance between")}
    n = len(chain.joints)
    assert len(distances) == sum(max(0, n - first - 1) + (first < n - 1) for first in range(n + 1))
    model = in_mujoco(chain)
    data = mujoco.MjData(model)
    for row, coordinates in enumerate(q):
        data.qpos = coordinates
        mujoco.mj_kinematics(model, data)
        for label, values in distances.items():
            ids = [model.geom(body).id for body in label.removeprefix("distance between links (")[:-1].split(", ")]
            measured = mujoco.mj_geomDistance(model, data, *ids, 10.0, np.zeros(6))
            assert values[row] == pytest.approx(measured, abs=2e-6)


@pytest.mark.parametrize("name", CHAINS)
def test_a_box_is_never_nearer_than_it_says(name: str) -> None:
    """Distances from boxes are those along the axis that separates most: below the true one, and 0 with it."""
    chain, q = CHAINS[name], states(CHAINS[name])
    distances = {k: v for k, v in found(chain, q).items() if "table" in k}
    assert len(distances) == len(chain.joints) + 1
    model = in_mujoco(chain)
    data = mujoco.MjData(model)
    for row, coordinates in enumerate(q):
        data.qpos = coordinates
        mujoco.mj_kinematics(model, data)
        for label, values in distances.items():
            body = label.removeprefix("distance from table (")[:-1]
            measured = mujoco.mj_geomDistance(
                model, data, model.geom(body).id, model.geom("table").id, 10.0, np.zeros(6)
            )
            if measured > 0.0:
                assert values[row] <= measured + 1e-6
            else:
                assert values[row] <= 1e-6


def test_the_search_keeps_off_before_anything_touches() -> None:
    chain, q = CHAINS["robot"], states(CHAINS["robot"])
    case = ROBOT.model_copy(update={"machine": ROBOT.machine.model_copy(update={"chain": chain})})
    symbol, none = ca.SX.sym("q", len(chain.joints)), ca.SX(len(chain.joints), 1)
    shares = [s.value for s in SerialChain(chain).shares(case, symbol, none, none) if s.name == "distance"]
    largest = over_samples(ca.Function("shares", [symbol], [ca.vertcat(*shares)]), q)[0].max(axis=1)
    nearest = np.min(list(found(chain, q).values()), axis=0)
    assert np.all(largest[nearest < -0.005] > 1.0)
    assert np.any(largest[nearest > 0.05] < 1.0) or not np.any(nearest > 0.05)


def test_without_bodies_nothing_is_kept_off() -> None:
    bare = odd().model_copy(update={"keep_out": (TABLE,)})
    assert not found(bare, states(bare))


THIN = KeepOut(name="sheet", x_mm=(200.0, 200.05), y_mm=(-100.0, 100.0), z_mm=(-100.0, 100.0))
NEEDLE = {"name": "needle", "to_mm": [0.0, 0.0, 5.0], "radius_mm": 0.01}


def slide(box: KeepOut = THIN) -> Chain:
    """A needle on a slide along x, which a thin sheet stands across."""
    joint = {
        "name": "X", "kind": "prismatic", "axis": [1.0, 0.0, 0.0], "position_mm": [-1000.0, 1000.0], "home_mm": 0.0,
    }  # fmt: skip
    return Chain.model_validate({"joints": [joint], "tool": [NEEDLE], "keep_out": [box.model_dump()]})


@pytest.mark.parametrize("offset", [0.0, 0.25e-3, 0.5e-3, 0.75e-3])
def test_nothing_passes_a_thin_box_between_two_instants(offset: float) -> None:
    """2 m/s at 1 kHz are 2 mm a step, the sheet has 0.05 mm: no instant need see it."""
    t = offset + np.arange(0.0, 0.2, 1e-3)
    still = np.zeros((len(t), 1))
    motion = Motion(t, 2.0 * t[:, None], np.full((len(t), 1), 2.0), still, still)
    (quantity,) = body_clearances(motion, slide())
    assert quantity.ratio.max() > 1.0


@pytest.mark.parametrize("name", CHAINS)
def test_distances_of_few_instants_bound_those_of_many_and_not_by_much(name: str) -> None:
    chain = CHAINS[name]
    size = np.where([joint.turns for joint in chain.joints], 1.0, 0.1)
    waves = np.random.default_rng(2).uniform(1.0, 3.0, len(chain.joints))
    few, many = (np.linspace(0.0, 2.0, 2 * rate + 1) for rate in (1000, 20_000))

    def nearest(t: np.ndarray) -> dict[str, float]:
        angle = t[:, None] * waves
        q, first, second = (size * np.sin(angle), size * waves * np.cos(angle), -size * waves**2 * np.sin(angle))
        motion = Motion(t, chain.home + q, first, second, np.zeros_like(q))
        return {q.name + label: float(v.min()) for q in body_clearances(motion, chain) for label, v in zip(
            q.labels, q.values.T, strict=True)}  # fmt: skip

    coarse, fine = nearest(few), nearest(many)
    assert coarse.keys() == fine.keys()
    for label, distance in fine.items():
        assert distance - 0.012 <= coarse[label] <= distance, label
