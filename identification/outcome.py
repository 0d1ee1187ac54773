"""The result of an identification as users hold it: parameters by name, saved and loaded as a folder."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from cases.basis import case_of, require_unchanged, result_basis
from cases.errors import FileProblem, HexciteError
from cases.files import DAMAGED, RESULT, atomic_folder, check_folder, json_text, read_json
from cases.schema import Case
from cases.units import Array, as_html
from identification.criteria import Identifiability
from identification.estimation.fit import Value
from identification.finding import Finding, sentences
from identification.model import Model, identification_model
from identification.result import Estimate, ResultEntries, identifiability_of
from identification.saved_result import AGAIN, read_entries, require_agreement
from identification.signals import Residuals

# Entries of recording.json that a result takes over.
RUN_ENTRIES = ("controller", "program", "program_hash", "plan_hash", "seed", "payload", "simulation_source")
PROMINENT = ("m", "xC", "yC", "zC")  # shown first


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """Identified parameters.

    Args:
        case: case of the recording.
        record: entries of result.json.
        estimate: estimate with everything that is not saved; None where it was loaded.
        determined: what the run determined, as loaded; None where no file says it.
        file: file that it was loaded from.
        remarks: what has changed in the case since, where it was loaded nevertheless.
    """

    case: Case
    record: ResultEntries
    estimate: Estimate | None = None
    determined: Identifiability | None = None
    file: Path | None = None
    remarks: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        """Whether both say the same: entries, what the run determined, and the case."""
        return isinstance(other, Result) and self._data == other._data

    def __hash__(self) -> int:
        return hash((self.record.case_hash, self.record.values))

    @property
    def _data(self) -> tuple[str, ResultEntries, dict[str, Any] | None]:
        determined = self.identifiability
        return self.case.hash, self.record, None if determined is None else determined.to_json()

    def __getitem__(self, name: str) -> Value:
        """A physical parameter [SI]: `result["m"].value`, `.std` by (28), `.std_robust`, `.unit`."""
        return self.parameters[name]

    @property
    def parameters(self) -> Mapping[str, Value]:
        """Physical parameters by name [SI]."""
        return self.record.parameters

    @cached_property
    def identifiability(self) -> Identifiability | None:
        """What the run determined; None where no file says it."""
        return self.determined if self.estimate is None else identifiability_of(self.estimate)

    @cached_property
    def residuals(self) -> Residuals | None:
        """Residuals of the recorded forces; None where it was loaded."""
        made = self.estimate
        return None if made is None else made.evaluated.series(made.at, made.fit.values)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What speaks against it, and what is good to know."""
        return self.record.findings

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that a user should act on."""
        return sentences(self.findings, "warning")

    @property
    def notes(self) -> tuple[str, ...]:
        """Further sentences on the evaluation."""
        return sentences(self.findings, "note")

    @property
    def source(self) -> str:
        """Its name in messages: its file, or the recording that it is from."""
        return str(self.record.recording if self.file is None else self.file)

    @property
    def model(self) -> Model:
        """The model of the parameters.

        Raises:
            FileProblem: they belong to another case, or no model of it has that number.
        """
        name = self.record.case
        if self.case.name != name:
            problem = f"parameters of case {name}, not {self.case.name}"
            raise FileProblem(self.source, problem, f"identify them for {self.case.name}")
        try:
            return identification_model(self.case, self.record.model)
        except HexciteError as error:
            raise FileProblem(self.source, error.typed, AGAIN) from error

    @property
    def values(self) -> Array:
        """The linear parameters u, shape (u,) [SI]."""
        return np.array(self.record.values, dtype=float)

    @property
    def covariance(self) -> Array:
        """Covariance of u by (28), shape (u, u)."""
        return np.array(self.record.covariance, dtype=float)

    @property
    def covariance_robust(self) -> Array:
        """Covariance of u that allows for noise with memory, shape (u, u)."""
        return np.array(self.record.covariance_robust, dtype=float)

    @property
    def delay(self) -> float:
        """Delay of the forces [s]; 0 where none was estimated."""
        return 0.0 if self.record.delay_s is None else self.record.delay_s.value

    @property
    def recordings(self) -> frozenset[str]:
        """SHA-256 of the files that it was made of; empty where it does not say."""
        return frozenset(entry["sha256"] for entry in self.record.inputs)

    def write(self, folder: Path) -> None:
        """Writes result.json and identifiability.json into a folder that is there."""
        (folder / "result.json").write_text(json_text(self.record.to_json()), encoding="utf-8")
        if self.identifiability is not None:
            text = json_text(self.identifiability.to_json())
            (folder / "identifiability.json").write_text(text, encoding="utf-8")

    def save(self, folder: Path | str, overwrite: bool = False) -> None:
        """Makes a folder with the same files; residuals are not saved.

        Raises:
            FileProblem: the folder holds something else, or cannot be written.
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
        file, record = read_entries(Path(folder))
        about = record.to_json()
        own = case_of(file, about, AGAIN) if case is None else case
        result = cls(own, record, file=file)
        require_agreement(result.source, record, result.model, own.sensor_frame.has_moments)
        remarks = require_unchanged(file, about, result_basis(own), own, stale, AGAIN)
        beside, determined = file.parent / "identifiability.json", None
        if beside.is_file():
            try:
                determined = Identifiability.of_json(read_json(beside, "hexcite identify"))
            except DAMAGED as error:
                raise FileProblem(beside, f"entry {error} is missing or damaged", AGAIN) from error
        return replace(result, determined=determined, remarks=remarks)

    def __repr__(self) -> str:
        """A few lines: model, the body, s0, and warnings."""
        record, parameters = self.record, self.parameters
        lines = [f"Result for {self.case.name}: model {record.model}, {record.samples} samples"]
        names = [name for name in PROMINENT if name in parameters] or list(parameters)[:4]
        lines += [f"{n} = {v.value:.6g} +- {v.reported:.2g} {v.unit}" for n in names for v in (parameters[n],)]
        lines.append(f"{len(parameters)} parameters, s0 {record.s0:.3g}, condition {record.condition:.3g}")
        return "\n".join([*lines, *(f"warning: {warning}" for warning in self.warnings)])

    _repr_html_ = as_html


def case_of_result(path: Path) -> Case:
    """The case that a saved result names.

    Raises:
        FileProblem: no such result, or it names no case.
        CaseError: its case cannot be read.
    """
    file, record = read_entries(path)
    return case_of(file, record.to_json(), AGAIN)
