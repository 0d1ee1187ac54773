"""Parts of the error of an estimate on a simulated machine, and its standard deviation over machines."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cases.schema import Case
from cases.sensors import Disturbances
from identification.hexapod import Hexapod
from identification.motion import Array
from identification.parameters import physical_form
from identification.recording import Recording
from identification.result import Estimate
from identification.runs.evaluation import Run
from identification.runs.preparation import moving_run
from identification.runs.sample_checks import scan
from identification.runs.standstills import standstills
from identification.simulate import pose_covariance


@dataclass(frozen=True, slots=True)
class LinearAnswer:
    """Linear map from forces to parameters."""

    forces: Array  # evaluated forces, shape (n, 6) [N]
    matrices: Array  # A_j of the parameters alone, shape (n, 6, u)
    answer: Array  # u = sum over j of answer_j f_j, with further estimated quantities, shape (u, n, 6)
    poses: Array  # poses of the evaluated samples, shape (n, 6) [m, rad]
    run: Run | None  # a moving run with its filter; None for standstills

    def seen(self, added: Array) -> Array:
        """Forces of all samples of the recording as the evaluation sees them, shape (n, 6) [N]."""
        return added if self.run is None else self.run.filter.apply(added)[self.run.rows]

    def of(self, forces: Array) -> Array:
        """Shifts of the parameters, shape (u, k) [SI], by evaluated forces, shape (n, 6, k) [N]."""
        return np.asarray(np.tensordot(self.answer, forces, axes=2))


def linear_answer(case: Case, recording: Recording, estimate: Estimate) -> LinearAnswer:
    """The answer of an estimate by least squares of a recording, averaged where it stands, at its delay."""
    model = estimate.model
    struts, run, forces = recording.struts, None, recording.forces
    assert struts is not None
    if recording.t is None:
        matrices = columns = standstills(recording, case, model).matrices
        weights = np.ones(len(matrices)) if recording.weights is None else recording.weights
    else:
        run = moving_run(scan(recording, case)[1], case, model)
        run = replace(run, nuisances=estimate.evaluated.nuisances)
        delay = estimate.at
        forces, columns = run.forces, run.linearised(delay, estimate.fit.values)
        matrices = columns[:, :, : len(estimate.fit.values)]
        weights = np.ones(len(matrices))
        struts = struts[np.asarray(run.rows) + run.filter.margin]
    scale = weights[:, None] * np.sqrt(estimate.fit.weights)
    design = (columns * scale[:, :, None]).reshape(-1, columns.shape[2])
    size = np.linalg.norm(design, axis=0)
    answer = (np.linalg.pinv(design / size) / size[:, None]).reshape(len(size), len(columns), 6)[: matrices.shape[2]]
    return LinearAnswer(forces, matrices, answer * scale, Hexapod.of(case).poses(struts), run)


BODY = ("m", "xC", "yC", "zC", "IC11", "IC22", "IC33")  # parameters whose errors are reported
SUSPICIOUS = 3.0  # reported standard deviations; more is a systematic error
MODE, POSE, NOISE = "the structural mode", "the errors of the pose", "the noise of the sensors"
RIPPLE, LEFT_OUT = "ripple and sampling", "samples that were left out"
CAUSES = (MODE, POSE, NOISE, RIPPLE, LEFT_OUT)


def cause_of(parts: Mapping[str, float]) -> str:
    """The disturbance without which an error, the sum of its parts by cause, would be smallest."""
    return min(CAUSES, key=lambda cause: abs(sum(parts.values()) - parts[cause]))


def error_budget(
    answer: LinearAnswer, recording: Recording, parts: Array, estimate: Estimate, truth: Array
) -> dict[str, dict[str, float]]:
    """Parts of the error of an estimate, less truth, which add up to it: for each parameter, by cause [SI].

    The residual forces beside mode, pose errors and noise are those of ripple, encoders and sampling: motion that
    the evaluation computes otherwise than the sensors measured it. Ripple that the mode amplifies counts as the mode's.

    Args:
        recording: recording that was identified, averaged where it stands.
        parts: parts of its true forces, see `force_parts`, at the same rows.
        estimate: estimate by least squares.
        truth: linear parameters u of its model, shape (u,) [SI].
    """
    model = estimate.model
    noise = recording.forces - parts.sum(axis=0)
    added = [answer.seen(part) for part in (*parts[1:], noise)]
    *shifts, whole = answer.of(np.stack([*added, answer.forces - answer.matrices @ truth], axis=2)).T
    form, none = physical_form(model), np.zeros((len(truth), len(truth)))
    values, true = form.of(estimate.fit.values, none)[0], form.of(truth, none)[0]
    effects = [values - form.of(estimate.fit.values - shift, none)[0] for shift in shifts]
    effects.append(values - form.of(estimate.fit.values - whole, none)[0] - sum(effects))
    effects.append(values - true - sum(effects))
    return {
        p.name: {cause: float(shift[k]) for cause, shift in zip(CAUSES, effects, strict=True)}
        for k, p in enumerate(form.parameters)
        if p.name in BODY
    }


def true_deviations(
    case: Case, answer: LinearAnswer, estimate: Estimate, disturbances: Disturbances, load: float
) -> dict[str, float]:
    """Standard deviations of parameters over machines that differ in their pose errors, by name [SI].

    The errors of the pose have the covariance that the simulated machine samples them from; all the rest is white, as
    in (28).

    Args:
        load: mass of the mounted weights [kg].
    """
    model = estimate.model
    home = case.need_machine("a validation")[0].home.vector
    weight = load * float(np.linalg.norm(case.gravity))
    common = pose_covariance(disturbances, home, answer.poses, weight)
    covariance = sum(part @ common @ part.T for part in np.moveaxis(answer.answer, 2, 0))
    form = physical_form(model)
    _, by_pose = form.of(estimate.fit.values, np.asarray(covariance))
    return {
        p.name: float(np.sqrt(variance + estimate.physical[p.name].std ** 2))
        for p, variance in zip(form.parameters, np.diag(by_pose), strict=True)
    }
