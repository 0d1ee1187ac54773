"""A run of any length in constant memory: overlapping blocks through the filter, QR of blocks into one triangle.

Read at least twice: the first pass gives parameters, weights and delay; the next ones are at these, look for contacts
and tell what is left of the forces. Blocks overlap by the filter's length, so that filtered samples are those of the
whole run at once.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError, RecordingError
from cases.schema import Case
from identification.blocks import Blocks, block_run, mended
from identification.compressed import Compressed, degrees_of_freedom, determined, inverse_root, scores, triangle
from identification.contact import NEAR, Contact, find_contacts, touched
from identification.contact_free import require_free
from identification.estimator import WEIGHT_ROUNDS, WEIGHT_TOLERANCE, best_values
from identification.estimators import Problem
from identification.evaluation import MOST_DELAY, Run
from identification.fit import Filtered, Fit, long_run_covariance
from identification.formats.stream import Recording
from identification.hexapod import Hexapod
from identification.identify import placed
from identification.model import identification_model
from identification.moving import GAUSS_MARKOV, fit_with_delay
from identification.plausibility import scan
from identification.recording import files_of
from identification.result import Delay, Estimate, Evaluation, estimate_of
from identification.signals import Filter
from identification.smoothing import smoothed, smoothing_of

Array = NDArray[np.float64]

LONG = 150_000_000  # bytes of a file from which on it is not read at once
PASSES = 6
TOLERANCE = 3e-8  # [s] of the delay between passes; its square is what is left
WEIGHTS_SETTLED = 1e-4  # of each weight between passes; parameters move by far less than their standard deviation
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
    """Identifies parameters by Gauss-Markov from one file of any length, weights equal, per channel or per unit.

    The robust standard deviations add those of blocks, contacts are looked for block by block; the rest is as in
    `identify`, with the same result up to rounding (equal weights) or to the tolerance of the weights.

    Args:
        path: one file, or a folder of `hexcite run`.
        case: machine, filter and sensor frame.
        number: of the model in Table 2; 9 by default.

    Raises:
        IdentificationError, RecordingError: as `identify`; a case with weights from stated noise.
    """
    model = identification_model(case, 9 if number is None else number)
    problem = Problem.of(model, case, GAUSS_MARKOV)
    if problem.noise is not None:
        raise RecordingError(
            f"{path}: is too long to be read at once, and weights from stated noise need that; cut it, or choose other "
            "sensors.weights"
        )
    try:
        return _identified(path, case, problem)
    except IdentificationError as error:
        raise IdentificationError(placed(str(path), error)) from error
    except RecordingError as error:
        raise RecordingError(placed(str(path), error)) from error


def _identified(path: Path, case: Case, problem: Problem) -> LongRun:
    model, blocks = problem.model, Blocks(path, case)
    head, low_pass = blocks.head()
    usable, bad = mended(head, scan(head, case).bad)
    begin = block_run(usable, bad, model, Hexapod.of(case), low_pass).run
    first = fit_with_delay(begin, GAUSS_MARKOV, problem)
    count, basis = len(model.names), np.eye(len(model.names))
    begin = smoothed(begin, first.fit, basis, first.w, first.delay.value)
    delay, values, weights, bend = first.delay.value, first.fit.values[:count], first.fit.weights, 0.0
    contacts: tuple[Touch, ...] = ()
    total = _Total(delay, values, weights)
    for number in range(PASSES):
        names = [*model.names, *begin.nuisances]
        # The first reading has the parameters of its head only, too little to tell a contact by.
        total = _Total(delay, values, weights, total.kept if number else None, contacts, begin.smoothing, bend)
        for run in blocks.runs(model, low_pass):
            total.add(run)
        if total.looked_at:
            require_free(total.touched / total.looked_at, [_told(t) for t in total.found])
        found = best_values(total.compressed, names, len(begin.nuisances))
        step = float(np.clip(found[-1], -MOST_DELAY / 2, MOST_DELAY / 2))
        values, bend = found[:count], float(found[count]) if begin.smoothing else 0.0
        newer = weights if problem.pooled else total.new_weights(low_pass, problem.alike)
        settled = abs(step) < TOLERANCE and np.all(np.abs(newer / weights - 1.0) < WEIGHTS_SETTLED)
        if number and settled and _alike(total.found, contacts):  # what is left is then what the estimate leaves
            break
        contacts, weights = total.found, newer
        if not number and not begin.smoothing:  # the whole run may tell what its head did not
            begin = smoothed(begin, first.fit, basis, first.w, first.delay.value, begin.samples / total.samples)
        delay = float(np.clip(delay + step, -MOST_DELAY, MOST_DELAY))
    fit = _fit(total, found, names, low_pass)
    std = float(np.sqrt(max(fit.covariance[-1, -1], fit.covariance_robust[-1, -1])))
    smoothing = smoothing_of(begin, fit) if begin.smoothing else None
    about = Evaluation(
        total.samples, total.kept, Delay(total.delay + float(found[-1]), std),
        notes=() if smoothing is None else tuple(smoothing.notes),
        told={} if smoothing is None else {"smoothing_s2": smoothing._asdict()},
    )  # fmt: skip
    warnings = (
        *blocks.warnings[:MOST_WARNINGS],
        *(f"{_told(t)}; left out" for t in total.found[:MOST_WARNINGS]),
        *fit.doubts,
    )
    more = len(total.found) - MOST_WARNINGS
    if more > 0:
        warnings += (f"and {more} more contacts",)
    if case.sensors.state_noise:
        warnings += ("a long run, evaluated in blocks: s0 is not compared with the noise that the case states",)
    estimate = estimate_of(model, fit, str(path), case, about, GAUSS_MARKOV, warnings)
    rms = np.sqrt(total.squares / total.rows)
    return LongRun(replace(estimate, residual_rms=rms, s0_N=float(np.sqrt(np.mean(rms**2)))), head)


class Touch(NamedTuple):
    """A contact, and its first and last row as messages name them."""

    contact: Contact
    first: str
    last: str


def _told(touch: Touch) -> str:
    contact, word = touch.contact, touch.first.split()[0]
    return (
        f"{word}s {touch.first.split()[-1]} to {touch.last.split()[-1]}: external contact from {contact.start:.3f} to "
        f"{contact.end:.3f} s, up to {contact.peak:.3g} N"
    )


def _alike(some: tuple[Touch, ...], others: tuple[Touch, ...]) -> bool:
    return [t.contact[:2] for t in some] == [t.contact[:2] for t in others]


def _merged(found: tuple[Touch, ...], more: list[Touch]) -> tuple[Touch, ...]:
    """Contacts in the order of time; those that go on in the next block as one."""
    merged = list(found)
    for touch in more:
        if merged and touch.contact.start - merged[-1].contact.end < NEAR:
            one = merged.pop()
            contact = Contact(one.contact.start, touch.contact.end, max(one.contact.peak, touch.contact.peak))
            touch = Touch(contact, one.first, touch.last)
        merged.append(touch)
    return tuple(merged)


@dataclass(slots=True)
class _Total:
    """What is left of a run after its blocks: a triangle and sums.

    Args:
        delay: at which the blocks are evaluated [s].
        values: u whose residuals are judged, shape (u,).
        weights: diagonal of W for one sample, shape (6,).
        usual: what the reading before left, shape (k, 6); by it contacts are told from noise. None: do not look.
        known: contacts that the reading before found.
        smoothing: whether that of the forces is estimated.
        bend: what the reading before found of it [s^2].
    """

    delay: float
    values: Array
    weights: Array
    usual: Array | None = None
    known: tuple[Touch, ...] = ()
    smoothing: bool = False
    bend: float = 0.0
    triangle: Array | None = None
    rows: int = 0
    samples: int = 0
    squares: Array = field(default_factory=lambda: np.zeros(6))
    smooth_squares: Array = field(default_factory=lambda: np.zeros(6))
    information: Array | None = None
    gradient: Array | None = None
    meat: Array | None = None
    found: tuple[Touch, ...] = ()
    touched: int = 0
    looked_at: int = 0
    pieces: list[Array] = field(default_factory=list)
    thinning: int = 1

    def add(self, run: Run) -> None:
        """One block more; what it leaves at earlier values."""
        if not len(run.rows):
            return
        run = replace(run, smoothing=self.smoothing)
        matrices, nuisances = run.linearised(self.delay, self.values)
        forces = run.forces
        left = forces - matrices @ self.values
        if self.bend:
            left -= self.bend * nuisances[:, :, 0]
        if self.usual is not None:
            keep = ~self._contacts(run, left)
            self.looked_at, self.touched = self.looked_at + len(keep), self.touched + int(np.sum(~keep))
            if not keep.all():
                if not keep.any():
                    return
                run, matrices, nuisances = run.without(~keep), matrices[keep], nuisances[keep]
                forces, left = forces[keep], left[keep]
        augmented = np.dstack([matrices, nuisances])
        joined = np.dstack([augmented, forces]) * np.sqrt(self.weights)[:, None]
        own = triangle(joined.reshape(-1, joined.shape[2]))
        self.triangle = own if self.triangle is None else triangle(np.vstack([self.triangle, own]))
        self.rows += len(run.rows)
        self.samples += run.samples
        self.squares = self.squares + np.sum((run.recorded_forces - matrices @ self.values) ** 2, axis=0)
        self.smooth_squares = self.smooth_squares + np.sum(left**2, axis=0)
        information = np.einsum("nku,nkv->kuv", augmented, augmented, optimize=True)
        self.information = information if self.information is None else self.information + information
        slope = np.einsum("nku,nk->ku", augmented, left)
        self.gradient = slope if self.gradient is None else self.gradient + slope
        meat = long_run_covariance(scores(augmented, left, self.weights))
        self.meat = meat if self.meat is None else self.meat + meat
        self.pieces.append(left[:: self.thinning])
        if sum(map(len, self.pieces)) > MOST_KEPT:
            self.pieces = [np.vstack(self.pieces)[::2]]
            self.thinning *= 2

    def _contacts(self, run: Run, left: Array) -> NDArray[np.bool_]:
        """Samples of a block that a contact may have moved; what is found is kept with its rows."""
        here = find_contacts(run.t, left, run.model.structure, run.forces - left, self.usual)
        rows = [self._rows_of(run, contact) for contact in here]
        self.found = _merged(self.found, [Touch(c, *r) for c, r in zip(here, rows, strict=True)])
        return touched(run.t, (*here, *(t.contact for t in self.known)))

    @staticmethod
    def _rows_of(run: Run, contact: Contact) -> tuple[str, str]:
        assert run.recording.t is not None
        inside = np.flatnonzero((run.recording.t >= contact.start) & (run.recording.t <= contact.end))
        place = run.recording.lines.place
        return place(int(inside[0])), place(int(inside[-1]))

    @property
    def kept(self) -> Array:
        """Residuals behind the filter, thinned, shape (k, 6)."""
        return np.vstack(self.pieces)

    @property
    def compressed(self) -> Compressed:
        """The QR of all blocks.

        Raises:
            IdentificationError: no sample was left.
        """
        if self.triangle is None:
            raise IdentificationError("no sample of the window can be used; record again")
        r = self.triangle
        return Compressed(r[:-1, :-1], r[:-1, -1], float(r[-1, -1] ** 2), 6 * self.rows)

    def new_weights(self, low_pass: Filter, alike: tuple[int, ...]) -> Array:
        """W as `per_channel` finds it, in turns with the parameters, from the sums of each channel.

        chi^2 of a channel at u + du is q - 2 g^T du + du^T I du with the sums q, g, I at u.
        """
        assert self.information is not None
        assert self.gradient is not None
        scale = 1.0 / np.sqrt(np.einsum("kuu->u", self.information))
        own, slope = self.information * np.outer(scale, scale), self.gradient * scale
        same = np.equal.outer(np.asarray(alike), np.asarray(alike)).astype(float)
        weights = self.weights
        for _ in range(WEIGHT_ROUNDS):
            inverse = np.linalg.inv(np.einsum("k,kuv->uv", weights, own))
            step = inverse @ (weights @ slope)
            left = self.smooth_squares - 2.0 * slope @ step + np.einsum("kuv,u,v->k", own, step, step)
            freedom = self.rows * low_pass.noise_gain * low_pass.stride
            freedom_left = freedom - weights * np.einsum("kuv,uv->k", own, inverse)
            variance = same @ left * low_pass.stride / (same @ freedom_left)
            if not variance.min() > 0.0:
                raise IdentificationError("a channel fits without residual; its variance cannot be estimated: check it")
            settled = bool(np.all(np.abs(1.0 / variance / weights - 1.0) < WEIGHT_TOLERANCE))
            weights = np.asarray(1.0 / variance)
            if settled:
                break
        return weights


def _fit(total: _Total, found: Array, names: list[str], low_pass: Filter) -> Fit:
    compressed = total.compressed
    rank, condition = determined(compressed.root, names, compressed.rows, len(names) - len(total.values))
    filtered = Filtered(low_pass.noise_gain, low_pass.stride)
    freedom = degrees_of_freedom(compressed.rows, len(names), filtered)
    s0 = float(np.sqrt(compressed.chi_squared(found) * low_pass.stride / freedom))
    half = inverse_root(compressed.root)
    inverse = half @ half.T
    assert total.meat is not None
    robust = inverse @ total.meat @ inverse
    covariance = s0**2 / low_pass.stride * inverse
    return Fit(found, covariance, robust, s0, freedom, total.kept, total.weights, rank, condition)
