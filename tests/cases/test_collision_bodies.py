"""Bodies around the collision geometry of a URDF: they cover it, and keep clear where coal says that it does."""

import re
import struct
from pathlib import Path

import coal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from cases.base.convex import capsule_around
from cases.collision_bodies import mesh_file
from cases.machine import Tool
from cases.schema import load_case
from cases.urdf import read_urdf
from hexcite._new_arm import new_arm
from identification.limits.chain import body_clearances, chain_frames
from identification.motion.motion import Motion
from tests.helpers import examples

LENGTHS = (0.35, 0.3, 0.2)  # of the links [m], along x


def bent(k: int) -> np.ndarray:
    """Corners of a link that is no capsule: an L with a knob, shape (n, 3) [m]."""
    draw, long = np.random.default_rng(k), LENGTHS[k]
    beam = draw.uniform([0.0, -0.03, -0.02], [long, 0.03, 0.04], (60, 3))
    return np.vstack([beam, draw.uniform([long - 0.06, 0.0, -0.03], [long, 0.12, 0.05], (30, 3))])


def triangles(points: np.ndarray) -> np.ndarray:
    """The convex hull of points, shape (m, 3, 3)."""
    return points[ConvexHull(points).simplices]


def stl(points: np.ndarray) -> bytes:
    faces = triangles(points)
    rows = [struct.pack("<12fH", 0, 0, 0, *face.ravel(), 0) for face in faces]
    return b"solid binary all the same".ljust(80) + struct.pack("<I", len(faces)) + b"".join(rows)


def stl_text(points: np.ndarray) -> bytes:
    loops = "".join(
        "facet normal 0 0 0\n outer loop\n"
        + "".join(f"  vertex {x!r} {y!r} {z!r}\n" for x, y, z in face.tolist())
        + " endloop\nendfacet\n"
        for face in triangles(points)
    )
    return f"solid link\n{loops}endsolid link\n".encode()


def obj(points: np.ndarray) -> bytes:
    return "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist()).encode()


PLACE = '<origin xyz="0.01 -0.02 0.015" rpy="0.1 -0.2 0.3"/>'
WRITTEN = (("a.stl", stl, "meshes/a.stl"), ("b.STL", stl_text, "package://arm/meshes/b.STL"),
           ("c.obj", obj, "../meshes/c.obj"))  # fmt: skip


def robot(folder: Path, more: str = "") -> Path:
    """A package with an arm of three links whose meshes are there, one in tenths of millimetres."""
    (folder / "arm" / "meshes").mkdir(parents=True)
    links, joints = ['<link name="base"/>'], []
    for k, (name, form, uri) in enumerate(WRITTEN):
        scale = 1e4 if k == 1 else 1.0
        (folder / "arm" / "meshes" / name).write_bytes(form(scale * bent(k)))
        uri = uri if uri.startswith(("package", "..")) else f"../{uri}"
        size = f' scale="{1 / scale} {1 / scale} {1 / scale}"' if scale != 1.0 else ""
        shape = f'<collision>{PLACE}<geometry><mesh filename="{uri}"{size}/></geometry></collision>'
        links.append(f'<link name="link_{k}">{shape}{more if k == 2 else ""}</link>')
        x = LENGTHS[k - 1] if k else 0.0
        joints.append(
            f'<joint name="j{k}" type="revolute"><parent link="{f"link_{k - 1}" if k else "base"}"/>'
            f'<child link="link_{k}"/><origin xyz="{x} 0 0.2" rpy="{0.3 * k} 0 0"/><axis xyz="0 0 1"/>'
            '<limit lower="-3" upper="3" velocity="2" effort="50"/></joint>'
        )
    (folder / "arm" / "urdf").mkdir()
    file = folder / "arm" / "urdf" / "robot.urdf"
    file.write_text(f'<robot name="bent">{"".join(links + joints)}</robot>')
    return file


def hull(k: int) -> coal.CollisionGeometry:
    return hull_of(bent(k))


def hull_of(points: np.ndarray) -> coal.CollisionGeometry:
    model = coal.BVHModelOBBRSS()
    faces = triangles(points)
    model.beginModel(len(faces), 3 * len(faces))
    for face in faces:
        model.addTriangle(*face)
    model.endModel()
    model.buildConvexHull(True, "Qt")
    return model.convex


def off(points: np.ndarray, body: Tool) -> float:
    """How far points are out of a convex body, by coal, which knows points as small spheres [m]."""
    corners = hull_of(body.points)
    distances = [
        coal.distance(
            corners, coal.Transform3s(), coal.Sphere(1e-6), coal.Transform3s(np.eye(3), point),
            coal.DistanceRequest(), coal.DistanceResult(),
        )
        for point in points
    ]  # fmt: skip
    return max(distances) + 1e-6 - body.radius_mm / 1e3


@settings(max_examples=examples(40), deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 40), st.floats(0.0, 1.0))
def test_a_capsule_covers_points_and_is_not_much_longer(seed: int, count: int, flat: float) -> None:
    draw = np.random.default_rng(seed)
    points = draw.normal(size=(count, 3)) * [1.0, flat, 0.1]
    ends, radius = capsule_around(points)
    way = ends[1] - ends[0]
    share = np.clip((points - ends[0]) @ way / max(way @ way, 1e-300), 0.0, 1.0)
    distances = np.linalg.norm(points - ends[0] - share[:, None] * way, axis=1)
    assert distances.max() <= radius + 1e-12
    width = np.linalg.norm(np.ptp(points, axis=0))
    assert np.linalg.norm(way) + 2 * radius <= 2.0 * width + 1e-9


def test_a_cylinder_with_round_ends_is_found_as_it_is() -> None:
    draw = np.random.default_rng(1)
    directions = draw.normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    turn = Rotation.from_euler("xyz", [20, 40, 60], degrees=True).as_matrix()
    points = (0.05 * directions + np.outer(np.where(draw.random(4000) < 0.5, -0.2, 0.2), [0, 0, 1])) @ turn.T
    ends, radius = capsule_around(points)
    assert radius == pytest.approx(0.05, rel=0.03)
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(0.4, rel=0.05)


def test_bodies_of_meshes_cover_them_and_their_clearance_is_on_the_safe_side(tmp_path: Path) -> None:
    """Distances of the hulls of the meshes are coal's."""
    arm = read_urdf(robot(tmp_path), "link_2")
    assert not any("body" in note for note in arm.notes)
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = Rotation.from_euler("xyz", [0.1, -0.2, 0.3]).as_matrix(), [0.01, -0.02, 0.015]
    for k, (body,) in enumerate(arm.bodies):
        assert off(bent(k) @ place[:3, :3].T + place[:3, 3], body) <= 0.0
    case = bodied_case(tmp_path)
    chain = case.chain
    q = np.random.default_rng(0).uniform(-2.5, 2.5, (60, 3))
    motion = Motion(np.arange(60.0), q, *(np.zeros_like(q) for _ in range(3)))
    places = [frame for frame, _, _ in chain_frames(motion, chain)]
    found = {label: values for quantity in body_clearances(motion.t, chain_frames(motion, chain), chain)
             for label, values in zip(quantity.labels, quantity.values.T, strict=True)}  # fmt: skip
    (label,) = [label for label in found if "link_0" in label and "link_2" in label]
    first, last, exact = hull(0), hull(2), np.zeros(60)
    for k in range(60):
        at = [coal.Transform3s(frame[k, :3, :3] @ place[:3, :3], (frame[k] @ place)[:3, 3])
              for frame in (places[0], places[2])]  # fmt: skip
        result = coal.DistanceResult()
        exact[k] = coal.distance(first, at[0], last, at[1], coal.DistanceRequest(), result)
    assert np.all(found[label] <= np.maximum(exact, 0.0) + 1e-6)
    larger = max(body.radius for joint in chain.joints for body in joint.bodies if body.corners_mm)
    rounding = max(body.radius_mm / 1e3 for joint in chain.joints for body in joint.bodies)
    closest = int(np.argmin(found[label]))  # elsewhere it may say less: the closest instant decides
    assert rounding < 2e-3 < larger
    assert exact[closest] - found[label][closest] < 2.0 * rounding + 1e-6


def bodied_case(folder: Path):
    """A case of the arm with the bodies that stand in it as comments."""
    file = new_arm("arm", folder / "arm" / "urdf" / "robot.urdf", "link_2", folder / "case")
    text = file.read_text()
    assert load_case(str(file)).chain.joints[0].bodies == ()  # a proposal
    file.write_text(re.sub(r"^# (bodies = )", r"\1", text, flags=re.MULTILINE))
    return load_case(str(file))


def test_what_stands_and_several_shapes_are_covered(tmp_path: Path) -> None:
    shapes = "".join(
        f'<collision><origin xyz="0 0 {0.1 * k}"/><geometry>{shape}</geometry></collision>'
        for k, shape in enumerate(('<sphere radius="0.05"/>', '<cylinder radius="0.03" length="0.2"/>',
                                   '<box size="0.1 0.2 0.4"/>'))
    )  # fmt: skip
    file = robot(tmp_path, shapes)
    file.write_text(file.read_text().replace('<link name="base"/>', f'<link name="base">{shapes}</link>'))
    arm = read_urdf(file, "link_2")
    assert [body.name for body in arm.standing] == ["base 1", "base 2", "base 3"]
    sphere, cylinder, box = arm.standing
    assert sphere.radius_mm == pytest.approx(50.0, abs=0.05)
    np.testing.assert_allclose(cylinder.axis, [[0, 0, 0.0], [0, 0, 0.2]], atol=1e-9)
    corners = np.array([[x, y, 0.2 + z] for x in (-0.05, 0.05) for y in (-0.1, 0.1) for z in (-0.2, 0.2)])
    assert off(corners, box) <= 0.0
    assert len(arm.bodies[2]) == 4


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        ("package://other/a.stl", "its collision mesh in package://other is not there"),
        ("../meshes/d.dae", "d.dae is .dae; convert it to STL, and name that in the URDF"),
        ("../meshes/e.stl", "no corners"),
        ("\x01" * 3, "not there"),
    ],
)
def test_a_mesh_that_cannot_be_used_is_named_with_its_link(mesh: str, words: str, tmp_path: Path) -> None:
    file = robot(tmp_path)
    for name in ("d.dae", "e.stl"):
        (file.parent.parent / "meshes" / name).write_bytes(b"nothing")
    text = file.read_text().replace("../meshes/a.stl", mesh.replace("\x01", "%"))
    file.write_text(text)
    arm = read_urdf(file, "link_2")
    assert any("link_0" in note and words in note for note in arm.notes)
    assert arm.bodies[0] == ()
    assert len(arm.bodies[1]) == 1


def test_a_package_is_looked_for_around_the_file(tmp_path: Path) -> None:
    file = robot(tmp_path)
    assert mesh_file("package://arm/meshes/a.stl", file.parent) == tmp_path / "arm" / "meshes" / "a.stl"
    assert mesh_file("package://arm/meshes/z.stl", file.parent) is None
