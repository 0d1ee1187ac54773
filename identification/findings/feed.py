"""Feed override other than 100 %, by the control's own column."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from identification.finding import Finding, Kind, warning
from identification.formats.stream import Recording

Array = NDArray[np.float64]

STEP = 0.07  # of the feed, by which neighbouring stretches differ
MOST_NAMED = 3
CONSEQUENCE = (
    "the parameters are valid, for they come from the measured motion; figures of the plan (duration, predicted "
    "standard deviations, efficiency) are not of this run, whose accelerations go with the square of its feed"
)


class Stretch(NamedTuple):
    """Samples that went at one feed: a slice of the recording, and the feed over the programmed one."""

    rows: slice
    scale: float


def recorded_overrides(recording: Recording) -> tuple[Stretch, ...]:
    """Stretches of the motion that the recording's own column says went at another feed than 100 %."""
    if recording.override is None or recording.t is None:
        return ()
    on = np.ones(len(recording.forces), dtype=bool) if recording.trigger is None else recording.trigger
    rows = np.flatnonzero(on & (np.abs(recording.override - 1.0) > 1e-6))
    return tuple(
        Stretch(slice(int(part[0]), int(part[-1]) + 1), float(np.median(recording.override[part])))
        for group in np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
        for part in np.split(group, 1 + np.flatnonzero(np.abs(np.diff(recording.override[group])) > STEP))
        if len(part)
    )


def other_feed(recording: Recording) -> list[Finding]:
    """What went at another feed than 100 %."""
    stretches = recorded_overrides(recording)
    if not stretches:
        return []
    assert recording.t is not None
    told, named = [], []
    for rows, scale in stretches:
        first, last = (recording.lines.place(k) for k in (rows.start, rows.stop - 1))
        word, number = first.rsplit(" ", 1)
        where = first if first == last else f"{word}s {number} to {last.rsplit(' ', 1)[1]}"
        start, end = float(recording.t[rows.start]), float(recording.t[rows.stop - 1])
        told.append({"from_s": start, "to_s": end, "feed": scale, "where": where})
        named.append(f"{where} ({start:.3f} to {end:.3f} s) at {100 * scale:.3g} %")
    more = f" and {len(named) - MOST_NAMED} more stretches" if len(named) > MOST_NAMED else ""
    found_by = "the recorded override"
    sentence = f"feed other than 100 %, by {found_by}: {', '.join(named[:MOST_NAMED])}{more}; {CONSEQUENCE}"
    return [warning(Kind.FEED, sentence, feed={"found_by": found_by, "stretches": told})]
