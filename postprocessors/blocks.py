"""The neutral program: what a controller shall do, block by block, before any dialect."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.motion import Trajectory
from identification.trajectories.moves import CircularMove, StraightMove
from identification.trajectories.polynomial import PolynomialMotion

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Comment:
    """A remark for people."""

    text: str  # any; dialects wrap it and replace what their controller cannot read


@dataclass(frozen=True, slots=True)
class ToHome:
    """A straight move to home at a safe feed from wherever the machine stands."""

    pose: Array  # coordinates at home, shape (k,) [m or rad]
    feed: float  # along the path of the origin [m/s]; of a chain the share of the limits of its joints


@dataclass(frozen=True, slots=True)
class ExactStopMove:
    """A straight move in the six coordinates from rest to rest, exact stop at its end.

    Controllers know feeds, not durations: a dialect writes the feed that makes its controller's own time law, under the
    limits of the case, take as long as planned.
    """

    move: StraightMove  # where from, where to, and the planned time law

    @property
    def feed(self) -> float:
        """Largest speed of the planned move: of the origin [m/s], or of the angles where the origin rests [rad/s]."""
        return self.move.profile.peak_velocity * self.length

    @property
    def length(self) -> float:
        """Way of the origin [m], or of the angles where the origin rests [rad]: what feeds count."""
        way = self.move.end - self.move.start
        linear = float(np.linalg.norm(way[:3]))
        return linear if linear > 0.0 else float(np.linalg.norm(way[3:]))


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular move in a coordinate plane from rest to rest, exact stop at its end; full circles too."""

    move: CircularMove  # where from, about what, how far, and the planned time law

    @property
    def feed(self) -> float:
        """Largest speed of the origin in the planned move [m/s]."""
        return self.move.profile.peak_velocity * self.move.length


@dataclass(frozen=True, slots=True)
class TimedPath:
    """Poses to be passed at given times, from rest at the pose before to rest at the last."""

    name: str  # what it is for
    times: Array  # shape (k,), increasing, the first 0 [s]
    poses: Array  # coordinates, one row a time, the first is where the machine stands [m, rad]
    # the motion that was sampled, on the clock of `times`, for dialects that can carry more than points
    source: Trajectory | None = None


@dataclass(frozen=True, slots=True)
class SplinePath:
    """Polynomial pieces, one after the other, from rest to rest: the exact path and time law of a spline."""

    name: str  # what it is for
    motion: PolynomialMotion  # its pieces, each with its duration


@dataclass(frozen=True, slots=True)
class Dwell:
    """Standing still."""

    duration: float  # [s]


@dataclass(frozen=True, slots=True)
class Trigger:
    """The recording's trigger, switched while the machine stands."""

    on: bool


Block = Comment | ToHome | ExactStopMove | Arc | TimedPath | SplinePath | Dwell | Trigger


@dataclass(frozen=True, slots=True)
class NeutralProgram:
    """A program."""

    header: tuple[str, ...]  # comment lines that say where it comes from and what it was proven against
    blocks: tuple[Block, ...]

    @property
    def paths(self) -> tuple[TimedPath, ...]:
        """Its timed paths."""
        return tuple(b for b in self.blocks if isinstance(b, TimedPath))
