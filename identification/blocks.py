"""A file of any length in overlapping blocks, read as often as it is needed: what one block says of itself is kept."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.errors import RecordingError
from cases.schema import Case
from identification.evaluation import MOVING, Run, checked_filter, spoilt_by
from identification.formats.stream import UNIFORMITY, Recording, Stream
from identification.formats.table import Lines
from identification.hexapod import Hexapod
from identification.model import Model
from identification.plausibility import bridged, scan
from identification.recording import read_batches
from identification.signals import Filter

HEAD = 60_000  # rows that give the delay to start from

Rows = NDArray[np.bool_]


@dataclass(slots=True)
class Blocks:
    """The blocks of one file.

    Args:
        path: file, or folder of `hexcite run`.
        case: machine, filter and sensor frame.
        warnings: what is wrong with single samples, with their rows; known after the first reading.
        bad: rows of each batch that no estimate may use; known after the first reading.
        moving: first and last instant of movement [s], which stand for a trigger; None where there is one.
    """

    path: Path
    case: Case
    warnings: list[str] = field(default_factory=list)
    bad: list[NDArray[np.int64]] = field(default_factory=list)
    moving: tuple[float, float] | None = None

    def head(self) -> tuple[Recording, Filter]:
        """The first rows of the window, with what the filter needs around them, and the filter.

        Raises:
            RecordingError: as the reader; channels are missing; the trigger is never on.
        """
        if self.moving is None:
            self._find_movement()
        parts: list[Recording] = []
        on = 0
        for batch in self._batches():
            assert batch.trigger is not None
            if not on:
                parts = parts[-1:]  # of a long standstill before the window only what the filter needs
            parts.append(batch)
            on += int(batch.trigger.sum())
            if on >= HEAD:
                break
        head = _joined(parts)
        if not np.any(head.trigger):
            raise RecordingError(f"{self.path}, trigger: is never 1; record with the trigger or leave it out")
        return head, checked_filter(head, self.case)

    def runs(self, model: Model, low_pass: Filter) -> Iterator[Run]:
        """The blocks, each with the last rows of the one before: filtered samples are those of the whole run."""
        first = not self.bad
        hexapod, passed = Hexapod.of(self.case), 0
        before: tuple[Recording, Rows] | None = None
        step = None
        for number, batch in enumerate(self._batches()):
            if first:
                found = scan(batch, self.case)
                self.warnings += found.warnings
                self.bad.append(np.flatnonzero(found.bad))
            bad = np.zeros(len(batch.forces), dtype=bool)
            bad[self.bad[number]] = True
            part, _ = mended(batch, bad)
            if before is not None:
                part, bad = _joined([before[0], part]), np.r_[before[1], bad]
            assert part.t is not None
            step = part.step if step is None else step
            uneven = np.abs(np.diff(part.t) - step) > UNIFORMITY * step
            if uneven.any():
                _ = part.step  # names the place
            if len(part.t) > 2 * low_pass.margin + 1:
                run = block_run(part, bad, model, hexapod, low_pass, passed)
                passed += run.passed
                yield run.run
                part, bad = _last(part, 2 * low_pass.margin), bad[len(bad) - 2 * low_pass.margin :]
            before = part, bad

    def _batches(self) -> Iterator[Recording]:
        for stream in read_batches(self.path, self.case):
            yield _recording(stream, self.moving)

    def _find_movement(self) -> None:
        """Reads the file once for the first and last movement, where it has no trigger."""
        before: Recording | None = None
        low_pass = None
        start = end = None
        for stream in read_batches(self.path, self.case):
            if stream.trigger is not None:
                return
            part = _recording(stream, (-np.inf, np.inf))
            part = part if before is None else _joined([before, part])
            low_pass = checked_filter(part, self.case) if low_pass is None else low_pass
            if len(part.forces) > 2 * low_pass.margin + 1:
                assert part.t is not None
                assert part.struts is not None
                inner = part.t[low_pass.margin : -low_pass.margin]
                moves = inner[np.abs(low_pass.apply(part.struts, 1)).max(axis=1) > MOVING]
                if len(moves):
                    start, end = float(moves[0]) if start is None else start, float(moves[-1])
                part = _last(part, 2 * low_pass.margin)
            before = part
        self.moving = (-np.inf, np.inf) if start is None or end is None else (start, end)


def mended(recording: Recording, bad: Rows) -> tuple[Recording, Rows]:
    """A recording with bad samples bridged, and these."""
    if not bad.any():
        return recording, bad
    assert recording.struts is not None
    struts, forces = bridged(recording.struts, bad), bridged(recording.forces, bad)
    return replace(recording, struts=struts, forces=forces), bad


@dataclass(frozen=True, slots=True)
class Part:
    """A block as a run, and how many samples of the window it holds."""

    run: Run
    passed: int


def block_run(
    recording: Recording, bad: Rows, model: Model, hexapod: Hexapod, low_pass: Filter, passed: int = 0
) -> Part:
    """A block as a run.

    Args:
        recording: the block, with a trigger; bad samples bridged.
        bad: samples that no estimate may use, shape (n,).
        model: gives A.
        hexapod: kinematics.
        low_pass: the filter.
        passed: samples of the window before this block, so that every stride-th is kept across blocks as in one run.
    """
    assert recording.trigger is not None
    on = recording.trigger[low_pass.margin : -low_pass.margin] & ~spoilt_by(bad, low_pass)
    inside = np.flatnonzero(on)
    rows = inside[(-passed) % low_pass.stride :: low_pass.stride]
    return Part(Run(recording, model, hexapod, low_pass, rows, len(inside)), len(inside))


def _recording(stream: Stream, moving: tuple[float, float] | None) -> Recording:
    """A batch as a recording; raises RecordingError where a channel is not there."""
    if stream.t is None or stream.struts is None or stream.forces is None:
        raise RecordingError(
            f"{stream.source}: is too long to be read at once; in blocks it needs t_s, struts and forces in one file: "
            "add what is missing, or cut the run"
        )
    on = stream.trigger
    if on is None:
        start, end = (-np.inf, np.inf) if moving is None else moving
        on = (stream.t >= start) & (stream.t <= end)
    return Recording(stream.source, stream.t, stream.struts, None, stream.forces, on, lines=stream.lines)


def _joined(parts: list[Recording]) -> Recording:
    if len(parts) == 1:
        return parts[0]
    arrays: dict[str, Any] = {
        n: np.concatenate([getattr(p, n) for p in parts]) for n in ("t", "struts", "forces", "trigger")
    }
    skipped = tuple(s for p in parts for s in p.lines.skipped)
    return replace(parts[0], **arrays, lines=replace(parts[0].lines, skipped=skipped))


def _last(recording: Recording, count: int) -> Recording:
    """The last rows of a recording."""
    rows = len(recording.forces) - count
    assert recording.t is not None
    assert recording.struts is not None
    assert recording.trigger is not None
    place = int(recording.lines.place(rows).rsplit(" ", 1)[1])
    later = tuple(s for s in recording.lines.skipped if s > place)
    return replace(
        recording, t=recording.t[rows:], struts=recording.struts[rows:], forces=recording.forces[rows:],
        trigger=recording.trigger[rows:], lines=Lines(place, later, recording.lines.word),
    )  # fmt: skip
