"""What `recording.json` says of a run: the machine, the program, and what a controller made of it; a typed record."""

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from pydantic import BaseModel, NonNegativeFloat, NonNegativeInt, ValidationError

from cases.base.errors import Code, FileProblem, HexciteError
from cases.base.phrases import phrase
from cases.base.text_formats import json_text
from cases.base.units import Array
from cases.basis import recording_basis
from cases.schema import Case

SCHEMA_VERSION = 1
AGAIN = phrase("run_again", "run the program again")


class Entries(BaseModel, strict=True, frozen=True, allow_inf_nan=False, extra="allow"):
    """Entries of a JSON object; those that no field names stay as they are."""

    def to_json(self) -> dict[str, Any]:
        """The object, without what is not stated."""
        return self.model_dump(mode="json", exclude_unset=True)

    def __getitem__(self, key: str) -> Any:
        """An entry by its key in the file, as in version 0.2, where these were mappings; fields say the same."""
        return self.to_json()[key]

    def __contains__(self, key: object) -> bool:
        return key in self.to_json()

    def get(self, key: str, default: Any = None) -> Any:
        """The same, or a default."""
        return self.to_json().get(key, default)


class Payload(Entries):
    """What was mounted for a run."""

    weights: NonNegativeInt = 0  # how many weights of the case
    mass_kg: NonNegativeFloat = 0.0  # their mass


class RunOrigin(Entries):
    """Where a run is from: entries that a result takes over. None: not stated."""

    simulated: bool | None = None  # whether sensors and encoders are simulated
    controller: str | None = None
    program: str | None = None  # path of its file
    program_hash: str | None = None
    plan_hash: str | None = None
    seed: int | None = None  # seed of the sensors' noise
    payload: Payload | None = None
    simulation_source: str | None = None
    path_error_mm: NonNegativeFloat | None = None

    @property
    def mounted(self) -> float:
        """Mass of the payload [kg]; 0 where nothing is stated."""
        return 0.0 if self.payload is None else self.payload.mass_kg


class Executed(Entries):
    """What a controller made of a program."""

    controller: str
    executed_s: NonNegativeFloat  # time that the excitation took
    planned_s: NonNegativeFloat
    path_error_mm: NonNegativeFloat  # largest distance from the planned path
    d_efficiency: NonNegativeFloat | None  # as executed, behind the filter of the evaluation; None at poses
    d_efficiency_planned: NonNegativeFloat | None = None
    peaks_of_limit: Mapping[str, NonNegativeFloat]  # largest share of each limit, by its words
    exceeded: tuple[str, ...]  # sentences on limits that were exceeded
    remark: str


class RunRecord(Entries):
    """The entries of `recording.json`; the file has those of `origin` and `executed` beside the others."""

    case: str | None = None
    case_file: str | None = None
    case_hash: str | None = None
    computed_from: Mapping[str, Any] | None = None  # values of the case by dotted key
    origin: RunOrigin = RunOrigin()
    executed: Executed | None = None  # None where no controller of hexcite ran it
    poses_m_rad: tuple[tuple[float, ...], ...] = ()  # poses at which a program measured
    trigger_windows_s: tuple[tuple[float, float], ...] = ()

    @classmethod
    def of_json(cls, entries: Mapping[str, Any]) -> Self:
        """The record of a file's entries.

        Raises:
            HexciteError: an entry is missing or of another kind; `place` is its key.
        """
        parts: dict[str, Any] = {"origin": {key: entries[key] for key in RunOrigin.model_fields if key in entries}}
        if "executed_s" in entries:
            parts["executed"] = {key: entries[key] for key in Executed.model_fields if key in entries}
        named = {key for part in parts.values() for key in part}
        additional = {key: value for key, value in entries.items() if key not in named}
        try:
            return cls.model_validate_json(json_text(additional | parts))
        except ValidationError as error:
            place = [str(part) for part in error.errors()[0]["loc"] if part not in parts]
            raise HexciteError(
                place=".".join(place), problem="is missing or damaged", remedy=AGAIN, code=Code.DAMAGED
            ) from error

    @classmethod
    def of_case(cls, case: Case, **entries: Any) -> Self:
        """The record of a run of a case's machine, with what else is known of it, by field."""
        about: dict[str, Any] = {
            "schema_version": SCHEMA_VERSION,
            "case": case.name,
            "case_file": case.origin,
            "case_hash": case.hash,
        }
        return cls(**about, computed_from=recording_basis(case), **entries)

    def to_json(self) -> dict[str, Any]:
        """The object of the file."""
        entries_of_run = self.model_dump(mode="json", exclude_unset=True, exclude={"origin", "executed"})
        executed = {} if self.executed is None else self.executed.to_json()
        return entries_of_run | self.origin.to_json() | executed

    def poses(self, coordinates: int) -> Array | None:
        """Poses that the program measured, shape (n, coordinates); None where it measured none.

        Raises:
            FileProblem: they are poses of another machine.
        """
        if not self.poses_m_rad:
            return None
        if {len(pose) for pose in self.poses_m_rad} != {coordinates}:
            raise FileProblem(
                place="recording.json: poses_m_rad",
                problem=f"are not poses of {coordinates} numbers",
                remedy=AGAIN,
                code=Code.DAMAGED,
            )
        return np.array(self.poses_m_rad)
