"""The rest-to-rest profile with seven segments of constant jerk, in closed form, and straight moves that follow it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from identification.motion import Motion

Array = NDArray[np.float64]


class Profile(NamedTuple):
    """Jerk +j, 0, -j, 0, -j, 0, +j over the times jerk, hold, jerk, cruise, jerk, hold, jerk.

    Args:
        jerk: magnitude of the jerk [1/s^3 of the unit of the distance].
        jerk_time: duration of each segment with jerk [s].
        hold_time: duration of each segment of constant acceleration [s].
        cruise_time: duration of the segment of constant velocity [s].
    """

    jerk: float
    jerk_time: float
    hold_time: float
    cruise_time: float

    @property
    def duration(self) -> float:
        """Duration of the whole move [s]."""
        return 4 * self.jerk_time + 2 * self.hold_time + self.cruise_time

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """Distance covered, velocity, acceleration and jerk at times t, each of shape (n,)."""
        time = np.clip(np.asarray(t, dtype=float), 0.0, self.duration)
        lengths = [self.jerk_time, self.hold_time, self.jerk_time, self.cruise_time]
        lengths += [self.jerk_time, self.hold_time, self.jerk_time]
        signs = [1, 0, -1, 0, -1, 0, 1]
        s, v, a = np.zeros_like(time), np.zeros_like(time), np.zeros_like(time)
        j = np.zeros_like(time)
        start, s0, v0, a0 = 0.0, 0.0, 0.0, 0.0
        for length, sign in zip(lengths, signs, strict=True):
            rows = time >= start
            tau, jerk = np.minimum(time[rows] - start, length), sign * self.jerk
            s[rows] = s0 + v0 * tau + a0 * tau**2 / 2 + jerk * tau**3 / 6
            v[rows] = v0 + a0 * tau + jerk * tau**2 / 2
            a[rows] = a0 + jerk * tau
            j[rows] = jerk
            s0 += v0 * length + a0 * length**2 / 2 + jerk * length**3 / 6
            v0 += a0 * length + jerk * length**2 / 2
            a0 += jerk * length
            start += length
        return s, v, a, j


def fastest_profile(distance: float, velocity: float, acceleration: float, jerk: float) -> Profile:
    """The fastest rest-to-rest profile over a distance within three limits, all above 0 and in one unit of distance."""
    jerk_time = min(acceleration / jerk, np.sqrt(velocity / jerk), np.cbrt(distance / (2 * jerk)))
    hold_time = 0.0
    if jerk_time == acceleration / jerk:  # only then does the acceleration reach its limit and can be held
        by_velocity = velocity / acceleration - jerk_time
        by_distance = (-3 * jerk_time + np.sqrt(jerk_time**2 + 4 * distance / acceleration)) / 2
        hold_time = max(0.0, min(by_velocity, by_distance))
    peak = jerk * jerk_time * (jerk_time + hold_time)
    cruise_time = max(0.0, distance / peak - 2 * jerk_time - hold_time)
    return Profile(jerk, float(jerk_time), float(hold_time), float(cruise_time))


@dataclass(frozen=True, slots=True)
class StraightMove:
    """A straight line in the pose coordinates from rest to rest, all coordinates in step.

    Args:
        start: shape (6,) [m, rad].
        end: shape (6,) [m, rad], different from start.
        profile: time law of the share of the way covered, from 0 to 1.
    """

    start: Array
    end: Array
    profile: Profile

    @classmethod
    def fastest(
        cls, start: ArrayLike, end: ArrayLike, rate: ArrayLike, acceleration: ArrayLike, jerk: ArrayLike
    ) -> "StraightMove":
        """The fastest such move within limits on each coordinate, shapes (6,).

        Raises:
            ValueError: start and end are the same.
        """
        a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
        way = np.abs(b - a)
        if not way.any():
            raise ValueError("a move needs two different poses")
        moves = way > 0.0
        limits = [float(np.min(np.asarray(limit)[moves] / way[moves])) for limit in (rate, acceleration, jerk)]
        return cls(a, b, fastest_profile(1.0, *limits))

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
