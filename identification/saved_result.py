"""What is read from `result.json`: each entry as it was written, and whether the entries agree with one another."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AliasPath, BaseModel, BeforeValidator, Field, NonNegativeFloat, PositiveInt, ValidationError

from cases.errors import FileProblem
from cases.files import read_json
from identification.estimation.biases import AccelerometerBias
from identification.estimation.fit import Uncertain
from identification.finding import FINDINGS, Finding, Kind, Severity, sentences
from identification.model import Model
from identification.result import SCHEMA_VERSION, Value, physical_values

AGAIN = "identify again"
ALIKE = 1e-9  # of numbers that are computed anew: another computer rounds otherwise


def _named(entry: Any) -> Any:
    if not isinstance(entry, Mapping):  # a list would do for pydantic
        raise ValueError("is not an object")
    return entry


class Origin(BaseModel, strict=True, frozen=True, allow_inf_nan=False):
    """What a result was made of, and how; entries with a default may be absent."""

    case: str
    case_hash: str
    recording: str
    inputs: list[Annotated[dict[Literal["file", "sha256"], str], Field(min_length=2)]]
    versions: dict[str, str]
    model: int
    error_terms: list[str]
    estimator: str
    weights: str
    measuring_s: NonNegativeFloat | None = None
    plan_hash: str | None = None
    run: dict[str, Any] = {}
    stale: list[str] = []


class Parameters(BaseModel, strict=True, frozen=True, allow_inf_nan=False):
    """Parameters in both forms [SI]."""

    parameters: dict[str, Annotated[Value, BeforeValidator(_named)]]
    intervals_95: dict[str, Annotated[list[float], Field(min_length=2, max_length=2)]]
    names: list[str] = Field(validation_alias=AliasPath("linear", "names"))
    values: list[float] = Field(validation_alias=AliasPath("linear", "values"))
    covariance: list[list[float]]  # covariance of the linear ones by (28)
    covariance_robust: list[list[float]]
    delay_s: Annotated[Uncertain, BeforeValidator(_named)] | None
    accelerometer: AccelerometerBias | None


class ResultEntries(Origin, Parameters):
    """Entries of `result.json` that something is made of again; the others are only shown where they arose."""

    s0: NonNegativeFloat
    s0_N: NonNegativeFloat
    residual_rms: Annotated[list[NonNegativeFloat], Field(min_length=6, max_length=6)]
    samples: PositiveInt
    degrees_of_freedom: float
    rank: PositiveInt
    condition: NonNegativeFloat
    notes: list[str]
    warnings: list[str]
    findings: Annotated[tuple[Finding, ...], BeforeValidator(FINDINGS.validate_python)] = ()


def read_record(path: Path) -> tuple[Path, dict[str, Any]]:
    """Reads `result.json`, or that of the folder that holds it: the file, and what it says.

    Raises:
        FileProblem: missing, damaged or of another version.
    """
    file = path / "result.json" if path.is_dir() else path
    record = read_json(file, "hexcite identify")
    version = record.get("schema_version")
    if version != SCHEMA_VERSION:
        raise FileProblem(file, f"schema_version {version!r}, expected {SCHEMA_VERSION}", AGAIN)
    try:
        entries = ResultEntries.model_validate(record)
    except ValidationError as error:
        place = ".".join(map(str, error.errors()[0]["loc"]))
        raise FileProblem(file, f"entry {place} is missing or damaged", AGAIN) from error
    count = len(entries.values)
    for square in (entries.covariance, entries.covariance_robust):
        if len(square) != count or any(len(row) != count for row in square):
            raise FileProblem(file, "values and covariance do not belong together", AGAIN)
    if "findings" not in record:  # version 0.1
        told = ((Severity.NOTE, entries.notes), (Severity.WARNING, entries.warnings))
        findings = tuple(Finding(Kind.UNSAID, severity, text) for severity, texts in told for text in texts)
        record["findings"] = FINDINGS.dump_python(findings, mode="json")
    return file, record


def require_agreement(file: str, record: Mapping[str, Any], model: Model, wrench: bool) -> None:
    """Computes anew what follows from other entries, so that no two entries disagree.

    Args:
        record: as `read_record` returns it.
        model: the model that the entries name.
        wrench: whether the channels are three forces and three moments.

    Raises:
        FileProblem: an entry was changed by hand, or the parameters are those of another model.
    """
    linear, parameters, intervals = record["linear"], record["parameters"], record["intervals_95"]
    white, robust = np.array(record["covariance"]), np.array(record["covariance_robust"])
    if linear["names"] != list(model.names) or len(linear["values"]) != len(model.names):
        raise FileProblem(file, f"its parameters are not those of model {model.number}", AGAIN)
    physical = physical_values(model, np.array(linear["values"]), white, robust)
    if not physical.keys() == parameters.keys() == intervals.keys():
        raise FileProblem(file, f"its parameters are not those of model {model.number}", AGAIN)

    def require(entry: str, stated: float, computed: float, size: float, by: str) -> None:
        if not abs(stated - computed) <= ALIKE * size:
            raise FileProblem(file, f"{entry} is {stated:.6g}, but {computed:.6g} by {by}: changed by hand", AGAIN)

    for name, computed in physical.items():
        stated = Value(**parameters[name])
        size = max(abs(computed.value), computed.reported)
        require(f"value of {name}", stated.value, computed.value, size, "the linear parameters")
        require(f"std of {name}", stated.std, computed.std, size, "the linear parameters")
        require(f"std_robust of {name}", stated.std_robust, computed.std_robust, size, "the linear parameters")
        if stated.unit != computed.unit:
            raise FileProblem(file, f"unit of {name} is {stated.unit}, not {computed.unit}: changed by hand", AGAIN)
        of_interval = computed.interval(record["degrees_of_freedom"])
        for end, value, limit in zip(("lower", "upper"), intervals[name], of_interval, strict=True):
            require(f"{end} end of intervals_95 of {name}", value, limit, size, "its deviation")
    for key, square in (("covariance", white), ("covariance_robust", robust)):
        unequal = np.abs(square - square.T) > ALIKE * np.sqrt(np.outer(np.diag(square), np.diag(square)).clip(0.0))
        if unequal.any():
            row, column = np.argwhere(unequal)[0]
            place = f"{key} of {model.names[row]} and {model.names[column]}"
            require(place, square[row, column], square[column, row], 0.0, "the opposite entry")
    rms = float(np.sqrt(np.mean(np.square(record["residual_rms"][: 3 if wrench else 6]))))
    require("s0_N", record["s0_N"], rms, rms, "residual_rms")
    if record["warnings"] != list(sentences(FINDINGS.validate_python(record["findings"]), Severity.WARNING)):
        raise FileProblem(file, "its warnings are not those of its findings: changed by hand", AGAIN)
    if (accelerometer := record["accelerometer"]) is not None:
        deviations = np.sqrt(np.diag(accelerometer["covariance_m2_s4"]).clip(0.0))
        for stated_std, std in zip(accelerometer["std_m_s2"], deviations, strict=True):
            require("std_m_s2 of the accelerometer", stated_std, std, std, "its covariance")
