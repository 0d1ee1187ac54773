"""A run of any length in constant memory: overlapping blocks through the filter, QR of blocks into one triangle.

Read twice: the first pass gives parameters and delay, the second one is at that delay and tells what is left of the
forces. Blocks overlap by the filter's length, so that filtered samples are those of the whole run at once.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError, RecordingError
from cases.schema import Case
from identification.compressed import Compressed, degrees_of_freedom, determined, inverse_root, scores
from identification.estimator import best_values
from identification.estimators import Problem
from identification.evaluation import MOST_DELAY, Run, checked_filter
from identification.fit import Filtered, Fit, long_run_covariance
from identification.formats.stream import UNIFORMITY, Recording, Stream
from identification.formats.table import Lines
from identification.hexapod import Hexapod
from identification.identify import GAUSS_MARKOV, fit_with_delay, placed
from identification.model import Model, identification_model
from identification.plausibility import bridged, scan
from identification.recording import files_of, read_batches
from identification.result import Delay, Estimate, Evaluation, estimate_of
from identification.signals import Filter

Array = NDArray[np.float64]

LONG = 150_000_000  # bytes of a file from which on it is not read at once
HEAD = 60_000  # rows that give the delay to start from
PASSES = 5
TOLERANCE = 3e-8  # [s] of the delay between passes; its square is what is left
MOST_KEPT = 20_000  # residuals kept for the plots
MOST_WARNINGS = 10


def is_long(path: Path) -> bool:
    """Whether a recording is to be evaluated in blocks."""
    try:
        return files_of([path])[0].stat().st_size > LONG
    except OSError:  # the reader explains it
        return False


class LongRun(NamedTuple):
    """The result of a long run, and its head, which stands for it where a whole recording is needed."""

    estimate: Estimate
    head: Recording


def identify_long(path: Path, case: Case, number: int | None = None) -> LongRun:
    """Identifies parameters by Gauss-Markov with equal weights from one file of any length.

    Contacts are not searched for, and the robust standard deviations add those of blocks; the rest is as in
    `identify`, with the same result up to rounding.

    Args:
        path: one file, or a folder of `hexcite run`.
        case: machine, filter and sensor frame.
        number: of the model in Table 2; 9 by default.

    Raises:
        IdentificationError, RecordingError: as `identify`; a case with channel weights, a run without trigger.
    """
    model = identification_model(case, 9 if number is None else number)
    if case.sensors.weights != "equal":
        raise RecordingError(
            f"{path}: is too long to be read at once, and channel weights need that; cut it, or set sensors.weights = "
            "equal"
        )
    try:
        return _identified(path, case, model)
    except IdentificationError as error:
        raise IdentificationError(placed(str(path), error)) from error
    except RecordingError as error:
        raise RecordingError(placed(str(path), error)) from error


def _identified(path: Path, case: Case, model: Model) -> LongRun:
    head, low_pass = _head(path, case)
    first = fit_with_delay(
        _run(head, case, model, low_pass, _Window()), GAUSS_MARKOV, Problem.of(model, case, GAUSS_MARKOV)
    )
    names, delay, values = [*model.names, "delay"], first.delay.value, first.fit.values[:-1]
    total = _Total()
    for number in range(PASSES):
        total = _Total()
        for run in _runs(path, case, model, low_pass, total):
            total.add(run, delay, values)
        found = best_values(total.compressed, names, 1)
        step = float(np.clip(found[-1], -MOST_DELAY / 2, MOST_DELAY / 2))
        values = found[:-1]
        if number and abs(step) < TOLERANCE:  # at the second reading the residuals are those of the estimate
            break
        delay = float(np.clip(delay + step, -MOST_DELAY, MOST_DELAY))
    fit = _fit(total, found, names, low_pass)
    robust = float(np.sqrt(fit.covariance_robust[-1, -1]))
    about = Evaluation(total.samples, total.kept, Delay(delay + float(found[-1]), robust))
    warnings = (
        *total.warnings[:MOST_WARNINGS],
        *fit.doubts,
        "a long run, evaluated in blocks: external contacts were not searched for",
    )
    if case.sensors.state_noise:
        warnings += ("a long run, evaluated in blocks: s0 is not compared with the noise that the case states",)
    estimate = estimate_of(model, fit, str(path), case, about, GAUSS_MARKOV, warnings)
    rms = np.sqrt(total.squares / total.rows)
    return LongRun(replace(estimate, residual_rms=rms, s0_N=float(np.sqrt(np.mean(rms**2)))), head)


@dataclass(slots=True)
class _Window:
    """How many samples of the window have passed: every stride-th is kept, across blocks as in one run."""

    passed: int = 0

    def rows(self, on: NDArray[np.bool_], stride: int) -> NDArray[np.int64]:
        """Indices that are kept of samples that are on or off."""
        inside = np.flatnonzero(on)
        kept = inside[(-self.passed) % stride :: stride]
        self.passed += len(inside)
        return kept


@dataclass(slots=True)
class _Total:
    """What is left of a run after its blocks: a triangle and sums."""

    triangle: Array | None = None
    rows: int = 0
    samples: int = 0
    squares: Array = field(default_factory=lambda: np.zeros(6))
    meat: Array | None = None
    pieces: list[Array] = field(default_factory=list)
    thinning: int = 1
    warnings: list[str] = field(default_factory=list)

    def add(self, run: Run, delay: float, values: Array) -> None:
        """One block more, at a delay; what it leaves at earlier values."""
        if not len(run.rows):
            return
        matrices, forces = run.regressors(delay), run.forces
        augmented = np.dstack([matrices, run.effect_of_delay(delay, matrices, values)])
        joined = np.concatenate([augmented, forces[:, :, None]], axis=2).reshape(-1, augmented.shape[2] + 1)
        stacked = joined if self.triangle is None else np.vstack([self.triangle, joined])
        self.triangle = np.asarray(np.linalg.qr(stacked, mode="r"))
        self.rows += len(run.rows)
        self.samples += run.samples
        expected = matrices @ values
        self.squares = self.squares + np.sum((run.recorded_forces - expected) ** 2, axis=0)
        left = forces - expected
        meat = long_run_covariance(scores(augmented, left, np.ones(6)))
        self.meat = meat if self.meat is None else self.meat + meat
        self.pieces.append(left[:: self.thinning])
        if sum(map(len, self.pieces)) > MOST_KEPT:
            self.pieces = [np.vstack(self.pieces)[::2]]
            self.thinning *= 2

    @property
    def kept(self) -> Array:
        """Residuals behind the filter, thinned, shape (k, 6)."""
        return np.vstack(self.pieces)

    @property
    def compressed(self) -> Compressed:
        """The QR of all blocks."""
        assert self.triangle is not None
        r = self.triangle
        return Compressed(r[:-1, :-1], r[:-1, -1], float(r[-1, -1] ** 2), 6 * self.rows)


def _fit(total: _Total, found: Array, names: list[str], low_pass: Filter) -> Fit:
    compressed = total.compressed
    rank, condition = determined(compressed.root, names, compressed.rows, 1)
    filtered = Filtered(low_pass.noise_gain, low_pass.stride)
    freedom = degrees_of_freedom(compressed.rows, len(names), filtered)
    s0 = float(np.sqrt(compressed.chi_squared(found) * low_pass.stride / freedom))
    half = inverse_root(compressed.root)
    inverse = half @ half.T
    assert total.meat is not None
    robust = inverse @ total.meat @ inverse
    covariance = s0**2 / low_pass.stride * inverse
    return Fit(found, covariance, robust, s0, freedom, total.kept, np.ones(6), rank, condition)


def _head(path: Path, case: Case) -> tuple[Recording, Filter]:
    """The first rows of the window, with what the filter needs around them, and the filter."""
    parts: list[Recording] = []
    on = 0
    for batch in _batches(path, case):
        assert batch.trigger is not None
        if not on:
            parts = parts[-1:]  # of a long standstill before the window only what the filter needs
        parts.append(batch)
        on += int(batch.trigger.sum())
        if on >= HEAD:
            break
    head = _joined(parts)
    if not np.any(head.trigger):
        raise RecordingError(f"{path}, trigger: is never 1; record with the trigger or leave it out")
    return head, checked_filter(head, case)


def _runs(path: Path, case: Case, model: Model, low_pass: Filter, total: _Total) -> Iterator[Run]:
    """The blocks of a run, each with the last rows of the one before."""
    window, before, step = _Window(), None, None
    for batch in _batches(path, case):
        found = scan(batch, case)
        total.warnings += found.warnings
        part = batch
        if found.bad.any():
            assert batch.struts is not None
            part = replace(batch, struts=bridged(batch.struts, found.bad), forces=bridged(batch.forces, found.bad))
        joined = part if before is None else _joined([before, part])
        assert joined.t is not None
        step = joined.step if step is None else step
        uneven = np.abs(np.diff(joined.t) - step) > UNIFORMITY * step
        if uneven.any():
            _ = joined.step  # names the place
        if len(joined.t) <= 2 * low_pass.margin + 1:
            before = joined
            continue
        yield _run(joined, case, model, low_pass, window)
        before = _last(joined, 2 * low_pass.margin)


def _run(recording: Recording, case: Case, model: Model, low_pass: Filter, window: _Window) -> Run:
    assert recording.trigger is not None
    on = recording.trigger[low_pass.margin : -low_pass.margin]
    rows = window.rows(on, low_pass.stride)
    return Run(recording, model, Hexapod.of(case), low_pass, rows, int(on.sum()))


def _batches(path: Path, case: Case) -> Iterator[Recording]:
    for stream in read_batches(path, case):
        yield _recording(stream)


def _recording(stream: Stream) -> Recording:
    """A batch as a recording; raises RecordingError where a channel is not there."""
    if stream.t is None or stream.struts is None or stream.forces is None or stream.trigger is None:
        raise RecordingError(
            f"{stream.source}: is too long to be read at once; in blocks it needs t_s, struts, forces and trigger in "
            "one file: add what is missing, or cut the run"
        )
    return Recording(stream.source, stream.t, stream.struts, None, stream.forces, stream.trigger, lines=stream.lines)


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
