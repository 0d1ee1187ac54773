"""Streams of one run on one time axis: samples that coincide are joined, clocks that differ by a trigger in both."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from cases.base.errors import Code, RecordingError
from cases.base.phrases import NOTHING, Phrase, phrase
from cases.base.units import Array, Flags
from identification.finding import Finding, Kind, note, warning
from identification.recording.formats.table import Channel, Stream

_MOTION: tuple[Channel, ...] = ("drives", "poses", "rotations", "specific_forces")  # whose clock is kept
_MOST_RATE = 1e-3  # by which two clocks may differ: crystals are within 1e-4
_SIGNIFICANT = 3.0  # standard deviations of a rate from which on it is a difference of the clocks


def on_one_axis(streams: Sequence[Stream], stated: Sequence[bool]) -> tuple[list[Stream], tuple[Finding, ...]]:
    """Streams on the time axis of the one with the motion, and what was done.

    Args:
        stated: of each stream whether the case states how its clock differs: its trigger then moves nothing.

    Raises:
        RecordingError: two streams have one channel, their triggers contradict each other, or they do not overlap.
    """
    streams = [replace(stream, trigger=None) if _never_switches(stream, streams) else stream for stream in streams]
    with_trigger = [k for k, stream in enumerate(streams) if stream.trigger is not None]
    first = min(with_trigger, key=lambda k: {*_MOTION}.isdisjoint(streams[k].channels), default=0)
    joined: list[Stream] = []
    findings: list[Finding] = []
    for k, stream in enumerate(streams):
        if k != first and k in with_trigger and not _coincide(streams[first], stream):
            stream, finding = _joined_by_trigger(streams[first], stream, stated[k] or stated[first])
            findings += [finding]
        joined = _with(joined, stream)
    _require_overlap(joined)
    return joined, tuple(findings)


def _never_switches(stream: Stream, streams: Sequence[Stream]) -> bool:
    """Whether a trigger that never switches is one of several, which it then says nothing beside."""
    several = sum(s.trigger is not None for s in streams) > 1
    return several and stream.trigger is not None and bool(np.all(stream.trigger == stream.trigger[0]))


def _coincide(one: Stream, other: Stream) -> bool:
    if one.t is None or other.t is None:
        return one.t is other.t and one.rows == other.rows
    return np.array_equal(one.t, other.t)


def _with(joined: Sequence[Stream], stream: Stream) -> list[Stream]:
    """Streams and another one, in one with that whose samples coincide with its own."""
    same = next((k for k, s in enumerate(joined) if _coincide(s, stream)), None)
    if same is None:
        return [*joined, stream]
    first = joined[same]
    more: dict[Any, Any] = {**stream.channels}
    if first.trigger is not None and stream.trigger is not None:
        if not np.array_equal(first.trigger, stream.trigger):
            reason = f"has another trigger than {first.source}, sample by sample"
            raise RecordingError(
                place=stream.source,
                problem=reason,
                remedy=phrase("leave_a_trigger", "leave one of the triggers out"),
                code=Code.TRIGGER,
            )
        del more["trigger"]
    masks = [s.missing for s in (first, stream) if s.missing is not None]
    missing = np.any(masks, axis=0) if masks else None
    whole = replace(first, missing=missing, missing_in=(*first.missing_in, *stream.missing_in), **more)
    return [*joined[:same], whole, *joined[same + 1 :]]


@dataclass(frozen=True, slots=True)
class _Edges:
    """Instants at which a trigger switches."""

    t: Array  # shape (n,) [s]
    half: Array  # half the time between the samples around each, shape (n,) [s]
    rising: Flags  # shape (n,)
    span: tuple[float, float]  # first and last sample [s]

    def inside(self, other: "_Edges", shift: float) -> Flags:
        """Which of the edges the other recorder must have seen, its clock shifted [s], shape (n,)."""
        margin = self.half + (other.half.max() if len(other.half) else 0.0)
        return (self.t - margin > other.span[0] + shift) & (self.t + margin < other.span[1] + shift)


def _edges(stream: Stream) -> _Edges:
    assert stream.t is not None
    assert stream.trigger is not None
    k = np.flatnonzero(stream.trigger[1:] != stream.trigger[:-1])
    half = (stream.t[k + 1] - stream.t[k]) / 2.0
    return _Edges(stream.t[k] + half, half, stream.trigger[k + 1], (float(stream.t[0]), float(stream.t[-1])))


@dataclass(frozen=True, slots=True)
class _ClockMap:
    """Time of the reference = t + shift + rate (t - middle)."""

    shift: float  # [s]
    rate: float  # without a unit
    rate_std: float  # infinite where one edge is common
    middle: float  # [s]
    edges: int  # that are in both

    @property
    def differs(self) -> bool:
        """Whether the edges show that the clocks run at different rates."""
        return abs(self.rate) > _SIGNIFICANT * self.rate_std

    def of(self, t: Array) -> Array:
        """Times of the reference, shape (n,) [s]."""
        return t + self.shift + (self.rate * (t - self.middle) if self.differs else 0.0)


def _fit(reference: _Edges, other: _Edges, shift: int) -> _ClockMap | None:
    """How clocks differ if edge k of the reference is edge k + shift of the other; None where that cannot be."""
    first, last = max(0, -shift), min(len(reference.t), len(other.t) - shift)
    if last <= first:
        return None
    ours, theirs = slice(first, last), slice(first + shift, last + shift)
    if np.any(reference.rising[ours] != other.rising[theirs]):
        return None
    delays, half = reference.t[ours] - other.t[theirs], reference.half[ours] + other.half[theirs]
    weights = 3.0 / (reference.half[ours] ** 2 + other.half[theirs] ** 2)  # an edge is anywhere between its samples
    middle, mean = (float(weights @ v / weights.sum()) for v in (other.t[theirs], delays))
    away = other.t[theirs] - middle
    spread = float(weights @ away**2)
    rate = float(weights @ (away * (delays - mean))) / spread if last - first > 1 else 0.0
    fit = _ClockMap(mean, rate, spread**-0.5 if last - first > 1 else np.inf, middle, last - first)
    if np.any(np.abs(delays - mean) > half + _MOST_RATE * np.abs(away)):
        return None
    own_samples, other_samples = reference.inside(other, mean), other.inside(reference, -mean)
    own_samples[ours], other_samples[theirs] = False, False
    return None if own_samples.any() or other_samples.any() else fit


def _joined_by_trigger(reference: Stream, stream: Stream, stated: bool) -> tuple[Stream, Finding]:
    """A stream on the clock of another one that has the trigger too, without its own, and what was done."""
    pair = f"{stream.source} and {reference.source}"
    if reference.t is None or stream.t is None:
        raise RecordingError(
            place=pair,
            problem=phrase("triggers_no_clocks", "have a trigger each, and not both have a clock"),
            remedy=phrase("state_period", "state recording.clock.period_ms"),
            code=Code.TRIGGER,
        )
    ours, theirs = _edges(reference), _edges(stream)
    fit, count = _longest_fit(ours, theirs, pair)
    resolution = float(np.max(ours.half) + np.max(theirs.half))
    edges = (
        phrase("edges", "{count} edges of the trigger", count=fit.edges)
        if fit.edges > 1
        else phrase("one_edge", "1 edge of the trigger")
    )
    within = f"{1e3 * resolution:.2g}"
    if stated:
        if abs(fit.shift) <= resolution:
            sentence = phrase(
                "clocks_as_stated",
                "{pair}: {edges} agree with recording.clock.offset_s within {within} ms",
                pair=pair,
                edges=edges,
                within=within,
            )
            return replace(stream, trigger=None), note(Kind.CLOCK, sentence)
        sentence = phrase(
            "clocks_not_as_stated",
            "the clocks of {pair} differ by {shift} s more than recording.clock.offset_s states, by {edges}; correct "
            "it or leave it out",
            pair=pair,
            shift=f"{fit.shift:.4f}",
            edges=edges,
        )
        return replace(stream, trigger=None), warning(Kind.CLOCK, sentence)
    if abs(fit.shift) <= resolution and not fit.differs:
        sentence = phrase(
            "one_clock",
            "{pair} have one clock: {edges} agree within {within} ms",
            pair=pair,
            edges=edges,
            within=within,
        )
        return replace(stream, trigger=None), note(Kind.CLOCK, sentence, clock_offset_s=0.0, clock_rate_ppm=0.0)
    ways = NOTHING
    if count > 1:
        ways = phrase("ways_to_fit", "; it is the longest of {count} ways in which their edges fit", count=count)
    sentence = phrase(
        "clocks_joined",
        "the clock of {file} is joined with that of {other} by {edges}: {shift} s{rate}{ways}",
        file=stream.source,
        other=reference.source,
        edges=edges,
        shift=f"{fit.shift:+.4f}",
        rate=_rate_words(fit),
        ways=ways,
    )
    moved = replace(stream, t=fit.of(stream.t), trigger=None)
    quantity = {"clock_offset_s": fit.shift, "clock_rate_ppm": 1e6 * fit.rate if fit.differs else 0.0}
    return moved, note(Kind.CLOCK, sentence, **quantity)


def _longest_fit(ours: _Edges, theirs: _Edges, pair: str) -> tuple[_ClockMap, int]:
    """The clock map by which most edges of two triggers fit, and how many fit some.

    Raises RecordingError where there is no such map, or several: `pair` names the files.
    """
    shifts = range(-len(ours.t) + 1, len(theirs.t))
    maps = [fit for shift in shifts if (fit := _fit(ours, theirs, shift)) is not None]
    most = max((fit.edges for fit in maps), default=0)
    best = [fit for fit in maps if fit.edges == most]
    if len(best) != 1:
        raise RecordingError(
            place=pair,
            problem=f"have triggers that {_differ(ours, theirs, len(best))}",
            remedy=_REMEDY,
            code=Code.TRIGGER,
        )
    return best[0], len(maps)


def _rate_words(fit: _ClockMap) -> Phrase:
    """The rate of a clock against the other, where edges tell it."""
    if not np.isfinite(fit.rate_std):
        return NOTHING
    sizes = {"rate": f"{1e6 * fit.rate:+.3g}", "std": f"{1e6 * fit.rate_std:.2g}"}
    if fit.differs:
        return phrase("clock_rate", ", rate {rate} +- {std} ppm", **sizes)
    return phrase("clock_rate_left_out", ", rate {rate} +- {std} ppm, which is not significant and left out", **sizes)


_REMEDY = (
    "check clock.unit and clock.period_ms of both files, record both from before the trigger to after it, or state "
    "recording.clock.offset_s and leave one trigger out"
)


def _differ(ours: _Edges, theirs: _Edges, ways: int) -> str:
    """What to say of triggers that cannot be brought together, or in several ways."""
    counts = " and ".join(f"{len(edges.t)} edges" for edges in (theirs, ours))
    if ways > 1:
        return f"fit each other in {ways} ways ({counts})"
    longest = [max((b - a for a, b in pairwise(edges.t.tolist())), default=0.0) for edges in (theirs, ours)]
    return f"do not fit each other: {counts}, at most {longest[0]:.4g} s and {longest[1]:.4g} s apart"


def _require_overlap(streams: Sequence[Stream]) -> None:
    """Raises RecordingError unless the streams of a run overlap in time."""
    if len(streams) == 1:
        return
    if any(stream.t is None for stream in streams):
        sources = ", ".join(stream.source for stream in streams)
        reason = "have no common rows, and not all of them have time stamps"
        raise RecordingError(
            place=sources,
            problem=reason,
            remedy=phrase("files_of_one_run", "give files of one run, recorded together"),
            code=Code.OTHER_SOURCE,
        )
    spans = [(float(s.t[0]), float(s.t[-1]), s.source) for s in streams if s.t is not None]
    start, _, latest = max(spans)
    end, early = min((end, source) for _, end, source in spans)
    if start >= end:
        raise RecordingError(
            place=latest,
            problem=phrase(
                "starts_after", "starts {seconds} s after {other} ends", seconds=f"{start - end:.6g}", other=early
            ),
            remedy=phrase(
                "one_run_or_offset",
                "give the files of one run, or state how their clocks differ in recording.clock.offset_s",
            ),
            code=Code.OTHER_SOURCE,
        )
