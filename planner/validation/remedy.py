"""Where a structural mode draws an estimate: the same recording, identified with the mode (`identify --flexible`)."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import TypeAdapter, ValidationError

from cases.files import write_text
from cases.sensors import Disturbances
from identification.identify import identify
from identification.samples import Conditioning
from planner.validation.experiment import Excitation
from planner.validation.step import BODY, MODE, SUSPICIOUS, Identified, Step


class Remedy(NamedTuple):
    """A step whose errors are the mode's, identified with the mode.

    Args:
        step: as it was.
        names: of the parameters that were off for the mode.
        estimate: with the mode.
    """

    step: Step
    names: tuple[str, ...]
    estimate: Identified

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


def remedy_of(excitation: Excitation, step: Step, disturbances: Disturbances) -> Remedy | None:
    """Identifies a step with the mode; None where the mode causes none of its errors.

    Args:
        excitation: the method of the step.
        step: as it was.
        disturbances: of its recording.
    """
    names = tuple(
        n for n in BODY
        if step.budget is not None and abs(step.error(n) or 0.0) > SUSPICIOUS and step.budget.cause(n) == MODE
    )  # fmt: skip
    if not names:
        return None
    recording, _ = excitation.recorded(step.weights, disturbances)
    estimate = identify(recording, excitation.case, conditioning=Conditioning(flexible=True))
    return Remedy(step, names, Identified.of(estimate))


@dataclass(frozen=True, slots=True)
class Kept:
    """A finished step.

    Args:
        key: fingerprint of all that it follows from, but for what the whole validation has in common.
        controller: that executed the method, and what to know about the run.
        step: as found.
        remedy: the same with the structural mode, where that was the cause of an error.
    """

    key: str
    controller: str
    step: Step
    remedy: Remedy | None


_JSON = TypeAdapter(Kept)


def keep(folder: Path, done: Kept) -> None:
    """Writes a finished step."""
    write_text(_file(folder, done.step.method, done.step.weights), _JSON.dump_json(done).decode())


def kept_step(folder: Path, method: str, weights: int, key: str) -> Kept | None:
    """A step that was finished before; None where there is none that follows from the same."""
    file = _file(folder, method, weights)
    if not file.is_file():
        return None
    try:
        found = _JSON.validate_json(file.read_bytes())
    except ValidationError:  # of another version of this program
        return None
    return found if found.key == key else None


def _file(folder: Path, method: str, weights: int) -> Path:
    return folder / "steps" / f"{method}-{weights}.json"
