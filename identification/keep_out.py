"""Distances of platform, struts and tools from boxes that nothing may enter."""

from itertools import combinations, product

import numpy as np

from cases.machine import KeepOut, Workspace
from cases.units import MM, Array


def distance_of_points(points: Array, corners: Array) -> Array:
    """Distance along the axis that separates point and box most, below 0 inside, shape (..) [m].

    `points` have the shape (.., 3), lower and upper corner of the box (2, 3) [m].
    """
    return np.asarray(np.maximum(corners[0] - points, points - corners[1]).max(axis=-1))


def distance_of_segments(start: Array, way: Array, corners: Array) -> Array:
    """The least distance that a point of each segment start + s way, 0 <= s <= 1, has, shape (n, k) [m].

    Exact: along a segment the distance is the largest of six affine functions of s, so that its minimum lies at an end
    or where two of them meet. Shapes: start (k, 3) or (n, k, 3), way (n, k, 3), corners (2, 3) [m].
    """
    half = (corners[1] - corners[0]) / 2
    x = [np.ascontiguousarray(start[..., k] - corners[:, k].mean()) for k in range(3)]  # far quicker than by rows of 3
    w = [np.ascontiguousarray(way[..., k]) for k in range(3)]

    def at(share: Array | float) -> Array:
        first, second, third = (np.abs(x[k] + share * w[k]) - half[k] for k in range(3))
        return np.asarray(np.maximum(np.maximum(first, second), third))

    least = np.minimum(at(0.0), at(1.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        meetings = [-x[k] / w[k] for k in range(3)]  # of the two sides of one axis
        meetings += [
            (half[i] - half[j] - a * x[i] + b * x[j]) / (a * w[i] - b * w[j])
            for i, j in combinations(range(3), 2)
            for a, b in product((1.0, -1.0), repeat=2)
        ]
    for share in meetings:  # parallel ones meet nowhere: an end of the segment instead
        least = np.minimum(least, at(np.fmax(np.fmin(share, 1.0), 0.0)))
    return np.where(np.isfinite(way).all(axis=2), least, np.nan)


def guarded(workspace: Workspace) -> tuple[str, ...]:
    """Names of what must stay out of a box: the columns of `distances`."""
    numbered = (f"{kind} {k}" for kind in ("joint", "strut") for k in range(1, 7))
    return ("origin", *numbered, *(tool.name for tool in workspace.tool))


def distances(box: KeepOut, workspace: Workspace, origin: Array, turn: Array, base: Array, strut: Array) -> Array:
    """Distances of the platform's origin and joints, of struts and tools from a box, shape (n, 13 and more) [m].

    Below 0 inside; in the order of `guarded`. Shapes: origin of {P} (n, 3), R (n, 3, 3), base joints (6, 3), struts
    from these to the platform's joints (n, 6, 3) [m].
    """
    points = distance_of_points(np.concatenate([origin[:, None], strut + base], axis=1), box.corners)
    struts = distance_of_segments(base, strut, box.corners) - workspace.strut_radius_mm * MM
    if not workspace.tool:
        return np.hstack([points, struts])
    low, high = (np.array([tool.axis[end] for tool in workspace.tool]) @ turn.transpose(0, 2, 1) for end in (0, 1))
    radii = np.array([tool.radius_mm for tool in workspace.tool]) * MM
    tools = distance_of_segments(origin[:, None] + low, high - low, box.corners) - radii
    return np.hstack([points, struts, tools])
