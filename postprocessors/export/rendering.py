"""What all written languages share: templates, names, and text that is safe inside a comment."""

import re
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from cases.errors import FileProblem
from postprocessors.export.calibration import Calibration

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
