"""A motion along a periodic Fourier series (34)-(36), repeated, at rest itself or led in and out of."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike, NDArray

from identification.motion import Motion

Array = NDArray[np.float64]


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

    def at(self, t: ArrayLike) -> Motion:
        """(34), (35), (36) and the third derivative at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        series = self._series(time - self.run_in)
        if self.run_in == 0.0:
            return series
        begin = self._series(np.zeros(1))
        state = np.vstack([begin.pose - self.centre, begin.rates, begin.accelerations])
        fields = [v.copy() for v in (series.pose, series.rates, series.accelerations, series.jerks)]
        last = self.duration - self.run_in
        for rows, matrices in (
            (time < self.run_in, run_in(time[time < self.run_in], self.run_in)),
            (time > last, run_out(time[time > last] - last, self.run_in)),
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


NEGLIGIBLE = 0.02  # of the largest amplitude; a harmonic below adds nothing that can be measured


def needless_harmonics(motion: FourierMotion) -> int:
    """Number of highest harmonics whose rates are negligible beside the largest, in every coordinate."""
    amplitude = np.hypot(motion.a, motion.b)
    share = (amplitude / np.maximum(amplitude.max(axis=0), 1e-300)).max(axis=1)
    return int(np.argmax(share[::-1] > NEGLIGIBLE))


# Over the share s of the time, from rest: to a way, a rate, an acceleration of 1 at s = 1, each alone.
_TO_WAY = Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
_TO_RATE = Polynomial([0.0, 0.0, 0.0, -4.0, 7.0, -3.0])
_TO_ACCELERATION = Polynomial([0.0, 0.0, 0.0, 0.5, -1.0, 0.5])


def run_in(time: Array, duration: float) -> tuple[Array, Array, Array, Array]:
    """Quintic run-in: matrices from the state reached (way, rate, acceleration) to value, rate, acceleration and jerk.

    A series of one harmonic never rests: its rate and acceleration have no common zero. It is led in and out of, and
    so carries nothing but its own harmonic while it runs.

    Args:
        time: time after the start out of rest, shape (n,) [s], from 0 to duration.
        duration: [s].

    Returns:
        Four matrices of shape (n, 3).
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
