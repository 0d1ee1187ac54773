"""A moving run and its fit: the delay between forces and motion is found together with the parameters."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from cases.errors import IdentificationError
from cases.schema import Case
from identification.estimation.biases import Biases, gain, widened, with_uncertain_offsets
from identification.estimation.estimators import Method, Problem, gauss_markov_of, method
from identification.estimation.fit import Fit
from identification.estimation.weighing import of_forces, w_of, whitened
from identification.findings.doubts import require_sense
from identification.findings.plausibility import Scan
from identification.model import Model
from identification.periodic.averaging import PeriodicRun, periodic_run
from identification.recording import Recording
from identification.result import Delay
from identification.runs.accelerated import accelerated
from identification.runs.conditioning import Conditioning
from identification.runs.evaluation import MOST_DELAY, Run
from identification.runs.preparation import moving_run
from identification.runs.wrist import WristRun, wrist_run

Array = NDArray[np.float64]

DELAY_STEPS = 8
DELAY_TOLERANCE = 1e-9  # [s]; the step that is left is in the fit's own nuisance
SANDWICHED = ("gauss-markov", "consistent")  # whose robust covariance is the sandwich of the weights alone
GAUSS_MARKOV = method()
AnyRun = Run | WristRun | PeriodicRun


class Moving(NamedTuple):
    """A run with its fit: residuals are those of the forces as recorded; W is the square of `whitening` where given."""

    run: AnyRun
    fit: Fit
    delay: Delay
    residuals: Array
    whitening: Array | None = None

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
    run = moving_run(recording, case, model, found=found)
    return run if conditioning.accelerated is None else accelerated(run, conditioning.accelerated).run


def fit_with_delay(run: AnyRun, how: Method, problem: Problem, delay: float = 0.0, held: Delay | None = None) -> Moving:
    """Gauss-Newton over the delay; it stays in the last fit as a nuisance, so that its uncertainty counts.

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
    search = gauss_markov_of(problem)
    forces, names = run.forces, [*model.names, *run.nuisances[:beside]]
    matrices = run.regressors(delay)
    channels = forces.std(axis=0)
    scale = 1.0 / np.where(channels > 0.0, channels, 1.0) if not problem.pooled else np.ones(6)
    selection, whitening = how.selection(model), None
    weighted: Array | None = None  # the values that W was found with, which it depends on in turn
    for _ in range(DELAY_STEPS):
        # The effect of the delay is that of the best forces of the moment, whatever parameters make them.
        left = (forces - matrices @ selection.offset) * scale
        reduced = matrices @ selection.basis * scale[:, None]
        free = np.linalg.lstsq(reduced.reshape(-1, reduced.shape[2]), left.ravel(), rcond=None)[0]
        values = selection.offset + selection.basis @ free
        effect = run.nuisance_columns(delay, matrices, values)[:, :, :beside]
        if problem.noise is not None:
            whitening = problem.noise.whitening(values if weighted is None else weighted)
        augmented = np.dstack([matrices, effect])
        first = np.dstack([matrices @ selection.basis, effect])
        rest = forces - matrices @ selection.offset
        fit = search(*whitened(whitening, first, rest), [*selection.names, *run.nuisances[:beside]])
        weighted = selection.offset + selection.basis @ fit.values[: selection.basis.shape[1]]
        if held is not None:
            break
        step = float(np.clip(fit.values[-1], -MOST_DELAY / 2, MOST_DELAY / 2))
        if abs(step) < DELAY_TOLERANCE:
            break
        delay = float(np.clip(delay + step, -MOST_DELAY, MOST_DELAY))
        matrices = run.regressors(delay)
    if abs(delay) >= MOST_DELAY:
        raise IdentificationError(
            f"no delay up to {MOST_DELAY * 1e3:.0f} ms brings forces and motion together; are they "
            "of one run, and struts and forces in the order of the case?"
        )
    white = whitened(whitening, augmented, forces)
    fit = how.estimator(problem)(*white, names)
    if how.name in SANDWICHED and not how.priors:
        basis = block_diag(selection.basis, np.eye(beside))
        robust = run.robust_covariance(white[0] @ basis, fit.residuals, fit.weights, whitening)
        if robust is not None:
            notes = (*fit.notes, *robust.notes)
            covariance = basis @ robust.covariance @ basis.T
            fit = replace(fit, covariance_robust=covariance, notes=notes, field=robust.field)
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
        return Moving(run, fit, held, residuals, whitening)
    value = delay + (float(fit.values[-1]) if abs(fit.values[-1]) < DELAY_TOLERANCE else 0.0)
    return Moving(
        run,
        fit,
        Delay(value, float(np.sqrt(max(fit.covariance[-1, -1], fit.covariance_robust[-1, -1])))),
        residuals,
        whitening,
    )


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
