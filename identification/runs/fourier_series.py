"""Fourier series of sampled signals: by least squares, differentiated analytically, and the period that fits best."""

from typing import NamedTuple

import numpy as np

from cases.units import Array

CHUNK = 8192  # samples at a time: memory does not grow with the run
REFINEMENTS = 20
SETTLED = 1e-10  # of the period


class FourierSeries(NamedTuple):
    """A periodic signal."""

    coefficients: Array  # c_0, a_1, b_1, a_2, .., shape (2 H + 1, channels)
    period: float  # [s]
    start: float  # instant of phase 0 [s]

    @property
    def harmonics(self) -> int:
        """H."""
        return (len(self.coefficients) - 1) // 2

    @property
    def omega(self) -> float:
        """Angular frequency of the first harmonic [1/s]."""
        return 2.0 * np.pi / self.period

    @property
    def power(self) -> Array:
        """a_h^2 + b_h^2 of harmonics 1 to H, shape (H, channels)."""
        return np.asarray(self.coefficients[1::2] ** 2 + self.coefficients[2::2] ** 2)

    def at(self, t: Array, order: int = 0) -> Array:
        """The signal or a time derivative of it, analytically.

        Args:
            t: instants, shape (n,) [s].
            order: order of the derivative, 0, 1, 2, ..

        Returns:
            Shape (n, channels).
        """
        scale = np.repeat((np.arange(1, self.harmonics + 1) * self.omega) ** order, 2)
        scaled = np.vstack([self.coefficients[:1] * (order == 0), self.coefficients[1:] * scale[:, None]])
        result = np.empty((len(t), self.coefficients.shape[1]))
        for first in range(0, len(t), CHUNK):
            part = slice(first, first + CHUNK)
            result[part] = basis(t[part] - self.start, self.period, self.harmonics, order) @ scaled
        return result

    def truncated(self, harmonics: int) -> "FourierSeries":
        """The series up to a harmonic."""
        return self._replace(coefficients=self.coefficients[: 2 * harmonics + 1])


def basis(t: Array, period: float, harmonics: int, quarter_turns: int = 0) -> Array:
    """1, cos wt, sin wt, cos 2wt, .., each oscillation advanced by quarter turns, shape (n, 2 H + 1)."""
    angle = np.outer(2.0 * np.pi / period * t, np.arange(1, harmonics + 1)) + quarter_turns * np.pi / 2.0
    columns = np.empty((len(t), 2 * harmonics + 1))
    columns[:, 0] = 1.0
    columns[:, 1::2], columns[:, 2::2] = np.cos(angle), np.sin(angle)
    return columns


def fit_series(t: Array, values: Array, period: float, start: float, harmonics: int) -> FourierSeries:
    """The series of least squares.

    Args:
        t: instants, shape (n,) [s], over about a whole number of periods: the normal equations are well conditioned
            only there.
        values: shape (n, channels).
        period: [s].
        start: instant of phase 0 [s].
        harmonics: H; at least 2 H + 1 samples are needed.

    Raises:
        ValueError: fewer samples than coefficients.
    """
    count = 2 * harmonics + 1
    if len(t) < count:
        raise ValueError(f"{len(t)} samples are too few for {harmonics} harmonics")
    mean = values.mean(axis=0)  # against rounding: struts of a metre oscillate by some centimetres
    gram, right = np.zeros((count, count)), np.zeros((count, values.shape[1]))
    for first in range(0, len(t), CHUNK):
        part = slice(first, first + CHUNK)
        columns = basis(t[part] - start, period, harmonics)
        gram += columns.T @ columns
        right += columns.T @ (values[part] - mean)
    coefficients: Array = np.asarray(np.linalg.solve(gram, right), dtype=np.float64)
    coefficients[0] += mean
    return FourierSeries(coefficients, period, start)


def refined_period(t: Array, values: Array, period: float, harmonics: int) -> float:
    """The period whose series fits best [s], by Gauss-Newton over it with the coefficients projected out.

    Args:
        t: instants, shape (n,) [s], over two periods or more.
        values: shape (n, channels), of like size.
        period: period to start from, off by less than a quarter of the shortest oscillation over the whole run [s].
        harmonics: H.
    """
    start, span = float(t[0]), float(t[-1] - t[0])
    for _ in range(REFINEMENTS):
        series = fit_series(t, values, period, start, harmonics)
        residuals = values - series.at(t)
        slope = -(t - start)[:, None] / period * series.at(t, 1)  # of the series, with the period
        slope -= fit_series(t, slope, period, start, harmonics).at(t)
        most = 0.02 * period**2 / span  # a fiftieth of a period over the run: no leap to another minimum
        step = float(np.clip(np.sum(slope * residuals) / max(np.sum(slope**2), np.finfo(float).tiny), -most, most))
        period += step
        if abs(step) < SETTLED * period:
            break
    return period
