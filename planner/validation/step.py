"""What a method says with some of the weights mounted: one row of Table 7, as a value that can be kept in a file."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from identification.result import Estimate, Value
from planner.validation.causes import BODY, Budget

COMPARED = ("m", "zC", "IC33")  # what Table 7 compares with theory
SHOWN = (*COMPARED, "f_q0_3", "k0", "k1")


@dataclass(frozen=True, slots=True)
class Identified:
    """What a validation needs of an estimate.

    Args:
        model: number in Table 2.
        samples: used.
        unknowns: parameters of the model.
        s0_N: rms residual of the recorded forces [N].
        physical: parameters by name.
        warnings: sentences.
        mode: frequency of the structural mode that was estimated [Hz]; None where none was.
    """

    model: int
    samples: int
    unknowns: int
    s0_N: float
    physical: Mapping[str, Value]
    warnings: tuple[str, ...] = ()
    mode: float | None = None

    @classmethod
    def of(cls, estimate: Estimate) -> "Identified":
        """Of an estimate."""
        told = estimate.told.get("structural_mode_Hz")
        return cls(
            estimate.model,
            estimate.samples,
            len(estimate.names),
            estimate.s0_N,
            estimate.physical,
            estimate.warnings,
            None if told is None else float(told["value"]),
        )


@dataclass(frozen=True, slots=True)
class Step:
    """What a method says with some of the weights mounted.

    Args:
        method: its name.
        weights: so many.
        load: their mass [kg].
        duration: measuring time [s].
        estimate: the identification.
        theory: values by the identification without payload plus the weights, by name [SI].
        truth: of a simulated machine, by name [SI]; empty for recordings.
        budget: what a simulated machine's errors consist of; None for recordings.
        scatter: standard deviations over machines whose pose errors differ, by name [SI]; empty where unknown.
        columns: of Table 3: the same recording identified with other models, by number, for the methods in `TABLE_3`.
    """

    method: str
    weights: int
    load: float
    duration: float | None
    estimate: Identified
    theory: Mapping[str, float]
    truth: Mapping[str, float]
    budget: Budget | None = None
    scatter: Mapping[str, float] = field(default_factory=dict)
    columns: Mapping[int, Identified] = field(default_factory=dict)

    @property
    def s0(self) -> float:
        """(27) of the recorded forces: their residuals, and what the parameters take of them [N]."""
        forces = 6 * self.estimate.samples
        return self.estimate.s0_N * float(np.sqrt(forces / (forces - self.estimate.unknowns)))

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

    def to_json(self) -> dict[str, Any]:
        """One row of the answer, SI units."""
        return {
            "method": self.method,
            "weights": self.weights,
            "load_kg": self.load,
            "duration_s": self.duration,
            "model": self.estimate.model,
            "samples": self.estimate.samples,
            "s0_N": self.s0,
            "parameters": {name: value._asdict() for name, value in self.estimate.physical.items()},
            "relative_deviation": {n: self.deviation(n) for n in SHOWN if self.deviation(n) is not None},
            "error_in_std": {n: self.error(n) for n in BODY if self.error(n) is not None},
            "error_budget_in_std": {} if self.budget is None else self.budget.in_std(self.estimate.physical),
            "std_over_machines": dict(self.scatter),
            "warnings": list(self.estimate.warnings),
        }
