"""Arcs of the origin of {P} in a coordinate plane, from rest to rest; the angles ride along linearly."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from cases.units import Array
from identification.motion import Motion
from identification.trajectories.moves import TimeLaw, fastest_profile


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

    Raises:
        ValueError: no radius, no angle, or more than a full circle.
    """

    start: Array  # pose, shape (6,) [m, rad]
    end_angles: Array  # roll, pitch, yaw at the end, shape (3,) [rad]
    plane: Plane  # plane in which it lies
    centre: Array  # along the plane's first and second axis, absolute in {B}, shape (2,) [m]
    # turned about the plane's normal, positive counter-clockwise seen from its positive end; 2 pi is a full circle, at
    # most that [rad]
    angle: float
    profile: TimeLaw  # time law of the share of the way covered, from 0 to 1

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
        first, second, _ = self.plane.axes
        share, v, a, j = self.profile.at(time)
        values = [np.zeros((len(time), 6)) for _ in range(4)]
        values[0][:] = self.start
        turn = self.end_angles - self.start[3:]
        for value, law in zip(values, (share, v, a, j), strict=True):
            value[:, 3:] += law[:, None] * turn
        place = self._place(share)
        arm = place - self.centre
        across = np.column_stack([-arm[:, 1], arm[:, 0]])  # arm turned by 90 degrees
        w, w1, w2 = (self.angle * law[:, None] for law in (v, a, j))
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

    Args:
        start: pose, shape (6,) [m, rad].
        plane: plane in which it lies.
        centre: along the plane's axes, shape (2,) [m].
        angle: see `CircularMove` [rad].
        rate: limits, shape (6,).
        acceleration: limits, shape (6,).
        jerk: limits, shape (6,).

    Raises:
        ValueError: it cannot be slowed into its limits.
    """
    pose = np.asarray(start, dtype=float)
    limits = [np.asarray(limit, dtype=float) for limit in (rate, acceleration, jerk)]
    way = abs(angle) * np.hypot(*_arm(pose, plane, np.asarray(centre, dtype=float)))
    profile = fastest_profile(1.0, *(float(limit[list(plane.axes[:2])].min() / way) for limit in limits))
    for _ in range(60):
        move = CircularMove(pose, pose[3:], plane, np.asarray(centre, dtype=float), angle, profile)
        motion = move.at(np.linspace(0.0, move.duration, 4001))
        shares = [
            float(np.max(np.abs(values) / limit)) ** (1 / order)
            for order, (values, limit) in enumerate(
                zip((motion.rates, motion.accelerations, motion.jerks), limits, strict=True), start=1
            )
        ]
        if max(shares) <= 1.0:
            return move
        profile = profile.slowed(1.0 / (max(shares) * (1 + 1e-9)))
    raise ValueError("an arc cannot be slowed into its limits")


def _arm(pose: Array, plane: Plane, centre: Array) -> Array:
    """Vector from the centre of an arc to a pose, along the plane's axes, shape (2,) [m]."""
    first, second, _ = plane.axes
    return np.array([pose[first] - centre[0], pose[second] - centre[1]])
