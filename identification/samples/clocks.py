"""Forces and struts of different rates brought to one clock.

Forces that are sampled faster than the motion are averaged over the motion's sampling interval (section 7 of the
paper), centred on its instants, so that the average has no group delay. The average of the straight lines between
samples is taken, so that rates need no common multiple; what averaging and straight lines take from a signal's
curvature is given back to second order: the force then is that of the instant, as the motion is. Struts that are
sampled faster than the forces are read from the cubic spline through them at the instants of the forces.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.base.units import Array, Flags, Indices
from cases.schema import Case
from identification.machines.hexapod import Hexapod
from identification.recording.formats.table import Channel, Stream
from identification.recording.recording import Recording
from identification.samples.sample_checks import at_full_range

GAP = 1.6  # usual steps of the forces without a sample, which an average would hide
SLACK = 0.1  # steps by which a gap may be longer: one lost sample makes two steps, up to what clocks are fitted to
ROUNDING = 1e-6  # of a step, that clocks may be off by rounding
OVERSAMPLED = 1.5  # samples of the forces in a motion's interval, from which they are averaged
HELD_CHANGES = 50  # changes of the struts, from which on a rhythm is looked for
HELD = 0.98  # of the changes, that must follow the rhythm


def on_one_clock(recording: Recording, case: Case) -> Recording:
    """The run with forces and struts at the same instants; those that a gap of either would hide are marked missing.

    Args:
        recording: any; without a clock or a machine, or with one rate, it is returned as it is.
        case: case with the machine whose struts were recorded, and the range of the sensors.

    Raises:
        RecordingError: struts are held, and a gap breaks their rhythm; forces and struts hardly overlap.
    """
    if (case.hexapod is None and case.chain is None) or recording.t is None:
        return recording
    motion = _motion(recording, case)
    if motion is None or motion.t is None or motion.drives is None or len(motion.t) < 2 or len(recording.t) < 2:
        return recording
    interval, step = (float(np.median(np.diff(t))) for t in (motion.t, recording.t))
    if interval < OVERSAMPLED * step:
        return _at_the_forces(recording, motion)
    return _at_the_motion(recording, motion, interval, step, case)


def _motion(recording: Recording, case: Case) -> Stream | None:
    """The struts with their own clock; None where they have that of the forces."""
    if recording.drives is not None:
        return _released(recording)
    stream = recording.stream_with("drives") or recording.stream_with("poses")
    if stream is None or stream.poses is None or stream.drives is not None:
        return stream
    return replace(stream, drives=Hexapod.of(case).strut_lengths(stream.poses))


def _released(recording: Recording) -> Stream | None:
    """The samples of struts that a file holds until the next one comes; None where every row has its own."""
    assert recording.drives is not None
    assert recording.t is not None
    rhythm = _rhythm_of(recording.drives)
    if rhythm is None:
        cuts = 1 + np.flatnonzero(recording.lost)
        between = _rhythm_of(max(np.split(recording.drives, cuts), key=len)) if len(cuts) else None
        if between is not None:
            raise RecordingError(
                place=f"{recording.source}, {recording.lines.place(int(cuts[0]))}",
                problem=phrase(
                    "drives_held",
                    "positions of drives are held for {rows} rows each, and a gap breaks their rhythm",
                    rows=between[0],
                ),
                remedy=phrase("cut_or_apart", "cut the run there, or export drives and forces as files of their own"),
                code=Code.CLOCK,
            )
        return None
    ratio, phase = rhythm
    rows = slice(phase, None, ratio)
    trigger = None if recording.trigger is None else recording.trigger[rows]
    missing = None if recording.missing is None else recording.missing[rows]
    return Stream(
        recording.source, recording.t[rows], recording.drives[rows], None, None, trigger,
        lines=recording.lines.later(phase, ratio), missing=missing, missing_in=recording.missing_in,
    )  # fmt: skip


def _rhythm_of(struts: Array) -> tuple[int, int] | None:
    """Rows for each sample of held struts, shape (n, 6), and the first of these; None where every row has its own."""
    changes = np.flatnonzero(np.any(np.diff(struts, axis=0) != 0.0, axis=1)) + 1
    if len(changes) < HELD_CHANGES:
        return None
    ratio = int(np.median(np.diff(changes)))
    phase = int(np.bincount(changes % ratio).argmax())
    if ratio < 2 or np.mean(changes % ratio == phase) < HELD or np.mean(np.diff(changes) == ratio) < HELD / 2:
        return None
    return ratio, phase


def _at_the_motion(recording: Recording, motion: Stream, interval: float, step: float, case: Case) -> Recording:
    """The run at the samples of the motion, which are an interval apart [s], the forces averaged over it."""
    assert motion.t is not None
    assert motion.drives is not None
    assert recording.t is not None
    measured = slice(None) if recording.missing is None else ~recording.missing  # the others make a gap
    t, forces = recording.t[measured], recording.forces[measured]
    half = interval / 2.0
    # A sample more on either side for the curvature; rounding must not decide whether the first reaches the edge.
    room = half - ROUNDING * step
    inside = np.flatnonzero((motion.t - room >= t[0]) & (motion.t + room <= t[-1]))
    if len(inside) < 3:
        raise RecordingError(
            place=recording.source,
            problem=phrase("forces_apart", "its forces cover less than 3 samples of the motion"),
            remedy=phrase("record_together", "record together"),
            code=Code.TOO_FEW,
        )
    means = interval_means(t, forces, motion.t[inside], interval)
    curvature = means[2:] - 2.0 * means[1:-1] + means[:-2]
    means = means[1:-1] - (1.0 / 24.0 + (step / interval) ** 2 / 12.0) * curvature
    inside = inside[1:-1]
    at = motion.t[inside]
    # The neighbours' averages are in the curvature.
    hidden = _reach_a_gap(t, (max(GAP, 0.5 * interval / step) + SLACK) * step, at, 1.5 * interval)
    means = _at_full_range(means, t, forces, at, half, case)
    run = _at_clock(recording, motion, inside, hidden, "the forces averaged there", motion.drives[inside], means)
    return replace(run, averaged=interval / step)


def _reach_a_gap(t: Array, most: float, centres: Array, reach: float) -> Flags:
    """Whether samples further apart than `most` are within reach of some instants, shape (m,)."""
    long = np.flatnonzero(np.diff(t) > most)
    ends = np.searchsorted(centres + reach, t[long], side="right"), np.searchsorted(centres - reach, t[long + 1])
    change = np.zeros(len(centres) + 1, dtype=np.int64)
    np.add.at(change, ends[0], 1)
    np.add.at(change, np.maximum(*ends), -1)
    return np.asarray(np.cumsum(change)[:-1] > 0)


def interval_means(t: Array, values: Array, centres: Array, interval: float) -> Array:
    """Means over intervals of the straight lines between samples, shape (m, channels).

    Args:
        t: increasing, shape (n,) [s].
        values: shape (n, channels).
        centres: centres of the intervals, which lie inside t, shape (m,) [s].
        interval: their length [s].
    """
    from scipy.interpolate import make_interp_spline

    mean = values.mean(axis=0)  # keeps rounding small against what changes
    integral = make_interp_spline(t, values - mean, k=1).antiderivative()
    return np.asarray((integral(centres + interval / 2.0) - integral(centres - interval / 2.0)) / interval + mean)


def _latest(recording: Recording, name: Channel, at: Array) -> Any:
    """A channel that switches, or changes slowly, as last recorded at given instants; None where there is none."""
    stream = recording.stream_with(name)
    if stream is None or stream.t is None:
        return None
    return getattr(stream, name)[np.maximum(np.searchsorted(stream.t, at, side="right") - 1, 0)]


def _at_full_range(means: Array, t: Array, forces: Array, centres: Array, half: float, case: Case) -> Array:
    """Averages over samples at the end of the sensor's range are at its end too, so that they are found there."""
    if case.sensors.range is None:
        return means
    first, end = np.searchsorted(t, centres - half), np.searchsorted(t, centres + half)
    for k, most in enumerate(case.sensors.range):
        clipped = np.r_[0, np.cumsum(at_full_range(forces[:, k], most))]
        rows = clipped[end] > clipped[first]
        if np.abs(forces[:, k]).min() < most:  # else its range is about a constant, and its end is in the means
            means[rows, k] = np.copysign(most, means[rows, k])
    return means


def _at_the_forces(recording: Recording, motion: Stream) -> Recording:
    """Struts as fast as the forces or faster, on a clock of their own."""
    from scipy.interpolate import CubicSpline

    if recording.drives is not None:
        return recording
    assert motion.t is not None
    assert motion.drives is not None
    assert recording.t is not None
    measured = slice(None) if motion.missing is None else ~motion.missing
    at, struts = motion.t[measured], motion.drives[measured]
    usual = float(np.median(np.diff(at)))
    inside = np.flatnonzero((recording.t >= at[0]) & (recording.t <= at[-1]))
    if not len(inside):
        return recording
    t = recording.t[inside]
    hidden, struts = _reach_a_gap(at, GAP * usual, t, usual), CubicSpline(at, struts)(t)
    return _at_clock(recording, recording, inside, hidden, "the drives there", struts, recording.forces[inside])


def _at_clock(
    recording: Recording, clock: Stream, inside: Indices, hidden: Flags, what: str, struts: Array, forces: Array
) -> Recording:
    """The run at samples of a clock, with struts and forces there; `what` is missing where a gap would hide it."""
    assert clock.t is not None
    t = clock.t[inside]
    override = _latest(recording, "override", t)
    trigger = _latest(recording, "trigger", t) if clock.trigger is None else clock.trigger[inside]
    return replace(
        recording, source=clock.source, t=t, drives=struts, forces=forces, trigger=trigger, override=override,
        rotations=None, poses=None, specific_forces=None, others=(), lines=clock.lines.later(int(inside[0])),
        missing=hidden | clock.bad[inside], missing_in=(*clock.missing_in, *((what,) if hidden.any() else ())),
    )  # fmt: skip
