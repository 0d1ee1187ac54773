"""Motion in the coordinates of a machine: sampled (`Motion`), continuous (`Trajectory`), through timed points."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike

from cases.base.renamed import renamed
from cases.base.units import Array as Array

if TYPE_CHECKING:
    from scipy.interpolate import BSpline


@renamed(pose="coordinates")
@dataclass(frozen=True, slots=True)
class Motion:
    """Coordinates of a machine and their time derivatives, one row a sample; ValueError for other shapes.

    Those of a hexapod are (x, y, z, roll, pitch, yaw) of its platform, those of a chain the positions of its joints.
    """

    t: Array  # time, shape (n,) [s]
    coordinates: Array  # shape (n, k) [m or rad]
    rates: Array  # first derivatives, shape (n, k) [m/s or rad/s]
    accelerations: Array  # second derivatives, shape (n, k) [m/s^2 or rad/s^2]
    jerks: Array  # third derivatives, shape (n, k) [m/s^3 or rad/s^3]

    def __post_init__(self) -> None:
        shape = (len(self.t), *self.coordinates.shape[1:2])
        for name in ("coordinates", "rates", "accelerations", "jerks"):
            value = getattr(self, name)
            if value.shape != shape:
                raise ValueError(f"{name} has shape {value.shape}, expected {shape}")
            value.setflags(write=False)


LoadMotion = tuple[tuple[Array, Array, Array], Array]
"""Motion of the frame {P} of the load in {B}: R, R', R'', shapes (n, 3, 3), and p'', shape (n, 3) [m/s^2]."""


class Trajectory(Protocol):
    """A motion that is known at every instant from 0 to `duration`."""

    @property
    def duration(self) -> float:
        """Duration [s]."""

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""


@dataclass(frozen=True, slots=True)
class TimedPoints:
    """A motion through given poses at given times, from rest to rest.

    Between the points it is the quintic spline through them (continuous up to the fourth derivative), with rates and
    accelerations zero at both ends. Points of a motion whose jerk is constant between knots (a cubic spline) get the
    cubic one, which is that motion itself; a smoother curve would overshoot its jerks. Either is an assumption about
    what a controller does between the points it is given.
    """

    times: Array  # shape (k,), strictly increasing from 0 [s]
    poses: Array  # shape (k, c) [m or rad]
    spline: "BSpline"  # through them

    @classmethod
    def through(cls, times: ArrayLike, poses: ArrayLike) -> "TimedPoints":
        """Interpolates between times, shape (k,) [s], and coordinates, shape (k, c) [m or rad].

        Raises ValueError for fewer than two points, or times that do not increase from 0.
        """
        from scipy.interpolate import make_interp_spline  # half a second that programs of moves can do without

        t, p = np.asarray(times, dtype=float), np.asarray(poses, dtype=float)
        if len(t) < 2 or np.any(np.diff(t) <= 0.0) or t[0] != 0.0 or p.ndim != 2 or len(p) != len(t):
            raise ValueError("timed points need at least two poses at times that increase from 0")
        if _piecewise_cubic(t, p) and (cubic := _cubic_at_rest(t, p)) is not None:
            return cls(t, p, cubic)
        at_rest = [(1, np.zeros(p.shape[1])), (2, np.zeros(p.shape[1]))]
        return cls(t, p, make_interp_spline(t, p, k=5, bc_type=(at_rest, at_rest)))

    @property
    def duration(self) -> float:
        """Time of the last point [s]."""
        return float(self.times[-1])

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        return Motion(time, *(self.spline(time, nu=order) for order in range(4)))


RESOLUTION = 1e-8  # [m, rad] of program words
SAME_JERK = 0.005  # share of a coordinate's range of jerks
FEWEST_POINTS = 8
# Share of the blocks: of smooth motions 0.1 or less, of cubic splines 0.25 or more from four blocks an interval on.
OFTEN = 0.2
NO_ACCELERATION = 0.01  # share of the largest acceleration


def _piecewise_cubic(times: Array, poses: Array) -> bool:
    """Whether third divided differences stay the same from block to block as those of cubic pieces do."""
    if len(times) < FEWEST_POINTS:
        return False
    values = poses
    for order in (1, 2, 3):
        values = np.diff(values, axis=0) / (times[order:] - times[:-order])[:, None]
    rounding = 8.0 * RESOLUTION / (6.0 * np.diff(times).min() ** 3)
    same = np.abs(np.diff(values, axis=0)) <= SAME_JERK * np.ptp(values, axis=0) + rounding
    return bool(np.mean(same.all(axis=1)) >= OFTEN)


def _cubic_at_rest(times: Array, poses: Array) -> "BSpline | None":
    """The cubic spline with rates zero at both ends; None where it has accelerations there."""
    from scipy.interpolate import make_interp_spline

    still = np.zeros(poses.shape[1])
    spline = make_interp_spline(times, poses, k=3, bc_type=([(1, still)], [(1, still)]))
    accelerations = np.abs(spline(times, nu=2))
    rounding = 4.0 * RESOLUTION / np.diff(times).min() ** 2
    at_ends = accelerations[[0, -1]] <= NO_ACCELERATION * accelerations.max(axis=0) + rounding
    return spline if bool(at_ends.all()) else None


@renamed(pose="coordinates")
@dataclass(frozen=True, slots=True)
class Standstill:
    """A motion that stays at one pose, and may be measured there when it has settled."""

    coordinates: Array  # shape (n,) [m or rad]
    settle: float  # time that is not measured [s]
    average: float = 0.0  # time after it that is averaged, with the trigger on [s]

    @property
    def duration(self) -> float:
        """Settling and averaging [s]."""
        return self.settle + self.average

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        still = [np.zeros((len(time), len(self.coordinates))) for _ in range(3)]
        return Motion(time, np.tile(self.coordinates, (len(time), 1)), *still)


@dataclass(frozen=True, slots=True)
class StandingPoses:
    """Poses one after the other, one a second, each at rest: only limits of poses apply."""

    poses: Array  # coordinates, shape (n, k) [m or rad]

    @property
    def duration(self) -> float:
        """When the last pose is taken [s]."""
        return float(len(self.poses) - 1)

    def at(self, t: ArrayLike) -> Motion:
        """The poses that are visited at times t, shape (n,) [s], at rest."""
        time = np.asarray(t, dtype=float)
        still = [np.zeros((len(time), self.poses.shape[1])) for _ in range(3)]
        return Motion(time, self.poses[np.round(time).astype(int)], *still)


@dataclass(frozen=True, slots=True)
class Joined:
    """Trajectories one after the other."""

    parts: tuple[Trajectory, ...]  # each begins where the one before it ends, at rest

    @property
    def starts(self) -> Array:
        """Start of each part and end of the last, shape (parts + 1,) [s]."""
        return np.concatenate([[0.0], np.cumsum([p.duration for p in self.parts])])

    @property
    def duration(self) -> float:
        """Sum of the durations [s]."""
        return float(self.starts[-1])

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        starts = self.starts
        indices = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, len(self.parts) - 1)
        values = np.zeros((4, len(time), self.parts[0].at(np.zeros(1)).coordinates.shape[1]))
        for k in np.unique(indices):
            part, rows = self.parts[k], indices == k
            state = part.at(np.clip(time[rows] - starts[k], 0.0, part.duration))
            values[:, rows] = state.coordinates, state.rates, state.accelerations, state.jerks
        return Motion(time, *values)


def sample(trajectory: Trajectory, rate: float) -> Motion:
    """The trajectory at equal time steps that include both ends, at least `rate` of them a second [1/s]."""
    steps = max(1, int(np.ceil(trajectory.duration * rate - 1e-9)))
    return trajectory.at(np.linspace(0.0, trajectory.duration, steps + 1))


@dataclass(frozen=True, slots=True)
class Slowed:
    """A motion at a share of its speed: the same path, everything else slower."""

    motion: Trajectory
    speed: float  # share of the speed, above 0

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.motion.duration / self.speed

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        fast = self.motion.at(np.clip(time * self.speed, 0.0, self.motion.duration))
        s = self.speed
        return Motion(time, fast.coordinates, fast.rates * s, fast.accelerations * s**2, fast.jerks * s**3)


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
    angles, rates, accelerations = motion.coordinates[:, 3:], motion.rates[:, 3:], motion.accelerations[:, 3:]
    x0, x1, x2 = axis_rotation(0, angles[:, 0], rates[:, 0], accelerations[:, 0])
    y0, y1, y2 = axis_rotation(1, angles[:, 1], rates[:, 1], accelerations[:, 1])
    z0, z1, z2 = axis_rotation(2, angles[:, 2], rates[:, 2], accelerations[:, 2])
    yx = y0 @ x0
    yx1 = y1 @ x0 + y0 @ x1
    yx2 = y2 @ x0 + 2 * (y1 @ x1) + y0 @ x2
    return z0 @ yx, z1 @ yx + z0 @ yx1, z2 @ yx + 2 * (z1 @ yx1) + z0 @ yx2
