"""How far the bodies of a chain are from boxes and from each other: in NumPy from the definitions, for the proof.

Between two instants nothing passes: a distance is less what the axes of its bodies can move by in half a step.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.chain import Chain
from cases.machine import Tool
from cases.units import MM
from identification.keep_out import distance_of_segments
from identification.limit import Limit, LimitKind
from identification.limited_quantities import Quantity

Array = NDArray[np.float64]


class _Body(NamedTuple):
    """A round body: number of its link, ends of its axis, shapes (n, 3), radius, way of the axis in half a step [m]."""

    link: int
    name: str
    start: Array
    end: Array
    radius: float
    way: Array


def clearances(chain: Chain, frames: Sequence[tuple[Array, Array, Array]], t: Array) -> Iterable[Quantity]:
    """Distances at each instant and until half way to the next; bodies of one link, or of two that meet, may touch.

    The share is 1 at the surface and above 1 inside. Of a box it falls to 0 at a distance of half the box's diagonal,
    of two bodies at one of the sum of their radii.

    Args:
        chain: chain with bodies of base, links and tool, and boxes to keep out of.
        frames: T, T', T'' of the moved frame of each joint and of the sensor's, shapes (n, 4, 4).
        t: the instants, shape (n,) [s].
    """
    count = len(t)
    still = np.tile(np.eye(4), (count, 1, 1)), np.zeros((count, 4, 4)), np.zeros((count, 4, 4))
    half = float(np.diff(t).max()) / 2 if count > 1 else 0.0
    last = len(chain.joints)
    owners = [(0, still, chain.base), *((k + 1, frames[k], joint.bodies) for k, joint in enumerate(chain.joints))]
    bodies = [
        _placed(link, frame, body, half)
        for link, frame, own in (*owners, (last, frames[-1], chain.tool))
        for body in own
    ]
    moving = [body for body in bodies if body.link]
    for box in chain.keep_out:
        if moving:
            columns = [_from_box(body, box.corners) for body in moving]
            limit = Limit(LimitKind.DISTANCE_FROM_BOX, box.name)
            yield _kept(limit, [body.name for body in moving], columns, [box.vicinity] * len(moving))
    pairs = [(a, b) for k, a in enumerate(bodies) for b in bodies[k + 1 :] if abs(a.link - b.link) > 1]
    if pairs:
        labels, reach = [f"{a.name}, {b.name}" for a, b in pairs], [a.radius + b.radius for a, b in pairs]
        limit = Limit(LimitKind.DISTANCE_BETWEEN_LINKS)
        yield _kept(limit, labels, [_between(a, b) for a, b in pairs], reach)


def _kept(limit: Limit, labels: list[str], columns: list[Array], reach: list[float]) -> Quantity:
    distance = np.column_stack(columns)
    ratio = np.nan_to_num(np.maximum(0.0, 1.0 - distance / np.array(reach)), nan=np.inf)
    return Quantity(limit, tuple(labels), distance, np.zeros((2, len(labels))), ratio)


def _placed(link: int, frames: tuple[Array, Array, Array], body: Tool, half: float) -> _Body:
    """Of a point of the axis the velocity is affine along it, so that none is faster than one of the ends."""
    ends = [[frame[:, :3, :3] @ point + frame[:, :3, 3] for point in body.axis] for frame in frames]
    speed, acceleration = (np.linalg.norm(both, axis=2).max(axis=0) for both in ends[1:])
    way = (speed + acceleration * half / 2) * half
    return _Body(link, body.name, ends[0][0], ends[0][1], body.radius_mm * MM, way)


def _from_box(body: _Body, corners: Array) -> Array:
    distances = distance_of_segments(body.start[:, None], (body.end - body.start)[:, None], corners)
    return np.asarray(distances[:, 0] - body.radius - body.way)


def _between(one: _Body, other: _Body) -> Array:
    """Distance of two bodies, shape (n,) [m]: that of their axes (Ericson, Real-Time Collision Detection, 5.1.9)."""
    d, e, r = one.end - one.start, other.end - other.start, one.start - other.start
    dd, ee, de, dr, er = (np.einsum("ni,ni->n", u, v) for u, v in ((d, d), (e, e), (d, e), (d, r), (e, r)))
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.nan_to_num(np.clip((de * er - dr * ee) / (dd * ee - de**2), 0.0, 1.0))
        t = np.nan_to_num(np.clip((de * s + er) / ee, 0.0, 1.0))
        s = np.nan_to_num(np.clip((de * t - dr) / dd, 0.0, 1.0))
    gap = r + s[:, None] * d - t[:, None] * e
    return np.asarray(np.linalg.norm(gap, axis=1) - one.radius - other.radius - one.way - other.way)
