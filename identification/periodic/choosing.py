"""What of a repeating run is averaged: which rows, the periods that are like the others, the harmonics that tell."""

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft
from scipy.special import chdtri

from cases.errors import RecordingError
from identification.finding import Finding, Kind, warning
from identification.findings.plausibility import places
from identification.periodic.fourier import FourierSeries
from identification.periodic.periods import PeriodScatter, strangers
from identification.recording import Recording

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

FEWEST = 2  # harmonics
MEDIAN_POWER = float(chdtri(12, 0.5)) / 12.0  # over the mean, of a harmonic of six struts


def longest_window(recording: Recording) -> NDArray[np.int64]:
    """Consecutive rows to look at, shape (m,): the longest time that the trigger is on; without a trigger all of them.

    Raises:
        RecordingError: the trigger is never on.
    """
    if recording.trigger is None:
        return np.arange(len(recording.forces))
    edges = np.flatnonzero(np.diff(np.r_[False, recording.trigger, False].astype(np.int8)))
    if not len(edges):
        raise RecordingError(f"{recording.source}, trigger: is never 1; record with the trigger or leave it out")
    longest = int(np.argmax(edges[1::2] - edges[::2]))
    return np.arange(edges[2 * longest], edges[2 * longest + 1])


def kept_periods(recording: Recording, periods: PeriodScatter, bad: Rows) -> tuple[list[int], tuple[Finding, ...]]:
    """Numbers of the periods that are averaged, and what is to be said of the others.

    Args:
        recording: gives the names of rows.
        periods: all of them.
        bad: samples that may not be used, shape (n of the recording,).

    Raises:
        RecordingError: every period has some.
    """
    count = len(periods.rows)
    sound = [k for k in range(count) if not bad[periods.rows[k]].any()]
    if not sound:
        raise RecordingError(f"{recording.source}: every one of the {count} periods has samples left out")
    found = strangers(periods.only(sound))
    strange = {sound[k]: size for k, size in found.items()}
    warnings: tuple[Finding, ...] = ()
    if len(strange) > len(sound) / 2:
        most = max(strange.values())
        warnings = (
            warning(
                Kind.DAMAGE, f"forces of {len(strange)} of {count} periods differ by up to {most:.3g} N; all are used"
            ),
        )
        strange = {}
    for k in range(count):
        if k in strange or k not in sound:
            why = f"differs from the others by up to {strange[k]:.3g} N" if k in strange else "has bad samples"
            rows = np.zeros(len(bad), dtype=bool)
            rows[periods.rows[k]] = True
            warnings += (
                warning(Kind.DAMAGE, f"period {k + 1} of {count} {why}; left out", places(recording.lines, rows)),
            )
    return [k for k in sound if k not in strange], warnings


def telling_harmonics(motion: FourierSeries, periods: PeriodScatter, t: Array, struts: Array) -> int:
    """The number of harmonics whose accelerations come closest to the true ones (Mallows 1973, Technometrics 15:661).

    A harmonic is worth its place if it is larger than its own noise: noise of accelerations grows with the square of
    the frequency, and the struts' spectrum falls.

    Args:
        motion: series of all harmonics that may be used.
        periods: the same, period by period.
        t: time of the recording, shape (n,) [s].
        struts: of the recording, shape (n, 6) [m].
    """
    count = len(periods.series)
    floor = _floor(motion, periods, t, struts)
    if count > 1:
        scatter = np.diagonal(periods.smoothed(motion.harmonics, 2), axis1=1, axis2=2).real.sum(axis=1)[1:]
        # Steps of encoders repeat with the motion; what does not repeat has been counted already.
        noise = scatter + max(0.0, floor - count * float(np.median(scatter)))
    else:
        noise = np.full(motion.harmonics, floor)
    gain = (motion.power.sum(axis=1) - 2.0 * noise) * np.arange(1, motion.harmonics + 1) ** 4.0
    return max(FEWEST, int(np.argmax(np.cumsum(gain))) + 1)


def _floor(motion: FourierSeries, periods: PeriodScatter, t: Array, struts: Array) -> float:
    """Power of a harmonic of one period by white noise [m^2]: from half of the Nyquist frequency on nothing moves."""
    power = []
    for rows in periods.rows:
        spectrum = 2.0 / len(rows) * rfft(struts[rows] - motion.at(t[rows]), axis=0)
        power.append(np.median(np.sum(np.abs(spectrum[len(rows) // 4 : (len(rows) - 1) // 2]) ** 2, axis=1)))
    return float(np.mean(power)) / MEDIAN_POWER
