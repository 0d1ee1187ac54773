"""A structural mode between drives and sensors that rings after moves: its frequency, damping, and what it biases.

Behind a mode of angular frequency w a load does what drives do at the frequency s by 1 / (1 - (s / w)^2) times as much,
if hardly damped: far below w it accelerates as a - a'' / w^2. A run estimates that as a sharpening of its forces, where
it is clear; elsewhere it biases the estimate, and so does what the sharpening differs by from 1 / w^2.
What the sensors read and the motion behind a wider filter than that of the fit does not explain shows it: a peak of
the spectrum that comes and goes with the motion, as a hum of the mains does not. The fit's own filter would leave what
moves themselves hold above its band, which has such peaks too.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cases.base.phrases import phrase
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.alternatives import Remainder
from identification.finding import Finding, Kind, note, warning
from identification.findings.left_out import STEP, LeftOut
from identification.samples.moving import SMOOTHED, MovingRun
from identification.samples.samples import Fitted
from identification.signals import white_noise
from identification.texts import parameter_phrase

LOWEST, HIGHEST = 0.75, 0.6  # of the cut-off, and of that of the wider filter, between which a mode is looked for
WIDER, MOST = 8.0, 0.33  # cut-off of that filter: times that of the fit, and of the samples a second, at most
PEAK = 15.0  # of the median power there
SIDES, FLANKS = 4.0, (0.75, 1.33)  # of the power at so many times its frequency, which a peak is above
BURSTS = 5.0  # of the power that nine tenths of the time are below, over that of a quarter
SECOND = 1.0  # [s] of a stretch of the spectrum
REACH = 0.06  # [s] over which its amplitude is averaged
LONGEST = 0.12  # [s] over which it is correlated
HARM = 1.0  # deviations by which it biases a parameter, from which on it is a warning


class Mode(NamedTuple):
    """A structural mode that forces show."""

    frequency: float  # [Hz]
    damping: float  # share of the critical damping; of so few bursts a rough one

    @property
    def sharpening(self) -> float:
        """1 / w^2, by which accelerations seem larger with their bend [s^2]."""
        return float((2.0 * np.pi * self.frequency) ** -2)


class Ringing(NamedTuple):
    """A mode with what it biases."""

    mode: Mode
    bias: Array  # of the values of the fit, shape (v,)


def mode_of(fitted: Fitted) -> Mode | None:
    """The mode that forces of a moving run show; None where they show none."""
    run = fitted.samples
    if not isinstance(run, MovingRun):
        return None
    behind = _widely(run)
    oscillation = behind.series(fitted.at, fitted.fit.values[: len(run.model.names)])
    step = run.filter.step
    length = min(len(oscillation.t), round(SECOND / step))
    scale = white_noise(oscillation.forces)
    if not np.all(scale > 0.0):
        return None
    off = oscillation.values / scale
    at, densities = oscillation.spectrum(length)
    power = np.mean((densities / scale) ** 2, axis=1)
    inside = (at > LOWEST * run.filter.cutoff) & (at < HIGHEST * behind.filter.cutoff)
    if np.count_nonzero(inside) < 8:
        return None
    peak = int(np.flatnonzero(inside)[np.argmax(power[inside])])
    flanks = [float(np.interp(share * at[peak], at, power)) for share in FLANKS]
    if power[peak] < PEAK * np.median(power[inside]) or power[peak] < SIDES * max(flanks):
        return None
    window = np.hanning(2 * round(REACH / step) + 1)
    window /= window.sum()
    turning = off * np.exp(-2j * np.pi * at[peak] * oscillation.t)[:, None]
    slow = np.stack([np.convolve(channel, window, "same") for channel in turning.T], axis=1)
    amplitude = np.sum(np.abs(slow) ** 2, axis=1)
    low, high = np.quantile(amplitude, [0.25, 0.9])
    if high < BURSTS * low:
        return None
    return followed(float(at[peak]), slow, step)


def followed(near: float, slow: Array, step: float) -> Mode | None:
    """The mode by how its amplitudes turn and decay; None where there are too few samples a second to follow it.

    Args:
        near: about its frequency [Hz].
        slow: amplitudes of the channels at that frequency, complex, shape (n, 6).
        step: time between samples [s].
    """
    lags = np.arange(1, round(LONGEST / step))
    each = np.array([np.sum(np.conj(slow[:-k]) * slow[k:]) for k in lags])
    early, late = lags * step < LONGEST / 3.0, lags * step > REACH / 2.0
    if np.count_nonzero(early) < 2 or np.count_nonzero(late) < 2:  # a line takes two
        return None
    shift = np.polyfit(lags[early] * step, np.unwrap(np.angle(each[early])), 1)[0] / (2.0 * np.pi)
    frequency = near + float(shift)
    decay = -float(np.polyfit(lags[late] * step, np.log(np.abs(each[late])), 1)[0])
    return Mode(frequency, max(decay, 0.0) / (2.0 * np.pi * frequency))


def _widely(run: MovingRun) -> MovingRun:
    """The same samples behind a wider filter, which passes unchanged what is looked at."""
    wide = run.filter._replace(cutoff=min(WIDER * run.filter.cutoff, MOST / run.filter.step))
    shift = max(run.filter.margin - wide.margin, 0)
    spoilt = None if run.spoilt is None else np.pad(run.spoilt, shift)
    return replace(run, filter=wide, rows=run.rows + shift, spoilt=spoilt)


def sharpened(mode: Mode, left_out: LeftOut) -> Array:
    """What a mode adds to the forces of a fit in the fit's motion, shape (n, 6)."""
    load = left_out.load
    bent = left_out.derivative(load.twist_rate, 2)
    return left_out.change(replace(load, twist_rate=load.twist_rate - STEP * mode.sharpening * bent))


def by_other_sharpening(mode: Mode, fitted: Fitted) -> Array:
    """By how much the values of a fit are off where it found another sharpening than that of a mode, shape (v,).

    The nearer a mode is to the band of the evaluation, the more of its response follows higher derivatives of the
    forces, of which the second, which is estimated, takes up a part. Zero where no sharpening was estimated.
    """
    fit, run = fitted.fit, fitted.samples
    if not isinstance(run, MovingRun) or run.nuisances != SMOOTHED:
        return np.zeros(len(fit.values))
    place = len(run.model.parameters)
    along = fit.covariance[:, place] / fit.covariance[place, place]
    return np.asarray(along * (fit.values[place] + mode.sharpening))


def biased_by(column: Array, rest: Remainder, basis: Array) -> Array:
    """By how much an effect on the forces puts the values of a fit off, shape (v,).

    Args:
        column: the effect as a fit sees it, shape (n, 6, 1).
        rest: what the fit leaves; what was estimated beside it takes up its part.
        basis: what was free in the fit, shape (v, free).
    """
    _, inside = rest.without_fit(rest.root @ column)
    return np.asarray(basis @ (rest.half @ inside))[:, 0]


def mode_findings(fitted: Fitted, ringing: Ringing | None, case: Case) -> list[Finding]:
    """The mode that forces show, and the parameter that it biases most."""
    if ringing is None:
        return []
    mode, fit, names = ringing.mode, fitted.fit, fitted.samples.model.names
    variance = np.maximum(np.diag(fit.covariance), np.diag(fit.covariance_robust))[: len(names)]
    free = variance > 0.0
    ratios = np.where(free, np.abs(ringing.bias[: len(names)]) / np.sqrt(np.where(free, variance, 1.0)), 0.0)
    worst = int(np.argmax(ratios))
    units = {p.name: p.unit for p in fitted.samples.model.parameters}
    sentence = phrase(
        "structural_mode",
        "a structural mode between drives and sensors rings at {frequency} Hz with the motion (damping about {damping} "
        "%): it may bias {parameter} by {bias} {unit} ({deviations} deviations of noise; +- counts it)",
        frequency=f"{mode.frequency:.3g}",
        damping=f"{100.0 * mode.damping:.1g}",
        parameter=parameter_phrase(names[worst]),
        bias=f"{abs(ringing.bias[worst]):.2g}",
        unit=units[names[worst]],
        deviations=f"{ratios[worst]:.2g}",
    )
    cutoff = case.recording.filter_cutoff_Hz
    if cutoff is not None and mode.frequency < 1.5 * cutoff:
        sentence = phrase(
            "mode_in_band",
            "{sentence}. It lies in the band of the evaluation: lower recording.filter_cutoff_Hz = {cutoff} to {lower}",
            sentence=sentence,
            cutoff=f"{cutoff:g}",
            lower=f"{mode.frequency / 2.0:.2g}",
        )
    entry = {
        "frequency_Hz": mode.frequency, "damping": mode.damping, "bias": ringing.bias[: len(names)].tolist(),
        "parameter": names[worst], "deviations": float(ratios[worst]),
    }  # fmt: skip
    harmful = ratios[worst] > HARM
    return [
        warning(Kind.MODEL, sentence, counted=True, structural_mode=entry)
        if harmful
        else note(Kind.MODEL, sentence, structural_mode=entry)
    ]
