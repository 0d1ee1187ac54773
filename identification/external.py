"""The measurement model in use: external force and moment from sensor forces, (1) and (10)-(15), and tare.

With f^ = A u the forces that the model expects without contact (18), (1) reads f_Ext = -J^-T (f_q - f^), in {P}.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from cases.schema import Case
from identification.finding import Severity, sentences
from identification.findings.drift import drifted_since, shifted_all_along
from identification.findings.sample_checks import Scan, unmeasured
from identification.model import Model
from identification.parameters import OFFSETS
from identification.recording import Recording
from identification.runs.preparation import moving_run, standstills
from identification.saved_result import SavedResult

Array = NDArray[np.float64]


class ExternalForce(NamedTuple):
    """External force and moment on the platform, about the origin of {P} and along its axes."""

    t: Array  # time, shape (n,) [s]; numbers of the standstills where there is no clock
    wrench: Array  # shape (n, 6) [N, N m]
    residuals: Array  # residuals of the sensors, measured less expected, shape (n, 6) [N, or N and N m]
    warnings: tuple[str, ...] = ()  # sentences about what was not measured, and is left out

    @property
    def rms(self) -> Array:
        """Root mean square of each component, shape (6,) [N, N m]."""
        return np.asarray(np.sqrt(np.mean(self.wrench**2, axis=0)))

    @property
    def peak(self) -> Array:
        """Largest magnitude of each component, shape (6,) [N, N m]."""
        return np.asarray(np.abs(self.wrench).max(axis=0))


def external_force(recording: Recording, case: Case, result: SavedResult, whole: bool = True) -> ExternalForce:
    """External force over a recording; moving runs behind the filter of the case.

    Args:
        result: identified parameters; their delay is compensated.
        whole: all samples; else only the excitation.

    Raises:
        FileProblem: parameters of another case.
        RecordingError, IdentificationError: the recording cannot be evaluated.
    """
    model = result.model_of(case)
    checks = unmeasured(recording)
    warnings = checks.warnings
    if recording.t is None or case.setup == "1a":
        still = standstills(recording, case, model, checks)
        t, forces, matrices, poses = still.t, still.recorded, still.matrices, _poses(model, recording, checks)
    else:
        run = moving_run(recording, case, model, whole, checks)
        warnings += sentences(run.window, Severity.WARNING)
        t, forces, matrices = run.t, run.forces, run.regressors(result.delay)
        poses = None if model.struts is None else run.kinematics(result.delay).pose
    residuals = forces - matrices @ result.values
    variance = np.diag(result.covariance_robust)[_offset_columns(model)]
    warnings += tuple(shifted_all_along(residuals, variance, case))
    return ExternalForce(t, -model.wrenches(residuals, poses), residuals, warnings)


def _poses(model: Model, recording: Recording, checks: Scan) -> Array | None:
    """Poses of the standstills that are used, where forces in struts are to become one on the platform."""
    if model.struts is None:
        return None
    if recording.struts is None:
        return None if recording.poses is None else recording.poses[~checks.bad]
    return model.struts.hexapod.coordinates(recording.struts[~checks.bad])


class Tare(NamedTuple):
    """New offsets."""

    values: Array  # u with the offsets replaced, shape (u,)
    covariance: Array  # covariance of u, shape (u, u): offsets and the rest no longer vary together
    change: Array  # new offsets less old ones, shape (6,)
    std: Array  # standard deviation of the new offsets from the scatter of the standstill, shape (6,)
    notes: tuple[str, ...] = ()  # sentences about offsets that have drifted since the result


STILL = 1e-4  # [m or rad] that drives may move in a standstill: encoder noise and drift, not motion


def tare(recording: Recording, case: Case, result: SavedResult) -> Tare:
    """Identifies f_q0 (11) anew from a standstill and leaves all other parameters.

    Args:
        recording: recording of a standstill without contact: one pose, any number of samples.
        case: case of the same machine as the parameters.
        result: identified parameters.

    Raises:
        IdentificationError: the machine moves, or there are fewer than two samples.
        FileProblem: parameters of another case.
    """
    model = result.model_of(case)
    checks = unmeasured(recording)
    count = int(np.sum(~checks.bad))
    if count < 2:
        raise IdentificationError(f"{recording.source}: {count} sample; a tare needs a standstill of two or more")
    travel = 0.0 if recording.struts is None else float(np.ptp(recording.struts[~checks.bad], axis=0).max())
    if travel > STILL:
        drives, unit = case.drive_words
        raise IdentificationError(
            f"{recording.source}: {drives} move by {travel * 1e3:.3g} {unit}, at most {STILL * 1e3:g} {unit} in a "
            "standstill; cut the motion off"
        )
    still = standstills(recording, case, model, checks)
    residuals = still.recorded - still.matrices @ result.values
    change = residuals.mean(axis=0)
    variance = residuals.var(axis=0, ddof=1) / count
    offsets = _offset_columns(model)
    values, covariance = result.values.copy(), result.covariance.copy()
    since = np.sqrt(variance + np.diag(result.covariance_robust)[offsets])
    notes = drifted_since(change, since, case, result.source)
    values[offsets] += change
    covariance[offsets, :] = covariance[:, offsets] = 0.0
    covariance[offsets, offsets] = variance
    return Tare(values, covariance, change, np.sqrt(variance), tuple(notes))


def _offset_columns(model: Model) -> NDArray[np.int64]:
    names = [p.name for p in OFFSETS.parameters]
    return np.array([model.names.index(name) for name in names])
