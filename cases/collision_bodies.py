"""Bodies that cover the collision geometry of links: spheres, cylinders, boxes, and meshes that are there.

Each element is covered by one body: whatever keeps clear of it keeps clear of the geometry. Spheres and slender
cylinders are covered by capsules, short ones by a prism around them, boxes by the hull of their corners, meshes by that
of some of theirs, made larger all around by what it does not hold; what is hollow or bent is filled up to its convex
hull.
"""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from cases.base.convex import capsule_around, corners_around
from cases.base.errors import FileProblem
from cases.base.file_reading import read_whole
from cases.base.units import MM, Array
from cases.machine import Tool, turned

MOST_MESH = 64 * 2**20  # bytes
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEAD = 84  # bytes of a binary STL before its triangles
_VERTEX = re.compile(rb"^[ \t]*+(?:vertex|v)[ \t]++(\S++)[ \t]++(\S++)[ \t]++(\S++)", re.MULTILINE)
_MOST = 1e3  # [m] of a point
SLENDER = 4.0  # half the length of a cylinder over its radius, from which its ends may be taken as round
SIDES = 12  # of the prism around a short one, which is wider by 3.5 % at its edges
FEWEST_CORNERS = 4  # of a body; fewer points get a capsule


class Uncovered(ValueError):
    """Why an element cannot be covered."""


def covering(link: Element, body_from_link: Array, folder: Path, name: str) -> Iterator[Tool | str]:
    """Bodies that cover the `<collision>` elements of a link, or why one cannot be covered.

    Args:
        body_from_link: the link in the frame that bodies are wanted in, shape (4, 4) [-, m].
        folder: folder of the URDF file, from which meshes are looked for.
        name: of the bodies; numbered where there are several.
    """
    elements = link.findall("collision")
    for k, element in enumerate(elements, 1):
        body_name = name if len(elements) == 1 else f"{name} {k}"
        try:
            points, radius = _hull(element, folder)
        except Uncovered as reason:
            yield str(reason)
            continue
        body_from_element = body_from_link @ _link_from_element(element)
        points = (body_from_element @ np.column_stack([points, np.ones(len(points))]).T).T[:, :3] / MM
        rounded = [tuple(round(float(v), 2) + 0.0 for v in point) for point in points]
        shape = {"from_mm": rounded[0], "to_mm": rounded[1]} if len(rounded) == 2 else {"corners_mm": rounded}
        # Rounding of points is in the radius.
        yield Tool.model_validate({"name": body_name, **shape, "radius_mm": math.ceil(1e2 * radius / MM + 1.0) / 1e2})


def _hull(element: Element, folder: Path) -> tuple[Array, float]:
    """Points, shape (k, 3), whose convex hull, larger by a radius [m], covers an element, in its own frame.

    Two are the ends of the axis of a capsule.
    """
    geometry = element.find("geometry")
    shape = next(iter(geometry), None) if geometry is not None else None
    if shape is None:
        raise Uncovered("a collision without geometry")
    if shape.tag == "sphere":
        return np.zeros((2, 3)), _numbers(shape, "radius", 1)[0]
    if shape.tag in ("cylinder", "capsule"):
        half, radius = _numbers(shape, "length", 1)[0] / 2.0, _numbers(shape, "radius", 1)[0]
        if shape.tag == "cylinder" and half < SLENDER * radius:
            around = 2.0 * np.pi * np.arange(SIDES) / SIDES
            rim = radius / math.cos(np.pi / SIDES) * np.column_stack([np.cos(around), np.sin(around)])
            return np.vstack([np.column_stack([rim, np.full(SIDES, z)]) for z in (-half, half)]), 0.0
        return np.array([[0.0, 0.0, -half], [0.0, 0.0, half]]), radius
    if shape.tag == "box":
        half_sizes = _numbers(shape, "size", 3) / 2.0
        return np.array([[(-1) ** (k >> i & 1) for i in range(3)] for k in range(8)]) * half_sizes, 0.0
    if shape.tag == "mesh":
        scale = _numbers(shape, "scale", 3) if shape.get("scale") else np.ones(3)
        points = _points(shape.get("filename", ""), folder, scale)
        corners, more = corners_around(points)
        return (corners, more) if len(corners) >= FEWEST_CORNERS else capsule_around(points)
    raise Uncovered(f"a collision of {shape.tag[:40]}")


def _points(uri: str, folder: Path, scale: Array) -> Array:
    """Corners of a mesh, its numbers times a scale, shape (n, 3) [m].

    Raises Uncovered where it is not there or cannot be read. Those of COLLADA (.dae) are not read: of the readers in
    use some follow its unit and its axis that points up, and others do not, so that nobody knows what a file means.
    """
    file = mesh_file(uri, folder)
    if file is None:
        place = uri.rpartition("/")[0][:200] or "."
        raise Uncovered(f"its collision mesh in {place} is not there; put that folder beside the file or around it")
    try:
        content = read_whole(file, MOST_MESH)
    except FileProblem as error:
        raise Uncovered(f"mesh {file}: {error.problem}") from None
    suffix, points = file.suffix.lower(), np.zeros((0, 3))
    if suffix == ".stl" and len(content) >= _HEAD:
        count = int.from_bytes(content[_HEAD - 4 : _HEAD], "little")
        if len(content) == _HEAD + count * _TRIANGLE.itemsize:
            points = np.frombuffer(content, _TRIANGLE, count, _HEAD)["corners"].reshape(-1, 3).astype(float)
    if suffix in (".stl", ".obj") and not len(points):
        try:
            points = np.array([[float(v) for v in vertex] for vertex in _VERTEX.findall(content)]).reshape(-1, 3)
        except ValueError:
            raise Uncovered(f"mesh {file}: a corner that is not three numbers") from None
    if suffix not in (".stl", ".obj"):
        raise Uncovered(f"mesh {file.name} is {suffix or 'of no kind'}; convert it to STL, and name that in the URDF")
    points = points * scale
    if not len(points) or not np.all(np.abs(points) < _MOST):
        raise Uncovered(f"mesh {file}: no corners that are numbers below {_MOST:g} m")
    return np.unique(points, axis=0)


def mesh_file(uri: str, folder: Path) -> Path | None:
    """The file that a URI of a URDF names, `package://` among the folders around it; None where it is not there."""
    scheme, _, path = uri.rpartition("://")
    if scheme in ("package", "model"):
        package, _, inside = path.partition("/")
        around_it = [folder, *folder.resolve().parents]
        candidates = [above / package / inside for above in around_it]
        candidates += [above / inside for above in around_it if above.name == package]
    else:
        candidates = [Path(path) if path.startswith("/") else folder / path]
    try:
        return next((file for file in candidates if file.is_file()), None)
    except (OSError, ValueError):  # a name that the system refuses
        return None


def _link_from_element(element: Element) -> Array:
    """Place of an element in its link, shape (4, 4) [-, m]; raises Uncovered."""
    place = np.eye(4)
    if (origin := element.find("origin")) is not None:
        place[:3, 3] = _numbers(origin, "xyz", 3, "0 0 0", least=-_MOST)
        place[:3, :3] = turned(_numbers(origin, "rpy", 3, "0 0 0", least=-_MOST))
    return place


def _numbers(element: Element, key: str, count: int, default: str = "", least: float = 0.0) -> Array:
    """Numbers of an attribute; raises Uncovered."""
    text = element.get(key, default)
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError:
        values = np.zeros(0)
    if len(values) != count or not np.all((values >= least) & (values < _MOST)):
        raise Uncovered(f"{key} of its {element.tag} is {text[:40]!r}")
    return values
