"""The entries of `result.json`, how they follow from an estimate, and whether they agree with one another."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    AliasPath,
    BaseModel,
    BeforeValidator,
    Field,
    NonNegativeFloat,
    PlainSerializer,
    PositiveInt,
    ValidationError,
)

from cases.errors import FileProblem
from cases.files import json_text, read_json
from cases.units import Array
from identification.estimation.biases import AccelerometerBias
from identification.estimation.fit import Uncertain
from identification.finding import AS_OBJECT, FROZEN, Entries, Finding, Kind, Severity, sentences
from identification.model import Model, identification_model
from identification.parameters import ERROR_TERMS
from identification.result import Estimate, Value, physical_values

SCHEMA_VERSION = 1
AGAIN = "identify again"
ALIKE = 1e-9  # of numbers that are computed anew: another computer rounds otherwise


def _named(entry: Any) -> Any:
    if isinstance(entry, list):  # it would do for pydantic
        raise ValueError("is not an object")
    return entry


Numbers = tuple[float, ...]
Physical = Annotated[Value, BeforeValidator(_named), PlainSerializer(Value._asdict)]
Delay = Annotated[Uncertain, BeforeValidator(_named), PlainSerializer(Uncertain._asdict)]
Input = Annotated[Mapping[Literal["file", "sha256"], str], Field(min_length=2), FROZEN, AS_OBJECT]


class Origin(BaseModel, strict=True, frozen=True, allow_inf_nan=False, populate_by_name=True):
    """What a result was made of; entries with a default may be absent."""

    case: str
    case_hash: str
    case_file: str | None = None
    recording: str
    inputs: tuple[Input, ...]
    versions: Annotated[Mapping[str, str], FROZEN, AS_OBJECT]
    computed_from: Entries | None = None  # values of the case by dotted key
    measuring_s: NonNegativeFloat | None = None
    plan_hash: str | None = None
    run: Entries | None = None
    standstills: Entries | None = None
    tared_with: str | None = None
    stale: tuple[str, ...] = ()


class Parameters(Origin):
    """Parameters in both forms [SI], and what was known of them."""

    model: int
    error_terms: tuple[str, ...]
    known: Entries | None = None
    dropped: tuple[str, ...] = ()
    priors: Entries | None = None
    parameters: Annotated[Mapping[str, Physical], FROZEN, AS_OBJECT]
    intervals_95: Annotated[Mapping[str, tuple[float, float]], FROZEN, AS_OBJECT]
    names: tuple[str, ...] = Field(validation_alias=AliasPath("linear", "names"))
    values: Numbers = Field(validation_alias=AliasPath("linear", "values"))
    covariance: tuple[Numbers, ...]  # covariance of the linear ones by (28)
    covariance_robust: tuple[Numbers, ...]
    delay_s: Delay | None
    accelerometer: AccelerometerBias | None
    attenuation: Entries | None = None


class ResultEntries(Parameters):
    """Entries of `result.json`."""

    estimator: str
    biases: Entries | None = None
    weights: str
    s0: NonNegativeFloat
    s0_N: NonNegativeFloat
    residual_rms: Annotated[tuple[NonNegativeFloat, ...], Field(min_length=6, max_length=6)]
    samples: PositiveInt
    degrees_of_freedom: float
    rank: PositiveInt
    condition: NonNegativeFloat
    w_diagonal: Numbers = ()
    noise_sources: Entries | None = None
    findings: tuple[Finding, ...]

    def replaced(self, **changes: Any) -> Self:
        """The same with other entries."""
        return type(self)(**{name: getattr(self, name) for name in self.model_fields_set} | changes)

    def to_json(self) -> dict[str, Any]:
        """The object of the file: `notes`, `warnings` and what findings say in numbers stand beside them."""
        entries = self.model_dump(mode="json", exclude_unset=True)
        entries["linear"] = {key: entries.pop(key) for key in ("names", "values")}
        texts = {f"{severity}s": list(sentences(self.findings, severity)) for severity in Severity}
        quantities = {key: value for finding in entries["findings"] for key, value in finding["quantity"].items()}
        return {"schema_version": SCHEMA_VERSION, **entries, **texts, **quantities}


def entries_of(estimate: Estimate, **origin: Any) -> ResultEntries:
    """Entries of an estimate.

    Args:
        origin: what it was made of, by field of `Origin`.
    """
    fit, how, model, case = estimate.fit, estimate.how, estimate.model, estimate.case
    standard = identification_model(case, model.number).names == model.names
    return ResultEntries(
        case=case.name,
        case_hash=case.hash,
        recording=estimate.source,
        model=model.number,
        error_terms=() if standard else tuple(n for n, b in ERROR_TERMS.items() if b in model.blocks),
        known=how.known,
        dropped=tuple(how.dropped),
        priors={p.name: {"value": p.value, "std": p.std} for p in how.priors},
        **entries_of_parameters(estimate.physical, fit.freedom, fit.values, fit.covariance, fit.covariance_robust),
        names=tuple(model.names),
        delay_s=estimate.delay,
        accelerometer=estimate.accelerometer,
        attenuation=estimate.attenuation,
        estimator=how.name,
        biases=None if how.biases is None else how.biases.to_json(),
        weights=how.weights or case.sensors.weights,
        s0=fit.s0,
        s0_N=estimate.s0_N,
        residual_rms=tuple(estimate.residual_rms.tolist()),
        samples=estimate.evaluated.samples,
        degrees_of_freedom=fit.freedom,
        rank=fit.rank,
        condition=fit.condition,
        w_diagonal=tuple(fit.weights.tolist()),
        noise_sources=None if estimate.noise is None else estimate.noise.to_json(),
        findings=estimate.findings,
        **origin,
    )


def entries_of_parameters(
    physical: Mapping[str, Value], freedom: float, u: Array, covariance: Array, robust: Array
) -> dict[str, Any]:
    """Entries on parameters: physical ones by name, and the linear ones u with both covariances."""
    return {
        "parameters": physical,
        "intervals_95": {name: value.interval(freedom) for name, value in physical.items()},
        "values": tuple(u.tolist()),
        "covariance": tuple(map(tuple, covariance.tolist())),
        "covariance_robust": tuple(map(tuple, robust.tolist())),
    }


def read_entries(path: Path) -> tuple[Path, ResultEntries]:
    """Reads `result.json`, or that of the folder that holds it: the file, and its entries.

    Raises:
        FileProblem: missing, damaged or of another version.
    """
    file = path / "result.json" if path.is_dir() else path
    data = read_json(file, "hexcite identify")
    version = data.get("schema_version")
    if version != SCHEMA_VERSION:
        raise FileProblem(file, f"schema_version {version!r}, expected {SCHEMA_VERSION}", AGAIN)
    for key in (key for key in ("notes", "warnings") if not isinstance(data.get(key), list)):
        raise FileProblem(file, f"entry {key} is missing or damaged", AGAIN)
    if "findings" not in data:  # version 0.1
        own = {*ResultEntries.model_fields, "linear", "schema_version", "notes", "warnings"}
        quantity = {key: value for key, value in data.items() if key not in own}
        texts = [(s, text) for s in Severity for text in data[f"{s}s"]]
        findings = [{"kind": Kind.UNSAID, "severity": severity, "sentence": text} for severity, text in texts]
        numbers = {"kind": Kind.UNSAID, "severity": Severity.NOTE, "sentence": "", "quantity": quantity}
        data["findings"] = [*findings, numbers] if quantity else findings
    try:
        entries = ResultEntries.model_validate_json(json_text(data))
    except ValidationError as error:
        place = ".".join(map(str, error.errors()[0]["loc"]))
        raise FileProblem(file, f"entry {place} is missing or damaged", AGAIN) from error
    count = len(entries.values)
    for square in (entries.covariance, entries.covariance_robust):
        if len(square) != count or any(len(row) != count for row in square):
            raise FileProblem(file, "values and covariance do not belong together", AGAIN)
    for key, value in entries.to_json().items():
        if key not in ResultEntries.model_fields and data.get(key) != value:
            raise FileProblem(file, f"{key} is not what findings say: changed by hand", AGAIN)
    return file, entries


def require_agreement(file: str, entries: ResultEntries, model: Model, wrench: bool) -> None:
    """Computes anew what follows from other entries, so that no two entries disagree.

    Args:
        model: the model that the entries name.
        wrench: whether the channels are three forces and three moments.

    Raises:
        FileProblem: an entry was changed by hand, or the parameters are those of another model.
    """
    parameters, intervals = entries.parameters, entries.intervals_95
    white, robust = np.array(entries.covariance), np.array(entries.covariance_robust)
    if entries.names != tuple(model.names) or len(entries.values) != len(model.names):
        raise FileProblem(file, f"its parameters are not those of model {model.number}", AGAIN)
    physical = physical_values(model, np.array(entries.values), white, robust)
    if not physical.keys() == parameters.keys() == intervals.keys():
        raise FileProblem(file, f"its parameters are not those of model {model.number}", AGAIN)

    def require(entry: str, stated: float, computed: float, size: float, by: str) -> None:
        if not abs(stated - computed) <= ALIKE * size:
            raise FileProblem(file, f"{entry} is {stated:.6g}, but {computed:.6g} by {by}: changed by hand", AGAIN)

    for name, computed in physical.items():
        stated = parameters[name]
        size = max(abs(computed.value), computed.reported)
        require(f"value of {name}", stated.value, computed.value, size, "the linear parameters")
        require(f"std of {name}", stated.std, computed.std, size, "the linear parameters")
        require(f"std_robust of {name}", stated.std_robust, computed.std_robust, size, "the linear parameters")
        if stated.unit != computed.unit:
            raise FileProblem(file, f"unit of {name} is {stated.unit}, not {computed.unit}: changed by hand", AGAIN)
        of_interval = computed.interval(entries.degrees_of_freedom)
        for end, value, limit in zip(("lower", "upper"), intervals[name], of_interval, strict=True):
            require(f"{end} end of intervals_95 of {name}", value, limit, size, "its deviation")
    for key, square in (("covariance", white), ("covariance_robust", robust)):
        unequal = np.abs(square - square.T) > ALIKE * np.sqrt(np.outer(np.diag(square), np.diag(square)).clip(0.0))
        if unequal.any():
            row, column = np.argwhere(unequal)[0]
            place = f"{key} of {model.names[row]} and {model.names[column]}"
            require(place, square[row, column], square[column, row], 0.0, "the opposite entry")
    rms = float(np.sqrt(np.mean(np.square(entries.residual_rms[: 3 if wrench else 6]))))
    require("s0_N", entries.s0_N, rms, rms, "residual_rms")
    if (accelerometer := entries.accelerometer) is not None:
        deviations = np.sqrt(np.diag(accelerometer.covariance_m2_s4).clip(0.0))
        for stated_std, std in zip(accelerometer.std_m_s2, deviations, strict=True):
            require("std_m_s2 of the accelerometer", stated_std, std, std, "its covariance")
