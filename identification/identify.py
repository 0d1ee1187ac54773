"""From a recording to parameters: kinematics (7)-(9), regressor (17)-(22), Gauss-Markov (23)-(28), physical form.

The delay between forces and motion of a moving run is estimated together with the parameters.
"""

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError, RecordingError
from cases.schema import Case
from identification.estimator import Fit, gauss_markov, per_channel, require_alive
from identification.evaluation import MOST_DELAY, Run, moving_run, standstills
from identification.identifiability import Identifiability, analyse
from identification.model import Model, identification_model
from identification.recording import Recording
from identification.result import Delay, Estimate, Evaluation, estimate_of

Array = NDArray[np.float64]

DELAY_STEPS = 8
DELAY_TOLERANCE = 1e-6  # [s]; the step that is left is in the fit's own nuisance
SUSPICIOUS_DELAY = 0.02  # [s]; more than any filter of a force channel, and a sign of unrelated streams


def default_model(recording: Recording) -> int:
    """The model that a recording can carry: 9 moving, 5 standing with struts, 0 with orientations only."""
    if recording.struts is None:
        return 0
    return 5 if recording.t is None else 9


def identify(recording: Recording, case: Case, number: int | None = None) -> Estimate:
    """Identifies the parameters of a model from one recording.

    Args:
        recording: the run.
        case: machine, sensor frame and gravity.
        number: of the model in Table 2; by default what the recording can carry.

    Raises:
        IdentificationError: the run does not determine the parameters; the message names them.
        RecordingError: the run cannot be evaluated.
        CaseError: the case lacks what the evaluation needs.
    """
    model = identification_model(case, default_model(recording) if number is None else number)
    try:
        if len(recording.forces) > 1:
            require_alive(recording.forces)
        if recording.t is None:
            return _from_standstills(recording, case, model)
        return _from_motion(recording, case, model)
    except IdentificationError as error:
        raise IdentificationError(_placed(recording.source, error)) from error
    except RecordingError as error:
        raise RecordingError(_placed(recording.source, error)) from error


def _placed(source: str, error: Exception) -> str:
    """The message with the file in front, which the mathematics does not know."""
    return str(error) if source in str(error) else f"{source}: {error}"


def identifiability(recording: Recording, case: Case, estimate: Estimate) -> Identifiability:
    """What the run determines, alone and together, of the parameters of an estimate (section 5).

    Args:
        recording: the run of the estimate.
        case: its case.
        estimate: gives model and delay.
    """
    model = identification_model(case, estimate.model)
    if recording.t is None:
        return analyse(standstills(recording, case, model).regressors, model.names)
    run = moving_run(recording, case, model)
    return analyse(run.regressors(estimate.delay.value if estimate.delay else 0.0), model.names)


def _from_standstills(recording: Recording, case: Case, model: Model) -> Estimate:
    if model.needs_motion:
        raise IdentificationError(
            f"{recording.source}: model {model.number} contains inertia, which standstills cannot excite; choose a "
            "model from 0 to 5, or record a motion"
        )
    data = standstills(recording, case, model)
    if case.sensors.weights == "per_channel":
        fit = per_channel(data.regressors, data.forces, model.names)
    else:
        fit = gauss_markov(data.regressors, data.forces, model.names, np.ones(6))
    return estimate_of(model, fit, recording.source, case, Evaluation(data.samples, fit.residuals, None), ())


def _from_motion(recording: Recording, case: Case, model: Model) -> Estimate:
    run = moving_run(recording, case, model)
    if case.sensors.weights == "per_channel":
        raise IdentificationError("a moving run with channel weights is not evaluated yet; set sensors.weights = equal")
    fit, delay, residuals = _with_delay(run)
    warnings = (
        () if abs(delay.value) < SUSPICIOUS_DELAY else (f"delay of {delay.value * 1e3:.1f} ms: do the streams match?",)
    )
    return estimate_of(model, fit, recording.source, case, Evaluation(run.samples, residuals, delay), warnings)


def _with_delay(run: Run) -> tuple[Fit, Delay, Array]:
    """Gauss-Newton over the delay; it stays in the last fit as a nuisance, so that its uncertainty counts.

    Returns the fit, the delay and the residuals of the forces as recorded.
    """
    forces, names = run.forces, [*run.model.names, "delay"]
    delay = 0.0
    for _ in range(DELAY_STEPS):
        matrices = run.regressors(delay)
        augmented = np.dstack([matrices, _effect_of_delay(matrices, forces, run.step)])
        fit = gauss_markov(augmented, forces, names, np.ones(6), nuisance=1, filtered=run.filtered)
        step = float(np.clip(fit.values[-1], -MOST_DELAY / 2, MOST_DELAY / 2))
        delay = float(np.clip(delay + step, -MOST_DELAY, MOST_DELAY))
        if abs(step) < DELAY_TOLERANCE:
            break
    if abs(delay) >= MOST_DELAY:
        raise IdentificationError(
            f"no delay up to {MOST_DELAY * 1e3:.0f} ms brings forces and motion together; are they of one run?"
        )
    residuals = run.recorded_forces - matrices @ fit.values[:-1]
    return fit, Delay(delay, float(np.sqrt(fit.covariance_robust[-1, -1]))), residuals


def _effect_of_delay(matrices: Array, forces: Array, step: float) -> Array:
    """How forces change with the delay: -d(A u)/dt, u by plain least squares, shape (n, 6)."""
    u = np.linalg.lstsq(matrices.reshape(-1, matrices.shape[2]), forces.ravel(), rcond=None)[0]
    return np.asarray(-np.gradient(matrices @ u, step, axis=0))
