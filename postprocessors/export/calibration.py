"""A result for export: whether it may be exported, its JSON, and the values in every language."""

import re
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from cases.base.errors import WITH_OUTPUT, Code, FileProblem, option
from cases.base.phrases import phrase
from cases.base.text_formats import json_text
from cases.schema import Case
from identification.results.payload import Payload
from identification.results.result import Result
from postprocessors.export.load import Carried, has_inertia, load_of


def require_exportable(result: Carried, force: bool = False) -> None:
    """Raises FileProblem where a mass is not positive, or its values are in doubt and `force` is not set.

    What the standard deviations allow for, or what was left out, is no such doubt; it is written into the file.
    """
    if isinstance(result, Payload):
        require_added(result)
        doubts = list(result.doubts)
    elif not result.values[0] > 0.0:
        raise FileProblem(
            place=result.source,
            problem=phrase("mass_negative", "mass {mass} kg is not positive", mass=f"{result.values[0]:.4g}"),
            remedy=phrase("another_run", "identify from another run"),
            code=Code.MISFIT,
        )
    else:
        doubts = [finding.sentence for finding in result.findings if finding.doubts_values]
    if doubts and not force:
        more = f" (and {len(doubts) - 1} more)" if len(doubts) > 1 else ""
        remedy = (
            f"mend that and identify again, or export with {option('force')}, which writes the warning into the file"
        )
        raise FileProblem(
            place=result.source,
            problem=phrase("carries_warning", "carries a warning{more}: {warning}", more=more, warning=doubts[0]),
            remedy=remedy,
            code=Code.MISFIT,
        )


def require_added(payload: Payload) -> None:
    """Raises FileProblem where it was taken off: no body has a negative mass."""
    mass = payload.whole_body.values[0]
    if not mass > 0.0:
        remedy = "name the results without and with payload, in this order"
        raise FileProblem(
            place=payload.source,
            problem=phrase("payload_negative", "the payload's mass {mass} kg is not positive", mass=f"{mass:.4g}"),
            remedy=remedy,
            code=Code.MISFIT,
        )


def result_hash(result: Result) -> str:
    """Fingerprint of the file of a result, its first 16 digits."""
    return result.fingerprint[:16]


def _recording(result: Result) -> str:
    """Names of the recordings from which the parameters were identified and the offsets tared."""
    tared = f", tared with {result.record.tared_with}" if result.record.tared_with else ""
    return f"{result.record.recording}{tared}"


def json_document(result: Result) -> str:
    """The calibrated model as JSON, complete for an independent implementation, in SI units and radians.

    `calibration.schema.json` beside this file, a JSON Schema, describes each entry.
    """
    case, model, hexapod = result.case, result.model, result.case_as_told.hexapod
    kinematics = None
    if hexapod is not None:
        drives = case.recording.drives
        kinematics = {
            "base_m": hexapod.base.points.tolist(),
            "platform_m": hexapod.platform.points.tolist(),
            "home": hexapod.home.vector.tolist(),
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
                "result_sha256": result_hash(result),
                "recording": _recording(result),
                "samples": result.record.samples,
                "s0": result.record.s0,
                "case": case.name,
                "case_hash": case.hash,
            },
            "warnings": (*result.warnings, *result.remarks),
            "model": model.number,
            "gravity_m_s2": model.gravity.tolist(),
            "structure": model.structure.tolist() if model.struts is None else None,
            "struts": model.struts and {"at": model.struts.sensors.at},
            "flange": _flange(result),
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
                for name, v in result.parameters.items()
            ],
        }
    )


def _flange(result: Result) -> dict[str, Any] | None:
    """The flange's entry of the document; None where the case states none."""
    place = result.case_as_told.flange_from_sensor
    if place is None:
        return None
    load = load_of(result, place) if has_inertia(result.model) else None
    return {
        "sensor": {"origin_m": place[:3, 3].tolist(), "axes": place[:3, :3].tolist()},
        "load": load
        and {
            "mass_kg": load.mass,
            "centre_of_gravity_m": load.centre.tolist(),
            "inertia_kg_m2": np.array(load.inertia).tolist(),
        },
    }


MOST_STEPS = 12  # steps of the forward kinematics from one start; from home into a corner of the workspace five

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


def default_name(case: Case) -> str:
    """Name of the model in the written language, short enough for a number behind it."""
    return f"{case.name[:22].rstrip('_')}_force"


def checked_name(stem: str, file: Path) -> str:
    """The name of a model or function from its file's name; raises FileProblem where no exported language takes it."""
    if not _NAME.fullmatch(stem) or stem.endswith("_"):
        problem = "becomes the name of the model, which is up to 31 small letters, digits and _, from a letter on"
        raise FileProblem(
            place=file,
            problem=f"{stem!r} {problem}",
            remedy=f"choose another file name{WITH_OUTPUT}",
            code=Code.WRONG_KIND,
        )
    return stem


def comment_lines(result: Carried) -> list[str]:
    """Result, or both of a payload, case, model and version behind a file, and every warning, one sentence a line.

    The text is printable ASCII that cannot end a comment in C, Structured Text or NC programs.
    """
    if isinstance(result, Payload):
        both = (("payload with", result.loaded), ("payload without", result.empty))
        origin = [f"{words} {line}" for words, of in both for line in _origin(of)]
        warned = dict.fromkeys((*result.warnings, *result.doubts))
    else:
        origin, warned = _origin(result), dict.fromkeys((*result.warnings, *result.remarks))
    lines = []
    for line in (f"made by hexcite {version('hexcite')}", *origin, *(f"WARNING: {warning}" for warning in warned)):
        plain = " ".join(line.split()).encode("ascii", "backslashreplace").decode()
        plain = "".join(c if c.isprintable() else "?" for c in plain)
        lines.append(plain.replace("*/", "* /").replace("*)", "* )").replace("(*", "( *").replace("/*", "/ *"))
    return lines


def _origin(result: Result) -> list[str]:
    """Where a result is from, and of which model."""
    case, model, record = result.case, result.model, result.record
    return [
        f"result {result.source} (sha256 {result_hash(result)}), from {_recording(result)}: {record.samples} samples"
        f", s0 {record.s0:.4g}",
        f"case {case.name}, hash {case.hash}; model {model.number} with {len(model.names)} parameters",
    ]


def rendered(template: str, result: Result, name: str, **further: Any) -> str:
    """A template filled with the values of a model called `name` that every language states, and with further ones."""
    case, model = result.case, result.model
    drives = case.recording.drives if case.hexapod is not None else None
    variances = np.maximum(result.covariance.diagonal(), result.covariance_robust.diagonal())  # (28) or the robust one
    rows = zip(model.parameters, result.values, np.sqrt(np.maximum(variances, 0.0)), strict=True)
    shared: dict[str, Any] = {
        "name": name,
        "NAME": name.upper(),
        "origin": comment_lines(result),
        "hexapod": case.hexapod is not None,
        "joints": 0 if case.chain is None else len(case.chain.joints),
        "joint_units": [] if case.chain is None else [number(joint.unit) for joint in case.chain.joints],
        "width": 6 if case.chain is None else max(6, len(case.chain.joints)),
        "home": [number(v) for v in (np.zeros(6) if case.hexapod is None else case.hexapod.home.vector)],
        "force_units": "N, N m" if case.sensor_frame.has_moments else "N",
        "delay": number(result.delay),
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
    return environment().get_template(template).render(shared | further)


def number(value: float) -> str:
    """A literal that reads back as the same float64, with a decimal point."""
    text = repr(float(value))
    mantissa, _, exponent = text.partition("e")
    if "." not in mantissa:
        mantissa += ".0"
    return f"{mantissa}E{exponent}" if exponent else mantissa
