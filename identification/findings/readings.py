"""Offsets that drift: within a run, all along a recording, and since a result.

Within a run a straight line in time, or in the temperature that was recorded, is added to each channel and judged by
the deviations that noise with memory leaves it. Afterwards a channel that reads too much all along has drifted, or
something presses on it all along.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.special import stdtrit

from cases.schema import Case
from identification.estimation.biases import DRIFTED
from identification.estimation.compressed import inverse_root, joint_triangle
from identification.estimation.estimators import Method
from identification.estimation.fit import whitened
from identification.findings import Finding, Kind, warning
from identification.fitting import SANDWICHED, Fitted
from identification.recording import Recording
from identification.runs.averaging import PeriodicRun
from identification.samples import Standstills
from identification.signals import fair_part

Array = NDArray[np.float64]

CHANCE = 1e-6  # probability of a drift that is none, in each channel
LEAST_WARMING = 0.2  # [K] within a run, from which on its temperature says more than its time
LEAST_FREEDOM = 4.0  # of a channel, that tell a deviation
STRETCHES = 10  # of a recording, in each of which a channel reads too much
WARM_UP = "let the sensor warm up, and run hexcite tare shortly before its readings count"


def drifting(recording: Recording, case: Case, how: Method, fitted: Fitted) -> list[Finding]:
    """Channels whose offset changes within a run, with the rate and the change over the run."""
    samples = fitted.samples
    freedom = len(fitted.fit.residuals) - fitted.columns.shape[2] / 6 - 1
    if isinstance(samples, PeriodicRun) or how.name not in SANDWICHED or how.priors or freedom < LEAST_FREEDOM:
        return []
    axis, warming = _axis(recording, samples.t)
    if np.ptp(axis) == 0.0:
        return []
    line = (axis - axis.mean()) / np.ptp(axis)
    if isinstance(samples, Standstills):
        line = line * samples.scale
    part = fair_part(len(line))
    if not _likely(*_with_lines(fitted, how, line, part), freedom * len(part) / len(line)):
        return []  # noise with memory makes deviations larger, and takes time
    columns, left, weights = _with_lines(fitted, how, line, np.arange(len(line)))
    change, white = _solved(columns, left, weights, freedom)
    robust = samples.robust_covariance(columns, left - columns @ change, weights, fitted.whitening)
    spread = white if robust is None else np.maximum(white, np.diag(robust.covariance)[-6:])
    # noise that remembers long has so few independent samples that a straight line is no surprise
    most = -stdtrit(np.maximum(freedom * white / spread, 1.0), CHANCE / 2.0)
    sure = np.abs(change[-6:]) / np.sqrt(spread)
    if not np.any(sure > most):
        return []
    return [_told(case, np.asarray(change[-6:]), sure, most, float(np.ptp(axis)), warming, recording.t is not None)]


def _with_lines(fitted: Fitted, how: Method, line: Array, rows: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """A with a line in each channel, residuals and weights of some samples, as an estimator takes them."""
    basis = how.selection(fitted.samples.model).basis
    free = fitted.columns[rows] @ block_diag(basis, np.eye(fitted.columns.shape[2] - len(basis)))
    lines = line[rows, None, None] * np.eye(6)
    columns, left = whitened(fitted.whitening, np.dstack([free, lines]), fitted.fit.residuals[rows])
    return columns, left, fitted.fit.weights if fitted.whitening is None else np.ones(6)


def _solved(columns: Array, left: Array, weights: Array, freedom: float) -> tuple[Array, Array]:
    """How far the values of a fit move with the lines, and the variance of these six by white noise."""
    top = joint_triangle(columns, left, np.sqrt(weights))
    half, change = inverse_root(top[:-1, :-1]), np.linalg.lstsq(top[:-1, :-1], top[:-1, -1], rcond=None)[0]
    covariance = half @ half.T * top[-1, -1] ** 2 / (6.0 * freedom)
    return np.asarray(change), np.diag(covariance)[-6:]


def _likely(columns: Array, left: Array, weights: Array, freedom: float) -> bool:
    """Whether a line is more than white noise makes."""
    change, white = _solved(columns, left, weights, freedom)
    return bool(np.any(np.abs(change[-6:]) > -stdtrit(freedom, CHANCE / 2.0) * np.sqrt(white)))


def _axis(recording: Recording, t: Array) -> tuple[Array, bool]:
    """What offsets may go with, at the evaluated samples, and whether that is the temperature."""
    if recording.temperature is None:
        return t, False
    own = np.arange(1.0, len(recording.temperature) + 1.0) if recording.t is None else recording.t
    temperature = np.interp(t, own, recording.temperature)
    return (temperature, True) if np.ptp(temperature) >= LEAST_WARMING else (t, False)


def _told(
    case: Case, change: Array, sure: Array, most: Array, span: float, warming: bool, clocked: bool
) -> Finding:  # fmt: skip
    worst = int(np.argmax(sure / most))
    channel, unit = _channel(case, worst)
    by = float(change[worst])
    if warming:
        rate, over = f"{by / span:+.2g} {unit}/K", f"the {span:.2g} K of this run"
    elif clocked:
        rate, over = f"{60.0 * by / span:+.2g} {unit} a minute", f"the {span:.3g} s of this run"
    else:
        rate, over = f"{by / span:+.2g} {unit} from standstill to standstill", f"these {round(span) + 1}"
    others = [_channel(case, k)[0] for k in np.flatnonzero(sure > most).tolist() if k != worst]
    more = f"; {', '.join(others)} too" if others else ""
    told = (
        f"the offset of {channel} drifts by {rate}, {by:+.2g} {unit} over {over} ({sure[worst]:.0f} standard "
        f"deviations){more}: the result has the mean; {WARM_UP}"
    )
    drift = {"channel": channel, "change": by, "standard_deviations": float(sure[worst]), "span": span, "unit": unit,
             "with": "temperature" if warming else "time"}  # fmt: skip
    return warning(Kind.OFFSETS, told, offset_drift=drift)


def shifted_all_along(residuals: Array, variance: Array, case: Case) -> list[str]:
    """What to say where a channel reads more, or less, than a result expects in every part of a recording.

    Args:
        residuals: measured less expected, in the order of time, shape (n, 6) [N, or N and N m].
        variance: variance of the result's offsets, shape (6,).
    """
    if len(residuals) < STRETCHES:
        return []
    means = np.array([part.mean(axis=0) for part in np.array_split(residuals, STRETCHES)])
    std = np.sqrt(variance + means.var(axis=0, ddof=1))
    one_way = np.abs(np.sign(means).sum(axis=0)) == STRETCHES
    least = np.where(one_way, np.abs(means).min(axis=0), 0.0) / np.maximum(std, np.finfo(float).tiny)
    worst = int(np.argmax(least))
    if not least[worst] > DRIFTED:
        return []
    channel, unit = _channel(case, worst)
    told = f"{channel} reads {means[:, worst].mean():+.2g} {unit} more than the result expects all along: its offset "
    return [f"{told}has drifted, or something presses all along; {WARM_UP}"]


def drifted_since(change: Array, std: Array, case: Case, source: str) -> list[str]:
    """What to say where a tare finds other offsets than a result.

    Args:
        change: new offsets less old ones, shape (6,) [N, or N and N m].
        std: standard deviation of that, shape (6,).
        source: the result.
    """
    sure = np.abs(change) / np.maximum(std, np.finfo(float).tiny)
    worst = int(np.argmax(sure))
    if not sure[worst] > DRIFTED:
        return []
    channel, unit = _channel(case, worst)
    told = (
        f"the offset of {channel} has drifted by {change[worst]:+.2g} {unit} ({sure[worst]:.0f} standard deviations) "
    )
    return [f"{told}since {source}: what was computed with that meanwhile is off by it"]


def _channel(case: Case, k: int) -> tuple[str, str]:
    name, _, unit = case.sensor_frame.channels[k].rpartition("_")
    return case.recording.file_name(f"{name}_{unit}"), {"Nm": "N m"}.get(unit, unit)
