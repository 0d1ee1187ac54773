"""What the error of an estimate consists of, on a simulated machine whose disturbances are known one by one.

The estimate is linear in the forces: what each disturbance added to them passes the evaluation's filter and the least
squares of the run itself, and comes out as that disturbance's part of the error. Nothing is run again.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.model import identification_model
from identification.parameters import physical_form
from identification.recording import Recording
from identification.result import Estimate, Value
from identification.simulate import ForceParts
from planner.validation.answer import LinearAnswer

Array = NDArray[np.float64]

BODY = ("m", "xC", "yC", "zC", "IC11", "IC22", "IC33")  # whose errors are told
SUSPICIOUS = 3.0  # reported standard deviations; more is a systematic error
MODE, POSE, NOISE = "the structural mode", "the errors of the pose", "the noise of the sensors"
RIPPLE, LEFT_OUT = "ripple and sampling", "samples that were left out"
CAUSES = (MODE, POSE, NOISE, RIPPLE, LEFT_OUT)


@dataclass(frozen=True, slots=True)
class Budget:
    """Errors of an estimate, and what they consist of.

    Args:
        errors: estimate less truth, by parameter [SI].
        parts: of each parameter, by cause; they add up to its error [SI].
    """

    errors: Mapping[str, float]
    parts: Mapping[str, Mapping[str, float]]

    def cause(self, name: str) -> str:
        """The disturbance without which the error of a parameter would be smallest."""
        return min(CAUSES, key=lambda cause: abs(self.errors[name] - self.parts[name][cause]))

    def in_std(self, physical: Mapping[str, Value]) -> dict[str, dict[str, float]]:
        """The parts over reported standard deviations, by parameter and cause."""
        std = {name: physical[name].reported for name in self.parts}
        return {name: {cause: v / std[name] for cause, v in parts.items()} for name, parts in self.parts.items()}


def error_budget(
    case: Case, answer: LinearAnswer, recording: Recording, parts: ForceParts, estimate: Estimate, truth: Array
) -> Budget:
    """Takes the error of an estimate apart.

    What is left of the forces beside mode, pose errors and noise is that of ripple, encoders and sampling: motion that
    the evaluation sees in another way than the sensors felt it. Ripple that the mode amplifies counts as the mode's.

    Args:
        case: of the recording.
        answer: of the estimate to forces.
        recording: that was identified, averaged where it stands.
        parts: what its true forces consist of, at the same rows.
        estimate: by least squares.
        truth: linear parameters u of its model, shape (u,) [SI].
    """
    model = identification_model(case, estimate.model, estimate.terms)
    noise = recording.forces - parts.total
    added = [answer.seen(part) for part in (parts.mode, parts.pose, noise)]
    *shifts, whole = answer.of(np.stack([*added, answer.left(truth)], axis=2)).T
    form, none = physical_form(model), np.zeros((len(truth), len(truth)))
    values, true = form.of(estimate.values, none)[0], form.of(truth, none)[0]
    moved = [values - form.of(estimate.values - shift, none)[0] for shift in shifts]
    moved.append(values - form.of(estimate.values - whole, none)[0] - sum(moved))
    moved.append(values - true - sum(moved))
    names = [p.name for p in form.parameters]
    found = {
        name: {cause: float(shift[k]) for cause, shift in zip(CAUSES, moved, strict=True)}
        for k, name in enumerate(names)
        if name in BODY
    }
    return Budget({n: float(values[names.index(n)] - true[names.index(n)]) for n in found}, found)
