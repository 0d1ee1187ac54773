"""Round bodies that cover the collision geometry of links: spheres, cylinders, boxes, and meshes that are there.

Each element is covered by one capsule: whatever keeps clear of it keeps clear of the geometry. Capsules are larger than
what they cover, most of all around boxes and bent links.
"""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from cases.base.errors import FileProblem
from cases.base.files import read_whole
from cases.base.units import MM, Array
from cases.machine import Tool, turned

MOST_MESH = 64 * 2**20  # bytes
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEAD = 84  # bytes of a binary STL before its triangles
_VERTEX = re.compile(rb"^\s*(?:vertex|v)\s+(\S+)\s+(\S+)\s+(\S+)", re.MULTILINE)
_MOST = 1e3  # [m] of a point


class Uncovered(ValueError):
    """Why an element cannot be covered."""


def covering(link: Element, place: Array, folder: Path, name: str) -> Iterator[Tool | str]:
    """Capsules that cover the `<collision>` elements of a link, or why one cannot be covered.

    Args:
        place: the link in the frame that capsules are wanted in, shape (4, 4) [-, m].
        folder: folder of the URDF file, from which meshes are looked for.
        name: of the capsules; numbered where there are several.
    """
    elements = link.findall("collision")
    for k, element in enumerate(elements, 1):
        own = name if len(elements) == 1 else f"{name} {k}"
        try:
            ends, radius = _capsule(element, folder)
        except Uncovered as reason:
            yield str(reason)
            continue
        ends = (place @ _place(element) @ np.column_stack([ends, np.ones(2)]).T).T[:, :3] / MM
        first, last = (tuple(round(float(v), 3) + 0.0 for v in end) for end in ends)
        # Rounding of ends is in the radius.
        yield Tool.model_validate(
            {"name": own, "from_mm": first, "to_mm": last, "radius_mm": math.ceil(1e2 * radius / MM + 1.0) / 1e2}
        )


def _capsule(element: Element, folder: Path) -> tuple[Array, float]:
    """Ends of the axis, shape (2, 3), and the radius [m] of a capsule that covers an element, in its own frame."""
    geometry = element.find("geometry")
    shape = next(iter(geometry), None) if geometry is not None else None
    if shape is None:
        raise Uncovered("a collision without geometry")
    if shape.tag == "sphere":
        return np.zeros((2, 3)), _numbers(shape, "radius", 1)[0]
    if shape.tag in ("cylinder", "capsule"):
        half = _numbers(shape, "length", 1)[0] / 2.0
        return np.array([[0.0, 0.0, -half], [0.0, 0.0, half]]), _numbers(shape, "radius", 1)[0]
    if shape.tag == "box":
        half_sizes = _numbers(shape, "size", 3) / 2.0
        return around(np.array([[(-1) ** (k >> i & 1) for i in range(3)] for k in range(8)]) * half_sizes)
    if shape.tag == "mesh":
        scale = _numbers(shape, "scale", 3) if shape.get("scale") else np.ones(3)
        return around(_points(shape.get("filename", ""), folder) * scale)
    raise Uncovered(f"a collision of {shape.tag[:40]}")


def around(points: Array) -> tuple[Array, float]:
    """Ends of the axis, shape (2, 3), and the radius of a small capsule that covers points, shape (n, 3) [m].

    The smallest of those along the principal axes of the points and along their coordinates; a smaller one may exist.
    """
    centred = points - points.mean(axis=0)
    _, _, principal = np.linalg.svd(centred, full_matrices=False) if len(points) > 2 else (0, 0, np.eye(3))
    found = [_along(points, axis) for axis in (*principal, *np.eye(3))]
    return min(found, key=lambda capsule: _volume(*capsule))


def _volume(ends: Array, radius: float) -> float:
    return math.pi * radius**2 * (float(np.linalg.norm(ends[1] - ends[0])) + 4.0 / 3.0 * radius)


def _along(points: Array, axis: Array) -> tuple[Array, float]:
    """The capsule along a direction, shape (3,)."""
    beside = np.eye(3) - np.outer(axis, axis)
    flat, along = points @ beside, points @ axis
    _, _, directions = np.linalg.svd(beside)  # the first two span the plane
    plane = flat @ directions[:2].T
    middle = (plane.min(axis=0) + plane.max(axis=0)) / 2.0
    for _ in range(200):  # towards the farthest point, ever less: Badoiu and Clarkson 2003
        off = plane - middle
        far = int(np.argmax(np.einsum("ni,ni->n", off, off)))
        middle = middle + off[far] / (_ + 2.0)
    distances = np.linalg.norm(plane - middle, axis=1)
    radius = float(distances.max())
    cap = np.sqrt(np.maximum(radius**2 - distances**2, 0.0))
    low, high = float((along + cap).min()), float((along - cap).max())
    if low > high:  # the two caps alone cover it
        low = high = (low + high) / 2.0
    origin = middle @ directions[:2]
    ends = origin + np.outer([low, high], axis)
    return ends, _farthest(points, ends)


def _farthest(points: Array, ends: Array) -> float:
    """Largest distance of points from a segment."""
    way = ends[1] - ends[0]
    square = float(way @ way)
    share = np.zeros(len(points)) if square == 0.0 else np.clip((points - ends[0]) @ way / square, 0.0, 1.0)
    return float(np.linalg.norm(points - ends[0] - share[:, None] * way, axis=1).max())


def _points(uri: str, folder: Path) -> Array:
    """Corners of a mesh, shape (n, 3); raises Uncovered where it is not there or cannot be read."""
    file = mesh_file(uri, folder)
    if file is None:
        raise Uncovered(f"its collision mesh in {uri.rpartition('/')[0][:200] or '.'} is not there")
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
            points = np.array([[float(v) for v in found] for found in _VERTEX.findall(content)]).reshape(-1, 3)
        except ValueError:
            raise Uncovered(f"mesh {file}: a corner that is not three numbers") from None
    if suffix not in (".stl", ".obj"):
        raise Uncovered(f"mesh {file.name} is {suffix or 'of no kind'}; convert it to STL")
    if not len(points) or not np.all(np.abs(points) < _MOST):
        raise Uncovered(f"mesh {file}: no corners that are numbers below {_MOST:g}")
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


def _place(element: Element) -> Array:
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
