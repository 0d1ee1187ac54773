"""The neutral program: what a controller shall do, block by block, before any dialect; motions as polynomial pieces.

Pieces are exact where a motion consists of such; else it is known how far they are off it under two laws of time.
"""

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import NDArray

from identification.motion import Joined, TimedPoints, Trajectory
from identification.trajectories.curves import PolynomialMotion
from identification.trajectories.moves import CircularMove, StraightMove
from identification.trajectories.profile import Profile

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

    @property
    def motion(self) -> Trajectory:
        """The motion that was sampled; where it is not known, the curve through the points."""
        return self.source or TimedPoints.through(self.times, self.poses)


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


CHECKS = 16  # instants inside a piece at which it is compared
FINEST = 64  # subdivisions of a piece before giving up


class TooCoarse(ValueError):
    """No subdivision keeps the tolerance."""


@dataclass(frozen=True, slots=True)
class Pieces:
    """Polynomials of one parameter p from 0 to 1 each."""

    times: Array  # start of each and end of the last, shape (k + 1,) [s]
    coefficients: Array  # coefficients of 1, p, p^2, .., shape (k, d + 1, 6) [m, rad]

    def at(self, p: Array) -> Array:
        """Poses of every piece at parameters p, shape (m,); shape (k, m, 6)."""
        powers = p[:, None] ** np.arange(self.coefficients.shape[1])
        return np.asarray(np.einsum("mi,kij->kmj", powers, self.coefficients))


@dataclass(frozen=True, slots=True)
class PieceDeviation:
    """Largest distance from the plan at the same instant."""

    position: float  # [m]
    angle: float  # [rad]


def knots(motion: Trajectory) -> Array:
    """Instants at which a motion changes from one polynomial to the next, shape (k,) [s]; its ends where it is none."""
    if isinstance(motion, PolynomialMotion):
        return motion.times
    if isinstance(motion, StraightMove) and isinstance(motion.profile, Profile):
        return np.unique(np.concatenate([[0.0], np.cumsum([s for s in motion.profile.lengths if s > 1e-9])]))
    if isinstance(motion, Joined):
        parts = [start + knots(part)[:-1] for start, part in zip(motion.starts, motion.parts, strict=False)]
        return np.append(np.concatenate(parts), motion.duration)
    return np.array([0.0, motion.duration])


def pieces(motion: Trajectory, degree: int, longest: float, tolerance: tuple[float, float]) -> Pieces:
    """Pieces that share pose and rates with the motion at their ends; of degree 5 the accelerations too.

    A motion of polynomials of that degree is met exactly.

    Args:
        degree: 3 or 5.
        longest: duration of a piece, at most [s].
        tolerance: how far they may be off, positions [m] and angles [rad].

    Raises:
        TooCoarse: no subdivision keeps the tolerance.
    """
    if isinstance(motion, PolynomialMotion) and (exact := _exact(motion, degree, longest)) is not None:
        return exact
    base = knots(motion)
    counts = np.ceil(np.diff(base) / longest - 1e-9).astype(int).clip(1)
    finer = 1
    while finer <= FINEST:
        times = np.append(
            np.concatenate(
                [np.linspace(a, b, n * finer, endpoint=False) for a, b, n in zip(base, base[1:], counts, strict=False)]
            ),
            base[-1],
        )
        spline = _hermite(motion, times, degree)
        off = even_deviation(spline, motion)
        if off.position <= tolerance[0] and off.angle <= tolerance[1]:
            return spline
        finer *= 2
    raise TooCoarse(f"polynomials of degree {degree} stay {off.position * 1e3:.2g} mm off the motion")


def _exact(motion: PolynomialMotion, degree: int, longest: float) -> Pieces | None:
    """The motion's own polynomials, cut where they are too long; None where one of them is of a higher degree."""
    coefficients, steps = [], []
    for piece in motion.pieces:
        own = np.zeros((max(degree + 1, len(piece.coefficients)), 6))
        own[: len(piece.coefficients)] = piece.coefficients
        if own[degree + 1 :].any():
            return None
        count = max(1, int(np.ceil(piece.duration / longest - 1e-9)))
        step = piece.duration / count
        for k in range(count):
            # c_i of p in [0, 1] is the i-th derivative where it begins, times step^i / i!.
            at, scaled = own[: degree + 1], []
            for i in range(degree + 1):
                scaled.append(np.polynomial.polynomial.polyval(k * step, at) * step**i / factorial(i))
                at = np.asarray(np.polynomial.polynomial.polyder(at)) if len(at) > 1 else np.zeros((1, 6))
            coefficients.append(np.array(scaled))
            steps.append(step)
    return Pieces(np.concatenate([[0.0], np.cumsum(steps)]), np.array(coefficients))


def _hermite(motion: Trajectory, times: Array, degree: int) -> Pieces:
    at, steps = motion.at(times), np.diff(times)[:, None]
    order = (degree - 1) // 2
    values = [at.pose, at.rates, at.accelerations][: order + 1]
    coefficients = [v[:-1] * steps**k / (1, 1, 2)[k] for k, v in enumerate(values)]  # c_0 .. c_order
    # The other half from the end: sum_i i!/(i-k)! c_i = x1^(k) T^k.
    high = np.arange(order + 1, degree + 1)
    falling = np.array(
        [[np.prod(high[c] - np.arange(k)) for c in range(len(high))] for k in range(order + 1)], dtype=float
    )
    targets = []
    for k, v in enumerate(values):
        rest = sum(np.prod(i - np.arange(k)) * coefficients[i] for i in range(k, order + 1))
        targets.append(v[1:] * steps**k - rest)
    rest_coefficients = np.einsum("ck,knj->cnj", np.linalg.inv(falling), np.stack(targets))
    return Pieces(times, np.stack([*coefficients, *rest_coefficients], axis=1))


def even_deviation(found: Pieces, motion: Trajectory) -> PieceDeviation:
    """If the parameter of each piece passes evenly in time."""
    p = np.linspace(0.0, 1.0, CHECKS + 1)
    return _deviation(found, motion, found.at(p), p)


def path_speed_deviation(found: Pieces, motion: Trajectory) -> PieceDeviation:
    """If each piece is passed at constant speed of the origin along its path, in the time planned for it."""
    p = np.linspace(0.0, 1.0, 8 * CHECKS + 1)
    poses = found.at(p)
    way = np.cumsum(np.linalg.norm(np.diff(poses[:, :, :3], axis=1), axis=2), axis=1)
    share = np.concatenate([np.zeros((len(way), 1)), way], axis=1)
    rests = share[:, -1:] <= 1e-12
    share = np.where(rests, p, share / np.where(rests, 1.0, share[:, -1:]))
    even = np.linspace(0.0, 1.0, CHECKS + 1)
    parameters = np.array([np.interp(even, row, p) for row in share])
    powers = parameters[:, :, None] ** np.arange(found.coefficients.shape[1])
    return _deviation(found, motion, np.einsum("kmi,kij->kmj", powers, found.coefficients), even)


def _deviation(spline: Pieces, motion: Trajectory, poses: Array, p: Array) -> PieceDeviation:
    starts, steps = spline.times[:-1, None], np.diff(spline.times)[:, None]
    instants = np.minimum(starts + steps * p, motion.duration)
    exact = motion.at(instants.ravel()).pose.reshape(poses.shape)
    off = poses - exact
    return PieceDeviation(float(np.linalg.norm(off[..., :3], axis=2).max()), float(np.abs(off[..., 3:]).max()))
