"""Clearances of a chain: coal's distances of capsules, boxes and planes, and the search's balls on the safe side."""

import casadi as ca
import coal
import numpy as np
import pytest
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

from cases.chain import Chain
from cases.machine import Frame, KeepOut, Tool
from identification.limits.chain import body_clearances, chain_frames
from identification.machines.casadi_batch import over_samples
from identification.machines.clearance import clearance_names, clearance_shares
from identification.machines.machine import VICINITY
from identification.machines.serial_chain import SerialChain
from identification.motion.motion import Motion
from tests.cases.base.test_convex import geometry
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
        f"{quantity.of} ({label})": values
        for quantity in body_clearances(motion.t, chain_frames(motion, chain), chain)
        for label, values in zip(quantity.labels, quantity.values.T, strict=True)
    }


def placed(frame: Frame, before: np.ndarray) -> np.ndarray:
    own = np.eye(4)
    own[:3, :3], own[:3, 3] = Rotation.from_euler("xyz", frame.rpy).as_matrix(), frame.origin
    return before @ own


def capsules(chain: Chain, q: np.ndarray) -> dict[str, tuple[coal.Capsule, coal.Transform3s]]:
    """The bodies of a chain for coal, placed by SciPy's rotations."""
    frame = np.eye(4)
    owners = [(frame, chain.base)]
    for joint, value in zip(chain.joints, q, strict=True):
        move, axis = np.eye(4), np.array(joint.axis) / np.linalg.norm(joint.axis)
        if joint.turns:
            move[:3, :3] = Rotation.from_rotvec(value * axis).as_matrix()
        else:
            move[:3, 3] = value * axis
        frame = placed(joint, frame) @ move
        owners.append((frame, joint.bodies))
    owners.append((placed(chain.sensor, frame), chain.tool))
    found = {}
    for frame, bodies in owners:
        for body in bodies:
            start, end = body.axis @ frame[:3, :3].T + frame[:3, 3]
            along, _ = Rotation.align_vectors([end - start], [[0.0, 0.0, 1.0]])
            shape = coal.Capsule(body.radius_mm / 1e3, float(np.linalg.norm(end - start)))
            found[body.name] = shape, coal.Transform3s(along.as_matrix(), (start + end) / 2)
    return found


def apart(one: tuple[object, coal.Transform3s], other: tuple[object, coal.Transform3s]) -> float:
    return float(coal.distance(*one, *other, coal.DistanceRequest(), coal.DistanceResult()))


@pytest.mark.parametrize("name", CHAINS)
def test_coal_measures_the_same_distances_between_links(name: str) -> None:
    chain, q = CHAINS[name], states(CHAINS[name])
    distances = {k: v for k, v in found(chain, q).items() if k.startswith("distance between")}
    n = len(chain.joints)
    assert len(distances) == sum(max(0, n - first - 1) + (first < n - 1) for first in range(n + 1))
    for row, coordinates in enumerate(q):
        bodies = capsules(chain, coordinates)
        for label, values in distances.items():
            one, other = label.removeprefix("distance between links (")[:-1].split(", ")
            assert values[row] == pytest.approx(apart(bodies[one], bodies[other]), abs=2e-6)


@pytest.mark.parametrize("name", CHAINS)
def test_a_box_is_never_nearer_than_it_says(name: str) -> None:
    """Distances from boxes are those along the axis that separates most: below the true one, and 0 with it."""
    chain, q = CHAINS[name], states(CHAINS[name])
    distances = {k: v for k, v in found(chain, q).items() if "table" in k}
    assert len(distances) == len(chain.joints) + 1
    table = coal.Box(*np.diff(TABLE.corners, axis=0)[0]), coal.Transform3s(np.eye(3), TABLE.corners.mean(axis=0))
    for row, coordinates in enumerate(q):
        bodies = capsules(chain, coordinates)
        for label, values in distances.items():
            measured = apart(bodies[label.removeprefix("distance from table (")[:-1]], table)
            assert values[row] <= max(measured, 0.0) + 1e-6


@pytest.mark.parametrize("name", CHAINS)
def test_a_box_with_one_side_is_the_plane_that_coal_knows(name: str) -> None:
    """A wall that fills x > 0.2 m: bodies are apart from it, or as deep in it, as coal says of the half space."""
    wall = KeepOut(name="wall", x_mm=(200.0, 9000.0))
    chain, q = CHAINS[name].model_copy(update={"keep_out": (wall,)}), states(CHAINS[name])
    half_space = coal.Halfspace(np.array([-1.0, 0.0, 0.0]), -0.2), coal.Transform3s()
    distances = {k: v for k, v in found(chain, q).items() if "wall" in k}
    assert any(v.min() < 0.0 for v in distances.values())
    for row, coordinates in enumerate(q):
        bodies = capsules(chain, coordinates)
        for label, values in distances.items():
            measured = apart(bodies[label.removeprefix("distance from wall (")[:-1]], half_space)
            assert values[row] == pytest.approx(measured, abs=1e-9)


def convex(of: Chain) -> Chain:
    """The same chain with hulls of corners about the axes of its links, 5 mm larger all around; its tool is round."""
    draw, joints = np.random.default_rng(3), []
    for joint in of.joints:
        (body,) = joint.bodies
        axis, radius = body.axis / 1e-3, body.radius / 1e-3
        corners = axis[draw.integers(0, 2, 14)] + draw.normal(size=(14, 3)) * radius / 2.0
        hull = Tool(name=body.name, corners_mm=tuple(map(tuple, corners.tolist())), radius_mm=5.0)
        joints.append(joint.model_copy(update={"bodies": (hull,)}))
    return of.model_copy(update={"joints": tuple(joints)})


def frames_of(chain: Chain, q: np.ndarray) -> list[np.ndarray]:
    """The moved frame of each joint, by SciPy's rotations."""
    frames = [np.eye(4)]
    for joint, value in zip(chain.joints, q, strict=True):
        move, axis = np.eye(4), np.array(joint.axis) / np.linalg.norm(joint.axis)
        if joint.turns:
            move[:3, :3] = Rotation.from_rotvec(value * axis).as_matrix()
        else:
            move[:3, 3] = value * axis
        frames.append(placed(joint, frames[-1]) @ move)
    return frames[1:]


Shape = tuple[coal.CollisionGeometry, coal.Transform3s, float]


def shapes(chain: Chain, q: np.ndarray) -> dict[str, Shape]:
    """The bodies of a chain for coal: hulls with what they are larger, capsules with 0."""
    bare = chain.model_copy(update={"joints": tuple(j.model_copy(update={"bodies": ()}) for j in chain.joints)})
    every = {name: (*shape, 0.0) for name, shape in capsules(bare, q).items()}
    for frame, joint in zip(frames_of(chain, q), chain.joints, strict=True):
        for body in joint.bodies:
            place = coal.Transform3s(frame[:3, :3], frame[:3, 3])
            every[body.name] = geometry(np.array(body.corners_mm) / 1e3), place, body.radius_mm / 1e3
    return every


@pytest.mark.parametrize("name", CHAINS)
def test_coal_measures_the_same_distances_of_convex_bodies(name: str) -> None:
    """One instant at a time, for of several the closest alone is exact; boxes too are convex bodies then.

    So it is of pairs: those that are not the closest may be farther apart than is said, which is not less than that.
    """
    chain, table = convex(CHAINS[name]), coal.Box(*np.diff(TABLE.corners, axis=0)[0])
    at_table = coal.Transform3s(np.eye(3), TABLE.corners.mean(axis=0))
    apart_some = 0
    for coordinates in states(chain, 25):
        bodies = shapes(chain, coordinates)
        bodies["table"] = table, at_table, 0.0
        every = {label: value for label, (value,) in found(chain, coordinates[None]).items()}
        least = min(value for label, value in every.items() if label.startswith("distance between"))
        for label, value in every.items():
            names = label.partition("(")[2].removesuffix(")").split(", ")
            if label.startswith("distance from"):
                names.append("table")
            if names == ["tool", "table"]:
                continue  # a capsule and a box, along one axis
            (one, place, more), (other, elsewhere, further) = (bodies[own] for own in names)
            measured = apart((one, place), (other, elsewhere))
            if measured > 1e-6 and value > least and label.startswith("distance between"):
                assert least <= value <= measured - more - further + 3e-6, label
            elif measured > 1e-6:
                assert value == pytest.approx(measured - more - further, abs=3e-6), label
                apart_some += 1
            else:
                assert value <= 3e-6 - more - further, label
    assert apart_some > 100


def test_overlapping_convex_bodies_exceed_their_limit() -> None:
    """Corners that are within a box: the share is above 1, whatever the radius."""
    block = KeepOut(name="block", x_mm=(-500.0, 500.0), y_mm=(-500.0, 500.0), z_mm=(-500.0, 500.0))
    cone = {"name": "cone", "corners_mm": [[0.0, 0.0, 0.0], [1.0, 0.0, 20.0], [-1.0, 1.0, 20.0], [0.0, -1.0, 20.0]]}
    chain = Chain.model_validate(slide(block).model_dump(exclude_none=True) | {"tool": [cone]})
    still = np.zeros((1, 1))
    inside, outside = (Motion(np.zeros(1), still + x, still, still, still) for x in (0.0, 0.9))
    (quantity,) = body_clearances(inside.t, chain_frames(inside, chain), chain)
    assert quantity.ratio.max() > 1.0
    (quantity,) = body_clearances(outside.t, chain_frames(outside, chain), chain)
    assert quantity.values[0, 0] == pytest.approx(0.4 - 1e-3)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({}, "one of them"),
        ({"to_mm": (0.0, 0.0, 1.0), "corners_mm": ((0.0, 0.0, 0.0),) * 4}, "one of them"),
        ({"from_mm": (0.0, 0.0, 1.0), "corners_mm": ((0.0, 0.0, 0.0),) * 4}, "from_mm"),
        ({"corners_mm": ((0.0, 0.0, 0.0),) * 3}, "corners_mm"),
    ],
)
def test_a_body_has_one_shape(keys: dict, words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        Tool(name="odd", **keys)


def test_a_box_without_sides_is_refused() -> None:
    with pytest.raises(ValidationError, match="no x_mm, y_mm or z_mm"):
        KeepOut(name="everything")


def test_the_search_keeps_off_before_anything_touches() -> None:
    chain, q = CHAINS["robot"], states(CHAINS["robot"])
    case = ROBOT.model_copy(update={"machine": ROBOT.machine.model_copy(update={"chain": chain})})
    symbol, none = ca.SX.sym("q", len(chain.joints)), ca.SX(len(chain.joints), 1)
    shares = [
        share for kind, _, share in SerialChain(chain).shares(case, symbol, none, none) if kind == "distance from"
    ]
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
    (quantity,) = body_clearances(t, chain_frames(motion, slide()), slide())
    assert quantity.ratio.max() > 1.0


@pytest.mark.first(1)
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
        quantities = body_clearances(t, chain_frames(motion, chain), chain)
        return {str(q.of) + label: float(v.min()) for q in quantities for label, v in zip(
            q.labels, q.values.T, strict=True)}  # fmt: skip

    coarse, fine = nearest(few), nearest(many)
    assert coarse.keys() == fine.keys()
    for label, distance in fine.items():
        assert distance - 0.012 <= coarse[label] <= distance, label


@pytest.mark.parametrize("name", CHAINS)
def test_limits_of_the_search_have_the_names_of_the_proof(name: str) -> None:
    """Each share follows from the distance of that name in the proof."""
    chain = CHAINS[name]
    q = ca.SX.sym("q", len(chain.joints))
    places = states(chain, 60)
    shares = clearance_shares(chain, q, places[0], SerialChain(chain).frames(q))
    values = np.array(ca.Function("shares", [q], [ca.vertcat(*(share for *_, share in shares))]).map(60)(places.T)).T
    distances = found(chain, places)
    names = clearance_names(chain)
    assert sorted(names) == sorted(distances)
    for label, column in zip(names, values.T, strict=True):
        near = distances[label] > 0.0  # elsewhere they overlap
        if near.sum() > 20:
            beside = -VICINITY * np.log(column[near]) - distances[label][near]  # but for a constant the same distance
            assert np.ptp(beside) < 0.04, label
