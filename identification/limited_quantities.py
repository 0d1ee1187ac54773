"""Limited quantities of coordinates and of a hexapod, along a sampled motion: in NumPy from the definitions."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cases.chain import JointMotionLimits
from cases.machine import HexapodMachine, MotionLimits, Workspace
from cases.units import DEG, Array
from identification.keep_out import distances, guarded
from identification.limit import Limit, LimitKind
from identification.motion import Motion

STEP = 10.0  # times the limit of jerk: a change of the acceleration that is a step, not the rounding of two pieces
SHORTEST_GAP = 1e-6  # [s] between instants, below which a change of the acceleration is not looked at more closely
_STRUTS = tuple(f"strut {k}" for k in range(1, 7))


@dataclass(frozen=True, slots=True)
class Quantity:
    """A limited quantity, one row an instant and one column a coordinate or strut."""

    of: Limit
    labels: tuple[str, ...]  # labels of the columns
    values: Array  # shape (n, k)
    limits: Array  # lower and upper limit of each column, twice the same where there is but one, shape (2, k)
    ratio: Array  # share of the limit that is used, infinite where a value is not a number, shape (n, k)

    @classmethod
    def between(cls, kind: LimitKind, labels: tuple[str, ...], values: Array, low: Array, high: Array) -> "Quantity":
        """Two-sided limits: the share is the distance from their middle over half their width.

        Args:
            labels: labels of its k columns.
            values: shape (n, k) [SI].
            low: shape (k,) [SI].
            high: shape (k,) [SI].
        """
        values = np.asfortranarray(values)  # column by column, or every operation below goes through rows of three
        ratio = values - (low + high) / 2
        np.abs(ratio, out=ratio)
        ratio /= (high - low) / 2
        if np.isnan(ratio.max()):
            ratio[np.isnan(ratio)] = np.inf
        return cls(Limit(kind), labels, values, np.stack([low, high]), ratio)

    @classmethod
    def clear(cls, of: Limit, labels: tuple[str, ...], values: Array, reach: Array | float) -> "Quantity":
        """Distances, shape (n, k) [m], which must not be below 0: the share falls from 1 there to 0 at `reach`."""
        ratio = np.nan_to_num(np.maximum(0.0, 1.0 - values / reach), nan=np.inf)
        return cls(of, labels, values, np.zeros((2, len(labels))), ratio)

    def limit_of(self, row: int, column: int) -> float:
        """The limit on whose side of the middle a value lies."""
        low, high = self.limits[:, column]
        return float(high if self.values[row, column] >= (low + high) / 2 else low)


Box = MotionLimits | JointMotionLimits
"""Limits of the coordinates of a machine: of a case, from home, all in SI."""


def plane(motion: Motion, machine: HexapodMachine, workspace: Workspace) -> Quantity:
    """Distances of a hexapod's platform from home, in the plane that it can reach."""
    low, high = workspace.plane[0], workspace.plane[1]
    offset = motion.pose[:, :2] - machine.home.vector[:2]
    return Quantity.between(LimitKind.WORKSPACE_POSITION, ("x", "y"), offset, low, high)


def jerks_with_steps(motion: Motion, limit: Array) -> Array:
    """Jerks, shape (n, k); where accelerations step between two instants, their change over the time between these."""
    if len(motion.t) < 2:
        return motion.jerks
    gaps = np.diff(motion.t)[:, None]
    slopes = np.diff(motion.accelerations, axis=0) / np.maximum(gaps, SHORTEST_GAP)
    jerks = motion.jerks.copy()
    np.copyto(jerks[1:], slopes, where=np.abs(slopes) > STEP * limit)
    return jerks


def strut_velocities(motion: Motion, machine: HexapodMachine, limits: MotionLimits) -> Quantity:
    """Velocities of the struts alone."""
    most = np.full(6, limits.strut_velocity_m_s)
    return Quantity.between(LimitKind.STRUT_VELOCITY, _STRUTS, strut_motion(motion, machine)[1], -most, most)


def limited_rates(motion: Motion, limits: Box) -> Iterable[Quantity]:
    """Rates of the coordinates alone."""
    v = limits.rate
    yield from by_kind((LimitKind.VELOCITY, LimitKind.ANGULAR_VELOCITY), motion.rates, -v, v, limits)


def by_kind(
    kinds: tuple[LimitKind, LimitKind], values: Array, low: Array, high: Array, limits: Box
) -> Iterable[Quantity]:
    """Translations and rotations of a derivative of the coordinates; the kind of each, values in SI."""
    for kind, axes in zip(kinds, (~limits.turns, limits.turns), strict=True):
        if axes.any():
            labels = tuple(label for label, own in zip(limits.labels, axes, strict=True) if own)
            yield Quantity.between(kind, labels, values[:, axes], low[axes], high[axes])


def axis_rotation(axis: int, angle: Array, rate: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    """A rotation about one axis and its first and second time derivative, shapes (n, 3, 3)."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    c, s = np.cos(angle), np.sin(angle)
    turn, first, second = (np.zeros((len(angle), 3, 3)) for _ in range(3))
    turn[:, axis, axis] = 1.0
    turn[:, i, i] = turn[:, j, j] = c
    turn[:, j, i], turn[:, i, j] = s, -s
    first[:, i, i] = first[:, j, j] = -s * rate  # (c)' = -s a', (s)' = c a'
    first[:, j, i], first[:, i, j] = c * rate, -c * rate
    second[:, i, i] = second[:, j, j] = -s * acceleration - c * rate**2
    second[:, j, i] = c * acceleration - s * rate**2
    second[:, i, j] = -second[:, j, i]
    return turn, first, second


def rotation_motion(motion: Motion) -> tuple[Array, Array, Array]:
    """R and its first and second time derivative, shapes (n, 3, 3)."""
    angles, rates, accelerations = motion.pose[:, 3:], motion.rates[:, 3:], motion.accelerations[:, 3:]
    x0, x1, x2 = axis_rotation(0, angles[:, 0], rates[:, 0], accelerations[:, 0])
    y0, y1, y2 = axis_rotation(1, angles[:, 1], rates[:, 1], accelerations[:, 1])
    z0, z1, z2 = axis_rotation(2, angles[:, 2], rates[:, 2], accelerations[:, 2])
    yx = y0 @ x0
    yx1 = y1 @ x0 + y0 @ x1
    yx2 = y2 @ x0 + 2 * (y1 @ x1) + y0 @ x2
    return z0 @ yx, z1 @ yx + z0 @ yx1, z2 @ yx + 2 * (z1 @ yx1) + z0 @ yx2


def strut_vectors(
    motion: Motion, rotation: tuple[Array, Array, Array], machine: HexapodMachine
) -> tuple[Array, Array, Array, Array]:
    """Strut vectors and their first and second derivative, shapes (n, 6, 3), and the platform's normal, (n, 3)."""
    turn, first, second = rotation
    points = machine.platform.points.T
    strut = motion.pose[:, None, :3] + (turn @ points).transpose(0, 2, 1) - machine.base.points
    velocity = motion.rates[:, None, :3] + (first @ points).transpose(0, 2, 1)
    acceleration = motion.accelerations[:, None, :3] + (second @ points).transpose(0, 2, 1)
    return strut, velocity, acceleration, turn[:, :, 2]


def strut_motion(motion: Motion, machine: HexapodMachine) -> tuple[Array, Array, Array]:
    """Strut lengths [m], velocities and accelerations of a motion, each of shape (n, 6)."""
    return _along(*strut_vectors(motion, rotation_motion(motion), machine)[:3])


def _along(strut: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    length = np.linalg.norm(strut, axis=2)
    along = np.einsum("nki,nki->nk", strut, velocity) / length
    # l l' = s s'; differentiated once more: l'^2 + l l'' = s' s' + s s''
    second = np.einsum("nki,nki->nk", velocity, velocity) + np.einsum("nki,nki->nk", strut, acceleration)
    return length, along, (second - along**2) / length


def limited_struts(
    motion: Motion,
    rotation: tuple[Array, Array, Array],
    machine: HexapodMachine,
    workspace: Workspace,
    limits: MotionLimits,
) -> Iterable[Quantity]:
    """Limited quantities of struts and joints, with the distances from boxes and singularities.

    Args:
        workspace: reach of the machine.
    """
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
    yield from _joint_angles(direction, normal, workspace)
    yield _singularity(motion, strut, direction, machine)


def _keep_out(motion: Motion, turn: Array, base: Array, strut: Array, workspace: Workspace) -> Iterable[Quantity]:
    """Distance of platform, struts and tools from each box, along the axis that separates them most.

    The share is 1 at the surface, above 1 inside, and falls to 0 at a distance of half the box's diagonal. Struts are
    lines from joint to joint, with the radius that the case says around them, tools likewise. At 1 m/s
    a distance is at most 0.05 mm smaller between two instants of 10 kHz.
    """
    for box in workspace.keep_out:
        labels = guarded(workspace)
        distance = distances(box, workspace, motion.pose[:, :3], turn, base, strut)
        yield Quantity.clear(Limit(LimitKind.DISTANCE_FROM_BOX, box.name), labels, distance, box.vicinity)


def _joint_angles(direction: Array, normal: Array, workspace: Workspace) -> Iterable[Quantity]:
    """Angles between struts and the normals of base and platform; 0 is straight up."""
    at_base = np.arccos(np.clip(direction[:, :, 2], -1.0, 1.0))
    at_platform = np.arccos(np.clip(np.einsum("nki,ni->nk", direction, normal), -1.0, 1.0))
    for kind, angle, limit in (
        (LimitKind.BASE_JOINT_ANGLE, at_base, workspace.base_joint_angle_deg * DEG),
        (LimitKind.PLATFORM_JOINT_ANGLE, at_platform, workspace.platform_joint_angle_deg * DEG),
    ):
        yield Quantity.between(kind, _STRUTS, angle, np.full(6, -limit), np.full(6, limit))


def _determinant(direction: Array, arms: Array) -> Array:
    return np.asarray(np.linalg.det(np.concatenate([direction, np.cross(arms, direction)], axis=2)))


def _at_home(machine: HexapodMachine) -> float:
    """det(J^-1) at home."""
    standing = Motion(np.zeros(1), machine.home.vector[None, :].copy(), *(np.zeros((1, 6)) for _ in range(3)))
    strut, _, _, _ = strut_vectors(standing, rotation_motion(standing), machine)
    direction = strut / np.linalg.norm(strut, axis=2)[:, :, None]
    return float(_determinant(direction, strut + machine.base.points - machine.home.vector[:3])[0])


def _singularity(motion: Motion, strut: Array, direction: Array, machine: HexapodMachine) -> Quantity:
    """det(J^-1) in % of that at home: 100 there, 0 in a singularity, negative behind one; the share is what is lost."""
    arms = strut + machine.base.points - motion.pose[:, None, :3]
    determinant = (_determinant(direction, arms) / _at_home(machine))[:, None]
    ratio = np.nan_to_num(1.0 - determinant, nan=np.inf)
    return Quantity(Limit(LimitKind.SINGULARITY), ("",), determinant, np.zeros((2, 1)), ratio)
