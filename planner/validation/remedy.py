"""Where a structural mode draws an estimate: the same recording, identified with the mode (`identify --flexible`)."""

from typing import Any, NamedTuple

from cases.sensors import Disturbances
from identification.identify import identify
from identification.samples import Conditioning
from planner.validation.experiment import Excitation
from planner.validation.step import BODY, MODE, SUSPICIOUS, Identified, MethodStep


class Remedy(NamedTuple):
    """A step whose errors are the mode's, identified with the mode."""

    step: MethodStep  # as it was
    names: tuple[str, ...]  # names of the parameters that were off for the mode
    estimate: Identified  # estimate with the mode

    def error(self, name: str) -> float:
        """That is left, in reported standard deviations."""
        value = self.estimate.physical[name]
        return (value.value - self.step.truth[name]) / value.reported

    def rows(self) -> list[list[str]]:
        """For a table."""
        mode = "not seen" if self.estimate.mode is None else f"{self.estimate.mode:.1f} Hz"
        rows = []
        for name in self.names:
            before, truth = self.step.error(name) or 0.0, self.step.truth[name]
            relative = f"{100 * (self.estimate.physical[name].value / truth - 1):+.2f} %"
            errors = (f"{before:+.1f}", f"{self.error(name):+.1f}", relative)
            rows.append([self.step.method, f"{self.step.load:.0f} kg", name, *errors, mode])
        return rows

    def to_json(self) -> dict[str, Any]:
        """For the answer."""
        return {
            "method": self.step.method,
            "weights": self.step.weights,
            "mode_Hz": self.estimate.mode,
            "error_in_std": {name: self.error(name) for name in self.names},
        }


REMEDY_COLUMNS = ("method", "load", "parameter", "error in std", "with the mode", "relative", "mode found")


def remedy_of(excitation: Excitation, step: MethodStep, disturbances: Disturbances) -> Remedy | None:
    """Identifies a step with the mode; None where the mode causes none of its errors."""
    names = tuple(
        n for n in BODY
        if step.budget is not None and abs(step.error(n) or 0.0) > SUSPICIOUS and step.budget.cause(n) == MODE
    )  # fmt: skip
    if not names:
        return None
    recording, _ = excitation.recorded(step.weights, disturbances)
    estimate = identify(recording, excitation.case, conditioning=Conditioning(flexible=True))
    return Remedy(step, names, Identified.of(estimate))
