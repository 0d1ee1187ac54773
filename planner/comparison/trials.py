"""The payload experiment of section 8: known weights are mounted one after the other and identified by each method.

Theoretical values are those of the platform as identified without payload plus the known weights, as in Table 7; a
simulated machine knows its true values too, and errors are also given in reported standard deviations of these.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cases.errors import CaseError, FileProblem, HexciteError
from cases.schema import Case
from cases.sensors import Disturbances, RigidBody
from identification.identify import estimate_parameters, standing_of
from identification.model import full_model
from identification.motion import Array
from identification.parameters import RIGID, body_parameters, linear_parameters, physical_form
from identification.recording import Recording, read
from identification.result import Estimate
from identification.runs.preparation import on_one_clock
from identification.runs.standstills import average, find_standstills, match
from identification.simulate import Circumstances, Moved, loaded_truth, moved, sensed
from identification.trajectories.executed import Execution
from planner.comparison.error_budget import BODY, error_budget, linear_answer, true_deviations

COMPARED = ("m", "zC", "IC33")  # what Table 7 compares with theory
SHOWN = (*COMPARED, "f_q0_3", "k0", "k1")


@dataclass(frozen=True, slots=True)
class Trial:
    """Identification by a method with some of the weights mounted: one row of Table 7."""

    method: str  # its name
    weights: int  # number of mounted weights
    load: float  # their mass [kg]
    duration: float | None  # measuring time [s]
    estimate: Estimate
    theory: Mapping[str, float]  # values by the identification without payload plus the weights, by name [SI]
    truth: Mapping[str, float]  # truth of a simulated machine, by name [SI]; empty for recordings
    # parts of a simulated machine's errors, by parameter and cause [SI]; empty for recordings
    budget: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    # standard deviations over machines whose pose errors differ, by name [SI]; empty where unknown
    scatter: Mapping[str, float] = field(default_factory=dict)

    @property
    def s0(self) -> float:
        """The value of (27) for the recorded forces, with the degrees of freedom of the parameters [N]."""
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
        """Parts of the error of a parameter, by cause, in reported standard deviations."""
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


@dataclass(frozen=True, slots=True)
class Excitation:
    """A method as a controller executed its program, without payload."""

    case: Case  # case with a simulated machine
    name: str  # method
    duration: float  # measuring time as executed [s]
    execution: Execution  # motion that the controller executed
    trigger: Array  # start and end of each time the trigger was on, shape (k, 2) [s]
    poses: Array  # poses at which the program measures standing still, shape (k, 6), empty for motions [m, rad]
    seed: int  # seed of the sensors' noise
    controller: str = ""  # controller that executed it, with a remark on the run

    def moved(self, weights: int, disturbances: Disturbances | None) -> Moved:
        """The machine's motion with some weights mounted; its drives ripple anew in each run."""
        return moved(self.case, self.execution, Circumstances((), disturbances), self.seed + weights)

    def recorded(
        self, weights: int, disturbances: Disturbances | None, run: Moved | None = None
    ) -> tuple[Recording, Array]:
        """The run with some weights mounted, averaged where it stands, and the parts of its forces."""
        around = Circumstances(_weights(self.case, weights), disturbances)
        run = self.moved(weights, disturbances) if run is None else run
        source = f"{self.name} with {weights} weights"
        recording, parts = sensed(self.case, run, self.trigger, self.seed + weights, source, around)
        if not len(self.poses):
            return recording, parts
        windows = find_standstills(recording, 0.0)
        averages, those = match(average(recording, windows), self.case, self.poses, source)
        return averages, np.array([[part[w].mean(axis=0) for w in windows[those]] for part in parts])


def _weights(case: Case, count: int) -> tuple[RigidBody, ...]:
    if case.payloads is None:
        case.missing("payloads", "a validation with payloads")
    return case.payloads.weights[:count]


def trials(excitation: Excitation, mounted: Sequence[int], disturbances: Disturbances | None) -> Iterator[Trial]:
    """The simulated machine identified with numbers of weights on it, ascending from 0.

    A set of poses is travelled through once: its standstills do not depend on the way there.
    """
    case = excitation.case
    once = excitation.moved(0, disturbances) if len(excitation.poses) else None
    bare: Estimate | None = None
    for k in mounted:
        recording, parts = excitation.recorded(k, disturbances, once)
        estimate = estimate_parameters(recording, case)
        bare = estimate if bare is None else bare
        weights = _weights(case, k)
        body = loaded_truth(case.need_simulation("the validation").parameters, weights)
        model = estimate.model
        linear = linear_parameters(model, body)
        form = physical_form(model)
        values, _ = form.of(linear, np.zeros((len(linear), len(linear))))
        truth = {p.name: float(v) for p, v in zip(form.parameters, values, strict=True) if p.name in BODY}
        load, budget, scatter = sum(w.mass_kg for w in weights), {}, {}
        if disturbances is not None:
            answer = linear_answer(case, recording, estimate)
            budget = error_budget(answer, recording, parts, estimate, linear)
            scatter = true_deviations(case, answer, estimate, disturbances, load)
        theory = _theory(bare, weights)
        yield Trial(excitation.name, k, load, excitation.duration, estimate, theory, truth, budget, scatter)


def recorded_trials(case: Case, folder: Path) -> Iterator[Trial]:
    """Recordings of a machine: in `folder` the runs 0, 1, .. with so many weights, as folders or files.

    Raises:
        FileProblem: the run without payload or one of the others is missing, or there are fewer than two.
        HexciteError: a run cannot be evaluated.
    """
    runs = {
        k: p for k in range(len(_weights(case, 99)) + 1) for p in (folder / f"{k}.csv", folder / str(k)) if p.exists()
    }
    files = [runs[k] for k in sorted(runs)]
    for k in range(len(files)):
        if k not in runs:
            raise FileProblem(folder, f"holds runs up to {max(runs)}, but not {k}", "each number of weights is wanted")
    if len(files) < 2:
        raise FileProblem(
            folder,
            f"holds {len(files)} of the runs 0, 1, .. (folders or CSV files, named after the number of weights "
            "mounted)",
            "a validation needs at least 0 and 1",
        )
    bare: Estimate | None = None
    for k, file in enumerate(files):
        estimate = estimate_parameters(standing_of(on_one_clock(read(file, case), case), case)[0], case)
        bare = estimate if bare is None else bare
        weights = _weights(case, k)
        load = sum(w.mass_kg for w in weights)
        yield Trial(folder.name, k, load, None, estimate, _theory(bare, weights), {})


def _theory(bare: Estimate, mounted: Sequence[RigidBody]) -> dict[str, float]:
    """The platform as identified without payload, with weights on it; offsets stay.

    Linear parameters of bodies add; the estimate need not be one of a real body.
    """
    names, form = bare.model.names, physical_form(bare.model)
    bodies = [body_parameters(weight) for weight in mounted]
    linear = bare.fit.values + [sum(body.get(name, 0.0) for body in bodies) for name in names]
    values, _ = form.of(linear, np.zeros((len(names), len(names))))
    return {p.name: float(v) for p, v in zip(form.parameters, values, strict=True) if p.name[0] not in "kK"}


def require_weights(case: Case) -> None:
    """Raises CaseError where a case has no weights, or a machine for which methods are not compared."""
    if case.limits is not None and full_model(case) == RIGID:
        raise CaseError(
            f"case {case.name}",
            "setup",
            f"is {case.setup}: a validation compares methods for sensors in a hexapod's platform; run and identify "
            "with and without a weight, and see what hexcite payload says of it",
        )
    _weights(case, 0)


def mounted_weights(case: Case, wanted: str | None) -> tuple[int, ...]:
    """Numbers of weights to mount, by default all; raises HexciteError where `wanted` is not such, as in 0,3,5."""
    require_weights(case)
    most = len(_weights(case, 99))
    if wanted is None:
        return tuple(range(most + 1))
    words = [word.strip() for word in wanted.split(",")]
    numbers = tuple(int(word) for word in words if word.isdecimal())
    if len(numbers) < len(words) or numbers[0] != 0 or list(numbers) != sorted(set(numbers)) or numbers[-1] > most:
        raise HexciteError(
            f"weights {wanted!r}: give how many are mounted, from 0 upwards to at most {most}, as in 0,{most}"
        )
    return numbers
