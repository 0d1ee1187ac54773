"""Time laws from rest to rest in closed form (seven segments of constant jerk, trapezoid), and straight moves."""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from identification.motion import Motion

Array = NDArray[np.float64]


class TimeLaw(Protocol):
    """How a way is covered over time, from rest to rest."""

    @property
    def duration(self) -> float:
        """Duration [s]."""
        ...

    @property
    def peak_velocity(self) -> float:
        """Largest velocity [unit of the distance per second]."""
        ...

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """Distance covered, velocity, acceleration and jerk at times t, each of shape (n,)."""
        ...

    def slowed(self, speed: float) -> "TimeLaw":
        """The same way at a share of the speed."""
        ...


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

    @property
    def peak_velocity(self) -> float:
        """Largest velocity."""
        return self.jerk * self.jerk_time * (self.jerk_time + self.hold_time)

    def slowed(self, speed: float) -> "Profile":
        """The same way at a share of the speed."""
        return Profile(self.jerk * speed**3, self.jerk_time / speed, self.hold_time / speed, self.cruise_time / speed)

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


class Trapezoid(NamedTuple):
    """Acceleration +a, 0, -a: the law of a controller without a jerk limit. Its jerk is infinite where a steps; `at`
    gives 0 there and everywhere else.

    Args:
        acceleration: magnitude [1/s^2 of the unit of the distance].
        ramp_time: duration of each of the two ramps [s].
        cruise_time: duration at constant velocity [s].
    """

    acceleration: float
    ramp_time: float
    cruise_time: float

    @property
    def duration(self) -> float:
        """Duration of the whole move [s]."""
        return 2 * self.ramp_time + self.cruise_time

    @property
    def peak_velocity(self) -> float:
        """Largest velocity."""
        return self.acceleration * self.ramp_time

    def slowed(self, speed: float) -> "Trapezoid":
        """The same way at a share of the speed."""
        return Trapezoid(self.acceleration * speed**2, self.ramp_time / speed, self.cruise_time / speed)

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """Distance covered, velocity, acceleration and jerk at times t, each of shape (n,)."""
        time = np.clip(np.asarray(t, dtype=float), 0.0, self.duration)
        braking = time > self.ramp_time + self.cruise_time
        up, down = np.minimum(time, self.ramp_time), np.where(braking, self.duration - time, self.ramp_time)
        cruise = np.clip(time - self.ramp_time, 0.0, self.cruise_time)
        v = self.acceleration * np.minimum(up, down)
        s = self.acceleration * (up**2 / 2 + self.ramp_time * cruise + (self.ramp_time**2 - down**2) / 2)
        a = np.where(braking, -self.acceleration, np.where(time < self.ramp_time, self.acceleration, 0.0))
        return s, v, a, np.zeros_like(s)


def fastest_trapezoid(distance: float, velocity: float, acceleration: float) -> Trapezoid:
    """The fastest trapezoid over a distance within two limits, all above 0 and in one unit of distance."""
    ramp = min(velocity / acceleration, float(np.sqrt(distance / acceleration)))
    return Trapezoid(acceleration, ramp, max(0.0, distance / (acceleration * ramp) - ramp))


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


def limits_along(way: Array, *limits: ArrayLike) -> list[float]:
    """What limits of each coordinate leave of share rates on a straight way.

    Args:
        way: how far each coordinate moves, at least one of them, shape (6,) [m, rad].
        limits: of rates, accelerations or jerks, shapes (6,).
    """
    moves = way > 0.0
    return [float(np.min(np.asarray(limit)[moves] / way[moves])) for limit in limits]


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
    profile: TimeLaw

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
