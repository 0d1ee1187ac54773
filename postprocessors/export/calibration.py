"""A saved result together with its case and model: what is exported, and whether it may be; all of it as JSON."""

import hashlib
import re
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from numpy.typing import NDArray

from cases.errors import FileProblem
from cases.files import json_text
from cases.loading import load_case
from cases.schema import Case
from identification.hexapod import Hexapod
from identification.model import Model
from identification.outcome import Result
from identification.result import Value

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Calibration:
    """The calibrated measurement model."""

    result: Result
    case: Case  # the machine that they belong to, unchanged since
    model: Model
    hexapod: Hexapod | None  # kinematics, None where the case has no machine
    physical: dict[str, Value]  # physical parameters by name
    recording: str  # what they were identified from, and what the offsets were tared with
    samples: int  # how many samples that were
    s0: float  # (27)
    result_hash: str  # fingerprint of the file of the result
    warnings: tuple[str, ...]  # warnings that the result carries

    @property
    def deviations(self) -> Array:
        """Standard deviations of u, the larger of (28) and the robust ones, shape (u,)."""
        both = np.maximum(self.result.covariance.diagonal(), self.result.covariance_robust.diagonal())
        return np.asarray(np.sqrt(np.maximum(both, 0.0)))

    @property
    def origin(self) -> tuple[str, ...]:
        """Which result, case, model and version made a file, and every warning: one sentence a line."""
        terms = f" ({', '.join(self.result.terms)})" if self.result.terms else ""
        return (
            f"made by hexcite {version('hexcite')}",
            f"result {self.result.source} (sha256 {self.result_hash}), from {self.recording}: {self.samples} samples, "
            f"s0 {self.s0:.4g}",
            f"case {self.case.name}, hash {self.case.hash}; model {self.model.number}{terms} with "
            f"{len(self.model.names)} parameters",
            *(f"WARNING: {warning}" for warning in self.warnings),
        )


def load_calibration(path: Path, case_name: str | None, force: bool, stale: bool = False) -> Calibration:
    """Loads a result for export.

    Args:
        path: `result.json` or the folder that holds it.
        case_name: built-in name, folder or file of the case; by default the one that the result names.
        stale: export although the case has changed since; the file says so.

    Raises:
        FileProblem: the result is damaged, belongs to another case, or carries warnings and `force` is not set.
        CaseError: no such case.
    """
    return calibration_of(Result.load(path, None if case_name is None else load_case(case_name), stale), force)


def calibration_of(result: Result, force: bool = False) -> Calibration:
    """A result for export; errors as `load_calibration`."""
    model, file, data = result.model, result.source, result.record
    warnings, recording = result.warnings, data["recording"]
    if "tared_with" in data:
        recording += f", tared with {data['tared_with']}"
    if not result.values[0] > 0.0:
        raise FileProblem(file, f"mass {result.values[0]:.4g} kg is not positive", "identify from another run")
    if warnings and not force:
        more = f" (and {len(warnings) - 1} more)" if len(warnings) > 1 else ""
        raise FileProblem(
            file,
            f"carries a warning{more}: {warnings[0]}",
            "identify from a better run, or export with --force, which writes the warning into the file",
        )
    content = json_text(dict(data)).encode() if result.file is None else result.file.read_bytes()
    return Calibration(
        result=result,
        case=result.case,
        model=model,
        hexapod=Hexapod.of(result.case) if result.case.hexapod is not None else None,
        physical=result.parameters,
        recording=recording,
        samples=data["samples"],
        s0=data["s0"],
        result_hash=hashlib.sha256(content).hexdigest()[:16],
        warnings=(*warnings, *result.remarks),
    )


def json_document(calibration: Calibration) -> str:
    """The calibrated model as JSON, everything that an implementation of its own needs, in SI units and radians.

    `calibration.schema.json` beside this file, a JSON Schema, describes each entry.
    """
    case, result, model = calibration.case, calibration.result, calibration.model
    kinematics = None
    if case.hexapod is not None:
        drives = case.recording.drives
        kinematics = {
            "base_m": case.hexapod.base.points.tolist(),
            "platform_m": case.hexapod.platform.points.tolist(),
            "home": case.hexapod.home.vector.tolist(),
            "drives": drives and {"drive": drives.order, "sign": drives.sign, "offset_m": drives.offset.tolist()},
        }
    deviations = [np.sqrt(np.maximum(c.diagonal(), 0.0)) for c in (result.covariance, result.covariance_robust)]
    linear = zip(model.parameters, result.values.tolist(), *(d.tolist() for d in deviations), strict=True)
    return json_text(
        {
            "schema_version": 1,
            "kind": "hexcite calibration",
            "origin": {
                "hexcite": version("hexcite"),
                "result": result.source,
                "result_sha256": calibration.result_hash,
                "recording": calibration.recording,
                "samples": calibration.samples,
                "s0": calibration.s0,
                "case": case.name,
                "case_hash": case.hash,
            },
            "warnings": calibration.warnings,
            "model": model.number,
            "error_terms": result.terms,
            "gravity_m_s2": case.gravity.tolist(),
            "structure": model.structure.tolist() if model.struts is None else None,
            "struts": model.struts and {"at": model.struts.sensors.at},
            "force_delay_s": result.delay,
            "kinematics": kinematics,
            "linear": [
                {"name": p.name, "unit": p.unit, "value": value, "std": std, "std_robust": robust}
                for p, value, std, robust in linear
            ],
            "covariance": result.covariance.tolist(),
            "covariance_robust": result.covariance_robust.tolist(),
            "physical": [
                {"name": name, "unit": v.unit, "value": v.value, "std": v.std, "std_robust": v.std_robust}
                for name, v in calibration.physical.items()
            ],
        }
    )


MOST_STEPS = 12
"""Of the forward kinematics from one start; from home into a corner of the workspace it takes five."""

_NAME = re.compile(r"[a-z][a-z0-9_]{0,30}")


@cache
def environment() -> Environment:
    """Templates of this package; an undefined name in one is an error."""
    return Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # code, not pages
    )


def default_name(calibration: Calibration) -> str:
    """Name of the model in the written language, short enough for a number behind it."""
    return f"{calibration.case.name[:22].rstrip('_')}_force"


def checked_name(stem: str, file: Path) -> str:
    """A file's name as the name of what is in it.

    Raises:
        FileProblem: it is not a name in the languages that are written.
    """
    if not _NAME.fullmatch(stem) or stem.endswith("_"):
        raise FileProblem(
            file,
            f"{stem!r} becomes the name of the model, which is up to 31 small letters, digits and _, from a letter on",
            "choose another file name with -o",
        )
    return stem


def comment_lines(calibration: Calibration) -> list[str]:
    """Where the parameters are from, as printable ASCII that ends no comment in C, Structured Text or NC programs."""
    lines = []
    for line in calibration.origin:
        plain = " ".join(line.split()).encode("ascii", "backslashreplace").decode()
        plain = "".join(c if c.isprintable() else "?" for c in plain)
        lines.append(plain.replace("*/", "* /").replace("*)", "* )").replace("(*", "( *").replace("/*", "/ *"))
    return lines


def rendered(template: str, calibration: Calibration, name: str, **own: Any) -> str:
    """A template filled with what every language is told of a model called `name`, and with values of its own."""
    case, model = calibration.case, calibration.model
    drives = case.recording.drives if calibration.hexapod is not None else None
    rows = zip(model.parameters, calibration.result.values, calibration.deviations, strict=True)
    shared: dict[str, Any] = {
        "name": name,
        "NAME": name.upper(),
        "origin": comment_lines(calibration),
        "hexapod": calibration.hexapod is not None,
        "home": [number(v) for v in (np.zeros(6) if case.hexapod is None else case.hexapod.home.vector)],
        "force_units": "N, N m" if case.sensor_frame.has_moments else "N",
        "delay": number(calibration.result.delay),
        "most_steps": MOST_STEPS,
        "drives": drives
        and {
            "index": drives.index,
            "sign": [number(s) for s in drives.sign],
            "offset": [number(v) for v in drives.offset],
        },
        "offsets": [n for n in model.names if n.startswith("f_q0_")],
        "parameters": [
            {"name": p.name, "unit": p.unit, "value": number(v), "meaning": f"+- {s:.2g} {p.unit}"} for p, v, s in rows
        ],
    }
    return environment().get_template(template).render(shared | own)


def number(value: float) -> str:
    """A literal that reads back as the same float64, with a decimal point."""
    text = repr(float(value))
    mantissa, _, exponent = text.partition("e")
    if "." not in mantissa:
        mantissa += ".0"
    return f"{mantissa}E{exponent}" if exponent else mantissa
