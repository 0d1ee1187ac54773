"""A moving run and its fit: the delay between forces and motion is found together with the parameters."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from cases.errors import IdentificationError
from cases.schema import Case
from identification.estimation.biases import Biases, gain, widened, with_uncertain_offsets
from identification.estimation.compressed import joint_triangle
from identification.estimation.estimators import Method, Problem, gauss_markov_of, method
from identification.estimation.fit import Fit
from identification.estimation.weighing import of_forces, w_of, whitened
from identification.findings.doubts import require_sense
from identification.findings.plausibility import Scan
from identification.model import Model
from identification.periodic.averaging import PeriodicRun, periodic_run
from identification.recording import Recording
from identification.result import Delay
from identification.runs.conditioning import Conditioning
from identification.runs.evaluation import MOST_DELAY, PART, Run
from identification.runs.preparation import moving_run
from identification.runs.wrist import WristRun, wrist_run

Array = NDArray[np.float64]

DELAY_STEPS = 8
DELAY_TOLERANCE = 1e-9  # [s]; the step that is left is in the fit's own nuisance
CLOSE = 1e-5  # [s] the same where the search began near by: of the noise in so many samples its square is a hundredth
EXCERPTS = (PART, 8 * PART)  # samples of a long run by which the search begins
SANDWICHED = ("gauss-markov", "consistent")  # whose robust covariance is the sandwich of the weights alone
GAUSS_MARKOV = method()
AnyRun = Run | WristRun | PeriodicRun


class Moving(NamedTuple):
    """A run with its fit.

    Args:
        run: that was evaluated.
        fit: to its forces.
        delay: of the forces.
        residuals: of the forces as recorded, shape (n, 6).
        whitening: W is its square, where it is given.
        columns: A and the nuisances, shape (n, 6, u + nuisances).
    """

    run: AnyRun
    fit: Fit
    delay: Delay
    residuals: Array
    whitening: Array | None
    columns: Array

    @property
    def matrices(self) -> Array:
        """A, shape (n, 6, u)."""
        return self.columns[:, :, : len(self.run.model.parameters)]

    @property
    def w(self) -> Array:
        """W for one sample, shape (6, 6)."""
        return w_of(self.whitening, self.fit)


def run_of(
    recording: Recording,
    case: Case,
    model: Model,
    conditioning: Conditioning,
    found: Scan | None = None,
    biases: Biases | None = None,
) -> AnyRun:
    """A moving run, ready to be evaluated, as it was asked for.

    Args:
        recording: with a clock.
        case: its case.
        model: gives A.
        conditioning: what is done to it.
        found: samples that may not be used.
        biases: of a wrist run, known beforehand.

    Raises:
        RecordingError: it cannot be evaluated so.
        IdentificationError: the model needs what the recording does not have.
    """
    if conditioning.periodic is not None:
        return periodic_run(recording, case, model, conditioning.periodic, found)
    if recording.struts is None:
        return wrist_run(recording, case, model, MOST_DELAY, biases, bad=None if found is None else found.bad)
    return moving_run(recording, case, model, found=found)


class _Converged(NamedTuple):
    """Where Gauss-Newton over the delay ended.

    Args:
        delay: of the linearisation [s].
        columns: A and the nuisances there, shape (n, 6, u + nuisances).
        values: u, shape (u,).
        whitening: root of W, where the case states noise.
    """

    delay: float
    columns: Array
    values: Array
    whitening: Array | None


def _converged(
    run: AnyRun,
    forces: Array,
    how: Method,
    problem: Problem,
    delay: float,
    held: Delay | None,
    near: Array | None = None,
) -> _Converged:
    """Gauss-Newton over the delay.

    Args:
        run: to be evaluated.
        forces: of that, shape (n, 6).
        how: what is known beforehand.
        problem: with the nuisances and the filter of the run.
        delay: to start from [s].
        held: a delay that is not estimated.
        near: u that a part of the run told, shape (u,), with its delay: one step is then enough.

    Raises:
        IdentificationError: no delay brings forces and motion together.
    """
    search, beside = gauss_markov_of(problem), problem.nuisance
    channels = forces.std(axis=0)
    scale = 1.0 / np.where(channels > 0.0, channels, 1.0) if not problem.pooled else np.ones(6)
    selection, whitening, values = how.selection(run.model), None, near
    names = [*selection.names, *run.nuisances[:beside]]
    whole = selection.basis.shape[0] == selection.basis.shape[1]
    for _ in range(DELAY_STEPS):
        columns = free = None  # of a long run there is room for one
        if values is None:
            # The effect of the delay is that of the best forces of the moment, whatever parameters make them.
            matrices = run.regressors(delay)
            right = forces - matrices @ selection.offset
            top = joint_triangle(matrices @ selection.basis, right, scale)
            values = (
                selection.offset
                + selection.basis @ np.linalg.lstsq(top[:, :-1], top[:, -1], rcond=forces.size * np.finfo(float).eps)[0]
            )
        columns = run.linearised(delay, values)
        matrices, nuisances = np.split(columns, [len(values)], axis=2)
        if len(run.nuisances) > beside:
            columns = columns[:, :, : len(values) + beside]
        if problem.noise is not None:
            whitening = problem.noise.whitening(values)
        rest = forces - matrices @ selection.offset
        free = columns if whole else np.dstack([matrices @ selection.basis, nuisances[:, :, :beside]])
        fit = search(*whitened(whitening, free, rest), names)
        values = selection.offset + selection.basis @ fit.values[: selection.basis.shape[1]]
        if held is not None:
            break
        step = float(np.clip(fit.values[-1], -MOST_DELAY / 2, MOST_DELAY / 2))
        if abs(step) < (DELAY_TOLERANCE if near is None else CLOSE):
            break
        delay = float(np.clip(delay + step, -MOST_DELAY, MOST_DELAY))
    if abs(delay) >= MOST_DELAY:
        raise IdentificationError(
            f"no delay up to {MOST_DELAY * 1e3:.0f} ms brings forces and motion together; are they "
            "of one run, and struts and forces in the order of the case?"
        )
    assert columns is not None
    assert values is not None
    return _Converged(delay, columns, values, whitening)


def fit_with_delay(run: AnyRun, how: Method, problem: Problem, delay: float = 0.0, held: Delay | None = None) -> Moving:
    """Gauss-Newton over the delay; it stays in the last fit as a nuisance, so that its uncertainty counts.

    A long run is fitted from where a part of it ends.

    Args:
        run: to be evaluated.
        how: estimator.
        problem: the run's model, and which channels have the same noise.
        delay: to start from [s].
        held: a delay that is taken as known with its standard deviation, which is propagated, and not estimated.
    """
    model = run.model
    beside = len(run.nuisances) - (held is not None)
    delay = delay if held is None else held.value
    problem = replace(problem, nuisance=beside, filtered=run.filtered)
    forces, names = run.forces, [*model.names, *run.nuisances[:beside]]
    near = None
    for most in EXCERPTS:
        part = run.excerpt(most)
        if part is not run:
            delay, _, near, _ = _converged(part, part.forces, how, problem, delay, held, near)
    delay, augmented, _, whitening = _converged(run, forces, how, problem, delay, held, near)
    selection = how.selection(model)
    white = whitened(whitening, augmented, forces)
    fit = how.estimator(problem)(*white, names)
    if how.name in SANDWICHED and not how.priors:
        basis = block_diag(selection.basis, np.eye(beside))
        free = white[0] if np.array_equal(basis, np.eye(len(basis))) else white[0] @ basis
        robust = run.robust_covariance(free, fit.residuals, fit.weights, whitening)
        if robust is not None:
            notes = (*fit.notes, *robust.notes)
            fit = replace(fit, covariance_robust=basis @ robust.covariance @ basis.T, notes=notes)
    fit = of_forces(whitening, fit, augmented, forces)
    require_sense(model, fit)
    told = augmented.shape[2] - (held is None)
    residuals = run.left(augmented[:, :, :told], fit.values[:told])
    basis = block_diag(selection.basis, np.eye(beside))
    if how.biases is not None:
        fit = with_uncertain_offsets(fit, model, basis, augmented, w_of(whitening, fit), how.biases)
    if isinstance(run, WristRun):
        fit = _with_uncertain_motion(run, fit, augmented, basis, w_of(whitening, fit), how.biases, delay, held)
    if held is not None:
        return Moving(run, fit, held, residuals, whitening, augmented)
    value = delay + (float(fit.values[-1]) if abs(fit.values[-1]) < CLOSE else 0.0)
    std = float(np.sqrt(max(fit.covariance[-1, -1], fit.covariance_robust[-1, -1])))
    return Moving(run, fit, Delay(value, std), residuals, whitening, augmented)


def _with_uncertain_motion(
    run: WristRun,
    fit: Fit,
    augmented: Array,
    basis: Array,
    w: Array,
    biases: Biases | None,
    delay: float,
    held: Delay | None,
) -> Fit:
    """The fit with the uncertainty of a held delay and of biases that were taken from the accelerometer."""
    count = len(run.model.names)
    columns = run.known_columns(delay, augmented[:, :, :count], fit.values[:count])
    covariance = np.zeros((4, 4))
    covariance[0, 0] = 0.0 if held is None else held.std**2
    if biases is not None:
        covariance[1:, 1:] = biases.require_accelerometer().covariance
    return widened(fit, basis @ gain(augmented @ basis, w, columns), covariance)
