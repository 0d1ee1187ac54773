"""Offsets that drift within a run: a straight line in time, or one that settles as a sensor does that warms up.

Of each channel the size of such a change is estimated beside the parameters, and judged by deviations that allow for
noise with memory, for slow noise wanders too. It is not removed.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag
from scipy.special import stdtrit

from cases.schema import Case
from cases.units import Array, Flags, Indices
from identification.estimation.fit import Regression, inverse_root, joint_triangle
from identification.finding import Finding, Kind, warning
from identification.findings.noise_level import channel_words
from identification.recording import Recording
from identification.samples import Fitted
from identification.signals import fair_part

WARM_UP = "let the sensor warm up, and run hexcite tare shortly before its readings count"
CHANCE = 1e-6  # probability of a false drift, in each channel
LEAST_FREEDOM = 4.0  # degrees of freedom of a channel, from which on a drift can be judged


SETTLING = (1.0 / 3.0, 0.1)  # time constants of sensors that warm up, in lengths of the run


class Drift(NamedTuple):
    """How offsets change within a run."""

    shape: Array  # of the change over time, by 1 over the run and of mean 0, shape (n,)
    settles: bool  # whether it is that of a sensor that warms up, else a straight line
    change: Array  # of each channel over the run, shape (6,) [N, or N and N m]
    sure: Array  # the same in standard deviations, shape (6,)
    drifts: Flags  # channels that drift for certain, shape (6,)
    bias: Array  # by how much the values of the fit are off for it, shape (v,)


def drift_of(fitted: Fitted) -> Drift | None:
    """How offsets change within the run of a fit; None where they do not, or where that cannot be judged."""
    samples, method = fitted.samples, fitted.method
    freedom = len(fitted.fit.residuals) - len(fitted.regression.names) / 6 - 1
    span = float(np.ptp(samples.t))
    if method.priors or freedom < LEAST_FREEDOM or span == 0.0:
        return None
    part = fair_part(len(samples.t))
    weights = fitted.fit.weights if fitted.whitening is None else np.ones(6)
    free = freedom * len(part) / len(samples.t)
    best, most, settles = None, -stdtrit(free, CHANCE / 2.0), False
    for share in (None, *SETTLING):
        shape = _shape((samples.t - samples.t.min()) / span, share)
        change, white = _solved(_with_lines(fitted, shape * samples.scale, part), weights, free)
        clear = float(np.max(np.abs(change[-6:]) / np.sqrt(white)))
        if clear > most:
            best, most, settles = shape, clear, share is not None
    if best is None:
        return None  # no more than white noise makes; noise with memory makes deviations larger, and takes time
    lines = _with_lines(fitted, best * samples.scale, np.arange(len(best)))
    change, white = _solved(lines, weights, freedom)
    robust = samples.robust_covariance(lines.regressors, lines.residuals(change), weights, fitted.whitening)
    spread = white if robust is None else np.maximum(white, np.diag(robust.covariance)[-6:])
    # noise with a long memory has so few independent samples that such a change is likely
    limits = -stdtrit(np.maximum(freedom * white / spread, 1.0), CHANCE / 2.0)
    sure = np.abs(change[-6:]) / np.sqrt(spread)
    if not np.any(sure > limits):
        return None
    return Drift(best, settles, change[-6:], sure, sure > limits, change[:-6])


def _shape(share: Array, memory: float | None) -> Array:
    """A change by 1 from a share of the run 0 to 1, of mean 0, shape (n,): straight, or settling with a memory."""
    shape = share if memory is None else -np.expm1(-share / memory) / -np.expm1(-1.0 / memory)
    return np.asarray(shape - shape.mean())


def drift_findings(recording: Recording, case: Case, fitted: Fitted, drift: Drift | None) -> list[Finding]:
    """The channel whose offset changes most surely within a run, with the change over the run."""
    if drift is None:
        return []
    span, by_channel = float(np.ptp(fitted.samples.t)), np.where(drift.drifts, drift.sure, 0.0)
    worst = int(np.argmax(by_channel))
    channel, unit = channel_words(case, worst)
    by = float(drift.change[worst])
    over = f"these {round(span) + 1} standstills" if recording.t is None else f"the {span:.3g} s of this run"
    others = [channel_words(case, k)[0] for k in np.flatnonzero(drift.drifts).tolist() if k != worst]
    more = f"; {', '.join(others)} too" if others else ""
    how = ", most at its beginning, as of a sensor that warms up" if drift.settles else ""
    sentence = (
        f"the offset of {channel} drifts by {by:+.2g} {unit} over {over}{how} ({drift.sure[worst]:.0f} standard "
        f"deviations){more}: the result has the mean; {WARM_UP}"
    )
    entry = {"channel": channel, "change": by, "standard_deviations": float(drift.sure[worst]), "span": span}
    return [warning(Kind.OFFSETS, sentence, offset_drift=entry | {"unit": unit})]


def _with_lines(fitted: Fitted, line: Array, rows: Indices) -> Regression:
    """Residuals of some samples by A with a line in each channel, as an estimator takes them."""
    basis = fitted.method.selection(fitted.samples.model).basis
    free = fitted.regression.regressors[rows] @ block_diag(basis, np.eye(fitted.regression.nuisance))
    columns = np.dstack([free, line[rows, None, None] * np.eye(6)])
    return Regression(columns, fitted.fit.residuals[rows], ()).whitened(fitted.whitening)


def _solved(lines: Regression, weights: Array, freedom: float) -> tuple[Array, Array]:
    """How far the values of a fit move with the lines, and the variance of these six by white noise."""
    top = joint_triangle(lines.regressors, lines.forces, np.sqrt(weights))
    half, change = inverse_root(top[:-1, :-1]), np.linalg.lstsq(top[:-1, :-1], top[:-1, -1], rcond=None)[0]
    covariance = half @ half.T * top[-1, -1] ** 2 / (6.0 * freedom)
    return np.asarray(change), np.diag(covariance)[-6:]
