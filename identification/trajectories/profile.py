"""Time laws from rest to rest in closed form (seven segments, with or without a jerk limit), and straight moves."""

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from identification.motion import Joined, Motion, Trajectory

Array = NDArray[np.float64]

UNLIMITED = math.inf  # no limit of jerk in any coordinate


class TimeLaw(Protocol):
    """How a way is covered over time, from rest to rest."""

    @property
    def duration(self) -> float:
        """Duration [s]."""

    @property
    def peak_velocity(self) -> float:
        """Largest velocity [unit of the distance per second]."""

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """Distance covered, velocity, acceleration and jerk at times t, each of shape (n,)."""

    def slowed(self, speed: float) -> "TimeLaw":
        """The same way at a share of the speed."""


class Profile(NamedTuple):
    """Jerk +j, 0, -j, 0, -j, 0, +j over the times jerk, hold, jerk, cruise, jerk, hold, jerk.

    Without a jerk limit the times with jerk are 0: accelerations step, a trapezoid of velocity.
    """

    acceleration: float  # peak of the acceleration [1/s^2 of the unit of the distance]
    jerk_time: float  # duration of each segment with jerk; 0 where the acceleration steps [s]
    hold_time: float  # duration of each segment of constant acceleration [s]
    cruise_time: float  # duration of the segment of constant velocity [s]

    @property
    def lengths(self) -> tuple[float, ...]:
        """Durations of the seven segments [s]."""
        ramp = (self.jerk_time, self.hold_time, self.jerk_time)
        return (*ramp, self.cruise_time, *ramp)

    @property
    def jerk(self) -> float:
        """Magnitude of the jerk, infinite where the acceleration steps."""
        return self.acceleration / self.jerk_time if self.jerk_time > 0.0 else math.inf

    @property
    def duration(self) -> float:
        """Duration of the whole move [s]."""
        return 4 * self.jerk_time + 2 * self.hold_time + self.cruise_time

    @property
    def peak_velocity(self) -> float:
        """Largest velocity."""
        return self.acceleration * (self.jerk_time + self.hold_time)

    def slowed(self, speed: float) -> "Profile":
        """The same way at a share of the speed."""
        times = (self.jerk_time / speed, self.hold_time / speed, self.cruise_time / speed)
        return Profile(self.acceleration * speed**2, *times)

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """Distance covered, velocity, acceleration and jerk at times t, each of shape (n,).

        Where the acceleration steps, the value after the step counts, at the end that before it; the jerk is 0 there.
        """
        time = np.clip(np.asarray(t, dtype=float), 0.0, self.duration)
        s, v, a, j = (np.zeros_like(time) for _ in range(4))
        start, s0, v0, a0 = 0.0, 0.0, 0.0, 0.0
        for length, sign in zip(self.lengths, (1, 0, -1, 0, -1, 0, 1), strict=True):
            step = sign * self.acceleration
            if length > 0.0:
                rows = time >= start
                tau, jerk = np.minimum(time[rows] - start, length), step / length
                s[rows] = s0 + v0 * tau + a0 * tau**2 / 2 + jerk * tau**3 / 6
                v[rows] = v0 + a0 * tau + jerk * tau**2 / 2
                a[rows] = a0 + jerk * tau
                j[rows] = jerk
            s0 += v0 * length + a0 * length**2 / 2 + step * length**2 / 6
            v0 += a0 * length + step * length / 2
            a0 += step
            start += length
        return s, v, a, j


def fastest_profile(distance: float, velocity: float, acceleration: float, jerk: float = math.inf) -> Profile:
    """The fastest rest-to-rest profile over a distance within limits, all above 0 and in one unit of distance.

    Only the jerk may be unlimited.
    """
    jerk_time = float(min(acceleration / jerk, np.sqrt(velocity / jerk), np.cbrt(distance / (2 * jerk))))
    peak, hold_time = jerk * jerk_time, 0.0
    if jerk_time == acceleration / jerk:  # only then does the acceleration reach its limit and can be held
        by_velocity = velocity / acceleration - jerk_time
        by_distance = (-3 * jerk_time + np.sqrt(jerk_time**2 + 4 * distance / acceleration)) / 2
        peak, hold_time = acceleration, max(0.0, float(min(by_velocity, by_distance)))
    fastest = peak * (jerk_time + hold_time)
    cruise_time = max(0.0, distance / fastest - 2 * jerk_time - hold_time)
    return Profile(peak, jerk_time, hold_time, float(cruise_time))


def limits_along(way: Array, *limits: ArrayLike) -> list[float]:
    """What limits of each coordinate leave of share rates on a straight way.

    Args:
        way: how far each coordinate moves, at least one of them, shape (n,) [m or rad].
        limits: limits of rates, accelerations or jerks, shapes (n,), or one number for all.
    """
    moves = way > 0.0
    return [float(np.min(np.broadcast_to(limit, way.shape)[moves] / way[moves])) for limit in limits]


@dataclass(frozen=True, slots=True)
class StraightMove:
    """A straight line in the coordinates from rest to rest, all coordinates in step."""

    start: Array  # shape (n,) [m or rad]
    end: Array  # shape (n,) [m or rad], different from start
    profile: TimeLaw  # time law of the share of the way covered, from 0 to 1

    @classmethod
    def fastest(
        cls, start: ArrayLike, end: ArrayLike, rate: ArrayLike, acceleration: ArrayLike, jerk: ArrayLike = UNLIMITED
    ) -> "StraightMove":
        """The fastest such move within limits on each coordinate, shapes (n,); the jerk may be unlimited.

        Raises:
            ValueError: start and end are the same.
        """
        a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
        way = np.abs(b - a)
        if not way.any():
            raise ValueError("a move needs two different poses")
        return cls(a, b, fastest_profile(1.0, *limits_along(way, rate, acceleration, jerk)))

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.profile.duration

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        share, *derivatives = self.profile.at(time)
        way = self.end - self.start
        return Motion(time, self.start + share[:, None] * way, *(d[:, None] * way for d in derivatives))


def has_steps(motion: Trajectory) -> bool:
    """Whether a motion has straight moves whose accelerations step."""
    parts = motion.parts if isinstance(motion, Joined) else (motion,)
    laws = (part.profile for part in parts if isinstance(part, StraightMove))
    return any(isinstance(law, Profile) and law.jerk_time == 0.0 for law in laws)
