"""The largest sensor forces of a motion of which only the way and the controller's limits are known.

No controller limits forces of sensors. But where it keeps velocities and accelerations, no time law of its own can
cause more than these: f = b (p'' - g) + d alpha + omega Q omega, with b, d and Q constant in the axes of the platform.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cases.machine import MotionLimits
from cases.schema import Case
from identification.circle import CircularMove
from identification.limited import rotation_motion
from identification.limits import LimitCheck, Status
from identification.motion import Array, Motion, Trajectory
from identification.overload import SHARE, sensor_forces, sensor_loads
from identification.profile import StraightMove
from identification.strut_move import StrutMove

SAMPLES = 64  # of a move: forces change with the pose alone, by less than a hundredth from one to the next
PATH_SAMPLES = 1000  # of a timed path
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


class Steady(NamedTuple):
    """One speed from end to end, which no law below that speed exceeds anywhere on the way."""

    duration: float

    @property
    def peak_velocity(self) -> float:
        """Of the share of the way [1/s]."""
        return 1.0 / self.duration

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """Share of the way and its derivatives, each of shape (n,)."""
        time = np.asarray(t, dtype=float)
        none = np.zeros_like(time)
        return time / self.duration, none + self.peak_velocity, none, none

    def slowed(self, speed: float) -> "Steady":
        """The same way at a share of the speed."""
        return Steady(self.duration / speed)


@dataclass(frozen=True, slots=True)
class ForceBounds:
    """Bounds of the sensor forces with every body that a case expects, in motions that keep its limits.

    Args:
        case: with gravity, sensors and bodies.
        limits: of rates and accelerations, which the controller keeps.
        linear: b, shape (channels, 3).
        angular: d, shape (channels, 3).
        spin: Q, symmetric, shape (channels, 3, 3).
    """

    case: Case
    limits: MotionLimits
    linear: Array
    angular: Array
    spin: Array

    @classmethod
    def of(cls, case: Case) -> "ForceBounds | None":
        """Bounds for a case; None where it names no range or no nominal body."""
        if case.sensors.range_N is None or not case.bodies:
            return None
        still = np.zeros((6, 3))
        axes = np.eye(3)
        pairs = np.array([axes[i] if i == j else axes[i] + axes[j] for i, j in _PAIRS])
        push = np.vstack([axes, np.zeros((9, 3))])
        turn = np.vstack([np.zeros((3, 3)), axes, still])
        spin = np.vstack([still, pairs])
        found = np.vstack([_probe(push, turn, spin, case, k).T for k in range(len(case.bodies))])
        quadratic = np.zeros((len(found), 3, 3))
        for column, (i, j) in enumerate(_PAIRS, start=6):
            both = found[:, column] if i == j else (found[:, column] - found[:, 6 + i] - found[:, 6 + j]) / 2
            quadratic[:, i, j] = quadratic[:, j, i] = both
        limits = case.need_machine("the check of a program")[2].motion
        return cls(case, limits, found[:, :3], found[:, 3:6], quadratic)

    def anywhere(self, clock: float) -> LimitCheck:
        """In whatever pose the motion is."""
        rate, acceleration = self.limits.rate, self.limits.acceleration
        omega = rate[3:].sum()  # |omega| <= |roll'| + |pitch'| + |yaw'|
        alpha = acceleration[3:].sum() + rate[3] * rate[4] + rate[3] * rate[5] + rate[4] * rate[5]
        pull = np.linalg.norm(acceleration[:3]) + np.linalg.norm(self.case.gravity)
        most = np.linalg.norm(self.linear, axis=1) * pull + np.linalg.norm(self.angular, axis=1) * alpha
        most += np.abs(np.linalg.eigvalsh(self.spin)).max(axis=1) * omega**2
        return self._check(most[None], np.array([clock]))

    def on(self, path: Trajectory, clock: float) -> LimitCheck:
        """At the poses of a path, whatever the motion along it or beside it."""
        t = np.linspace(0.0, path.duration, PATH_SAMPLES)
        pose = path.at(t).pose
        none = np.zeros_like(pose)
        turn = rotation_motion(Motion(t, pose.copy(), none, none, none))[0]
        rate, acceleration = self.limits.rate[3:], self.limits.acceleration
        axes = _rate_axes(pose[:, 3:])
        along = np.einsum("ci,nij->ncj", self.angular, axes)
        most = np.abs(np.einsum("nij,ci,j->nc", turn.transpose(0, 2, 1), self.linear, self.case.gravity))
        most += np.abs(np.einsum("nki,ci->nck", turn, self.linear)) @ acceleration[:3]
        most += np.abs(along) @ acceleration[3:]
        spin = np.einsum("nik,cij,njl->nckl", axes, self.spin, axes)
        crossed = _crossed_axes(pose[:, 3:])
        for i, j in _PAIRS:
            share = spin[:, :, i, j] if i == j else 2 * spin[:, :, i, j] + crossed[i, j] @ self.angular.T
            most += np.abs(share) * rate[i] * rate[j]
        return self._check(most, t + clock)

    def along(self, move: StraightMove | CircularMove | StrutMove, feed: float | None, clock: float) -> LimitCheck:
        """In a move at any speed and acceleration along its way: forces are affine in s'^2 and s''.

        Args:
            move: its way.
            feed: largest speed of the share of the way, besides the limits [1/s].
            clock: when it starts [s].
        """
        steady = replace(move, profile=Steady(1.0))
        way = steady.at(np.linspace(0.0, 1.0, SAMPLES + 1))
        none = np.zeros_like(way.pose)
        pose, tangent, bend = way.pose.copy(), way.rates.copy(), way.accelerations.copy()
        standing, turning, starting = (
            self._loads(Motion(way.t, pose, *values, none))
            for values in ((none, none), (tangent, bend), (none, tangent))
        )
        speed, acceleration = _fastest(move, tangent, bend, self.limits)
        square = min(speed, np.inf if feed is None else feed) ** 2
        most = np.maximum(np.abs(standing), np.abs(standing + square * (turning - standing)))
        return self._check(most + acceleration * np.abs(starting - standing), way.t * move.duration + clock)

    def _loads(self, motion: Motion) -> Array:
        (quantity,) = sensor_loads(motion, self.case)
        return quantity.values

    def _check(self, most: Array, times: Array) -> LimitCheck:
        assert self.case.sensors.range_N is not None
        limit = SHARE * self.case.sensors.range_N
        row, channel = (int(k) for k in np.unravel_index(int(np.argmax(most)), most.shape))
        name = f"sensor force (sensor {channel % 6 + 1}, {channel // 6} payloads, at most)"
        worst = float(most[row, channel])
        return LimitCheck(name, worst, limit, "N", worst / limit, float(times[row]), Status.PROVEN)


def _probe(push: Array, turn: Array, spin: Array, case: Case, body: int) -> Array:
    """Forces without gravity at R = 1 for accelerations, angular accelerations and velocities, shape (n, 6)."""
    first = _cross_matrices(spin)
    second = _cross_matrices(turn) + first @ first
    unturned = np.tile(np.eye(3), (len(push), 1, 1))
    return sensor_forces(unturned, first, second, push + case.gravity, case.bodies[body], case)


def _cross_matrices(vectors: Array) -> Array:
    matrices = np.zeros((len(vectors), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        matrices[:, j, i], matrices[:, i, j] = vectors[:, k], -vectors[:, k]
    return matrices


def _rate_axes(angles: Array) -> Array:
    """What rates of roll, pitch, yaw turn about, in the axes of the platform: columns, shape (n, 3, 3)."""
    (sr, sp), (cr, cp) = np.sin(angles[:, :2]).T, np.cos(angles[:, :2]).T
    zero, one = np.zeros_like(sr), np.ones_like(sr)
    return np.stack(
        [np.stack(v, axis=1) for v in ((one, zero, zero), (zero, cr, -sr), (-sp, sr * cp, cr * cp))], axis=2
    )


def _crossed_axes(angles: Array) -> dict[tuple[int, int], Array]:
    """Angular acceleration per product of two rates: derivatives of the axes, shape (n, 3) each."""
    (sr, sp), (cr, cp) = np.sin(angles[:, :2]).T, np.cos(angles[:, :2]).T
    zero = np.zeros_like(sr)
    return {
        (0, 1): np.stack([zero, -sr, -cr], axis=1),
        (0, 2): np.stack([zero, cr * cp, -sr * cp], axis=1),
        (1, 2): np.stack([-cp, -sr * sp, -cr * sp], axis=1),
    }


def _fastest(
    move: StraightMove | CircularMove | StrutMove, tangent: Array, bend: Array, limits: MotionLimits
) -> tuple[float, float]:
    """Largest speed and acceleration of the share of the way under the limits of each coordinate [1/s, 1/s^2]."""
    way = np.abs(tangent).max(axis=0)
    rates, accelerations = limits.rate.copy(), limits.acceleration.copy()
    if isinstance(move, CircularMove):
        plane = list(move.plane.axes[:2])
        for values in (rates, accelerations):
            values[plane] = float(np.hypot(*values[plane]))  # either axis may carry all of it
    moves = way > 0.0
    speed, acceleration = (float(np.min(v[moves] / way[moves])) for v in (rates, accelerations))
    bends = np.abs(bend).max(axis=0)
    turning = float(np.min(np.append(accelerations[bends > 0.0] / bends[bends > 0.0], np.inf)))
    return min(speed, float(np.sqrt(turning))), acceleration
