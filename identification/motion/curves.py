"""Motions along curves in closed form: polynomials piece by piece, rows of a table, periodic Fourier series.

A Fourier series (34)-(36) is repeated; it begins and ends at rest, by itself or by a run-in and a run-out.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import factorial, perm

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from cases.base.units import Array
from identification.motion.motion import Motion


@dataclass(frozen=True, slots=True)
class PolynomialMotion:
    """Polynomials sum_i c_i t^i one after the other, each on a clock of its own.

    Raises ValueError without any, for a duration that is not positive, or a gap between two of them.
    """

    table: Array  # c_i of each, shape (degree + 1, pieces, n) [m or rad over powers of seconds]
    durations: Array  # shape (pieces,) [s]
    times: Array = field(init=False, repr=False, compare=False)
    """Start of each piece and end of the last, shape (pieces + 1,) [s]."""

    def __post_init__(self) -> None:
        if not len(self.durations) or not np.all(self.durations > 0.0):
            raise ValueError("a motion of polynomials needs pieces of positive duration")
        object.__setattr__(self, "times", np.concatenate([[0.0], np.cumsum(self.durations)]))
        if np.max(np.abs(self.at_ends(0)[:-1] - self.table[0, 1:]), initial=0.0) > 1e-9:
            raise ValueError("a polynomial piece does not begin where the one before it ends")

    @classmethod
    def of_pieces(cls, pieces: Iterable[tuple[Array, float]]) -> "PolynomialMotion":
        """From c_0 to c_d, shape (d + 1, n), and duration [s] of each, whatever their degrees."""
        coefficients, durations = zip(*pieces, strict=True)
        most = max(map(len, coefficients))
        table = [np.pad(piece, ((0, most - len(piece)), (0, 0))) for piece in coefficients]
        return cls(np.stack(table, axis=1), np.array(durations))

    def at_starts(self, order: int) -> Array:
        """Derivative of an order at the start of each piece, shape (pieces, n)."""
        return factorial(order) * self.table[order] if order < len(self.table) else np.zeros_like(self.table[0])

    def at_ends(self, order: int) -> Array:
        """Derivative of an order at the end of each piece, shape (pieces, n)."""
        duration = self.durations[:, None]
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
        powers = speed ** np.arange(len(self.table))
        return PolynomialMotion(self.table * powers[:, None, None], self.durations / speed)

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        starts = self.times
        indices = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, len(self.durations) - 1)
        local = np.clip(time - starts[indices], 0.0, np.diff(starts)[indices])[:, None]
        table = self.table
        values = np.zeros((4, len(time), self.table.shape[2]))
        for order in range(4):
            for coefficient in table[::-1]:  # Horner's rule
                values[order] = values[order] * local + coefficient[indices]
            table = table[1:] * np.arange(1, len(table))[:, None, None]
        return Motion(time, *values)


@dataclass(frozen=True, slots=True)
class Tabulated:
    """Rows of pose, rates and accelerations at equal steps, from rest to rest; ValueError for other shapes.

    Between rows the pose is the cubic that shares pose and rates with both; rates and accelerations, which a table
    states for themselves, go straight from row to row. Jerks are the slopes of accelerations.
    """

    times: Array  # shape (k,), equal steps from 0 [s]
    coordinates: Array  # shape (k, n) [m or rad]
    rates: Array  # shape (k, n) [m/s or rad/s]
    accelerations: Array  # shape (k, n) [m/s^2 or rad/s^2]

    def __post_init__(self) -> None:
        shape = (len(self.times), *self.coordinates.shape[1:2])
        if len(self.times) < 2 or any(v.shape != shape for v in (self.coordinates, self.rates, self.accelerations)):
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
        start, end = self.coordinates[k], self.coordinates[k + 1]
        pose = start * (1 + 2 * p) * (1 - p) ** 2 + end * p**2 * (3 - 2 * p)
        pose += step * p * (1 - p) * (self.rates[k] * (1 - p) - self.rates[k + 1] * p)
        rates = self.rates[k] * (1 - p) + self.rates[k + 1] * p
        accelerations = self.accelerations[k] * (1 - p) + self.accelerations[k + 1] * p
        jerks = (self.accelerations[k + 1] - self.accelerations[k]) / step
        return Motion(time, pose, rates, accelerations, np.ascontiguousarray(jerks))


@dataclass(frozen=True, slots=True)
class FourierMotion:
    """A Fourier-series motion, repeated a whole number of times."""

    centre: Array  # x0 of (34), shape (n,) [m or rad]
    a: Array  # sine coefficients of (34), shape (N, n) [m/s or rad/s]
    b: Array  # cosine coefficients of (34), shape (N, n) [m/s or rad/s]
    period: float  # 2 pi / w [s]
    repeats: int  # number of periods
    # time from rest at x0 into the series, and again out of it [s]; 0 for a series that is at rest itself
    run_in: float = 0.0

    @property
    def order(self) -> int:
        """N of (34)."""
        return len(self.a)

    @property
    def duration(self) -> float:
        """Duration of all periods, and of the run-in and run-out [s]."""
        return self.period * self.repeats + 2 * self.run_in

    def slowed(self, speed: float) -> "FourierMotion":
        """The same path at a share of the speed."""
        return FourierMotion(
            self.centre, self.a * speed, self.b * speed, self.period / speed, self.repeats, self.run_in / speed
        )

    def at(self, t: ArrayLike) -> Motion:
        r"""(34), (35), (36) and the third derivative at times t, shape (n,) [s].

        .. math::
            x = x_0 + \sum_{l=1}^{N} \frac{a_l}{w l} \sin w l t - \frac{b_l}{w l} \cos w l t, \qquad
            \dot{x} = \sum_{l=1}^{N} a_l \cos w l t + b_l \sin w l t, \qquad
            \ddot{x} = \sum_{l=1}^{N} -a_l w l \sin w l t + b_l w l \cos w l t

        with t from the end of the run-in on.
        """
        time = np.asarray(t, dtype=float)
        series = self._series(time - self.run_in)
        if self.run_in == 0.0:
            return series
        fields = [values.copy() for values in (series.coordinates, series.rates, series.accelerations, series.jerks)]
        begin = self._series(np.zeros(1))
        state = np.vstack([begin.coordinates - self.centre, begin.rates, begin.accelerations])
        last = self.duration - self.run_in
        before, after = time < self.run_in, time > last
        for rows, matrices in (
            (before, run_in(time[before], self.run_in)),
            (after, run_out(time[after] - last, self.run_in)),
        ):
            for order, matrix in enumerate(matrices):
                fields[order][rows] = matrix @ state + (self.centre if order == 0 else 0.0)
        return Motion(time, *fields)

    def _series(self, time: Array) -> Motion:
        w = 2 * np.pi / self.period * np.arange(1, self.order + 1)
        sine, cosine = np.sin(time[:, None] * w), np.cos(time[:, None] * w)
        pose = self.centre + sine @ (self.a / w[:, None]) - cosine @ (self.b / w[:, None])
        rates = cosine @ self.a + sine @ self.b
        accelerations = -sine @ (self.a * w[:, None]) + cosine @ (self.b * w[:, None])
        jerks = -cosine @ (self.a * w[:, None] ** 2) - sine @ (self.b * w[:, None] ** 2)
        return Motion(time, pose, rates, accelerations, jerks)


# Over the share s of the time, from rest: to a way, a rate, an acceleration of 1 at s = 1, each alone.
_TO_WAY = Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
_TO_RATE = Polynomial([0.0, 0.0, 0.0, -4.0, 7.0, -3.0])
_TO_ACCELERATION = Polynomial([0.0, 0.0, 0.0, 0.5, -1.0, 0.5])


def run_in(time: Array, duration: float) -> tuple[Array, Array, Array, Array]:
    """Quintic run-in: matrices from the state reached (way, rate, acceleration) to value, rate, acceleration and jerk.

    A series of one harmonic never rests: its rate and acceleration have no common zero. With run-in and run-out it has
    no other harmonic than its own while it runs. Four matrices of shape (n, 3), at times after the start out of rest,
    shape (n,) [s], from 0 to the duration [s].
    """
    share = time / duration
    shapes = ((_TO_WAY, 1.0), (_TO_RATE, duration), (_TO_ACCELERATION, duration**2))
    value, rate, acceleration, jerk = (
        np.column_stack([p.deriv(order)(share) * unit if order else p(share) * unit for p, unit in shapes])
        / duration**order
        for order in range(4)
    )
    return value, rate, acceleration, jerk


def run_out(time: Array, duration: float) -> tuple[Array, Array, Array, Array]:
    """The same from the state back to rest, `time` after leaving it: a run-in with time reversed."""
    mirror = np.array([1.0, -1.0, 1.0])
    value, rate, acceleration, jerk = (
        matrix * mirror * (-1.0) ** order for order, matrix in enumerate(run_in(duration - time, duration))
    )
    return value, rate, acceleration, jerk
