"""What of a repeating run is averaged: which rows, the periods that are like the others, the harmonics above the noise.

What differs between periods is noise.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft
from scipy.special import chdtri

from cases.errors import RecordingError
from cases.units import Array, Flags, Indices
from identification.finding import Finding, Kind, warning
from identification.recording import Recording
from identification.runs.fourier_series import FourierSeries, basis, fit_series
from identification.runs.repeating import RepeatingPart
from identification.runs.sample_checks import places

INDEPENDENT = 24  # complex values that a spectral matrix of six channels is averaged over
STRANGE = 8.0  # standard deviations of the periods' scatter, anywhere in a period, that noise never reaches
MAJORITY = 3  # periods that are needed to say which of them is strange


def rows_of_periods(t: Array, part: RepeatingPart) -> list[Indices]:
    """Samples of each period, counted from the first of all samples, whose times are t, shape (n,) [s]."""
    inside = np.arange(part.first, part.end)
    number = ((t[inside] - t[part.first]) / part.period + 1e-9).astype(np.int64)
    number = np.clip(number, 0, part.periods - 1)
    return [inside[number == k] for k in range(part.periods)]


def each_period(t: Array, values: Array, periods: Sequence[Indices], part: RepeatingPart, harmonics: int) -> Array:
    """Coefficients of the Fourier series of each period, all with the same phase, shape (periods, 2 H + 1, channels).

    Args:
        t: time of all samples, shape (n,) [s].
        values: shape (n, channels).
        periods: samples of each.
        part: part that repeats.
        harmonics: H; less than half of the samples of a period.
    """
    start = float(t[part.first])
    return np.array([fit_series(t[r], values[r], part.period, start, harmonics).coefficients for r in periods])


def noise_spectra(periods: Array, harmonics: int, points: int) -> NDArray[np.complex128]:
    """Spectral matrices of the noise of the mean period, averaged over neighbouring harmonics.

    Args:
        periods: coefficients of each period, as of `each_period`.
        points: length of the discrete Fourier transform whose values they are the covariances of.

    Returns:
        Shape (harmonics + 1, channels, channels), Hermitian.
    """
    count = len(periods)
    values = points * (periods[:, 1::2] - 1j * periods[:, 2::2]) / 2.0
    values = np.concatenate([points * periods[:, :1].astype(complex), values], axis=1)
    deviations = values - values.mean(axis=0)
    raw = np.einsum("khi,khj->hij", deviations, deviations.conj()) / (count * (count - 1))
    beside = int(np.ceil((INDEPENDENT / (count - 1) - 1) / 2))
    total = np.concatenate([np.zeros((1, *raw.shape[1:])), np.cumsum(raw, axis=0)])
    h = np.arange(harmonics + 1)
    first, end = np.maximum(h - beside, 0), np.minimum(h + beside + 1, len(raw))
    return np.asarray((total[end] - total[first]) / (end - first)[:, None, None])


def strangers(periods: Array) -> dict[int, float]:
    """Periods that differ from the others by more than noise: contact, a transient of the start.

    Args:
        periods: coefficients of each period, as of `each_period`.

    Returns:
        By number from 0 the largest difference to the median of all periods; empty for fewer than three periods.
    """
    count, points, _ = periods.shape
    if count < MAJORITY:
        return {}
    values = basis(np.arange(points) / points, 1.0, points // 2) @ periods
    # The median over the period of the variances between periods: a contact moves few of them.
    spread = np.median(values.var(axis=0, ddof=1), axis=0)
    spread *= (count - 1) / float(chdtri(count - 1, 0.5))
    deviations = np.abs(values - np.median(values, axis=0))
    least = np.maximum(np.sqrt(spread), 1e-9 * np.abs(values).max(axis=(0, 1)))
    strange = np.flatnonzero((deviations > STRANGE * least).any(axis=(1, 2)))
    return {int(k): float(deviations[k].max()) for k in strange}


FEWEST = 2  # harmonics
MEDIAN_POWER = float(chdtri(12, 0.5)) / 12.0  # over the mean, of a harmonic of six struts


def kept_periods(
    recording: Recording, periods: Sequence[Indices], forces: Array, bad: Flags
) -> tuple[list[int], tuple[Finding, ...]]:
    """Numbers of the periods that are averaged, and findings about the others.

    Args:
        periods: samples of each.
        forces: coefficients of their forces, as of `each_period`.
        bad: samples that may not be used, shape (n of the recording,).

    Raises:
        RecordingError: every period has some of these.
    """
    count = len(periods)
    sound = [k for k in range(count) if not bad[periods[k]].any()]
    if not sound:
        raise RecordingError(recording.source, f"every one of the {count} periods has samples left out")
    strange = {sound[k]: size for k, size in strangers(forces[sound]).items()}
    warnings = []
    if len(strange) > len(sound) / 2:
        sentence = f"forces of {len(strange)} of {count} periods differ by up to {max(strange.values()):.3g} N"
        warnings, strange = [warning(Kind.DAMAGE, f"{sentence}; all are used")], {}
    kept = [k for k in sound if k not in strange]
    for k in sorted({*range(count)} - {*kept}):
        reason = f"differs from the others by up to {strange[k]:.3g} N" if k in strange else "has bad samples"
        rows = np.zeros(len(bad), dtype=bool)
        rows[periods[k]] = True
        where = places(recording.lines, rows)
        warnings.append(warning(Kind.DAMAGE, f"period {k + 1} of {count} {reason}; left out", where))
    return kept, tuple(warnings)


def telling_harmonics(
    motion: FourierSeries, scatter: Array, periods: Sequence[Indices], t: Array, struts: Array
) -> int:
    """The number of harmonics whose accelerations come closest to the true ones (Mallows 1973, Technometrics 15:661).

    A harmonic is worth its place if it is larger than its own noise: noise of accelerations grows with the square of
    the frequency, and the struts' spectrum falls.

    Args:
        motion: series of all harmonics that may be used.
        scatter: coefficients of each period, as of `each_period`.
        periods: samples of each.
        t: time of the recording, shape (n,) [s].
        struts: struts of the recording, shape (n, 6) [m].
    """
    # power of a harmonic of one period by white noise: from half of the Nyquist frequency on nothing moves
    powers = []
    for rows in periods:
        spectrum = 2.0 / len(rows) * rfft(struts[rows] - motion.at(t[rows]), axis=0)
        powers.append(np.median(np.sum(np.abs(spectrum[len(rows) // 4 : (len(rows) - 1) // 2]) ** 2, axis=1)))
    count, floor = len(periods), float(np.mean(powers)) / MEDIAN_POWER
    if count > 1:
        noise = np.trace(noise_spectra(scatter, motion.harmonics, 2), axis1=1, axis2=2).real[1:]
        # Steps of encoders repeat with the motion; what does not repeat has been counted already.
        noise = noise + max(0.0, floor - count * float(np.median(noise)))
    else:
        noise = np.full(motion.harmonics, floor)
    gain = (motion.power.sum(axis=1) - 2.0 * noise) * np.arange(1, motion.harmonics + 1) ** 4.0
    return max(FEWEST, int(np.argmax(np.cumsum(gain))) + 1)
