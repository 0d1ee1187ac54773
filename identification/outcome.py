"""The result of an identification as users hold it: parameters by name, saved and loaded as a folder."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases.files import RESULT, atomic_folder, check_folder, json_text, read_json
from cases.schema import Case
from cases.units import as_html
from identification.criteria import Identifiability
from identification.recording import Recording
from identification.result import Estimate, Residuals, Value
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
    residuals: Residuals | None = None

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
