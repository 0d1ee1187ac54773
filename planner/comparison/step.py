"""What a method says with some of the weights mounted: one row of Table 7, as a value."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cases.schema import Case
from identification.findings.sample_checks import scan
from identification.hexapod import Hexapod
from identification.motion import Array
from identification.parameters import physical_form
from identification.recording import Recording
from identification.result import Estimate
from identification.runs.evaluation import Run
from identification.runs.preparation import moving_run, standstills
from identification.simulate import ForceParts


@dataclass(frozen=True, slots=True)
class LinearAnswer:
    """What parameters become of forces."""

    forces: Array  # as evaluated, shape (n, 6) [N]
    matrices: Array  # A_j of the parameters alone, shape (n, 6, u)
    answer: Array  # u = sum over j of answer_j f_j, what is estimated beside u included, shape (u, n, 6)
    poses: Array  # poses of the evaluated samples, shape (n, 6) [m, rad]
    run: Run | None  # a moving run with its filter; None where it stands

    def seen(self, added: Array) -> Array:
        """Forces of all samples of the recording as the evaluation sees them, shape (n, 6) [N]."""
        return added if self.run is None else self.run.filter.apply(added)[self.run.rows]

    def left(self, truth: Array) -> Array:
        """Evaluated forces less those of some parameters u, shape (n, 6) [N]."""
        return np.asarray(self.forces - self.matrices @ truth)

    def of(self, forces: Array) -> Array:
        """What evaluated forces, shape (n, 6, k) [N], move the parameters by, shape (u, k) [SI]."""
        return np.asarray(np.tensordot(self.answer, forces, axes=2))


def linear_answer(case: Case, recording: Recording, estimate: Estimate) -> LinearAnswer:
    """The answer of an estimate by least squares, at its delay.

    Args:
        recording: recording that was identified, averaged where it stands.
    """
    model = estimate.model
    struts, run, forces = recording.struts, None, recording.forces
    assert struts is not None
    if recording.t is None:
        matrices = columns = standstills(recording, case, model).matrices
        weights = np.ones(len(matrices)) if recording.weights is None else recording.weights
    else:
        run = moving_run(recording, case, model, found=scan(recording, case))
        run = replace(run, smoothing="smoothing_s2" in estimate.told)
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


BODY = ("m", "xC", "yC", "zC", "IC11", "IC22", "IC33")  # whose errors are told
SUSPICIOUS = 3.0  # reported standard deviations; more is a systematic error
MODE, POSE, NOISE = "the structural mode", "the errors of the pose", "the noise of the sensors"
RIPPLE, LEFT_OUT = "ripple and sampling", "samples that were left out"
CAUSES = (MODE, POSE, NOISE, RIPPLE, LEFT_OUT)


def cause_of(parts: Mapping[str, float]) -> str:
    """The disturbance without which an error, the sum of its parts by cause, would be smallest."""
    return min(CAUSES, key=lambda cause: abs(sum(parts.values()) - parts[cause]))


def error_budget(
    answer: LinearAnswer, recording: Recording, parts: ForceParts, estimate: Estimate, truth: Array
) -> dict[str, dict[str, float]]:
    """Takes the error of an estimate, less truth, apart: what adds up to it of each parameter, by cause [SI].

    What is left of the forces beside mode, pose errors and noise is that of ripple, encoders and sampling: motion that
    the evaluation sees in another way than the sensors felt it. Ripple that the mode amplifies counts as the mode's.

    Args:
        recording: recording that was identified, averaged where it stands.
        parts: what its true forces consist of, at the same rows.
        estimate: estimate by least squares.
        truth: linear parameters u of its model, shape (u,) [SI].
    """
    model = estimate.model
    noise = recording.forces - parts.total
    added = [answer.seen(part) for part in (parts.mode, parts.pose, noise)]
    *shifts, whole = answer.of(np.stack([*added, answer.left(truth)], axis=2)).T
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


COMPARED = ("m", "zC", "IC33")  # what Table 7 compares with theory
SHOWN = (*COMPARED, "f_q0_3", "k0", "k1")


@dataclass(frozen=True, slots=True)
class MethodStep:
    """What a method says with some of the weights mounted."""

    method: str  # its name
    weights: int  # so many
    load: float  # their mass [kg]
    duration: float | None  # measuring time [s]
    estimate: Estimate
    theory: Mapping[str, float]  # values by the identification without payload plus the weights, by name [SI]
    truth: Mapping[str, float]  # truth of a simulated machine, by name [SI]; empty for recordings
    # what a simulated machine's errors consist of, by parameter and cause [SI]; empty for recordings
    budget: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    # standard deviations over machines whose pose errors differ, by name [SI]; empty where unknown
    scatter: Mapping[str, float] = field(default_factory=dict)

    @property
    def s0(self) -> float:
        """(27) of the recorded forces: their residuals, and what the parameters take of them [N]."""
        forces = 6 * self.estimate.evaluated.samples
        return self.estimate.s0_N * float(np.sqrt(forces / (forces - len(self.estimate.model.names))))

    def deviation(self, name: str) -> float | None:
        """Relative deviation from theory; None where there is no theory."""
        if name not in self.theory or name not in self.estimate.physical:
            return None
        return self.estimate.physical[name].value / self.theory[name] - 1.0

    def error(self, name: str) -> float | None:
        """Estimate less truth in reported standard deviations; None where the truth is unknown."""
        if name not in self.truth or name not in self.estimate.physical:
            return None
        value = self.estimate.physical[name]
        return (value.value - self.truth[name]) / value.reported

    def parts_in_std(self, name: str) -> dict[str, float]:
        """What the error of a parameter consists of, by cause, in reported standard deviations."""
        std = self.estimate.physical[name].reported
        return {cause: part / std for cause, part in self.budget[name].items()}

    def to_json(self) -> dict[str, Any]:
        """One row of the answer, SI units."""
        return {
            "method": self.method,
            "weights": self.weights,
            "load_kg": self.load,
            "duration_s": self.duration,
            "model": self.estimate.model.number,
            "samples": self.estimate.evaluated.samples,
            "s0_N": self.s0,
            "parameters": {name: value._asdict() for name, value in self.estimate.physical.items()},
            "relative_deviation": {n: self.deviation(n) for n in SHOWN if self.deviation(n) is not None},
            "error_in_std": {n: self.error(n) for n in BODY if self.error(n) is not None},
            "error_budget_in_std": {name: self.parts_in_std(name) for name in self.budget},
            "std_over_machines": dict(self.scatter),
            "warnings": list(self.estimate.warnings),
        }
