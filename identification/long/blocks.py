"""A file of any length in overlapping blocks, read as often as it is needed: what one block says of itself is kept."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import RecordingError
from cases.schema import Case
from identification.findings.plausibility import NO_FILTER, behind, bridged, require_usable, scan
from identification.formats.clock import lost_samples, require_step
from identification.formats.stream import Recording, Stream
from identification.hexapod import Hexapod
from identification.long.ahead import ahead
from identification.long.feed import LongFeed
from identification.long.rates import at_their_samples, first_rows, gathered, joined, last_rows
from identification.model import Model
from identification.recording import read_batches
from identification.runs.evaluation import Run
from identification.runs.preparation import MOST_BRIDGED, MOVING, about_left_out, checked_filter, spoilt_by
from identification.runs.rates import HELD_CHANGES, Rhythm, changes_of, rhythm_of
from identification.signals import Filter

HEAD = 60_000  # rows that give the delay to start from
LEAST = 16_384  # rows of a block: what blocks have in common, the filter's length, is then a small part of them
_ALWAYS = (-np.inf, np.inf)

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
        held: how struts are held that come at a lower rate than the rows; known once the file has been looked at.
        feed: what the file says of the feed; known after the first reading.
        window: samples of the excitation, those that are missing included; known after the first reading.
        left_out: of these, by damage and the filter's reach around it.
    """

    path: Path
    case: Case
    warnings: list[str] = field(default_factory=list)
    bad: list[NDArray[np.int64]] = field(default_factory=list)
    moving: tuple[float, float] | None = None
    held: Rhythm | None = None
    feed: LongFeed = field(default_factory=LongFeed)
    window: int = 0
    left_out: int = 0

    def head(self) -> tuple[Recording, Filter]:
        """The first rows of the window, with what the filter needs around them, and the filter.

        Raises:
            RecordingError: as the reader; channels are missing; the trigger is never on.
        """
        self.held = self._rhythm()
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
        head = joined(parts)
        if not np.any(head.trigger):
            raise RecordingError(f"{self.path}, trigger: is never 1; record with the trigger or leave it out")
        return head, checked_filter(head, self.case)

    def runs(self, model: Model, low_pass: Filter) -> Iterator[Run]:
        """The blocks, each with the last rows of the one before: filtered samples are those of the whole run."""
        first = not self.bad
        hexapod, passed = Hexapod.of(self.case), 0
        before: _Behind | None = None
        step = None
        rows = 0
        for number, batch in enumerate(self._batches()):
            rows += len(batch.forces)
            if first:
                self._look_at(batch, None if before is None else before.recording)
            bad = np.zeros(len(batch.forces), dtype=bool)
            bad[self.bad[number]] = True
            part, known = batch, 0
            if before is not None:
                part, bad, known = joined([before.recording, batch]), np.r_[before.bad, bad], before.known
            assert part.t is not None
            step = part.step if step is None else step
            require_step(part.source, part.t, part.lines, step)
            held = _few_at_the_end(bad)  # to be bridged when the next block tells where to
            used = len(bad) - held
            if used - known > 2 * low_pass.margin + 1:
                block, _ = mended(first_rows(part, used), bad[:used])
                run = block_run(block, bad[:used], model, hexapod, low_pass, passed, known)
                passed += run.passed
                if first:
                    self.window, self.left_out = self.window + run.window, self.left_out + run.left_out
                yield run.run
                overlap = 2 * low_pass.margin + held
                known = 1 + _few_at_the_end(bad[: len(bad) - overlap]) if bad[len(bad) - overlap] else 0
                part, bad = last_rows(part, overlap + known), bad[len(bad) - overlap - known :]
            before = _Behind(part, bad, known)
        if first:
            require_usable(str(self.path), sum(map(len, self.bad)), rows, self.warnings)
        if first and self.window:
            self.warnings[:0] = about_left_out(str(self.path), self.left_out / self.window, low_pass)

    def _look_at(self, batch: Recording, before: Recording | None) -> None:
        """What the first reading is to say of a batch, and what follows the rows before it."""
        if before is not None and before.t is not None and batch.t is not None:
            lost = int(lost_samples(np.r_[before.t[-1], batch.t])[0])
            if lost:
                last = np.array([len(before.t) - 1])
                self.warnings.append(f"{behind(before.lines, last, lost)}; {NO_FILTER}")
        found = scan(batch, self.case, most=1.0)  # of the whole run, not of a block
        self.warnings += found.warnings
        # Without a trigger every recorded override counts, as in a whole run.
        self.feed.add(batch if self.moving is None else replace(batch, trigger=None))
        self.bad.append(np.flatnonzero(found.bad))

    def _batches(self) -> Iterator[Recording]:
        yield from self._batches_of(self.moving)

    def _batches_of(self, moving: tuple[float, float] | None) -> Iterator[Recording]:
        parts = (_recording(stream, self.case, moving) for stream in ahead(read_batches(self.path, self.case)))
        return gathered(parts if self.held is None else at_their_samples(parts, self.held, self.case), LEAST)

    def _rhythm(self) -> Rhythm | None:
        """How struts are held, by the first rows in which they change."""
        parts: list[Recording] = []
        rows = passed = 0
        for stream in read_batches(self.path, self.case):
            parts.append(_recording(stream, self.case, _ALWAYS))
            rows += len(parts[-1].forces)
            if rows >= HEAD:
                struts = joined(parts).struts
                assert struts is not None
                if len(changes_of(struts)) >= HELD_CHANGES:
                    break
                parts, rows, passed = [], 0, passed + rows
        if not parts:
            return None
        struts = joined(parts).struts
        assert struts is not None
        found = rhythm_of(struts)
        return None if found is None else Rhythm(found.ratio, (found.phase + passed) % found.ratio)

    def _find_movement(self) -> None:
        """Reads the file once for the first and last movement, where it has no trigger."""
        for stream in read_batches(self.path, self.case):
            if stream.trigger is not None:
                return
            break
        before: Recording | None = None
        low_pass = None
        start = end = None
        for batch in self._batches_of(_ALWAYS):
            part = batch if before is None else joined([before, batch])
            low_pass = checked_filter(part, self.case) if low_pass is None else low_pass
            if len(part.forces) > 2 * low_pass.margin + 1:
                assert part.t is not None
                assert part.struts is not None
                inner = part.t[low_pass.margin : -low_pass.margin]
                moves = inner[np.abs(low_pass.apply(part.struts, 1)).max(axis=1) > MOVING]
                if len(moves):
                    start, end = float(moves[0]) if start is None else start, float(moves[-1])
                part = last_rows(part, 2 * low_pass.margin)
            before = part
        self.moving = _ALWAYS if start is None or end is None else (start, end)


def mended(recording: Recording, bad: Rows) -> tuple[Recording, Rows]:
    """A recording with bad samples bridged, and these."""
    if not bad.any():
        return recording, bad
    assert recording.struts is not None
    struts, forces = bridged(recording.struts, bad), bridged(recording.forces, bad)
    return replace(recording, struts=struts, forces=forces), bad


class _Behind(NamedTuple):
    """Rows that the next block begins with.

    Args:
        recording: the rows.
        bad: samples among them that no estimate may use, shape (n,).
        known: first of them that only tell where to bridge to.
    """

    recording: Recording
    bad: Rows
    known: int


def _few_at_the_end(bad: Rows) -> int:
    """Bad samples at the end where they are few enough to be bridged; 0 where they are more."""
    end = bad[-MOST_BRIDGED - 1 :][::-1]
    return 0 if end.all() else int(np.argmin(end))


@dataclass(frozen=True, slots=True)
class Part:
    """A block as a run, how many samples it evaluates, and of how many of the window it left how many out."""

    run: Run
    passed: int
    window: int
    left_out: int


def block_run(
    recording: Recording, bad: Rows, model: Model, hexapod: Hexapod, low_pass: Filter, passed: int = 0, known: int = 0
) -> Part:
    """A block as a run.

    Args:
        recording: the block, with a trigger; bad samples bridged.
        bad: samples that no estimate may use, shape (n,).
        model: gives A.
        hexapod: kinematics.
        low_pass: the filter.
        passed: samples of the window before this block, so that every stride-th is kept across blocks as in one run.
        known: rows at its beginning beside those that the filter needs: evaluated in the block before.
    """
    assert recording.trigger is not None
    inner = slice(low_pass.margin, -low_pass.margin)
    window, spoilt = recording.trigger[inner].copy(), spoilt_by(bad, recording.lost, low_pass)
    window[:known] = False
    before = slice(low_pass.margin - 1, -low_pass.margin - 1)
    lost = int(recording.lost[low_pass.margin - 1 : -low_pass.margin][window & recording.trigger[before]].sum())
    inside = np.flatnonzero(window & ~spoilt)
    rows = inside[(-passed) % low_pass.stride :: low_pass.stride]
    count = int(window.sum())
    run = Run(recording, model, hexapod, low_pass, rows, len(inside), spoilt=spoilt)
    return Part(run, len(inside), count + lost, count - len(inside) + lost)


def fits_blocks(path: Path, case: Case) -> bool:
    """Whether one file holds struts or poses, forces and a clock for all of them.

    Raises:
        RecordingError: as the reader.
    """
    for stream in read_batches(path, case):
        placed = stream.struts is not None or stream.poses is not None
        return placed and stream.t is not None and stream.forces is not None
    return True


def _recording(stream: Stream, case: Case, moving: tuple[float, float] | None) -> Recording:
    """A batch as a recording; raises RecordingError where a channel is not there."""
    struts = stream.struts
    if struts is None and stream.poses is not None:
        struts = Hexapod.of(case).strut_lengths(stream.poses)
    if stream.t is None or struts is None or stream.forces is None:
        raise RecordingError(
            f"{stream.source}: is too long to be read at once; in blocks it needs t_s, struts or poses, and forces in "
            "one file: add what is missing, or cut the run"
        )
    on = stream.trigger
    if on is None:
        start, end = _ALWAYS if moving is None else moving
        on = (stream.t >= start) & (stream.t <= end)
    missing = np.zeros(len(stream.forces), dtype=bool) if stream.missing is None else stream.missing
    return Recording(
        stream.source, stream.t, struts, None, stream.forces, on, lines=stream.lines, override=stream.override,
        missing=missing, missing_in=stream.missing_in,
    )  # fmt: skip
