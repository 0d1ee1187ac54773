"""A move whose six struts, not its coordinates, change in proportion: what controllers call point to point (PTP)."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from cases.errors import IdentificationError
from identification.hexapod import Hexapod
from identification.motion import Motion
from identification.trajectories.profile import TimeLaw

Array = NDArray[np.float64]

DEGREE = 40  # of the path in Chebyshev polynomials; its last terms show whether that is enough
ROUNDING = 1e-14  # [m, rad] terms below it are none
NEGLIGIBLE = 1e-9  # [m, rad] of the last terms, and of what is missed at the ends


class NoStrutMove(ValueError):
    """No such move leads from one pose to the other; the message says why."""


class Deviation(NamedTuple):
    """How far a path leaves the straight way between its ends.

    Args:
        position: position of the origin [m].
        angle: angle of (roll, pitch, yaw) [rad].
    """

    position: float
    angle: float


@dataclass(frozen=True, slots=True)
class StrutMove:
    """A move straight in the struts from rest to rest; a `Trajectory`.

    Args:
        start: pose, shape (6,) [m, rad].
        end: pose, shape (6,) [m, rad].
        path: Chebyshev coefficients of the pose over 2 s - 1, s the share of the way in the struts, shape (d + 1, 6).
        strut_way: what the strut that changes most changes by [m].
        profile: s over time.
    """

    start: Array
    end: Array
    path: Array
    strut_way: float
    profile: TimeLaw

    @classmethod
    def between(cls, hexapod: Hexapod, start: Array, end: Array, profile: TimeLaw) -> "StrutMove":
        """The move between two poses, shapes (6,) [m, rad], by forward kinematics (7).

        Raises:
            NoStrutMove: the struts do not close on the way, or close in another assembly.
        """
        lengths = hexapod.strut_lengths(np.vstack([start, end]))
        way = lengths[1] - lengths[0]
        nodes = np.cos(np.linspace(np.pi, 0.0, DEGREE + 1))
        try:
            poses = hexapod.poses(lengths[0] + ((1.0 + nodes) / 2)[:, None] * way)
        except IdentificationError as error:
            raise NoStrutMove("the platform cannot follow its struts on the way; choose another way") from error
        if max(np.abs(poses[0] - start).max(), np.abs(poses[-1] - end).max()) > NEGLIGIBLE:
            raise NoStrutMove("the struts lead to another assembly of the platform; choose another way")
        path = np.asarray(chebyshev.chebfit(nodes, poses, DEGREE), dtype=float)
        if np.abs(path[-2:]).max() > NEGLIGIBLE:
            raise NoStrutMove("the way in the struts passes too near to a singularity; choose another way")
        needed = int(np.flatnonzero(np.abs(path).max(axis=1) > ROUNDING)[-1]) + 1
        return cls(start, end, path[:needed], float(np.abs(way).max()), profile)

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.profile.duration

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        s, v, a, j = (x[:, None] for x in self.profile.at(time))
        q, first, second, third = self.along(s[:, 0])
        rates, accelerations = first * v, second * v**2 + first * a
        return Motion(time, q, rates, accelerations, third * v**3 + 3.0 * second * v * a + first * j)

    def along(self, shares: Array) -> tuple[Array, Array, Array, Array]:
        """Pose and its derivatives with respect to s, at shares of the way, each of shape (n, 6)."""
        coefficients = self.path
        found: list[Array] = []
        for _ in range(4):
            found.append(np.asarray(chebyshev.chebval(2.0 * shares - 1.0, coefficients), dtype=float).T)
            coefficients = np.asarray(chebyshev.chebder(coefficients, scl=2.0), dtype=float)
        return found[0], found[1], found[2], found[3]

    @property
    def deviation(self) -> Deviation:
        """Largest distance from the straight way between the ends."""
        poses = self.along(np.linspace(0.0, 1.0, 10 * DEGREE))[0] - self.start
        off = []
        for axes in (slice(0, 3), slice(3, 6)):
            way = (self.end - self.start)[axes]
            length = float(np.linalg.norm(way))
            direction = way / length if length > 0.0 else way
            across = poses[:, axes] - np.outer(poses[:, axes] @ direction, direction)
            off.append(float(np.linalg.norm(across, axis=1).max()))
        return Deviation(*off)
