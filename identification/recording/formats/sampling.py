"""Samples at equal steps: lost samples get rows, what was done is a finding.

Where stamps stray from equal steps, either the samples are at equal steps and the stamps are late, or they were taken
when the stamps say. The motion decides: with the wrong instants it is rougher.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cases.base.phrases import NOTHING, phrase
from cases.base.units import Array, Flags, Indices
from identification.finding import Finding, Kind, note, warning
from identification.recording.formats.clocks import GAP, Even, Unsteady, evened
from identification.recording.formats.table import Channel, Stream

MOST_PUT_BACK = 3  # samples in a row
_CUBIC = 4  # samples that a cubic goes through
_SWITCHING: tuple[Channel, ...] = ("trigger", "override", "rotations")  # a lost sample gets their last value
_MOTIONS: tuple[Channel, ...] = ("drives", "poses")
_SMOOTHER = 2.0  # times, by which the motion must be smoother for stamps to be the instants
_LEAST_MOVING = 100  # samples that show it
_LEAST_APART = 0.2  # steps between stamps of which it can be seen
_OTHER_CLOCK = 1e-3  # share by which a stated period may differ from the stamps before one of them is called wrong
_UNSURE = 1e-3  # share of the step, from which on its deviation is a warning


def on_equal_steps(stream: Stream, period: float | None = None) -> Stream | Unsteady:
    """The stream with samples at equal steps, and with rows for those that were lost, a few at a time.

    Args:
        stream: samples with their stamps.
        period: time between samples that is stated, which counts more than the stamps [s].

    Returns:
        the stream as it is where its stamps are at no one rate, `Stream.step` then says why; why nothing can be made of
        them where they do not increase.
    """
    if stream.t is None or len(stream.t) < 2:
        return stream
    even = evened(stream.t, period)
    if isinstance(even, Unsteady):
        repeated = np.diff(stream.t) <= 0.0
        if even.backwards or not repeated.any():
            return even if even.backwards else stream
        problem = (
            f"is not later than the time stamp above it, and stamps of no one rate do not say when: {even.problem}"
        )
        return Unsteady(1 + int(np.argmax(repeated)), problem, even.remedy, backwards=True)
    at_stamps = even.strays and period is None and _taken_when_stamped(stream, stream.t, even)
    findings = (*stream.findings, *_about(stream, even, at_stamps))
    if at_stamps:
        return replace(_at(stream, even), findings=findings)
    t = even.t if even.strays or even.written is not None else stream.t  # rounding of what is printed stays
    return _with_lost_rows(replace(stream, t=t, findings=findings), t, even.numbers)


def _name(stream: Stream) -> str:
    return Path(stream.source).name


def _about(stream: Stream, even: Even, taken: bool) -> list[Finding]:
    """What to say of the clock."""
    ms, name = 1e3, _name(stream)
    if even.written is not None:
        off = abs(even.written / even.step - 1.0)
        period = f"{even.step * ms:.6g}"
        if off < _OTHER_CLOCK:
            sentence = phrase(
                "period_counts",
                "{file}: recording.clock.period_ms = {period} counts, not its time stamps; these say which samples "
                "were lost",
                file=name,
                period=period,
            )
            return [note(Kind.CLOCK, sentence)]
        sentence = phrase(
            "period_contradicts",
            "{file}: recording.clock.period_ms = {period} counts, not its time stamps, which are {apart} ms apart: "
            "accelerations differ by {percent} %; find out which of them is right",
            file=name,
            period=period,
            apart=f"{even.written * ms:.6g}",
            percent=f"{200 * off:.2g}",
        )
        return [warning(Kind.CLOCK, sentence)]
    if not even.strays:
        return []
    treatment = phrase("taken_at_steps", "the samples are taken to be at these")
    if taken:
        treatment = phrase(
            "taken_at_stamps", "the motion is smoother at the stamps, so that samples are interpolated between them"
        )
    sentence = phrase(
        "stamps_stray",
        "{file}: time stamps stray from equal steps of {step} ms by {rms} ms (rms), at most {most} ms; {done}",
        file=name,
        step=f"{even.step * ms:.6g}",
        rms=f"{even.stray * ms:.3g}",
        most=f"{even.most * ms:.3g}",
        done=treatment,
    )
    figures = {"step_ms": even.step * ms, "rms_ms": even.stray * ms, "most_ms": even.most * ms}
    findings = [note(Kind.CLOCK, sentence, time_stamps=figures | {"step_deviation": even.deviation})]
    if even.deviation > _UNSURE:
        hidden = (
            NOTHING
            if even.clear
            else phrase("lost_unseen", ": single lost samples are not seen behind what stamps stray by")
        )
        sentence = phrase(
            "step_uncertain",
            "{file}: the step of {step} ms is uncertain by {percent} %{hidden}; state recording.clock.period_ms if it "
            "is known",
            file=name,
            step=f"{even.step * ms:.4g}",
            percent=f"{100 * even.deviation:.2g}",
            hidden=hidden,
        )
        findings.append(warning(Kind.CLOCK, sentence))
    return findings


def _with_lost_rows(stream: Stream, t: Array, numbers: Indices) -> Stream:
    """The stream with rows for samples that were lost, a few at a time, so that a filter can pass them.

    By the instants of its rows, shape (n,) [s], and their numbers where lost ones count.
    """
    gaps = np.diff(numbers) - 1
    count = np.r_[0, np.where(gaps <= MOST_PUT_BACK, gaps, 0)]
    if not count.any():
        return stream
    positions = np.arange(len(t)) + np.cumsum(count)  # where the rows that are there stand in the result
    rows = np.arange(positions[-1] + 1)
    present = np.zeros(len(rows), dtype=bool)
    present[positions] = True
    more: dict[Any, Any] = {n: spread(v, positions, rows, n in _SWITCHING) for n, v in stream.channels.items()}
    missing = ~present
    if stream.missing is not None:
        missing[positions] = stream.missing
    lines = replace(stream.lines, inserted=tuple(np.flatnonzero(~present).tolist()))
    return replace(stream, t=np.interp(rows, positions, t), lines=lines, missing=missing, **more)


def spread(values: Array, rows_of_values: Indices | Array, rows: Indices | Array, last: bool) -> Array:
    """Values at all rows: cubics through two that are there on either side, or the last of them.

    A straight line cuts the bends of a motion: at 5 m/s^2 a strut is 10 um off it midway between samples 4 ms apart,
    and accelerations behind the filter show that. Across more than a few samples it is a straight line nevertheless,
    for there a cubic would follow the noise of what it goes through.
    """
    if last:
        return np.asarray(values[np.maximum(np.searchsorted(rows_of_values, rows, side="right") - 1, 0)])
    columns = values.reshape(len(values), -1)
    result = np.stack([np.interp(rows, rows_of_values, column) for column in columns.T], axis=1)
    if len(rows_of_values) >= _CUBIC:
        before = np.clip(np.searchsorted(rows_of_values, rows, side="right") - 1, 0, len(rows_of_values) - 2)
        usual = np.median(np.diff(rows_of_values))
        near = rows_of_values[before + 1] - rows_of_values[before] <= (MOST_PUT_BACK + 1.5) * usual
        near &= (rows > rows_of_values[0]) & (rows < rows_of_values[-1]) & (rows != rows_of_values[before])
        at, first = rows[near], np.clip(before[near] - 1, 0, len(rows_of_values) - _CUBIC)
        nodes = first[:, None] + np.arange(_CUBIC)
        result[near] = np.einsum("nk,nkj->nj", _weights(rows_of_values[nodes], at), columns[nodes])
    return result.reshape(len(rows), *values.shape[1:])


def _weights(nodes: Array, at: Array) -> Array:
    """Weights of Lagrange's polynomials through nodes, shape (n, k), at instants, shape (n,)."""
    weights = np.ones(nodes.shape)
    for k in range(nodes.shape[1]):
        for other in range(nodes.shape[1]):
            if other != k:
                weights[:, k] *= (at - nodes[:, other]) / (nodes[:, k] - nodes[:, other])
    return weights


def _taken_when_stamped(stream: Stream, stamps: Array, even: Even) -> bool:
    """Whether the motion is clearly smoother with samples at their stamps than at equal steps."""
    if stamps.size < _LEAST_MOVING or np.diff(stamps).min() < _LEAST_APART * even.step:
        return False
    rougher = []
    for name in _MOTIONS:
        if name not in stream.channels:
            continue
        for column in stream.channels[name].reshape(len(stamps), -1).T:
            moving = _moving(column)
            if moving.sum() >= _LEAST_MOVING:
                levels = [float(np.median(np.abs(_rough(column, t)[moving]))) for t in (even.t, stamps)]
                rougher.append(levels[0] / max(levels[1], np.finfo(float).tiny))
    return bool(rougher) and float(np.median(rougher)) > _SMOOTHER


def _moving(column: Array) -> Flags:
    """Samples where a coordinate is fast, two at either end apart, shape (n - 4,)."""
    speed = np.abs(column[3:-1] - column[1:-3])
    return np.asarray((speed > 0.5 * np.quantile(speed, 0.95)) & (speed > 0.0))


def _rough(column: Array, t: Array) -> Array:
    """How far samples are from the cubic through two on either side, over what noise makes of it, shape (n - 4,)."""
    around = [np.arange(len(t) - 4) + k for k in (0, 1, 3, 4)]
    at, result, noise = t[2:-2], -column[2:-2], np.ones(len(t) - 4)
    for k in around:
        weight = np.ones(len(t) - 4)
        for other in around:
            if other is not k:
                weight = weight * (at - t[other]) / (t[k] - t[other])
        result = result + weight * column[k]
        noise = noise + weight**2
    return np.asarray(result / np.sqrt(noise))


def _at(stream: Stream, even: Even) -> Stream:
    """The samples, which were taken at their stamps, interpolated at equal steps."""
    from scipy.interpolate import CubicSpline

    assert stream.t is not None
    more: dict[Any, Any] = {}
    for name, values in stream.channels.items():
        if name in ("drives", "poses"):
            more[name] = CubicSpline(stream.t, values)(np.clip(even.t, stream.t[0], stream.t[-1]))
        else:
            more[name] = spread(values, stream.t, even.t, name in _SWITCHING)
    after = np.clip(np.searchsorted(stream.t, even.t), 1, len(stream.t) - 1)
    missing = stream.t[after] - stream.t[after - 1] > GAP * even.step
    if stream.missing is not None:
        missing |= stream.missing[after] | stream.missing[after - 1]
    return replace(stream, t=even.t, missing=missing if missing.any() else None, **more)
