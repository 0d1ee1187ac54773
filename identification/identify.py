"""From a recording to parameters: kinematics (7)-(9), regressor (17)-(22), Gauss-Markov (23)-(28), physical form.

Struts pass a zero-phase low-pass that also differentiates them; forces are used as recorded, so that white noise stays
white and (28) holds. The delay between forces and motion is estimated together with the parameters.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError, RecordingError
from cases.schema import Case
from identification.estimator import Fit, gauss_markov, per_channel
from identification.hexapod import Hexapod
from identification.model import Model, identification_model
from identification.recording import Recording
from identification.result import Delay, Estimate, estimate_of
from identification.signals import Filter
from identification.simulate import regressors

Array = NDArray[np.float64]

LEAST_TRAVEL = 1e-4  # [m] of the struts; below, the pose counts as constant
MOVING = 1e-3  # [m/s] strut speed from which the machine counts as moving, where there is no trigger
STRIDE = 5  # the delay is first found on every fifth sample
DELAY_STEPS = 6
DELAY_TOLERANCE = 1e-8  # [s]
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
    return estimate_of(model, fit, recording.source, case, None, ())


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
    rows: NDArray[np.int64]  # samples that are used, counted after the filter's margin

    def matrices(self, delay: float, stride: int) -> tuple[Array, Array]:
        """A at the instants t_k - delay, and the forces recorded at t_k."""
        assert self.recording.struts is not None
        rows = self.rows[::stride]
        strut_motion = [self.filter.apply(self.recording.struts, order, delay)[rows] for order in range(3)]
        matrices = regressors(self.model, self.hexapod.kinematics(*strut_motion))
        return matrices, self.recording.forces[self.filter.margin + rows]


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
            f"{recording.source}: filter_cutoff_Hz = {cutoff:g} is too high for {1 / step:.4g} samples a second; at most "
            f"{0.2 / step:.4g}"
        )
    low_pass = Filter(cutoff, step)
    run = _Run(recording, model, Hexapod.of(case), low_pass, _window(recording, low_pass))
    unknowns = len(model.names)
    if len(run.rows) * 6 <= unknowns:
        raise IdentificationError(
            f"{recording.source}: {len(run.rows)} usable samples for {unknowns} unknowns; record longer"
        )
    fit, delay = _with_delay(run, case, model)
    warnings = () if abs(delay.value) < MOST_DELAY else (f"delay of {delay.value * 1e3:.1f} ms: do the streams match?",)
    return estimate_of(model, fit, recording.source, case, delay, warnings)


def _window(recording: Recording, low_pass: Filter) -> NDArray[np.int64]:
    """Samples with the trigger on; without a trigger from the first movement out of rest to rest again."""
    assert recording.struts is not None
    margin = low_pass.margin
    if len(recording.struts) <= 2 * margin + 1:
        low_pass.apply(recording.struts)  # raises, naming what is needed
    if recording.trigger is not None:
        on = recording.trigger[margin:-margin]
        if not on.any():
            raise RecordingError(f"{recording.source}, trigger: is never 1; record with the trigger or leave it out")
        rows = np.flatnonzero(on)
    else:
        speed = np.abs(low_pass.apply(recording.struts, 1)).max(axis=1)
        moving = np.flatnonzero(speed > MOVING)
        rows = np.arange(moving[0], moving[-1] + 1) if len(moving) else moving
    travel = np.ptp(recording.struts[margin + rows], axis=0).max() if len(rows) else 0.0
    if travel < LEAST_TRAVEL:
        raise IdentificationError(
            f"{recording.source}: the pose is constant (struts move by {travel * 1e3:.3g} mm, at least "
            f"{LEAST_TRAVEL * 1e3:g} mm are needed); record the excitation, or remove t_s from averaged standstills"
        )
    return rows


def _with_delay(run: _Run, case: Case, model: Model) -> tuple[Fit, Delay]:
    """Gauss-Newton over the delay; the last fit carries it as a nuisance, so that its uncertainty counts."""
    delay, names = 0.0, [*model.names, "delay"]
    for _ in range(DELAY_STEPS):
        fit = _augmented(run, model, delay, STRIDE, names)
        step = float(np.clip(fit.values[-1], -MOST_DELAY, MOST_DELAY))
        delay = float(np.clip(delay + step, -2 * MOST_DELAY, 2 * MOST_DELAY))
        if abs(step) < 1e2 * DELAY_TOLERANCE:
            break
    fit = _augmented(run, model, delay, 1, names)
    delay += float(fit.values[-1])
    std = float(np.sqrt(fit.covariance_robust[-1, -1]))
    if case.sensors.weights == "per_channel":
        raise IdentificationError("a moving run with channel weights is not evaluated yet; set sensors.weights = equal")
    return fit, Delay(delay, std)


def _augmented(run: _Run, model: Model, delay: float, stride: int, names: list[str]) -> Fit:
    """Fit with one more column: how the forces change with the delay, -d(A u)/dt."""
    matrices, forces = run.matrices(delay, stride)
    values = np.linalg.lstsq(matrices.reshape(-1, matrices.shape[2]), forces.ravel(), rcond=None)[0]
    step = run.filter.step * stride
    late = -np.gradient(matrices @ values, step, axis=0)
    return gauss_markov(np.dstack([matrices, late]), forces, names, np.ones(6), nuisance=1)
