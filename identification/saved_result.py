"""What is read from `result.json`: its entries, and whether they agree with one another."""

from pathlib import Path

import numpy as np
from pydantic import ValidationError

from cases.errors import FileProblem
from cases.files import json_text, read_json
from identification.finding import SEVERITIES, Kind
from identification.model import Model
from identification.result import SCHEMA_VERSION, ResultEntries, physical_values

AGAIN = "identify again"
ALIKE = 1e-9  # of numbers that are computed anew: another computer rounds otherwise


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
        texts = [(s, text) for s in SEVERITIES for text in data[f"{s}s"]]
        findings = [{"kind": Kind.UNSAID, "severity": severity, "sentence": text} for severity, text in texts]
        numbers = {"kind": Kind.UNSAID, "severity": "note", "sentence": "", "quantity": quantity}
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

    By the model that they name; `wrench`: whether the channels are three forces and three moments.

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
        for key in ("value", "std", "std_robust"):
            require(f"{key} of {name}", getattr(stated, key), getattr(computed, key), size, "the linear parameters")
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
