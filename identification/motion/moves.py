"""Moves from rest to rest along straight lines in the coordinates or arcs, and the time laws of all moves.

Time laws have seven segments in closed form, with or without a limit of jerk; controllers compute theirs online, in
whole controller cycles, here by ruckig, for one move of one coordinate at a time. Intermediate waypoints, which a
service in the network would compute, are never given to it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cases.base.units import Array
from identification.motion.motion import Joined, Motion, Trajectory

UNLIMITED = math.inf  # no limit of jerk in any coordinate


class Profile(NamedTuple):
    """Time law of a way from rest to rest: jerk +j, 0, -j, 0, -j, 0, +j in seven segments.

    They last the times jerk, hold, jerk, cruise, jerk, hold, jerk. Without a jerk limit those with jerk are 0:
    accelerations step, a trapezoid of velocity.
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

    def without_short_phases(self, shortest: float) -> "Profile":
        """The same way in the same time, whose phases of constant velocity and acceleration last `shortest` [s] or 0.

        What a shorter one lasted is given to those beside it: no limit of jerk is exceeded by that, those of velocity
        and acceleration by half of its share of the move's time at most.
        """
        distance = self.peak_velocity * (2 * self.jerk_time + self.hold_time + self.cruise_time)
        jerk_time, hold_time, cruise_time = self.jerk_time, self.hold_time, self.cruise_time
        if cruise_time < shortest and hold_time >= shortest:
            hold_time, cruise_time = hold_time + cruise_time / 2, 0.0
        elif cruise_time < shortest and jerk_time > 0.0:
            jerk_time, cruise_time = jerk_time + cruise_time / 4, 0.0
        if hold_time < shortest and jerk_time > 0.0:
            jerk_time, hold_time = jerk_time + hold_time / 2, 0.0
        unit = unit_profile(jerk_time, hold_time, cruise_time)
        return unit._replace(acceleration=distance * unit.acceleration)

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


def unit_profile(jerk_time: float, hold_time: float, cruise_time: float) -> Profile:
    """The profile over a distance of 1 with these times [s]."""
    acceleration = 1.0 / ((jerk_time + hold_time) * (2 * jerk_time + hold_time + cruise_time))
    return Profile(acceleration, jerk_time, hold_time, cruise_time)


def fastest_profile(distance: float, velocity: float, acceleration: float, jerk: float = math.inf) -> Profile:
    """The fastest rest-to-rest profile over a distance within limits, all above 0 and in one unit of distance.

    Only the jerk may be unlimited.
    """
    jerk_time = float(min(acceleration / jerk, np.sqrt(velocity / jerk), np.cbrt(distance / (2 * jerk))))
    peak, hold_time = jerk * jerk_time, 0.0
    if jerk_time == acceleration / jerk:  # only then the acceleration reaches its limit and can stay there
        by_velocity = velocity / acceleration - jerk_time
        by_distance = (-3 * jerk_time + np.sqrt(jerk_time**2 + 4 * distance / acceleration)) / 2
        peak, hold_time = acceleration, max(0.0, float(min(by_velocity, by_distance)))
    fastest = peak * (jerk_time + hold_time)
    cruise_time = max(0.0, distance / fastest - 2 * jerk_time - hold_time)
    return Profile(peak, jerk_time, hold_time, float(cruise_time))


def limits_along(way: Array, *limits: ArrayLike) -> list[float]:
    """Limits of the share of a straight way, shape (n,) [m or rad], from those of each coordinate, or one for all."""
    moves = way > 0.0
    return [float(np.min(np.broadcast_to(limit, way.shape)[moves] / way[moves])) for limit in limits]


SAME = 1e-4  # of the way, the largest velocity and acceleration: rounding where the limit of jerk is next to none


class UntimedMotion(ValueError):
    """A move or path that cannot be timed; the message says why."""


def ruckig_profile(velocity: float, acceleration: float, jerk: float, cycle: float | None = None) -> Profile:
    """The fastest time law over a way of 1 that ruckig finds within three limits.

    Args:
        velocity, acceleration: limits [1/s, 1/s^2].
        jerk: limit [1/s^3]; infinite, without a cycle, where accelerations step.
        cycle: cycle of the controller [s], of which the law then lasts a whole number.

    Raises:
        UntimedMotion: a limit is not a finite number above 0, or ruckig finds no law of seven segments.
    """
    from ruckig import DurationDiscretization, InputParameter, Result, Ruckig, RuckigError, Trajectory

    whole = 1.0 if cycle is None else cycle
    numbers = {"velocity": velocity, "acceleration": acceleration, "jerk": jerk, "cycle": whole}
    for name, value in numbers.items():
        if not (value > 0.0 and (math.isfinite(value) or (name == "jerk" and cycle is None))):
            raise UntimedMotion(f"{name} {value:g} is not a finite number above 0")
    request, answer = InputParameter(1), Trajectory(1)
    request.current_position, request.target_position = [0.0], [1.0]
    request.max_velocity, request.max_acceleration, request.max_jerk = [velocity], [acceleration], [jerk]
    if cycle is not None:
        request.duration_discretization = DurationDiscretization.Discrete
    try:
        result = (Ruckig(1) if cycle is None else Ruckig(1, cycle)).calculate(request, answer)
    except RuckigError as error:
        raise UntimedMotion(f"no time law within these limits ({' '.join(str(error).split())})") from error
    if result != Result.Working:  # offline, this is what success is called
        raise UntimedMotion(f"no time law within these limits (ruckig: {result.name})")
    phases = answer.profiles[0][0]
    jerking, holding = (phases.t[0], phases.t[1] * (phases.j[1] == 0.0)) if math.isfinite(jerk) else (0.0, phases.t[0])
    cruising = max(0.0, answer.duration - 4 * jerking - 2 * holding)
    profile = unit_profile(jerking, holding, cruising)
    lengths = np.array(phases.t)
    middles = (np.cumsum(lengths) - lengths / 2)[lengths > 0.0]
    theirs = np.array([[values[0] for values in answer.at_time(float(t))[:3]] for t in middles]).T
    if any(np.abs(a - b).max() > SAME * np.abs(b).max() for a, b in zip(profile.at(middles)[:3], theirs, strict=True)):
        raise UntimedMotion("ruckig's time law is not one of seven segments: change the limits or the cycle slightly")
    return profile


@dataclass(frozen=True, slots=True)
class StraightMove:
    """A straight line in the coordinates from rest to rest, all coordinates in step."""

    start: Array  # shape (n,) [m or rad]
    end: Array  # shape (n,) [m or rad], different from start
    profile: Profile  # time law of the share of the way covered, from 0 to 1

    @classmethod
    def fastest(
        cls, start: ArrayLike, end: ArrayLike, rate: ArrayLike, acceleration: ArrayLike, jerk: ArrayLike = UNLIMITED
    ) -> "StraightMove":
        """The fastest such move within limits on each coordinate, shapes (n,); the jerk may be unlimited.

        Raises ValueError where start and end are the same.
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
        return self.along(time, self.profile.at(time))

    def along(self, time: Array, law: Sequence[Array]) -> Motion:
        """The motion at times, shape (n,) [s], where share of the way and its derivatives are those of another law."""
        share, *derivatives = law
        way = self.end - self.start
        return Motion(time, self.start + share[:, None] * way, *(d[:, None] * way for d in derivatives))


def has_steps(motion: Trajectory) -> bool:
    """Whether a motion has straight moves whose accelerations step."""
    parts = motion.parts if isinstance(motion, Joined) else (motion,)
    return any(isinstance(part, StraightMove) and part.profile.jerk_time == 0.0 for part in parts)


class Plane(Enum):
    """A coordinate plane: first axis, second axis and normal, right-handed; the value is what machines call it."""

    XY = "XY"
    ZX = "ZX"
    YZ = "YZ"

    @property
    def axes(self) -> tuple[int, int, int]:
        """Indices of first axis, second axis and normal in (x, y, z)."""
        return {"XY": (0, 1, 2), "ZX": (2, 0, 1), "YZ": (1, 2, 0)}[self.value]


@dataclass(frozen=True, slots=True)
class CircularMove:
    """An arc of the origin of {P} about an axis parallel to x, y or z; the other coordinates change in proportion.

    Raises ValueError without a radius or an angle, or for more than a full circle.
    """

    start: Array  # pose, shape (6,) [m, rad]
    end_angles: Array  # roll, pitch, yaw at the end, shape (3,) [rad]
    plane: Plane  # plane in which it lies
    centre: Array  # along the plane's first and second axis, absolute in {B}, shape (2,) [m]
    # turned about the plane's normal, positive counter-clockwise seen from its positive end; 2 pi is a full circle, at
    # most that [rad]
    angle: float
    profile: Profile  # time law of the share of the way covered, from 0 to 1

    def __post_init__(self) -> None:
        if not 0.0 < abs(self.angle) <= 2 * np.pi * (1 + 1e-12):
            raise ValueError(f"an arc turns by {self.angle:g} rad; more than 0 and at most a full circle")
        if not self.radius > 0.0:
            raise ValueError("an arc needs a centre away from its start")

    @property
    def radius(self) -> float:
        """Radius [m]."""
        return float(np.hypot(*_arm(self.start, self.plane, self.centre)))

    @property
    def length(self) -> float:
        """Way of the origin [m]."""
        return self.radius * abs(self.angle)

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.profile.duration

    @property
    def end(self) -> Array:
        """Pose at the end, shape (6,) [m, rad]; of a full circle exactly the start's position."""
        first, second, _ = self.plane.axes
        pose = np.concatenate([self.start[:3], self.end_angles])
        if abs(abs(self.angle) - 2 * np.pi) > 1e-12:
            pose[[first, second]] = self._place(np.ones(1))[0]
        return pose

    def _place(self, share: Array) -> Array:
        arm = _arm(self.start, self.plane, self.centre)
        cosine, sine = np.cos(share * self.angle), np.sin(share * self.angle)
        coordinates = [cosine * arm[0] - sine * arm[1], sine * arm[0] + cosine * arm[1]]
        return np.asarray(self.centre + np.column_stack(coordinates))

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        return self.along(time, self.profile.at(time))

    def along(self, time: Array, law: Sequence[Array]) -> Motion:
        """As `StraightMove.along`."""
        first, second, _ = self.plane.axes
        share, v, a, j = law
        values = [np.zeros((len(time), 6)) for _ in range(4)]
        values[0][:] = self.start
        turn = self.end_angles - self.start[3:]
        for value, derivative in zip(values, law, strict=True):
            value[:, 3:] += derivative[:, None] * turn
        place = self._place(share)
        arm = place - self.centre
        across = np.column_stack([-arm[:, 1], arm[:, 0]])  # arm turned by 90 degrees
        w, w1, w2 = (self.angle * derivative[:, None] for derivative in (v, a, j))
        values[0][:, [first, second]] = place
        values[1][:, [first, second]] = w * across
        values[2][:, [first, second]] = w1 * across - w**2 * arm
        values[3][:, [first, second]] = (w2 - w**3) * across - 3 * w * w1 * arm
        return Motion(time, *values)


def fastest_circle(
    start: ArrayLike,
    plane: Plane,
    centre: ArrayLike,
    angle: float,
    rate: ArrayLike,
    acceleration: ArrayLike,
    jerk: ArrayLike,
) -> CircularMove:
    """A fast arc within limits on each coordinate, shapes (6,): near the fastest seven-segment one, never beyond.

    The time law is the seven-segment profile, slowed as a whole until the motion satisfies every limit on a fine grid.
    Other arguments as in `CircularMove`.
    """
    pose, middle = np.asarray(start, dtype=float), np.asarray(centre, dtype=float)
    limits = [np.asarray(limit, dtype=float) for limit in (rate, acceleration, jerk)]
    way = abs(angle) * np.hypot(*_arm(pose, plane, middle))
    profile = fastest_profile(1.0, *(float(limit[list(plane.axes[:2])].min() / way) for limit in limits))
    move = CircularMove(pose, pose[3:], plane, middle, angle, profile)
    motion = move.at(np.linspace(0.0, move.duration, 4001))
    shares = [
        np.max(np.abs(values) / limit)
        for values, limit in zip((motion.rates, motion.accelerations, motion.jerks), limits, strict=True)
    ]
    most = max(float(share) ** (1 / order) for order, share in enumerate(shares, start=1))
    return move if most <= 1.0 else replace(move, profile=profile.slowed(1.0 / (most * (1 + 1e-9))))


def _arm(pose: Array, plane: Plane, centre: Array) -> Array:
    """Vector from the centre of an arc to a pose, along the plane's axes, shape (2,) [m]."""
    first, second, _ = plane.axes
    return np.array([pose[first] - centre[0], pose[second] - centre[1]])
