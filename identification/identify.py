"""From a recording to parameters: kinematics (7)-(9), regressor (17)-(22), Gauss-Markov (23)-(28), physical form.

Forces and struts of a moving run pass the same zero-phase low-pass, which also differentiates the struts: what a
controller's blocks and the encoders' steps add above the cut-off then disturbs neither side. What is left is kept at
the rate that it still needs. The delay between forces and motion is estimated together with the parameters.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError, RecordingError
from cases.schema import Case
from identification.estimator import Filtered, Fit, gauss_markov, per_channel
from identification.hexapod import Hexapod
from identification.model import Model, identification_model
from identification.recording import Recording
from identification.result import Delay, Estimate, Evaluation, estimate_of
from identification.signals import Filter
from identification.simulate import regressors

Array = NDArray[np.float64]

LEAST_TRAVEL = 1e-4  # [m] of the struts; below, the pose counts as constant
MOVING = 1e-3  # [m/s] strut speed from which the machine counts as moving, where there is no trigger
DELAY_STEPS = 8
DELAY_TOLERANCE = 1e-6  # [s]; the step that is left is in the fit's own nuisance
MOST_DELAY = 0.02  # [s]; more than any filter of a force channel, and a sign of unrelated streams


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
    if model.needs_position and recording.struts is None:
        raise IdentificationError(
            f"{recording.source}: model {model.number} needs the platform's position, the recording has orientations "
            "only; choose model 0 or 6, or record the struts"
        )
    if recording.t is None:
        return _from_standstills(recording, case, model)
    return _from_motion(recording, case, model)


def _fit(case: Case, matrices: Array, forces: Array, names: list[str]) -> Fit:
    if case.sensors.weights == "per_channel":
        return per_channel(matrices, forces, names)
    return gauss_markov(matrices, forces, names, np.ones(6))


def _from_standstills(recording: Recording, case: Case, model: Model) -> Estimate:
    if model.needs_motion:
        raise IdentificationError(
            f"{recording.source}: model {model.number} contains inertia, which standstills cannot excite; choose a "
            "model from 0 to 5, or record a motion"
        )
    count = len(recording.forces)
    if recording.struts is not None:
        poses = Hexapod.of(case).poses(recording.struts)
        positions, turns = poses[:, :3], _rotations(poses)
    else:
        assert recording.rotations is not None  # the reader admits no recording without a pose
        positions, turns = np.zeros((count, 3)), recording.rotations
    still = np.zeros((count, 6))
    matrices = model.matrices(positions, turns, still, still)
    fit = _fit(case, matrices, recording.forces, model.names)
    return estimate_of(model, fit, recording.source, case, Evaluation(count, fit.residuals, None), ())


def _rotations(poses: Array) -> Array:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_euler("xyz", poses[:, 3:]).as_matrix())


@dataclass(frozen=True, slots=True)
class _Run:
    """A moving run, ready to be evaluated at any delay between forces and motion."""

    recording: Recording
    model: Model
    hexapod: Hexapod
    filter: Filter
    rows: NDArray[np.int64]  # samples that are evaluated, counted after the filter's margin

    @property
    def recorded_forces(self) -> Array:
        """Forces as recorded at the evaluated samples, shape (n, 6)."""
        return self.recording.forces[self.filter.margin + self.rows]

    @property
    def forces(self) -> Array:
        """The same behind the filter."""
        return self.filter.apply(self.recording.forces)[self.rows]

    def matrices(self, delay: float) -> Array:
        """A at the instants t_k - delay, shape (n, 6, u)."""
        assert self.recording.struts is not None
        strut_motion = [self.filter.apply(self.recording.struts, order, delay)[self.rows] for order in range(3)]
        return regressors(self.model, self.hexapod.kinematics(*strut_motion))


def _from_motion(recording: Recording, case: Case, model: Model) -> Estimate:
    if recording.struts is None:
        raise RecordingError(
            f"{recording.source}: has a clock and rotation matrices; moving runs are evaluated from struts only, "
            "remove t_s if each row is an averaged standstill"
        )
    cutoff = case.recording.filter_cutoff_Hz
    if cutoff is None:
        raise RecordingError(
            f"{recording.source}: a moving run needs a filter; set recording.filter_cutoff_Hz in the case"
        )
    step = recording.step
    if not cutoff < 0.2 / step:
        raise RecordingError(
            f"{recording.source}: filter_cutoff_Hz = {cutoff:g} is too high for {1 / step:.4g} samples a second; at "
            f"most {0.2 / step:.4g}"
        )
    low_pass = Filter(cutoff, step)
    window = _window(recording, low_pass)
    run = _Run(recording, model, Hexapod.of(case), low_pass, window[:: low_pass.stride])
    if case.sensors.weights == "per_channel":
        raise IdentificationError("a moving run with channel weights is not evaluated yet; set sensors.weights = equal")
    fit, delay, residuals = _with_delay(run, model)
    warnings = () if abs(delay.value) < MOST_DELAY else (f"delay of {delay.value * 1e3:.1f} ms: do the streams match?",)
    return estimate_of(model, fit, recording.source, case, Evaluation(len(window), residuals, delay), warnings)


def _window(recording: Recording, low_pass: Filter) -> NDArray[np.int64]:
    """Samples with the trigger on; without a trigger from the first movement out of rest to rest again."""
    assert recording.struts is not None
    margin = low_pass.margin
    speed = low_pass.apply(recording.struts, 1)  # raises where the run is shorter than the filter
    if recording.trigger is not None:
        rows = np.flatnonzero(recording.trigger[margin:-margin])
        if not len(rows):
            raise RecordingError(f"{recording.source}, trigger: is never 1; record with the trigger or leave it out")
    else:
        moving = np.flatnonzero(np.abs(speed).max(axis=1) > MOVING)
        rows = np.arange(moving[0], moving[-1] + 1) if len(moving) else moving
    travel = np.ptp(recording.struts[margin + rows], axis=0).max() if len(rows) else 0.0
    if travel < LEAST_TRAVEL:
        raise IdentificationError(
            f"{recording.source}: the pose is constant (struts move by {travel * 1e3:.3g} mm, at least "
            f"{LEAST_TRAVEL * 1e3:g} mm are needed); record the excitation, or remove t_s from averaged standstills"
        )
    return rows


def _with_delay(run: _Run, model: Model) -> tuple[Fit, Delay, Array]:
    """Gauss-Newton over the delay; it stays in the last fit as a nuisance, so that its uncertainty counts.

    Returns the fit, the delay and the residuals of the forces as recorded.
    """
    forces = run.forces
    filtered = Filtered(run.filter.noise_gain, run.filter.stride)
    delay = 0.0
    for _ in range(DELAY_STEPS):
        matrices = run.matrices(delay)
        late = _effect_of_delay(matrices, forces, run.filter.step * run.filter.stride)
        fit = gauss_markov(
            np.dstack([matrices, late]), forces, [*model.names, "delay"], np.ones(6), nuisance=1, filtered=filtered
        )
        step = float(np.clip(fit.values[-1], -MOST_DELAY, MOST_DELAY))
        delay = float(np.clip(delay + step, -2 * MOST_DELAY, 2 * MOST_DELAY))
        if abs(step) < DELAY_TOLERANCE:
            break
    residuals = run.recorded_forces - matrices @ fit.values[:-1]
    return fit, Delay(delay, float(np.sqrt(fit.covariance_robust[-1, -1]))), residuals


def _effect_of_delay(matrices: Array, forces: Array, step: float) -> Array:
    """How forces change with the delay: -d(A u)/dt, u by plain least squares, shape (n, 6)."""
    u = np.linalg.lstsq(matrices.reshape(-1, matrices.shape[2]), forces.ravel(), rcond=None)[0]
    return np.asarray(-np.gradient(matrices @ u, step, axis=0))
