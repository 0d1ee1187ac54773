"""A run of any length in constant memory: overlapping blocks through the filter, QR of blocks into one triangle.

Read at least twice: the first pass gives parameters, weights and delay; the next ones are at these, look for contacts
and tell what is left of the forces. Blocks overlap by the filter's length, so that filtered samples are those of the
whole run at once.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from cases.errors import IdentificationError, RecordingError
from cases.schema import Case
from identification.estimation.compressed import degrees_of_freedom, determined, inverse_root
from identification.estimation.estimator import best_values
from identification.estimation.estimators import Method, Problem
from identification.estimation.fit import Filtered, Fit
from identification.estimation.selection import Selection
from identification.findings.contact import Calm
from identification.findings.contact_free import require_free
from identification.findings.doubts import doubts, require_scale, require_sense
from identification.findings.plausibility import scan
from identification.formats.stream import Recording
from identification.hexapod import Hexapod
from identification.identify import placed
from identification.long.blocks import Blocks, block_run, mended
from identification.long.total import Total, Touch
from identification.model import identification_model
from identification.noise.components import components_of
from identification.noise.sources import sources_of
from identification.recording import files_of
from identification.result import Delay, Estimate, Evaluation, estimate_of
from identification.runs.conditioning import USUAL, Conditioning
from identification.runs.evaluation import MOST_DELAY
from identification.runs.moving import GAUSS_MARKOV, fit_with_delay
from identification.runs.smoothing import smoothed, smoothing_of
from identification.signals import Filter

Array = NDArray[np.float64]

LONG = 150_000_000  # bytes of a file from which on it is not read at once
PASSES = 6
TOLERANCE = 3e-8  # [s] of the delay between passes; its square is what is left
WEIGHTS_SETTLED = 1e-4  # of each weight between passes; parameters move by far less than their standard deviation
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


def in_blocks(how: Method, conditioning: Conditioning) -> bool:
    """Whether blocks can do what is asked: Gauss-Markov, whatever is known or left out; other estimators need all."""
    return how.name == GAUSS_MARKOV.name and not how.priors and how.biases is None and conditioning == USUAL


def identify_long(
    path: Path, case: Case, number: int | None = None, how: Method = GAUSS_MARKOV, terms: Sequence[str] = ()
) -> LongRun:
    """Identifies parameters by Gauss-Markov from one file of any length.

    The robust standard deviations add those of blocks, contacts are looked for block by block; the rest is as in
    `identify`, with the same result up to rounding (equal weights) or to the tolerance of the weights.

    Args:
        path: one file, or a folder of `hexcite run`.
        case: machine, filter and sensor frame.
        number: of the model in Table 2; 9 by default.
        how: what is known beforehand or left out, and the weights; see `in_blocks`.
        terms: other forms of the error compensation than the model's: K1 to K5.

    Raises:
        IdentificationError, RecordingError: as `identify`.
        ValueError: blocks cannot do what is asked.
    """
    if not in_blocks(how, USUAL):
        raise ValueError(f"{how.name} with priors or biases is not evaluated in blocks")
    model = identification_model(case, 9 if number is None else number, terms)
    try:
        return _identified(path, case, Problem.of(model, case, how), how)
    except IdentificationError as error:
        raise IdentificationError(placed(str(path), error)) from error
    except RecordingError as error:
        raise RecordingError(placed(str(path), error)) from error


class _Free(NamedTuple):
    """What is estimated of u and of the nuisances beside it: u = offset + basis @ free."""

    names: list[str]
    offset: Array
    basis: Array

    @classmethod
    def of(cls, selection: Selection, nuisances: tuple[str, ...]) -> "_Free":
        beside = len(nuisances)
        basis = block_diag(selection.basis, np.eye(beside))
        return cls([*selection.names, *nuisances], np.r_[selection.offset, np.zeros(beside)], basis)


def _identified(path: Path, case: Case, problem: Problem, how: Method) -> LongRun:
    model, blocks = problem.model, Blocks(path, case)
    selection = how.selection(model)
    head, low_pass = blocks.head()
    usable, bad = mended(head, scan(head, case, most=1.0).bad)
    begin = block_run(usable, bad, model, Hexapod.of(case), low_pass).run
    first = fit_with_delay(begin, how, problem)
    count = len(model.names)
    begin = smoothed(begin, first.fit, selection.basis, first.w, first.delay.value)
    delay, values, bend = first.delay.value, first.fit.values[:count], 0.0
    root = np.diag(np.sqrt(first.fit.weights)) if first.whitening is None else first.whitening
    weighing = not problem.pooled
    contacts: tuple[Touch, ...] = ()
    sensors = case.sensors
    shaken = sensors if sensors.strut_variance is not None or sensors.acceleration_noise is not None else None
    total = Total(delay, values, root, weighing)
    for number in range(PASSES):
        free = _Free.of(selection, begin.nuisances)
        # The first reading has the parameters of its head only, too little to tell a contact by.
        calm = Calm.of(total.kept) if number else None
        total = Total(delay, values, root, weighing, shaken if number else None, calm, contacts, begin.smoothing, bend)
        for run in blocks.runs(model, low_pass):
            total.add(run)
        if total.looked_at:
            require_free(total.touched / total.looked_at, [_told(t) for t in total.found], model)
        compressed = total.compressed(free.offset, free.basis)
        found = free.offset + free.basis @ best_values(compressed, free.names, len(begin.nuisances))
        step = float(np.clip(found[-1], -MOST_DELAY / 2, MOST_DELAY / 2))
        values, bend = found[:count], float(found[count]) if begin.smoothing else 0.0
        newer = _new_root(total, values, problem, low_pass, free)
        settled = abs(step) < TOLERANCE and np.all(
            np.abs(np.sum(newer**2, axis=0) / total.weights - 1.0) < WEIGHTS_SETTLED
        )
        if number and settled and _alike(total.found, contacts):  # what is left is then what the estimate leaves
            break
        contacts, root = total.found, newer
        if not number and not begin.smoothing:  # the whole run may tell what its head did not
            share = begin.samples / total.samples
            begin = smoothed(begin, first.fit, selection.basis, first.w, first.delay.value, share)
        delay = float(np.clip(delay + step, -MOST_DELAY, MOST_DELAY))
    fit = _fit(total, found, free, low_pass)
    require_sense(model, fit)
    require_scale(model, fit.values, case)
    std = float(np.sqrt(max(fit.covariance[-1, -1], fit.covariance_robust[-1, -1])))
    smoothing = smoothing_of(begin, fit) if begin.smoothing else None
    notes: list[str] = [] if smoothing is None else smoothing.notes
    slower, told = blocks.feed.told()
    if smoothing is not None:
        told["smoothing_s2"] = smoothing._asdict()
    if head.averaged is not None:
        notes, told = [*notes, head.averaged.note(total.root.T @ total.root, fit.s0)], told | head.averaged.to_json()
    w = total.root.T @ total.root
    noise = None
    if sensors.state_noise:
        effect = None if total.noise is None else total.noise.of_samples(total.rows)
        noise = sources_of(effect, fit, w, Filtered(low_pass.noise_gain, low_pass.stride), sensors)
    components = components_of(total.products, total.rows, low_pass, model, found, case.sensor_frame.bars is None)
    if components is not None:
        told["noise_components"] = components.to_json()
        notes = [*notes, *components.notes(how.weights or sensors.weights)]
    about = Evaluation(
        total.samples, total.kept, Delay(total.delay + float(found[-1]), std), noise, notes=tuple(notes), told=told
    )
    warnings = (
        *blocks.warnings[:MOST_WARNINGS],
        *(f"{_told(t)}; left out" for t in total.found[:MOST_WARNINGS]),
        *doubts(fit, total.kept_forces),
        *slower,
    )
    more = len(total.found) - MOST_WARNINGS
    if more > 0:
        warnings += (f"and {more} more contacts",)
    if noise is not None:
        warnings += tuple(noise.doubts)
    estimate = estimate_of(model, fit, str(path), case, about, how, warnings)
    rms = np.sqrt(total.squares / total.rows)
    return LongRun(replace(estimate, residual_rms=rms, s0_N=float(np.sqrt(np.mean(rms**2)))), head)


def _new_root(total: Total, values: Array, problem: Problem, low_pass: Filter, free: _Free) -> Array:
    """C with W = C^T C as the parameters or the residuals of a reading say, shape (6, 6)."""
    if problem.noise is not None:
        return problem.noise.whitening(values)
    if problem.pooled:
        return total.root
    return np.diag(np.sqrt(total.new_weights(low_pass, problem.alike, free.basis)))


def _told(touch: Touch) -> str:
    contact, word = touch.contact, touch.first.split()[0]
    return (
        f"{word}s {touch.first.split()[-1]} to {touch.last.split()[-1]}: external contact from {contact.start:.3f} to "
        f"{contact.end:.3f} s, up to {contact.peak:.3g} N"
    )


def _alike(some: tuple[Touch, ...], others: tuple[Touch, ...]) -> bool:
    return [t.contact[:2] for t in some] == [t.contact[:2] for t in others]


def _fit(total: Total, found: Array, free: _Free, low_pass: Filter) -> Fit:
    compressed = total.compressed(free.offset, free.basis)
    nuisances = len(found) - len(total.values)
    rank, condition = determined(compressed.root, free.names, compressed.rows, nuisances)
    filtered = Filtered(low_pass.noise_gain, low_pass.stride)
    freedom = degrees_of_freedom(compressed.rows, len(free.names), filtered)
    s0 = float(np.sqrt(compressed.rest * low_pass.stride / freedom))
    half = free.basis @ inverse_root(compressed.root)
    inverse = half @ half.T
    assert total.meat is not None
    robust = inverse @ total.meat @ inverse
    covariance = s0**2 / low_pass.stride * inverse
    return Fit(found, covariance, robust, s0, freedom, total.kept, total.weights, rank, condition)
