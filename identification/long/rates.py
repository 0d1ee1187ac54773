"""Pieces of a long run: put together, cut, and, where struts are held over several rows, brought to their samples."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from cases.errors import RecordingError
from cases.schema import Case
from identification.formats.stream import Recording
from identification.runs.rates import HELD, HELD_CHANGES, Rhythm, changes_of, released

_ARRAYS = ("t", "struts", "forces", "trigger", "override", "missing")


def at_their_samples(parts: Iterator[Recording], rhythm: Rhythm, case: Case) -> Iterator[Recording]:
    """The blocks of a run with held struts, each with one row a sample of the struts.

    Args:
        parts: consecutive rows of the file.
        rhythm: counted from the first row of the file.
        case: range of the sensors.

    Raises:
        RecordingError: the struts lose their rhythm.
    """
    before: Recording | None = None
    passed = 0  # rows of the file before those at hand
    for part in parts:
        rows = part if before is None else joined([before, part])
        local = Rhythm(rhythm.ratio, (rhythm.phase - passed) % rhythm.ratio)
        _require_rhythm(rows, local)
        found = released(rows, local, case)
        before = rows
        if found is None:
            continue
        yield found
        # The next block begins one sample of the struts before the last that was given: so it goes on behind it.
        assert found.t is not None
        assert rows.t is not None
        last = int(np.searchsorted(rows.t, found.t[-1])) - rhythm.ratio
        before, passed = last_rows(rows, len(rows.forces) - last), passed + last


def _require_rhythm(rows: Recording, rhythm: Rhythm) -> None:
    assert rows.struts is not None
    changes = changes_of(rows.struts)
    off = changes % rhythm.ratio != rhythm.phase
    if len(changes) >= HELD_CHANGES and off.mean() > 1.0 - HELD:
        raise RecordingError(
            f"{rows.source}, {rows.lines.place(int(changes[off][0]))}: the struts were held for {rhythm.ratio} rows "
            "each, from here on they change at others; export the run at one rate of the struts, or cut it here"
        )


def gathered(parts: Iterator[Recording], rows: int) -> Iterator[Recording]:
    """Consecutive pieces of a file, so many of them together that they have at least `rows`; the last may have less."""
    pile: list[Recording] = []
    for part in parts:
        pile.append(part)
        if sum(len(p.forces) for p in pile) >= rows:
            yield joined(pile)
            pile = []
    if pile:
        yield joined(pile)


def joined(parts: list[Recording]) -> Recording:
    """Consecutive pieces of a file as one."""
    if len(parts) == 1:
        return parts[0]
    arrays: dict[str, Any] = {
        n: None if getattr(parts[0], n) is None else np.concatenate([getattr(p, n) for p in parts]) for n in _ARRAYS
    }
    names = tuple(dict.fromkeys(n for p in parts for n in p.missing_in))
    skipped = tuple(dict.fromkeys(s for p in parts for s in p.lines.skipped))
    starts = np.cumsum([0, *(len(p.forces) * p.lines.every for p in parts)]).tolist()
    inserted = tuple(start + k for start, p in zip(starts, parts, strict=False) for k in p.lines.inserted)
    lines = replace(parts[0].lines, skipped=skipped, inserted=inserted)
    return replace(parts[0], **arrays, missing_in=names, lines=lines)


def first_rows(recording: Recording, count: int) -> Recording:
    """The first rows of a recording."""
    arrays: dict[str, Any] = {
        n: None if getattr(recording, n) is None else getattr(recording, n)[:count] for n in _ARRAYS
    }
    return replace(recording, **arrays)


def last_rows(recording: Recording, count: int) -> Recording:
    """The last rows of a recording."""
    rows = len(recording.forces) - count
    arrays: dict[str, Any] = {
        n: None if getattr(recording, n) is None else getattr(recording, n)[rows:] for n in _ARRAYS
    }
    place = int(recording.lines.place(rows).rsplit(" ", 1)[1])
    later = tuple(s for s in recording.lines.skipped if s > place)
    return replace(recording, **arrays, lines=replace(recording.lines.later(rows), first=place, skipped=later))
