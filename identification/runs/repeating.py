"""Whether and where a run repeats itself: its period, estimated or given, and the part that it holds for.

Each lag is rated by the longest stretch over which the struts are where they were that lag before, so that approach,
return and rests do no harm; a lag is a period if the stretch is as long, and if less than the lag is not alike too.
"""

from typing import NamedTuple

import numpy as np

from cases.errors import RecordingError
from cases.units import Array, Indices
from identification.runs.fourier_series import refined_period
from identification.signals import stretches

TOLERATED = 0.01  # of the motion's rms: struts a period later; controllers repeat themselves to a thousandth
COARSE = 0.05  # the same before the period is known to fractions of a sample
USUAL = 4.0  # times the usual misfit, that the ends of the part may have
LEAST = 2e-4  # of the motion's rms, that they may have in any case
MOST_ROWS = 2000  # on which lags are compared
RISEN = 0.3  # of the motion's rms, by which parts of a period must differ: small lags are always alike
PARTS_OF_LAG = (0.25, 1 / 3, 0.5, 2 / 3)  # at which that is looked for
SHORT = 0.02  # of a period: windows that follow the movement lose the slow beginning and end
WHOLE = 0.005  # of a period, that may lack at the whole,
FEW = 2  # and so many samples
SEARCHED = 20  # harmonics by which the period is refined
AS_LONG = 0.9  # of the longest stretch; among lags that reach it the shortest is the period


REMEDY = "leave --period out, or give --period SECONDS where the run holds a single one"


class RepeatingPart(NamedTuple):
    """The periodic part of a run."""

    period: float  # [s]
    first: int  # first row
    end: int  # row behind the last
    periods: int  # how many it holds, at least 1
    misfit: float  # rms difference of the struts a period later [m]; of one period: between its ends
    motion: float  # rms of the struts about their means [m]

    @property
    def relative(self) -> float:
        """Misfit over motion."""
        return self.misfit / self.motion


def find_part(t: Array, struts: Array, window: Indices) -> RepeatingPart:
    """The period and the part of the run that it holds for: at least two periods of it.

    Args:
        t: equal steps, shape (n,) [s].
        struts: shape (n, 6) [m].
        window: consecutive rows to look at, shape (k,).

    Raises:
        RecordingError: it does not repeat; the message says by how much the best period misses.
    """
    x = struts[window] - struts[window].mean(axis=0)
    motion = float(np.sqrt(np.mean(x**2)))
    step = float(t[-1] - t[0]) / (len(t) - 1)
    best: RepeatingPart | None = None
    for lag in _lags(x, motion):
        first, end = _longest(x, lag, COARSE * motion)
        if end - first < (1.0 - SHORT) * lag:
            continue
        rows = window[first : end + lag]
        period = refined_period(t[rows], struts[rows], lag * step, min(SEARCHED, lag // 4))
        part = _part(t, struts, rows, period, motion)
        if part.relative <= TOLERATED:
            rows = np.arange(part.first, part.end)
            period = refined_period(t[rows], struts[rows], part.period, min(SEARCHED, lag // 4))
            deviations = _a_period_later(t, struts, rows, period)
            return part._replace(
                period=period, misfit=float(np.sqrt(np.mean(deviations**2))) if len(deviations) else part.misfit
            )
        best = part if best is None or part.relative < best.relative else best
    raise RecordingError(_refusal(x, step, motion, best))


def given_part(t: Array, struts: Array, window: Indices, period: float) -> RepeatingPart:
    """The part of the run that a period holds for: one period may be all there is, if it ends where it begins.

    Args:
        t: equal steps, shape (n,) [s].
        struts: shape (n, 6) [m].
        window: consecutive rows to look at, shape (k,).
        period: [s].

    Raises:
        RecordingError: the run is shorter, or does not repeat with it.
    """
    step = float(t[-1] - t[0]) / (len(t) - 1)
    span = len(window) * step
    if not 8.0 * step < period <= span * (1.0 + WHOLE):
        raise RecordingError(
            f"--period {period:g}",
            f"the motion is sampled for {span:.4g} s every {step * 1e3:.3g} ms; give a period of "
            "one to many samples that fits into it",
        )
    x = struts[window] - struts[window].mean(axis=0)
    motion = float(np.sqrt(np.mean(x**2)))
    lag = round(period / step)
    part = _part(t, struts, window, period, motion)
    if lag < len(window):
        first, end = _longest(x, lag, COARSE * motion)
        # Where less than two periods were recorded, the end of one must be its beginning.
        if end - first >= (lag * (1.0 - SHORT) if lag < len(window) * (0.5 + SHORT) else 1):
            part = _part(t, struts, window[first : end + lag], period, motion)
    if part.relative <= TOLERATED:
        return part
    try:
        best = f"; what repeats has a period of {find_part(t, struts, window).period:.6g} s"
    except RecordingError:
        best = ""
    text = "a period later the struts are" if part.periods > 1 else "at its ends the struts are"
    raise RecordingError(
        f"--period {period:g}",
        f"{text} {part.misfit * 1e3:.3g} mm rms from where they were, {100 * part.relative:.3g} % "
        f"of their motion, at most {100 * TOLERATED:g} % may be{best}; give another, or leave --period out",
    )


def _lags(x: Array, motion: float) -> list[int]:
    """Lags that may be periods: of those with the longest part of the run the shortest first."""
    every = max(1, len(x) // MOST_ROWS)
    coarse = x[::every]
    tolerance = COARSE * motion + float(np.sqrt(np.mean(np.diff(coarse, axis=0) ** 2)))
    candidates = []
    for lag in range(4, int(len(coarse) * (0.5 + SHORT)) + 1):
        first, end = _longest(coarse, lag, tolerance)
        if end - first < (1.0 - SHORT) * lag - 1:
            continue
        part = coarse[first : end + lag]
        shifts = [max(1, round(share * lag)) for share in PARTS_OF_LAG]
        if max(_away(part, k) for k in shifts) > (RISEN * motion) ** 2:
            candidates.append((lag, end + lag - first))
    longest = max((length for _, length in candidates), default=0)
    good = np.array([lag for lag, length in candidates if length >= AS_LONG * longest], dtype=np.int64)
    neighbours = np.split(good, np.flatnonzero(np.diff(good) > 1) + 1)
    middles = [int(group[len(group) // 2]) for group in neighbours if len(group)]
    return [_finest(x, lag * every, every, COARSE * motion) for lag in middles]


def _finest(x: Array, lag: int, every: int, tolerance: float) -> int:
    """The lag near a coarse one, in steps of one sample, at which the longest stretch repeats."""
    near = range(max(1, lag - every), min(lag + every, len(x) - 2) + 1)
    return max(near, key=lambda k: (np.subtract(*_longest(x, k, tolerance)[::-1]), -_away(x, k)))


def _away(x: Array, lag: int) -> float:
    return float(np.mean((x[lag:] - x[:-lag]) ** 2))


def _longest(x: Array, lag: int, tolerance: float) -> tuple[int, int]:
    """The longest stretch of rows that are where they were a lag before: first row and the one behind the last."""
    close = np.sqrt(np.mean((x[lag:] - x[: len(x) - lag]) ** 2, axis=1)) < tolerance
    longest = max(stretches(close), key=lambda part: part.stop - part.start, default=slice(0, 0))
    return longest.start, longest.stop


def _part(t: Array, struts: Array, rows: Indices, period: float, motion: float) -> RepeatingPart:
    """The last whole periods of rows; the first ones hold what dies out after the start."""
    step = float(t[-1] - t[0]) / (len(t) - 1)
    deviations = _a_period_later(t, struts, rows, period)
    if not len(deviations):
        ends = struts[rows[-1]] - struts[rows[0]]
        return RepeatingPart(period, int(rows[0]), int(rows[-1]) + 1, 1, float(np.sqrt(np.mean(ends**2))), motion)
    # The motion comes out of rest and to rest slowly; unusual differences at the ends do not belong to it.
    alike = np.flatnonzero(deviations <= max(USUAL * float(np.median(deviations)), LEAST * motion))
    rows = rows[alike[0] : alike[-1] + 1 + len(rows) - len(deviations)]
    periods = max(1, int((len(rows) + FEW) * step / period + WHOLE))
    rows = rows[len(rows) - min(round(periods * period / step), len(rows)) :]
    deviations = _a_period_later(t, struts, rows, period)
    misfit = float(np.sqrt(np.mean(deviations**2))) if len(deviations) else 0.0
    return RepeatingPart(period, int(rows[0]), int(rows[-1]) + 1, periods, misfit, motion)


def _a_period_later(t: Array, struts: Array, rows: Indices, period: float) -> Array:
    """How far the struts are from where they will be a period later, rms over the struts, shape (m,) [m]."""
    inside = t[rows]
    now = inside[inside + period <= inside[-1]]
    if not len(now):
        return np.zeros(0)
    from scipy.interpolate import CubicSpline

    deviations = CubicSpline(inside, struts[rows])(now + period) - struts[rows[: len(now)]]
    return np.asarray(np.sqrt(np.mean(deviations**2, axis=1)))


def _refusal(x: Array, step: float, motion: float, best: RepeatingPart | None) -> str:
    """How far the best period misses, in words."""
    if best is not None:
        period, misfit = best.period, best.misfit
    else:
        every = max(1, len(x) // MOST_ROWS)
        deviations = np.array([_away(x[::every], lag) for lag in range(1, len(x) // every // 2 + 1)])
        first_rise = int(np.argmax(deviations > RISEN * motion**2)) if len(deviations) else 0
        if not len(deviations) or deviations[first_rise] <= RISEN * motion**2:
            return f"not periodic: no part of the motion comes again; {REMEDY}"
        lag = first_rise + int(np.argmin(deviations[first_rise:]))
        period, misfit = (lag + 1) * every * step, float(np.sqrt(deviations[lag]))
    return (
        f"not periodic: after the best period, {period:.4g} s, the struts are {misfit * 1e3:.3g} mm rms from where "
        f"they were, {100 * misfit / motion:.3g} % of their motion, at most {100 * TOLERATED:g} % may be; {REMEDY}"
    )
