"""Saved results as `hexcite identify` writes them, with parameters that a test chooses."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.recording_format import Drives
from cases.schema import Case, load_case
from identification.model.model import Model, identification_model
from identification.model.parameters import body_parameters
from identification.results.estimate import physical_values
from identification.results.result import Result

Array = NDArray[np.float64]


def plausible(case: Case, model: Model, seed: int = 0) -> Array:
    """U of a machine that might exist: the nominal body and seeded offsets and factors."""
    draw = np.random.default_rng(seed)
    body = case.nominal
    known = body_parameters(body) if body is not None else {"m": 0.932, "mxC": 0.0003, "myC": 1e-4, "mzC": 0.041}
    return np.array([known.get(n, 30.0 * draw.normal()) for n in model.names])


def write_result(folder: Path, machine: Case, number: int, values: Array | None = None, **changes: Any) -> Path:
    """A result folder; `changes` replace entries of result.json."""
    model = identification_model(machine, number)
    u = plausible(machine, model) if values is None else values
    covariance = np.diag((1e-3 * np.abs(u) + 1e-3) ** 2)
    physical = physical_values(model, u, covariance, 4.0 * covariance)
    data = {
        "schema_version": 1,
        "case": machine.name,
        "case_hash": machine.hash,
        "recording": "run.csv",
        "inputs": [],
        "versions": {},
        "model": number,
        "s0": 1.0,
        "s0_N": 1.0,
        "residual_rms": [1.0] * 6,
        "samples": 3400,
        "degrees_of_freedom": 3380,
        "rank": len(u),
        "condition": 60.0,
        "weights": "equal",
        "delay_s": {"value": 2.5e-3, "std": 1e-4},
        "parameters": {name: value._asdict() for name, value in physical.items()},
        "linear": {"names": model.names, "values": u.tolist()},
        "covariance": covariance.tolist(),
        "covariance_robust": (4.0 * covariance).tolist(),
        "findings": [
            {"kind": "model", "severity": "warning", "sentence": text} for text in changes.pop("warnings", [])
        ],
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "result.json").write_text(json.dumps(data | changes), encoding="utf-8")
    return folder


DRIVES = {
    "order": [2, 1, 3, 6, 5, 4],
    "sign": [1.0, -1.0, 1.0, 1.0, -1.0, -1.0],
    "offset_mm": [500.0, 510.0, 520.0, 530.0, 540.0, 550.0],
}
"""Strut k = sign_k * drive order_k + offset_k."""


def with_drives(made: Result) -> Result:
    """The result of a machine whose case says how drives move its struts."""
    recording = made.case.recording.model_copy(update={"drives": Drives.model_validate(DRIVES)})
    return replace(made, case=made.case.model_copy(update={"recording": recording}))


def calibration(folder: Path, name: str, number: int, values: Array | None = None, **changes: Any) -> Result:
    """The result of a built-in case."""
    return Result.load(write_result(folder, load_case(name), number, values, **changes))
