"""The largest sensor forces of a motion of which only the way and the controller's limits are known.

No controller limits forces of sensors. But where it keeps velocities and accelerations, no time law of its own can
cause more than these: f = b (p'' - g) + d alpha + omega Q omega, with b, d and Q constant in the axes of the platform.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cases.chain import Chain
from cases.schema import Case
from identification.limited import Box, rotation_motion
from identification.limited_chain import frame_motion
from identification.limits import LimitCheck, Status
from identification.motion import Array, Motion, Trajectory
from identification.overload import PAIRS, Loads
from identification.trajectories.circle import CircularMove
from identification.trajectories.profile import StraightMove, limits_along

SAMPLES = 64  # of a move: forces change with the pose alone, by less than a hundredth from one to the next
PATH_SAMPLES = 1000  # of a timed path


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
    """Bounds of the sensor forces with every body that a case expects, in motions that keep its limits."""

    loads: Loads
    limits: Box  # limits of rates and accelerations, which the controller keeps
    chain: Chain | None = None  # the machine, where it is one; else a hexapod

    @classmethod
    def of(cls, case: Case) -> "ForceBounds | None":
        """Bounds for a case; None where it names no range or no nominal body."""
        loads = Loads.of(case)
        return None if loads is None else cls(loads, case.need_motion("the check of a program")[1], case.chain)

    @property
    def _spin(self) -> Array:
        """Q as symmetric matrices, shape (channels, 3, 3)."""
        matrices = np.zeros((len(self.loads.spin), 3, 3))
        for column, (i, j) in enumerate(PAIRS):
            both = self.loads.spin[:, column] / (1 if i == j else 2)
            matrices[:, i, j] = matrices[:, j, i] = both
        return matrices

    def anywhere(self, clock: float, share: float = 1.0) -> tuple[LimitCheck, ...]:
        """In whatever pose the motion is, with a share of the limits."""
        omega, alpha, pull = self._largest(share * self.limits.rate, share * self.limits.acceleration)
        pull += float(np.linalg.norm(self.loads.gravity))
        most = np.linalg.norm(self.loads.linear, axis=1) * pull + np.linalg.norm(self.loads.angular, axis=1) * alpha
        most += np.abs(np.linalg.eigvalsh(self._spin)).max(axis=1) * omega**2
        return self._checks(most[None], np.array([clock]))

    def _largest(self, rate: Array, acceleration: Array) -> tuple[float, float, float]:
        """Bounds of |omega|, |alpha| and |p''| in any pose [rad/s, rad/s^2, m/s^2]."""
        if self.chain is None:
            omega = float(rate[3:].sum())  # |omega| <= |roll'| + |pitch'| + |yaw'|
            alpha = float(acceleration[3:].sum() + rate[3] * rate[4] + rate[3] * rate[5] + rate[4] * rate[5])
            return omega, alpha, float(np.linalg.norm(acceleration[:3]))
        turns = self.limits.turns
        omega = float(rate[turns].sum())
        alpha = float(acceleration[turns].sum()) + omega**2 / 2.0  # each joint's axis turns with those before it
        reach = _reach(self.chain)
        slide = float(rate[~turns].sum())
        pull = float(acceleration[turns] @ reach[turns] + acceleration[~turns].sum())
        return omega, alpha, pull + omega**2 * float(reach[0]) + 2.0 * omega * slide

    def on(self, path: Trajectory, clock: float) -> tuple[LimitCheck, ...]:
        """At the poses of a path, whatever the motion along it or beside it."""
        t = np.linspace(0.0, path.duration, PATH_SAMPLES)
        pose = path.at(t).pose
        none = np.zeros_like(pose)
        turn = rotation_motion(Motion(t, pose.copy(), none, none, none))[0]
        rate, acceleration = self.limits.rate[3:], self.limits.acceleration
        axes = _rate_axes(pose[:, 3:])
        along = np.einsum("ci,nij->ncj", self.loads.angular, axes)
        most = np.abs(np.einsum("nij,ci,j->nc", turn.transpose(0, 2, 1), self.loads.linear, self.loads.gravity))
        most += np.abs(np.einsum("nki,ci->nck", turn, self.loads.linear)) @ acceleration[:3]
        most += np.abs(along) @ acceleration[3:]
        spin = np.einsum("nik,cij,njl->nckl", axes, self._spin, axes)
        crossed = _crossed_axes(pose[:, 3:])
        for i, j in PAIRS:
            share = spin[:, :, i, j] if i == j else 2 * spin[:, :, i, j] + crossed[i, j] @ self.loads.angular.T
            most += np.abs(share) * rate[i] * rate[j]
        return self._checks(most, t + clock)

    def along(self, move: StraightMove | CircularMove, feed: float | None, clock: float) -> tuple[LimitCheck, ...]:
        """In a move at any speed and acceleration along its way: forces are affine in s'^2 and s''.

        Args:
            feed: largest speed of the share of the way, besides the limits [1/s].
            clock: when it starts [s].
        """
        steady = replace(move, profile=Steady(1.0))
        way = steady.at(np.linspace(0.0, 1.0, SAMPLES + 1))
        none = np.zeros_like(way.pose)
        pose, tangent, bend = way.pose.copy(), way.rates.copy(), way.accelerations.copy()
        standing, turning, starting = (
            self._forces(Motion(way.t, pose, *values, none))
            for values in ((none, none), (tangent, bend), (none, tangent))
        )
        speed, acceleration = _fastest(move, tangent, bend, self.limits)
        square = min(speed, np.inf if feed is None else feed) ** 2
        most = np.maximum(np.abs(standing), np.abs(standing + square * (turning - standing)))
        return self._checks(most + acceleration * np.abs(starting - standing), way.t * move.duration + clock)

    def _forces(self, motion: Motion) -> Array:
        if self.chain is not None:
            return self.loads.forces(*frame_motion(motion, self.chain))
        return self.loads.forces(rotation_motion(motion), motion.accelerations[:, :3])

    def _checks(self, most: Array, times: Array) -> tuple[LimitCheck, ...]:
        """The worst force, and the worst moment where moments have a range."""
        kinds = [kind for kind in (~self.loads.moments, self.loads.moments) if kind.any()]
        return tuple(self._check(np.where(kind, most, 0.0), times) for kind in kinds)

    def _check(self, most: Array, times: Array) -> LimitCheck:
        row, channel = (int(k) for k in np.unravel_index(int(np.argmax(most / self.loads.limit)), most.shape))
        name, limit, worst = self.loads.labels[channel], float(self.loads.limit[channel]), float(most[row, channel])
        what, unit = ("moment", "N m") if self.loads.moments[channel] else ("force", "N")
        return LimitCheck(
            f"sensor {what} ({name}, at most)", worst, limit, unit, worst / limit, float(times[row]), Status.PROVEN
        )


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


def _fastest(move: StraightMove | CircularMove, tangent: Array, bend: Array, limits: Box) -> tuple[float, float]:
    """Largest speed and acceleration of the share of the way under the limits of each coordinate [1/s, 1/s^2]."""
    way = np.abs(tangent).max(axis=0)
    rates, accelerations = limits.rate.copy(), limits.acceleration.copy()
    if isinstance(move, CircularMove):
        plane = list(move.plane.axes[:2])
        for values in (rates, accelerations):
            values[plane] = float(np.hypot(*values[plane]))  # either axis may carry all of it
    speed, acceleration = limits_along(way, rates, accelerations)
    bends = np.abs(bend).max(axis=0)
    turning = float(np.min(np.append(accelerations[bends > 0.0] / bends[bends > 0.0], np.inf)))
    return min(speed, float(np.sqrt(turning))), acceleration


def _reach(chain: Chain) -> Array:
    """How far the sensor can be from the axis of each joint, whatever the joints after it do, shape (n,) [m]."""
    lengths = [float(np.linalg.norm(joint.origin)) for joint in (*chain.joints, chain.sensor)]
    slides = [0.0 if joint.turns else max(abs(v) for v in joint.position) for joint in chain.joints]
    behind = np.cumsum([b + s for b, s in zip(lengths[:0:-1], slides[::-1], strict=True)])
    return np.asarray(behind[::-1])
