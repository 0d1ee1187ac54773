"""What a case with a hexapod limits, and how its load moves: in NumPy from the definitions, for the proof."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from cases.base.units import DEG, MM, Array
from cases.machine import HexapodMachine, KeepOut, MotionLimits, Workspace, turned
from cases.schema import Case
from identification.limits.limit import Limit, LimitKind, Quantity
from identification.motion.motion import LoadMotion, Motion, rotation_motion

_STRUTS = tuple(f"strut {k}" for k in range(1, 7))


@dataclass(frozen=True, slots=True)
class LimitedHexapod:
    """A `LimitedMachine` whose coordinates are the pose of a platform on six struts."""

    machine: HexapodMachine
    workspace: Workspace
    limits: MotionLimits

    @classmethod
    def of(cls, case: Case) -> "LimitedHexapod":
        """The hexapod of a case; raises CaseError where the case lacks machine, workspace or limits."""
        return cls(*case.need_machine("the proof of limits"))

    def ranges(self, motion: Motion) -> Iterable[Quantity]:
        """Distances of the platform from home, as far as it can reach."""
        low, high = self.workspace.room
        offset = motion.coordinates[:, : len(low)] - self.machine.home.vector[: len(low)]
        yield Quantity.between(LimitKind.WORKSPACE_POSITION, ("x", "y", "z")[: len(low)], offset, low, high)

    def drives(self, motion: Motion) -> tuple[Array, Array, Array]:
        """Strut lengths [m], velocities and accelerations, each of shape (n, 6)."""
        return _along(*strut_vectors(motion, rotation_motion(motion), self.machine)[:3])

    def mechanics(self, motion: Motion) -> tuple[LoadMotion, Iterable[Quantity]]:
        """The platform's own motion; limits of struts and joints, with the distances from boxes and singularities."""
        rotation = rotation_motion(motion)
        return (rotation, motion.accelerations[:, :3]), self._mechanics(motion, rotation)

    def _mechanics(self, motion: Motion, rotation: tuple[Array, Array, Array]) -> Iterable[Quantity]:
        machine, workspace, limits = self.machine, self.workspace, self.limits
        strut, velocity, acceleration, normal = strut_vectors(motion, rotation, machine)
        yield from _keep_out(motion, rotation[0], machine.base.points, strut, workspace)
        length, along, second = _along(strut, velocity, acceleration)
        six = np.ones(6)
        low = max(limits.strut_length[0], workspace.strut_length[0])
        high = min(limits.strut_length[1], workspace.strut_length[1])
        v, a = limits.strut_velocity_m_s * six, limits.strut_acceleration_m_s2 * six
        yield Quantity.between(LimitKind.STRUT_LENGTH, _STRUTS, length, low * six, high * six)
        yield Quantity.between(LimitKind.STRUT_VELOCITY, _STRUTS, along, -v, v)
        yield Quantity.between(LimitKind.STRUT_ACCELERATION, _STRUTS, second, -a, a)
        direction = strut / length[:, :, None]
        for kind, normals, largest in (
            (LimitKind.BASE_JOINT_ANGLE, np.array([0.0, 0.0, 1.0]), workspace.base_joint_angle_deg),
            (LimitKind.PLATFORM_JOINT_ANGLE, normal[:, None], workspace.platform_joint_angle_deg),
        ):  # between struts and the normals of base and platform; 0 is straight up
            angle = np.arccos(np.clip(np.sum(direction * normals, axis=2), -1.0, 1.0))
            yield Quantity.between(kind, _STRUTS, angle, -largest * DEG * six, largest * DEG * six)
        yield _singularity(motion, strut, direction, machine)

    def fastest(self, rate: Array, acceleration: Array) -> tuple[float, float, float]:
        """|omega| <= |roll'| + |pitch'| + |yaw'|; alpha has the second derivatives and the products of rates."""
        omega = float(rate[3:].sum())
        alpha = float(acceleration[3:].sum() + rate[3] * rate[4] + rate[3] * rate[5] + rate[4] * rate[5])
        return omega, alpha, float(np.linalg.norm(acceleration[:3]))

    def from_anywhere(self, speed: float, rate: Array, acceleration: Array) -> Iterable[tuple[LimitKind, float, float]]:
        """Bounds of strut motion: l' <= |s'| and l'' <= |s''| + |s'|^2 / l, s' and s'' those of a platform joint."""
        arm = float(np.linalg.norm(self.machine.platform.points, axis=1).max())
        omega = float(rate[3:].sum())
        strut_speed = speed + arm * omega
        yield LimitKind.STRUT_VELOCITY, strut_speed, self.limits.strut_velocity_m_s
        turning = float(acceleration[3:].sum()) + omega**2
        shortest = max(self.limits.strut_length[0], self.workspace.strut_length[0])
        most = float(np.linalg.norm(acceleration[:3])) + arm * turning + strut_speed**2 / shortest
        yield LimitKind.STRUT_ACCELERATION, most, self.limits.strut_acceleration_m_s2


def strut_vectors(
    motion: Motion, rotation: tuple[Array, Array, Array], machine: HexapodMachine
) -> tuple[Array, Array, Array, Array]:
    """Strut vectors and their first and second derivative, shapes (n, 6, 3), and the platform's normal, (n, 3)."""
    turn, first, second = rotation
    points = machine.platform.points.T
    strut = motion.coordinates[:, None, :3] + (turn @ points).transpose(0, 2, 1) - machine.base.points
    velocity = motion.rates[:, None, :3] + (first @ points).transpose(0, 2, 1)
    acceleration = motion.accelerations[:, None, :3] + (second @ points).transpose(0, 2, 1)
    return strut, velocity, acceleration, turn[:, :, 2]


def _along(strut: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    length = np.linalg.norm(strut, axis=2)
    along = np.einsum("nki,nki->nk", strut, velocity) / length
    # l l' = s s'; differentiated once more: l'^2 + l l'' = s' s' + s s''
    second = np.einsum("nki,nki->nk", velocity, velocity) + np.einsum("nki,nki->nk", strut, acceleration)
    return length, along, (second - along**2) / length


def _keep_out(motion: Motion, turn: Array, base: Array, strut: Array, workspace: Workspace) -> Iterable[Quantity]:
    """Distance of platform, struts and tools from each box; at 1 m/s at most 0.05 mm smaller between two instants."""
    for box in workspace.keep_out:
        labels = guarded(workspace)
        distance = distances(box, workspace, motion.coordinates[:, :3], turn, base, strut)
        yield Quantity.clear(Limit(LimitKind.DISTANCE_FROM_BOX, box.name), labels, distance, box.vicinity)


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
    radii = np.array([tool.radius for tool in workspace.tool])
    tools = distance_of_segments(origin[:, None] + low, high - low, box.corners) - radii
    return np.hstack([points, struts, tools])


def _determinant(direction: Array, arms: Array) -> Array:
    return np.asarray(np.linalg.det(np.concatenate([direction, np.cross(arms, direction)], axis=2)))


def _singularity(motion: Motion, strut: Array, direction: Array, machine: HexapodMachine) -> Quantity:
    """det(J^-1) in % of that at home: 100 there, 0 in a singularity, negative behind one; the share is what is lost."""
    home = machine.home.vector
    at_home = (machine.platform.points @ turned(home[3:]).T)[None]
    standing = home[:3] + at_home - machine.base.points
    unit = standing / np.linalg.norm(standing, axis=2)[:, :, None]
    arms = strut + machine.base.points - motion.coordinates[:, None, :3]
    determinant = (_determinant(direction, arms) / _determinant(unit, at_home))[:, None]
    ratio = np.nan_to_num(1.0 - determinant, nan=np.inf)
    return Quantity(Limit(LimitKind.SINGULARITY), ("",), determinant, np.zeros((2, 1)), ratio)
