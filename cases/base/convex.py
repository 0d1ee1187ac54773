"""Convex bodies given by their corners: how far apart two of them are, and what covers points.

Distances are lower bounds with a reason: for any direction, two bodies are at least as far apart as their shadows on
it. The directions are those of Gilbert, Johnson and Keerthi (1988), whose bounds grow to the distance itself.
"""

import math
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from cases.base.units import Array

ROUNDS = 40  # of the search for a direction, at most; bodies of dozens of corners take 5 to 15
CLOSE = 1e-12  # share of its square by which a distance may be too small
TOUCHING = 1e-10  # [m] below which points of two bodies are the same
MOST_CORNERS = 40  # of a covering body
FLAT = 0.97  # cosine of the angle of two faces between which no edge is drawn
STRIDE = 32  # instants between two at which bodies are looked at closely
COVERED = 1e-3  # [m] distance of points from the hull of the chosen corners at which no further one is chosen


def separation(one: Array, other: Array) -> Array:
    """Distance of two convex bodies at each of n instants, or less by rounding; below 0 where they overlap, shape (n,).

    Where they overlap it is the least negative overlap of their shadows on some directions: at most minus the depth.

    Args:
        one: corners of one body, shape (n, p, 3) [m].
        other: corners of the other, shape (n, q, 3) [m].
    """
    return _separated(one, other)[0]


def _separated(one: Array, other: Array) -> tuple[Array, Array]:
    """`separation`, and the direction of which it is the gap of shadows, 0 where they overlap, shape (n, 3)."""
    count = len(one)
    best, along = np.full(count, -np.inf), np.zeros((count, 3))
    simplex, corners = np.zeros((count, 4, 3)), np.zeros((count, 4), dtype=bool)
    nearest = one[:, 0] - other[:, 0]
    simplex[:, 0], corners[:, 0] = nearest, True
    todo = np.arange(count)
    for _ in range(ROUNDS):
        v = nearest[todo]
        size = np.linalg.norm(v, axis=1)
        separated = size > TOUCHING
        todo, v, size = todo[separated], v[separated], size[separated]
        if not len(todo):
            break
        extreme = _extreme(one[todo], -v) - _extreme(other[todo], v)
        bound = np.einsum("ni,ni->n", extreme, v) / size
        better = bound > best[todo]
        best[todo[better]], along[todo[better]] = bound[better], (v / size[:, None])[better]
        going = size - bound > CLOSE * size + 1e-15
        todo, extreme = todo[going], extreme[going]
        if not len(todo):
            break
        before = np.linalg.norm(nearest[todo], axis=1)
        nearest[todo], simplex[todo], corners[todo] = _closest(simplex[todo], corners[todo], extreme)
        todo = todo[np.linalg.norm(nearest[todo], axis=1) < before]
    touching = ~(best > 0.0)
    if touching.any():
        best[touching] = np.maximum(best[touching], _shadows(one[touching], other[touching]))
        along[touching] = 0.0
    return best, along


def least_separation(one: Array, other: Array, bound: Array, enough: Array | float = math.inf) -> Array:
    """`separation`, exact at the instant where it is least; elsewhere a lower bound that is not below that, shape (n,).

    Args:
        one, other: as for `separation`, at instants in the order of time.
        bound: a lower bound that is known, shape (n,) [m].
        enough: distance from which a lower bound will do, shape (n,) or a number [m].
    """
    if np.all(bound >= enough):
        return bound
    some = np.unique(np.append(np.arange(0, len(bound), STRIDE), np.argmin(bound)))
    exact, along = _separated(one[some], other[some])
    # What separates bodies at an instant does so at those beside it, a little less.
    neighbours = along[np.searchsorted(some, np.arange(len(bound)), side="right") - 1]
    gaps = np.einsum("npi,ni->np", one, neighbours).min(axis=1) - np.einsum("npi,ni->np", other, neighbours).max(axis=1)
    result = np.maximum(bound, np.where(neighbours.any(axis=1), gaps, -np.inf))
    result[some] = np.maximum(bound[some], exact)
    smaller = (result < result[some].min()) & (result < enough)
    smaller[some] = False
    if smaller.any():
        result[smaller] = np.maximum(result[smaller], separation(one[smaller], other[smaller]))
    return result


def _extreme(corners: Array, direction: Array) -> Array:
    """The corner that is farthest along a direction, shape (n, 3)."""
    far = np.argmax(np.einsum("npi,ni->np", corners, direction), axis=1)
    return np.asarray(corners[np.arange(len(corners)), far])


def _closest(simplex: Array, used: Array, added: Array) -> tuple[Array, Array, Array]:
    """The point nearest to the origin of a simplex with a corner that is added, and the corners that it lies between.

    Of all corners, edges, faces and the whole with that corner, the nearest point that lies within: its weights are
    not negative. Shapes: (n, 4, 3), (n, 4), (n, 3).
    """
    count = len(added)
    best, size = added.copy(), np.einsum("ni,ni->n", added, added)
    support = np.zeros((count, 4), dtype=bool)
    for number in (1, 2, 3):
        for chosen in combinations(range(4), number):
            vertices = list(chosen)
            rows = np.flatnonzero(used[:, vertices].all(axis=1))
            if not len(rows):
                continue
            edges = simplex[rows][:, vertices] - added[rows, None]
            gram = edges @ edges.transpose(0, 2, 1)
            scale = np.trace(gram, axis1=1, axis2=2)
            gram = gram + (1e-14 * scale + 1e-300)[:, None, None] * np.eye(number)
            right = -np.einsum("nki,ni->nk", edges, added[rows])
            weights = np.linalg.solve(gram, right[..., None])[..., 0]
            point = added[rows] + np.einsum("nk,nki->ni", weights, edges)
            square = np.einsum("ni,ni->n", point, point)
            inside = (weights >= 0.0).all(axis=1) & (weights.sum(axis=1) <= 1.0) & (square < size[rows])
            rows, point, square = rows[inside], point[inside], square[inside]
            best[rows], size[rows], support[rows] = point, square, False
            support[rows[:, None], vertices] = True
    corners = np.where(support[..., None], simplex, 0.0)
    free = np.argmin(support, axis=1)  # there is one: three are kept at most
    corners[np.arange(count), free], support[np.arange(count), free] = added, True
    return best, corners, support


_DIRECTIONS = (
    np.array([d for d in np.ndindex(3, 3, 3) if d > (1, 1, 1)], dtype=float) - 1.0
)  # 13 lines: along edges, face and body diagonals of a cube


def _shadows(one: Array, other: Array) -> Array:
    """The largest gap of the shadows of two bodies on some directions, negative where all overlap, shape (n,) [m]."""
    middle = other.mean(axis=1) - one.mean(axis=1)
    most = np.full(len(one), -np.inf)
    units = [np.broadcast_to(d / np.linalg.norm(d), middle.shape) for d in _DIRECTIONS]
    size = np.linalg.norm(middle, axis=1, keepdims=True)
    units.append(np.where(size > 0.0, middle / np.where(size > 0.0, size, 1.0), [1.0, 0.0, 0.0]))
    for unit in units:
        first, second = (np.einsum("npi,ni->np", corners, unit) for corners in (one, other))
        gap = np.maximum(second.min(axis=1) - first.max(axis=1), first.min(axis=1) - second.max(axis=1))
        most = np.maximum(most, gap)
    return most


def corners_around(points: Array) -> tuple[Array, float]:
    """Some of the points, shape (k, 3), and the radius [m] within which their convex hull covers all of them, (n, 3).

    The points that are farthest in many directions, then the one that is farthest from the hull so far, until all are
    within `COVERED` of it or there are `MOST_CORNERS`.
    """
    points = points[_on_hull(points)]
    directions = np.vstack([_DIRECTIONS, -_DIRECTIONS])
    chosen = list(dict.fromkeys(np.argmax(points @ directions.T, axis=0).tolist()))
    while True:
        hull = points[chosen]
        distances = np.maximum(separation(points[:, None], np.broadcast_to(hull, (len(points), *hull.shape))), 0.0)
        far = int(np.argmax(distances))
        if distances[far] <= COVERED or len(chosen) >= MOST_CORNERS:
            return hull, float(distances[far])
        chosen.append(far)


def _on_hull(points: Array) -> NDArray[np.int64]:
    """Which points are corners of their convex hull, as numbers; all where they lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(ConvexHull(points).vertices, dtype=np.int64)
    except (QhullError, ValueError):
        return np.arange(len(points), dtype=np.int64)


def sharp_edges(corners: Array) -> Array:
    """Edges of the convex hull of corners, shape (k, 3), between faces that turn: their ends, shape (m, 2, 3)."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(corners)
    except (QhullError, ValueError):
        return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    edges = [
        np.intersect1d(hull.simplices[face], hull.simplices[other])
        for face, neighbours in enumerate(hull.neighbors)
        for other in neighbours
        if other > face and hull.equations[face, :3] @ hull.equations[other, :3] < FLAT
    ]
    return np.asarray(corners[np.array(edges, dtype=int).reshape(-1, 2)])


def capsule_around(points: Array) -> tuple[Array, float]:
    """Ends of the axis, shape (2, 3), and the radius of a small capsule that covers points, shape (n, 3) [m].

    The smallest of those along the principal axes of the points and along their coordinates; a smaller one may exist.
    """
    centred = points - points.mean(axis=0)
    _, _, principal = np.linalg.svd(centred, full_matrices=False) if len(points) > 2 else (0, 0, np.eye(3))
    capsules = [_along(points, axis) for axis in (*principal, *np.eye(3))]
    return min(capsules, key=lambda capsule: _volume(*capsule))


def _volume(ends: Array, radius: float) -> float:
    return math.pi * radius**2 * (float(np.linalg.norm(ends[1] - ends[0])) + 4.0 / 3.0 * radius)


def _along(points: Array, axis: Array) -> tuple[Array, float]:
    """The capsule along a direction, shape (3,)."""
    projector = np.eye(3) - np.outer(axis, axis)
    flat, along = points @ projector, points @ axis
    _, _, directions = np.linalg.svd(projector)  # the first two span the plane
    plane = flat @ directions[:2].T
    middle = (plane.min(axis=0) + plane.max(axis=0)) / 2.0
    for k in range(200):  # towards the farthest point, ever less: Badoiu and Clarkson 2003
        off = plane - middle
        far = int(np.argmax(np.einsum("ni,ni->n", off, off)))
        middle = middle + off[far] / (k + 2.0)
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
