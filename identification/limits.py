"""Numeric proof that a motion keeps the limits of its case.

Written in NumPy from the definitions (rotation matrices differentiated by the product rule), with no code in common
with the CasADi models that the optimiser uses.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from cases.machine import Machine, MotionLimits, Workspace
from cases.schema import Case
from cases.units import DEG, MM
from identification.motion import Motion, Trajectory

Array = NDArray[np.float64]

PROOF_RATE = 10_000.0  # [1/s]; at most 200 rad/s^3 * (1e-4 s)^2 / 8 escape between samples, 1e-7 of the rate limits
TOLERANCE = 1e-6  # a limit counts as kept up to this share of it: rounding, not motion
CHUNK = 20_000  # samples at once, bounds memory

_COORDINATES: tuple[str, ...] = ("x", "y", "z", "a", "b", "c")


class Status(StrEnum):
    """Who answers for a limit."""

    PROVEN = "proven"
    ENFORCED = "enforced by controller"
    NOT_ENFORCED = "NOT enforced"


@dataclass(frozen=True, slots=True)
class LimitCheck:
    """The worst approach to one limit.

    Args:
        name: limit, with the coordinate or strut that came closest.
        worst: the value there, in `unit`.
        limit: the limit it came closest to, in `unit`.
        unit: unit of both.
        ratio: share of the limit that is used; the limit is kept up to 1.
        time: when [s].
        status: who answers for it.
        binding: whether the motion itself is answerable for it; not where a controller's own law is only predicted.
    """

    name: str
    worst: float
    limit: float
    unit: str
    ratio: float
    time: float
    status: Status
    binding: bool = True

    @property
    def kept(self) -> bool:
        """Whether the limit is kept, as far as the motion is answerable for it."""
        return not self.binding or self.ratio <= 1.0 + TOLERANCE

    def sentence(self) -> str:
        """One phrase with value and limit."""
        digits = next(d for d in range(4, 18) if f"{self.worst:.{d}g}" != f"{self.limit:.{d}g}" or d == 17)
        return f"{self.name} reaches {self.worst:.{digits}g} {self.unit} at {self.time:.3f} s, limit {self.limit:.4g}"


@dataclass(frozen=True, slots=True)
class LimitReport:
    """All limits of a motion, worst case each."""

    checks: tuple[LimitCheck, ...]

    @property
    def kept(self) -> bool:
        """Whether every limit is kept."""
        return all(c.kept for c in self.checks)

    @property
    def violations(self) -> tuple[LimitCheck, ...]:
        """The limits that are passed, the worst first."""
        return tuple(sorted((c for c in self.checks if not c.kept), key=lambda c: -c.ratio))

    @property
    def worst_ratio(self) -> float:
        """Largest share that is used of a limit for which the motion is answerable."""
        return max(c.ratio for c in self.checks if c.binding)

    def to_json(self) -> dict[str, dict[str, float | str]]:
        """One object a limit, by name."""
        return {
            c.name.split(" (")[0]: {
                "at": c.name,
                "worst": c.worst,
                "limit": c.limit,
                "unit": c.unit,
                "ratio": c.ratio,
                "time_s": c.time,
                "status": str(c.status),
            }
            for c in self.checks
        }


def prove(
    trajectory: Trajectory, case: Case, rate: float = PROOF_RATE, offset: float = 0.0, in_box: bool = True
) -> LimitReport:
    """Checks every limit of `[limits.motion]` and `[workspace]` on a fine grid.

    Args:
        trajectory: the motion.
        case: its limits.
        rate: samples a second [1/s].
        offset: start of the trajectory on the clock that the report uses [s].
        in_box: whether it must keep the pose box of `[limits.motion]`; positioning need only keep `[workspace]`.

    Raises:
        CaseError: the case has no machine or no limits.
    """
    steps = max(1, math.ceil(trajectory.duration * rate - 1e-9))
    return prove_at(trajectory, case, np.linspace(0.0, trajectory.duration, steps + 1), offset, in_box)


def prove_at(
    trajectory: Trajectory, case: Case, instants: Array, offset: float = 0.0, in_box: bool = True
) -> LimitReport:
    """Checks every limit at given instants, shape (n,) [s]; see `prove`."""
    machine, workspace, limits = case.need_machine("the proof of limits")
    reports = []
    for first in range(0, len(instants), CHUNK):
        t = instants[first : first + CHUNK]
        m = trajectory.at(t)
        part = Motion(t + offset, m.pose, m.rates, m.accelerations, m.jerks)
        with np.errstate(invalid="ignore"):  # what is no number counts as passed, and is reported so
            reports.append(LimitReport(tuple(_checks(part, machine, workspace, limits.motion, in_box))))
    return worst_of(reports)


def worst_of(reports: Iterable[LimitReport]) -> LimitReport:
    """The worst of each limit over several stretches of motion."""
    worst: dict[str, LimitCheck] = {}
    for report in reports:
        for check in report.checks:
            key = check.name.split(" (")[0]
            if key not in worst or check.ratio > worst[key].ratio:
                worst[key] = check
    return LimitReport(tuple(worst.values()))


def _checks(
    motion: Motion, machine: Machine, workspace: Workspace, limits: MotionLimits, in_box: bool
) -> Iterable[LimitCheck]:
    home = machine.home.vector
    scale = np.array([1 / MM] * 3 + [1 / DEG] * 3)  # to mm and degrees for the report
    offset = motion.pose - home
    if in_box:
        low, high = limits.pose
        yield from _by_kind("position", "mm", "angle", "deg", motion.t, offset, low, high, scale)
    low, high = workspace.plane
    yield _worst("workspace position", "mm", ("x", "y"), motion.t, offset[:, :2], low, high, 1 / MM)
    yield from _by_kind(
        "velocity", "mm/s", "angular velocity", "deg/s", motion.t, motion.rates, -limits.rate, limits.rate, scale
    )
    one = np.ones(6)
    a, j = limits.acceleration, limits.jerk
    yield from _by_kind(
        "acceleration", "m/s^2", "angular acceleration", "rad/s^2", motion.t, motion.accelerations, -a, a, one
    )
    yield from _by_kind("jerk", "m/s^3", "angular jerk", "rad/s^3", motion.t, motion.jerks, -j, j, one)
    yield from _strut_checks(motion, machine, workspace, limits)


def _by_kind(
    length_name: str,
    length_unit: str,
    angle_name: str,
    angle_unit: str,
    t: Array,
    values: Array,
    low: Array,
    high: Array,
    scale: Array,
) -> Iterable[LimitCheck]:
    """Worst translation and worst rotation of a derivative of the coordinates."""
    for name, unit, axes in ((length_name, length_unit, slice(0, 3)), (angle_name, angle_unit, slice(3, 6))):
        yield _worst(name, unit, _COORDINATES[axes], t, values[:, axes], low[axes], high[axes], float(scale[axes][0]))


def _worst(
    name: str, unit: str, labels: tuple[str, ...], t: Array, values: Array, low: Array, high: Array, scale: float
) -> LimitCheck:
    """Worst share of a two-sided limit: distance from its middle over half its width; NaN counts as passed."""
    middle, half = (low + high) / 2, (high - low) / 2
    ratio = np.nan_to_num(np.abs(values - middle) / half, nan=np.inf)
    row, column = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    value = values[row, column]
    limit = high[column] if value >= middle[column] else low[column]
    return LimitCheck(
        f"{name} ({labels[column]})",
        float(value * scale),
        float(limit * scale),
        unit,
        float(ratio[row, column]),
        float(t[row]),
        Status.PROVEN,
    )


def _axis_rotation(axis: int, angle: Array, rate: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    """A rotation about one axis and its first and second time derivative, shapes (n, 3, 3)."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    generator = np.zeros((3, 3))
    generator[j, i], generator[i, j] = 1.0, -1.0
    c, s = np.cos(angle), np.sin(angle)
    turn = np.zeros((len(angle), 3, 3))
    turn[:, axis, axis] = 1.0
    turn[:, i, i] = turn[:, j, j] = c
    turn[:, j, i], turn[:, i, j] = s, -s
    first = turn @ generator
    second = first @ generator
    rate_, acceleration_ = rate[:, None, None], acceleration[:, None, None]
    return turn, first * rate_, second * rate_**2 + first * acceleration_


def _strut_vectors(motion: Motion, machine: Machine) -> tuple[Array, Array, Array, Array]:
    """Strut vectors and their first and second derivative, shapes (n, 6, 3), and the platform's normal, (n, 3)."""
    angles, rates, accelerations = motion.pose[:, 3:], motion.rates[:, 3:], motion.accelerations[:, 3:]
    x0, x1, x2 = _axis_rotation(0, angles[:, 0], rates[:, 0], accelerations[:, 0])
    y0, y1, y2 = _axis_rotation(1, angles[:, 1], rates[:, 1], accelerations[:, 1])
    z0, z1, z2 = _axis_rotation(2, angles[:, 2], rates[:, 2], accelerations[:, 2])
    zy, xz = z0 @ y0, y0 @ x0
    turn = zy @ x0
    first = z1 @ xz + z0 @ y1 @ x0 + zy @ x1
    second = z2 @ xz + z0 @ y2 @ x0 + zy @ x2 + 2 * (z1 @ y1 @ x0 + z1 @ y0 @ x1 + z0 @ y1 @ x1)
    points = machine.platform.points.T
    strut = motion.pose[:, None, :3] + (turn @ points).transpose(0, 2, 1) - machine.base.points
    velocity = motion.rates[:, None, :3] + (first @ points).transpose(0, 2, 1)
    acceleration = motion.accelerations[:, None, :3] + (second @ points).transpose(0, 2, 1)
    return strut, velocity, acceleration, turn[:, :, 2]


def strut_motion(motion: Motion, machine: Machine) -> tuple[Array, Array, Array]:
    """Strut lengths [m], velocities and accelerations of a motion, each of shape (n, 6)."""
    return _along(*_strut_vectors(motion, machine)[:3])


def _along(strut: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    length = np.linalg.norm(strut, axis=2)
    along = np.einsum("nki,nki->nk", strut, velocity) / length
    # l l' = s s'; differentiated once more: l'^2 + l l'' = s' s' + s s''
    second = np.einsum("nki,nki->nk", velocity, velocity) + np.einsum("nki,nki->nk", strut, acceleration)
    return length, along, (second - along**2) / length


def _strut_checks(motion: Motion, machine: Machine, workspace: Workspace, limits: MotionLimits) -> Iterable[LimitCheck]:
    strut, velocity, acceleration, normal = _strut_vectors(motion, machine)
    yield from _keep_out_checks(motion, strut + machine.base.points, workspace)
    length, along, second = _along(strut, velocity, acceleration)
    labels = tuple(f"strut {k}" for k in range(1, 7))
    six = np.ones(6)
    low = max(limits.strut_length[0], workspace.strut_length[0])
    high = min(limits.strut_length[1], workspace.strut_length[1])
    yield _worst("strut length", "mm", labels, motion.t, length, low * six, high * six, 1 / MM)
    v, a = limits.strut_velocity_m_s * six, limits.strut_acceleration_m_s2 * six
    yield _worst("strut velocity", "m/s", labels, motion.t, along, -v, v, 1.0)
    yield _worst("strut acceleration", "m/s^2", labels, motion.t, second, -a, a, 1.0)
    yield from _joint_checks(motion.t, strut / length[:, :, None], normal, workspace)
    yield _singularity_check(motion, strut / length[:, :, None], machine)


def _keep_out_checks(motion: Motion, joints: Array, workspace: Workspace) -> Iterable[LimitCheck]:
    """Distance of the platform's origin and joints from each box, along the axis that separates them most.

    The ratio is 1 at the surface, above 1 inside, and falls to 0 at a distance of half the box's diagonal.
    """
    points = np.concatenate([motion.pose[:, None, :3], joints], axis=1)
    labels = ("origin", *(f"joint {k}" for k in range(1, 7)))
    for box in workspace.keep_out:
        low, high = box.corners
        distance = np.maximum(low - points, points - high).max(axis=2)
        distance = np.nan_to_num(distance, nan=-np.inf)
        row, column = np.unravel_index(int(np.argmin(distance)), distance.shape)
        nearest = float(distance[row, column])
        ratio = max(0.0, 1.0 - nearest / (float(np.linalg.norm(high - low)) / 2))
        name = f"distance from {box.name} ({labels[column]})"
        yield LimitCheck(name, nearest / MM, 0.0, "mm", ratio, float(motion.t[row]), Status.PROVEN)


def _joint_checks(t: Array, direction: Array, normal: Array, workspace: Workspace) -> Iterable[LimitCheck]:
    """Angles between struts and the normals of base and platform; 0 is straight up."""
    labels = tuple(f"strut {k}" for k in range(1, 7))
    at_base = np.arccos(np.clip(direction[:, :, 2], -1.0, 1.0))
    at_platform = np.arccos(np.clip(np.einsum("nki,ni->nk", direction, normal), -1.0, 1.0))
    for name, angle, limit in (
        ("base joint angle", at_base, workspace.base_joint_angle_deg * DEG),
        ("platform joint angle", at_platform, workspace.platform_joint_angle_deg * DEG),
    ):
        yield _worst(name, "deg", labels, t, angle, np.full(6, -limit), np.full(6, limit), 1 / DEG)


def _determinant(direction: Array, arms: Array) -> Array:
    return np.asarray(np.linalg.det(np.concatenate([direction, np.cross(arms, direction)], axis=2)))


def _singularity_check(motion: Motion, direction: Array, machine: Machine) -> LimitCheck:
    """1 - det(J^-1) / det(J^-1 at home): 0 at home, 1 in a singularity, above 1 behind one."""
    standing = Motion(np.zeros(1), machine.home.vector[None, :].copy(), *(np.zeros((1, 6)) for _ in range(3)))
    strut, _, _, _ = _strut_vectors(standing, machine)
    home_direction = strut / np.linalg.norm(strut, axis=2)[:, :, None]
    at_home = _determinant(home_direction, strut + machine.base.points - machine.home.vector[:3])[0]
    strut_now, _, _, _ = _strut_vectors(motion, machine)
    arms = strut_now + machine.base.points - motion.pose[:, None, :3]
    ratio = 1.0 - _determinant(direction, arms) / at_home
    ratio = np.nan_to_num(ratio, nan=np.inf)
    row = int(np.argmax(ratio))
    worst = float(ratio[row])
    return LimitCheck("singularity", worst, 1.0, "of the way", worst, float(motion.t[row]), Status.PROVEN)
