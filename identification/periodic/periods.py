"""What differs between the periods of a run that repeats itself: its noise, and periods that are no part of it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from identification.periodic.finding import Part
from identification.periodic.fourier import FourierSeries, fit_series

Array = NDArray[np.float64]

INDEPENDENT = 24  # complex values that a spectral matrix of six channels is averaged over
STRANGE = 8.0  # standard deviations of the periods' scatter, anywhere in a period, that noise never reaches
MAJORITY = 3  # periods that tell which of them is strange


class PeriodScatter(NamedTuple):
    """A signal, period by period.

    Args:
        series: one of each period, all with the same phase.
        rows: samples of each.
    """

    series: tuple[FourierSeries, ...]
    rows: tuple[NDArray[np.int64], ...]

    def only(self, kept: Sequence[int]) -> "PeriodScatter":
        """Some of the periods."""
        return PeriodScatter(tuple(self.series[k] for k in kept), tuple(self.rows[k] for k in kept))

    def smoothed(self, harmonics: int, points: int) -> NDArray[np.complex128]:
        """Spectral matrices of the noise of the mean period, averaged over neighbouring harmonics.

        Args:
            harmonics: as many are wanted beside the constant.
            points: length of the discrete Fourier transform whose values they are the covariances of.

        Returns:
            Shape (harmonics + 1, channels, channels), Hermitian.
        """
        count = len(self.series)
        coefficients = np.array([s.coefficients for s in self.series])
        values = points * (coefficients[:, 1::2] - 1j * coefficients[:, 2::2]) / 2.0
        values = np.concatenate([points * coefficients[:, :1].astype(complex), values], axis=1)
        away = values - values.mean(axis=0)
        raw = np.einsum("khi,khj->hij", away, away.conj()) / (count * (count - 1))
        beside = int(np.ceil((INDEPENDENT / (count - 1) - 1) / 2))
        total = np.concatenate([np.zeros((1, *raw.shape[1:])), np.cumsum(raw, axis=0)])
        h = np.arange(harmonics + 1)
        first, end = np.maximum(h - beside, 0), np.minimum(h + beside + 1, len(raw))
        return np.asarray((total[end] - total[first]) / (end - first)[:, None, None])

    def covariance(self, harmonics: int) -> Array:
        """What does not repeat, up to a harmonic, as covariance of white noise, shape (channels, channels)."""
        samples = sum(len(rows) for rows in self.rows)
        return np.asarray(self.smoothed(harmonics, 1).real.mean(axis=0) * samples)


def each_period(t: Array, values: Array, part: Part, harmonics: int) -> PeriodScatter:
    """The series of each period.

    Args:
        t: time of all samples, shape (n,) [s].
        values: shape (n, channels).
        part: that repeats.
        harmonics: of each series; less than half of the samples of a period.
    """
    start = float(t[part.first])
    inside = np.arange(part.first, part.end)
    number = np.clip(((t[inside] - start) / part.period + 1e-9).astype(np.int64), 0, part.periods - 1)
    rows = tuple(inside[number == k] for k in range(part.periods))
    series = tuple(fit_series(t[r], values[r], part.period, start, harmonics) for r in rows)
    return PeriodScatter(series, rows)


def strangers(periods: PeriodScatter) -> dict[int, float]:
    """Periods that differ from the others by more than noise: contact, a start that has not died out.

    Returns:
        By number from 0 the largest difference to the median of all periods; empty where fewer than three tell.
    """
    count = len(periods.series)
    if count < MAJORITY:
        return {}
    one = periods.series[0]
    t = one.start + one.period * np.arange(2 * one.harmonics + 1) / (2 * one.harmonics + 1)
    values = np.array([s.at(t) for s in periods.series])
    # The median over the period of the variances between periods: a contact moves few of them.
    spread = np.median(values.var(axis=0, ddof=1), axis=0)
    spread *= (count - 1) / float(chdtri(count - 1, 0.5))
    away = np.abs(values - np.median(values, axis=0))
    least = np.maximum(np.sqrt(spread), 1e-9 * np.abs(values).max(axis=(0, 1)))
    strange = np.flatnonzero((away > STRANGE * least).any(axis=(1, 2)))
    return {int(k): float(away[k].max()) for k in strange}
