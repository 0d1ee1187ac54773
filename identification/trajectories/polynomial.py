"""A motion of polynomial pieces, each with its duration: what splines are made of."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import factorial, perm

import numpy as np
from numpy.typing import ArrayLike, NDArray

from identification.motion import Motion
from identification.trajectories.moves import StraightMove
from identification.trajectories.profile import Profile

Array = NDArray[np.float64]

SHORTEST_SEGMENT = 1e-9  # [s] below it a segment is absent


@dataclass(frozen=True, slots=True)
class Piece:
    """sum_i c_i t^i over 0 <= t <= duration in each of the six coordinates."""

    coefficients: Array  # c_0 to c_d, shape (d + 1, n) [m or rad over powers of seconds]
    duration: float  # [s]

    @property
    def start(self) -> Array:
        """Pose at its start, shape (n,) [m or rad]."""
        return np.asarray(self.coefficients[0])

    @property
    def end(self) -> Array:
        """Pose at its end, shape (n,) [m or rad]."""
        return np.asarray(np.polynomial.polynomial.polyval(self.duration, self.coefficients))


@dataclass(frozen=True, slots=True)
class PolynomialMotion:
    """Pieces one after the other.

    Raises:
        ValueError: no pieces, a duration that is not positive, or a gap between two of them.
    """

    pieces: tuple[Piece, ...]  # each begins where the one before it ends
    table: Array = field(init=False, repr=False, compare=False)
    """c_i of all pieces, those of lower degree filled up with zeros, shape (degree + 1, pieces, n)."""
    times: Array = field(init=False, repr=False, compare=False)
    """Start of each piece and end of the last, shape (pieces + 1,) [s]."""

    def __post_init__(self) -> None:
        if not self.pieces or any(not p.duration > 0.0 for p in self.pieces):
            raise ValueError("a motion of polynomials needs pieces of positive duration")
        table = np.zeros(
            (max(len(p.coefficients) for p in self.pieces), len(self.pieces), self.pieces[0].coefficients.shape[1])
        )
        for k, piece in enumerate(self.pieces):
            table[: len(piece.coefficients), k] = piece.coefficients
        object.__setattr__(self, "table", table)
        object.__setattr__(self, "times", np.concatenate([[0.0], np.cumsum([p.duration for p in self.pieces])]))
        if np.max(np.abs(self.at_ends(0)[:-1] - table[0, 1:]), initial=0.0) > 1e-9:
            raise ValueError("a polynomial piece does not begin where the one before it ends")

    def at_starts(self, order: int) -> Array:
        """Derivative of an order at the start of each piece, shape (pieces, n)."""
        return factorial(order) * self.table[order] if order < len(self.table) else np.zeros_like(self.table[0])

    def at_ends(self, order: int) -> Array:
        """Derivative of an order at the end of each piece, shape (pieces, n)."""
        duration = np.array([p.duration for p in self.pieces])[:, None]
        value = np.zeros_like(self.table[0])
        for power in range(len(self.table) - 1, order - 1, -1):  # Horner's rule
            value = value * duration + perm(power, order) * self.table[power]
        return np.asarray(value)

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return float(self.times[-1])

    def slowed(self, speed: float) -> "PolynomialMotion":
        """The same path at a share of the speed."""
        pieces = []
        for piece in self.pieces:
            powers = speed ** np.arange(len(piece.coefficients))
            pieces.append(Piece(piece.coefficients * powers[:, None], piece.duration / speed))
        return PolynomialMotion(tuple(pieces))

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        starts = self.times
        indices = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, len(self.pieces) - 1)
        local = np.clip(time - starts[indices], 0.0, np.diff(starts)[indices])[:, None]
        table = self.table
        values = np.zeros((4, len(time), self.pieces[0].coefficients.shape[1]))
        for order in range(4):
            for coefficient in table[::-1]:  # Horner's rule
                values[order] = values[order] * local + coefficient[indices]
            table = table[1:] * np.arange(1, len(table))[:, None, None]
        return Motion(time, *values)


def polynomials_of(moves: Sequence[StraightMove]) -> PolynomialMotion:
    """Moves of seven segments one after the other as what they are: a cubic polynomial a segment.

    Args:
        moves: each begins where the one before it ends.

    Raises:
        ValueError: a move of another law, or one that begins elsewhere.
    """
    return PolynomialMotion(tuple(piece for move in moves for piece in _segments(move)))


def _segments(move: StraightMove) -> Iterator[Piece]:
    law = move.profile
    if not isinstance(law, Profile):
        raise ValueError("a move has no law of seven segments")
    durations = np.array(law.lengths)
    starts = np.append(0.0, np.cumsum(durations[:-1]))  # added up as the law does: accelerations may step there
    s, v, a, _ = law.at(starts)
    jerk = law.at(starts + durations / 2)[3]
    way = move.end - move.start
    for k in np.flatnonzero(durations > SHORTEST_SEGMENT):
        shares = np.array([s[k], v[k], a[k] / 2, jerk[k] / 6])
        coefficients = shares[:, None] * way
        coefficients[0] += move.start
        yield Piece(coefficients, float(durations[k]))


@dataclass(frozen=True, slots=True)
class Tabulated:
    """Rows of pose, rates and accelerations at equal steps, from rest to rest.

    Between rows the pose is the cubic that shares pose and rates with both; rates and accelerations, which a table
    states for themselves, go straight from row to row. Jerks are the slopes of accelerations.

    Raises:
        ValueError: fewer than two rows, or shapes that do not belong together.
    """

    times: Array  # shape (k,), equal steps from 0 [s]
    pose: Array  # coordinates, shape (k, n) [m or rad]
    rates: Array  # shape (k, n) [m/s or rad/s]
    accelerations: Array  # shape (k, n) [m/s^2 or rad/s^2]

    def __post_init__(self) -> None:
        shape = (len(self.times), *self.pose.shape[1:2])
        if len(self.times) < 2 or any(v.shape != shape for v in (self.pose, self.rates, self.accelerations)):
            raise ValueError("a table needs two rows or more, each with as many coordinates, rates and accelerations")

    @property
    def duration(self) -> float:
        """Time of the last row [s]."""
        return float(self.times[-1])

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        k = np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, len(self.times) - 2)
        step = (self.times[k + 1] - self.times[k])[:, None]
        p = (time - self.times[k])[:, None] / step
        start, end = self.pose[k], self.pose[k + 1]
        pose = start * (1 + 2 * p) * (1 - p) ** 2 + end * p**2 * (3 - 2 * p)
        pose += step * p * (1 - p) * (self.rates[k] * (1 - p) - self.rates[k + 1] * p)
        rates = self.rates[k] * (1 - p) + self.rates[k + 1] * p
        accelerations = self.accelerations[k] * (1 - p) + self.accelerations[k + 1] * p
        jerks = (self.accelerations[k + 1] - self.accelerations[k]) / step
        return Motion(time, pose, rates, accelerations, np.ascontiguousarray(jerks))
