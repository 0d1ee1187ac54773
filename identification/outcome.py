"""The result of an identification as users hold it: parameters by name, saved and loaded as a folder."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cases.files import RESULT, atomic_folder, check_folder, json_text, read_json
from cases.schema import Case
from cases.units import as_html
from identification.criteria import Identifiability
from identification.model import expected_forces
from identification.recording import Recording
from identification.result import Estimate, Value
from identification.runs.averaging import PeriodicRun
from identification.runs.evaluation import Run
from identification.runs.wrist import WristRun
from identification.samples import Standstills
from identification.saved_result import SavedResult, load_result, solution_of, with_tare

if TYPE_CHECKING:
    from identification.external import ExternalForce

# Of what recording.json says of a run, what a result keeps.
TOLD_OF_RUNS = ("controller", "program", "program_hash", "plan_hash", "seed", "payload", "simulation_source")
PROMINENT = ("m", "xC", "yC", "zC")  # shown first


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Result:
    """Identified parameters.

    Args:
        case: case of the recording.
        record: what result.json says.
        identifiability: what the run determined; None where nothing says.
        estimate: estimate with everything that is not saved; None where it was loaded.
        residuals: residuals of the recorded forces; None where it was loaded.
    """

    case: Case
    record: Mapping[str, Any]
    identifiability: Identifiability | None = None
    estimate: Estimate | None = None
    residuals: "Residuals | None" = None

    def __getitem__(self, name: str) -> Value:
        """A physical parameter [SI]: `result["m"].value`, `.std` by (28), `.std_robust`, `.unit`."""
        return self.parameters[name]

    @property
    def parameters(self) -> dict[str, Value]:
        """Physical parameters by name [SI]."""
        return {name: Value(**entry) for name, entry in self.record["parameters"].items()}

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user should act on."""
        return tuple(self.record["warnings"])

    @property
    def notes(self) -> tuple[str, ...]:
        """What else there is to say of the evaluation."""
        return tuple(self.record["notes"])

    @property
    def solution(self) -> SavedResult:
        """The linear parameters with their covariance, for predictions."""
        return solution_of(self.record, str(self.record["recording"]))

    def write(self, folder: Path) -> None:
        """Writes result.json and identifiability.json into a folder that is there."""
        (folder / "result.json").write_text(json_text(dict(self.record)), encoding="utf-8")
        if self.identifiability is not None:
            text = json_text(self.identifiability.to_json())
            (folder / "identifiability.json").write_text(text, encoding="utf-8")

    def save(self, folder: Path | str, overwrite: bool = False) -> None:
        """Makes a folder with the same files; residuals are not saved.

        Raises:
            FileProblem: the folder is somebody's, or cannot be written.
        """
        check_folder(Path(folder), RESULT, overwrite=overwrite)
        with atomic_folder(Path(folder), RESULT, overwrite) as part:
            self.write(part)

    @classmethod
    def load(cls, folder: Path | str, case: Case | None = None, stale: bool = False) -> "Result":
        """The result of a folder.

        Args:
            folder: folder that `save` or `hexcite identify` wrote.
            case: instead of the one that the folder names.
            stale: read it although its case has changed since.

        Raises:
            FileProblem: missing, damaged, changed by hand or of another version; or its case has changed since.
        """
        place = Path(folder)
        saved = load_result(place)
        own = saved.artefact.case() if case is None else case
        if case is None:
            saved.remarks(own, stale)
        saved.require_own_parameters(own)
        file = place / "identifiability.json"
        identifiability = Identifiability.of_json(read_json(file, "hexcite identify")) if file.is_file() else None
        return cls(own, saved.about, identifiability)

    def __repr__(self) -> str:
        """A few lines: model, the body, s0, and warnings."""
        record, parameters = self.record, self.parameters
        lines = [f"Result for {self.case.name}: model {record['model']}, {record['samples']} samples"]
        names = [name for name in PROMINENT if name in parameters] or list(parameters)[:4]
        lines += [
            f"{name} = {parameters[name].value:.6g} +- {parameters[name].reported:.2g} {parameters[name].unit}"
            for name in names
        ]
        lines.append(f"{len(parameters)} parameters, s0 {record['s0']:.3g}, condition {record['condition']:.3g}")
        return "\n".join([*lines, *(f"warning: {warning}" for warning in self.warnings)])

    def _repr_html_(self) -> str:
        return as_html(repr(self))


def force(recording: Recording, result: Result, whole: bool = True) -> "ExternalForce":
    """External force and moment over a recording, in {P}; of a moving run behind the filter of the case.

    Args:
        recording: a run of the same machine.
        result: identified parameters; their delay is compensated.
        whole: all samples; else only the excitation.

    Raises:
        RecordingError, IdentificationError: the recording cannot be evaluated.
    """
    from identification.external import external_force
    from identification.runs.rates import on_one_clock

    return external_force(on_one_clock(recording, result.case), result.case, result.solution, whole)


def tare(recording: Recording, result: Result) -> Result:
    """The result with sensor offsets identified anew from a standstill without contact; all else stays.

    Args:
        recording: one pose, any number of samples.
        result: identified parameters.

    Raises:
        IdentificationError: the machine moves, or there are fewer than two samples.
    """
    from identification.external import tare as new_offsets
    from identification.runs.rates import on_one_clock

    solution = result.solution
    offsets = new_offsets(on_one_clock(recording, result.case), result.case, solution)
    return Result(
        result.case,
        with_tare(solution, result.case, offsets.values, offsets.covariance, recording.source, offsets.notes),
    )


Array = NDArray[np.float64]

MOST_SAMPLES = 60_000  # of the recording: a minute at 1 kHz says what its forces look like, and hours do not fit
SEGMENT = 1024  # samples of a periodogram: 1 Hz at 1 kHz


@dataclass(frozen=True, slots=True)
class Residuals:
    """Recorded forces and the model's, at every recorded sample of the excitation (standstills: at each of them)."""

    t: Array  # time, shape (n,) [s]; of standstills their number from 1
    forces: Array  # as recorded, shape (n, 6) [N, or N and N m]
    predicted: Array  # A u behind the evaluation's filter, the delay put right, shape (n, 6)
    step: float | None  # time between samples [s]; None for standstills
    # the forces as the estimator saw them, behind the evaluation's filter, shape (n, 6); None where it saw them as
    # recorded, or averaged in another way
    filtered: Array | None = None

    @property
    def values(self) -> Array:
        """Recorded less predicted, shape (n, 6)."""
        return np.asarray(self.forces - self.predicted)

    @property
    def seen(self) -> Array:
        """The forces that the model had to explain: behind the filter where there is one, shape (n, 6)."""
        return self.forces if self.filtered is None else self.filtered

    @property
    def left(self) -> Array:
        """What the model leaves of them, shape (n, 6)."""
        return np.asarray(self.seen - self.predicted)

    def spectrum(self) -> tuple[Array, Array]:
        """Amplitude spectral density of each channel, by Welch's method, shapes (k,) [Hz] and (k, 6) [N/sqrt(Hz)].

        Periodograms of segments under a Hann window that overlap by half, each less its mean, are averaged.

        Raises:
            ValueError: standstills have no spectrum.
        """
        if self.step is None:
            raise ValueError("standstills have no spectrum")
        from scipy.signal import welch  # loads slowly, and only pages ask for it

        frequencies, power = welch(self.values, 1.0 / self.step, nperseg=min(SEGMENT, len(self.t)), axis=0)
        return frequencies, np.sqrt(power)


def residuals_of(estimate: Estimate) -> Residuals:
    """What a run recorded beside what its own estimate says, at most the first `MOST_SAMPLES`."""
    samples, delay, u = estimate.evaluated, estimate.at, estimate.fit.values
    if isinstance(samples, Standstills):
        return Residuals(samples.t, samples.recorded, samples.matrices @ u, None)
    if isinstance(samples, WristRun):
        values, step = samples.regressors(delay) @ u, samples.filter.step * samples.filter.stride
        return Residuals(samples.t, samples.recorded_forces, values, step)
    if isinstance(samples, PeriodicRun):
        assert samples.recording.t is not None
        t = samples.recording.t[samples.used][:MOST_SAMPLES]
        expected = samples.predicted(samples.regressors(delay) @ u, t)
        return Residuals(t, samples.recording.forces[samples.used][:MOST_SAMPLES], expected, samples.recording.step)
    assert isinstance(samples, Run)
    rows = np.arange(samples.rows[0], samples.rows[-1] + 1)
    every = replace(samples, rows=(rows if samples.spoilt is None else rows[~samples.spoilt[rows]])[:MOST_SAMPLES])
    predicted = expected_forces(every.model, every.kinematics(delay), u)
    return Residuals(every.t, every.recorded_forces, predicted, samples.filter.step, every.forces)
