"""What all written languages share: templates, names, and text that is safe inside a comment."""

import re
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from cases.errors import FileProblem
from postprocessors.export.calibration import Calibration
from postprocessors.export.instructions import number

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
    """Name of the model in the written language."""
    return f"{calibration.case.name}_force"[:31]


def checked_name(stem: str, file: Path) -> str:
    """A file's name as the name of what is in it.

    Raises:
        FileProblem: it is no name in the languages that are written.
    """
    if not _NAME.fullmatch(stem) or stem.endswith("_"):
        raise FileProblem(
            f"{file}: {stem!r} becomes the name of the model, which is up to 31 small letters, digits and _, from a "
            "letter on; choose another file name with -o"
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


def shared_values(calibration: Calibration) -> dict[str, Any]:
    """What templates of every language are told of a model."""
    drives = calibration.case.recording.drives if calibration.hexapod is not None else None
    told = zip(calibration.model.parameters, calibration.result.values, calibration.deviations, strict=True)
    return {
        "hexapod": calibration.hexapod is not None,
        "most_steps": MOST_STEPS,
        "drives": drives
        and {
            "index": drives.index,
            "sign": [number(s) for s in drives.sign],
            "offset": [number(v) for v in drives.offset],
        },
        "offsets": [n for n in calibration.model.names if n.startswith("f_q0_")],
        "parameters": [
            {"name": p.name, "unit": p.unit, "value": number(v), "meaning": f"+- {s:.2g} {p.unit}"} for p, v, s in told
        ],
    }
