"""How fast a run went along its path, against its plan or by the control's own column: feed override other than 100 %.

Run and plan cover the same path, so that the length covered, in the space of the struts, tells where on the plan the
run is; the ratio of speeds there is the local scale of time. It says how fast, not why: an operator's override and a
control that slows down look alike.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_opening, uniform_filter1d

from cases.errors import RecordingError
from cases.schema import Case
from identification.findings.plausibility import bridged, scan
from identification.formats.stream import Recording
from identification.hexapod import Hexapod
from identification.motion import Trajectory
from identification.runs.preparation import MOST_BRIDGED, MOVING, checked_filter

Array = NDArray[np.float64]

AS_PLANNED = 0.04  # of the feed, by which it may differ: controls time corners and blocks in their own way
LEAST = 0.4  # [s] that a stretch lasts; starts and corners are shorter
WINDOW = 0.25  # [s] over which speeds are compared
SLOW = 0.15  # of the plan's mean speed; slower, a ratio says nothing
STEP = 0.07  # of the feed, by which neighbouring stretches differ
SAME_PATH = 0.03  # of the motion's rms, that the struts may stray from the plan's path
SAME_LENGTH = 0.1  # of the plan's path, by which that of the run may be longer or shorter
MOST_NAMED = 3
CONSEQUENCE = (
    "the parameters are valid, for they come from the measured motion; figures of the plan (duration, predicted "
    "standard deviations, efficiency) are not of this run, whose accelerations go with the square of its feed"
)


class Stretch(NamedTuple):
    """Samples that went at one feed.

    Args:
        rows: of the recording, shape (n,).
        scale: feed over the planned one.
    """

    rows: NDArray[np.bool_]
    scale: float


def recorded_overrides(recording: Recording) -> tuple[Stretch, ...]:
    """Stretches of the motion that the recording's own column says went at another feed than 100 %."""
    if recording.override is None or recording.t is None:
        return ()
    on = np.ones(len(recording.forces), dtype=bool) if recording.trigger is None else recording.trigger
    return _stretches(recording.override, np.flatnonzero(on & (np.abs(recording.override - 1.0) > 1e-6)), 1)


def against_plan(recording: Recording, case: Case, planned: Trajectory, name: str) -> tuple[Stretch, ...]:
    """Stretches of a run that went at another feed than planned.

    Args:
        recording: with struts, a clock, and the trigger on while the plan was executed; without a trigger all that
            moves is taken for it.
        case: the machine and its filter.
        planned: what the run should have done.
        name: of the plan, for messages.

    Raises:
        RecordingError: the run does not follow the plan's path, or cannot be compared.
    """
    if recording.struts is None or recording.t is None:
        raise RecordingError(f"{recording.source}: is no moving run with struts; it cannot be compared with {name}")
    low_pass = checked_filter(recording, case)
    if recording.lost.any():
        raise RecordingError(f"{recording.source}: has gaps; how fast it went cannot be compared with {name}")
    margin, step = low_pass.margin, low_pass.step
    bad = scan(recording, case).bad
    measured = bridged(recording.struts, bad & ~binary_opening(bad, np.ones(MOST_BRIDGED + 1)))
    speed = np.linalg.norm(low_pass.apply(measured, 1), axis=1)
    on = speed > MOVING if recording.trigger is None else recording.trigger[margin:-margin]
    rows = margin + np.flatnonzero(on)
    count = max(2, round(planned.duration / step) + 1)
    tau = np.clip((np.arange(count + 2 * margin) - margin) * step, 0.0, planned.duration)
    struts = Hexapod.of(case).strut_lengths(planned.at(tau).pose)
    pace = np.linalg.norm(low_pass.apply(struts, 1), axis=1)
    covered, way = (np.cumsum(v) * step for v in (speed[rows - margin], pace))
    if not len(rows) or abs(covered[-1] / way[-1] - 1.0) > SAME_LENGTH:
        length = covered[-1] if len(rows) else 0.0
        raise RecordingError(
            f"{recording.source}: covers {length:.3g} m in the space of the struts, {name} {way[-1]:.3g} m; it is no "
            "run of that plan: name the right one, or record the trigger"
        )
    # Where the plan rests, its way stands still; the little slope makes the inverse unique.
    at = np.interp(covered * way[-1] / covered[-1], way + 1e-12 * np.arange(count), np.arange(count) * step)
    there = np.column_stack([np.interp(at, np.arange(count) * step, s) for s in struts[margin:-margin].T])
    away = float(np.sqrt(np.mean((measured[rows] - there) ** 2)))
    motion = float(np.sqrt(np.mean((struts - struts.mean(axis=0)) ** 2)))
    if away > SAME_PATH * motion:
        raise RecordingError(
            f"{recording.source}: is {away * 1e3:.3g} mm rms from the path of {name}, {100 * away / motion:.2g} % of "
            f"its motion, at most {100 * SAME_PATH:g} % may be; it is no run of that plan: name the right one"
        )
    expected = np.interp(at, np.arange(count) * step, pace)
    width = max(1, round(WINDOW / step))
    done, asked = (uniform_filter1d(v, width, mode="nearest") for v in (speed[rows - margin], expected))
    scale = np.ones(len(recording.forces))
    tells = asked > SLOW * pace.mean()
    scale[rows[tells]] = done[tells] / asked[tells]
    return _stretches(scale, np.flatnonzero(np.abs(scale - 1.0) > AS_PLANNED), max(1, round(LEAST / step)))


def _stretches(scale: Array, rows: NDArray[np.int64], least: int) -> tuple[Stretch, ...]:
    """Rows cut into stretches of one feed, of `least` rows or more; shorter ones are accidents."""
    if not len(rows):
        return ()
    found = []
    for group in np.split(rows, np.flatnonzero(np.diff(rows) > least) + 1):
        if len(group) < least:
            continue
        for part in _joined(_levels(scale[group], max(least // 4, 2)), least):
            marked = np.zeros(len(scale), dtype=bool)
            marked[group[part]] = True
            found.append(Stretch(marked, float(np.median(scale[group[part]]))))
    return tuple(found)


def _joined(parts: list[slice], least: int) -> list[slice]:
    """Short pieces, which are the way from one level to the next, as part of the longer neighbour."""
    parts = list(parts)
    while len(parts) > 1:
        sizes = [p.stop - p.start for p in parts]
        k = int(np.argmin(sizes))
        if sizes[k] >= least:
            break
        beside = k - 1 if k + 1 == len(parts) or (k > 0 and sizes[k - 1] >= sizes[k + 1]) else k + 1
        first, last = min(k, beside), max(k, beside)
        parts[first : last + 1] = [slice(parts[first].start, parts[last].stop)]
    return parts


def _levels(values: Array, least: int) -> list[slice]:
    """Pieces of nearly one level: cut in two where that explains most, as long as the levels differ."""
    count, total = len(values), np.cumsum(values)
    if count >= 2 * least:
        k = np.arange(least, count - least + 1)
        before, after = total[k - 1] / k, (total[-1] - total[k - 1]) / (count - k)
        best = int(np.argmax(k * (count - k) * (before - after) ** 2))
        if abs(before[best] - after[best]) > STEP:
            cut = int(k[best])
            later = [slice(p.start + cut, p.stop + cut) for p in _levels(values[cut:], least)]
            return [*_levels(values[:cut], least), *later]
    return [slice(0, count)]


def about_feed(recording: Recording, stretches: tuple[Stretch, ...], against: str) -> tuple[list[str], dict[str, Any]]:
    """Sentences for people and entries for programs; empty where all went as planned.

    Args:
        recording: the run.
        stretches: found in it.
        against: what they were found by.
    """
    return about_pieces([piece_of(recording, stretch) for stretch in stretches], against)


class Piece(NamedTuple):
    """A stretch as it is told: from when to when [s], from which row to which, and its feed over the planned one."""

    start: float
    end: float
    first: str
    last: str
    scale: float

    @property
    def where(self) -> str:
        """Its rows, `line 12` or `lines 12 to 40`."""
        if self.first == self.last:
            return self.first
        word, first = self.first.rsplit(" ", 1)
        return f"{word}s {first} to {self.last.rsplit(' ', 1)[1]}"


def piece_of(recording: Recording, stretch: Stretch) -> Piece:
    """A stretch of a recording with a clock as it is told."""
    assert recording.t is not None
    first, last = (int(k) for k in np.flatnonzero(stretch.rows)[[0, -1]])
    place = recording.lines.place
    return Piece(float(recording.t[first]), float(recording.t[last]), place(first), place(last), stretch.scale)


def about_pieces(pieces: Sequence[Piece], against: str, more: int = 0) -> tuple[list[str], dict[str, Any]]:
    """The same of stretches that are told already.

    Args:
        pieces: in the order of time.
        against: what they were found by.
        more: stretches beyond them.
    """
    if not pieces:
        return [], {}
    told = [{"from_s": p.start, "to_s": p.end, "feed": p.scale, "where": p.where} for p in pieces]
    named = [f"{p.where} ({p.start:.3f} to {p.end:.3f} s) at {100 * p.scale:.3g} %" for p in pieces[:MOST_NAMED]]
    left = len(pieces) + more - len(named)
    beyond = f" and {left} more stretches" if left else ""
    sentence = f"feed other than 100 %, by {against}: {', '.join(named)}{beyond}; {CONSEQUENCE}"
    return [sentence], {"feed": {"found_by": against, "stretches": told} | ({"more": more} if more else {})}
