"""From a calibration to files: which targets there are, what each is called, and how it appears as a whole or not."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cases.errors import FileProblem, HexciteError
from cases.files import FolderKind, atomic_file, atomic_folder, check_file, check_folder, output_place
from identification.outcome import Result
from postprocessors.export.c99 import c_sources, linuxcnc_component
from postprocessors.export.calibration import Calibration, calibration_of, checked_name, default_name
from postprocessors.export.document import json_document
from postprocessors.export.isg import isg_load
from postprocessors.export.structured_text import structured_text
from postprocessors.export.urscript import urscript_payload


@dataclass(frozen=True, slots=True)
class SingleFile:
    """A target that is one file.

    Args:
        suffix: suffix of the file, where none is given.
        text: what it holds, from the calibration and the name of the model.
        named: whether the file's name becomes the name of the model.
    """

    suffix: str
    text: Callable[[Calibration, str], str]
    named: bool


SINGLE_FILES = {
    "linuxcnc": SingleFile(".comp", linuxcnc_component, named=True),
    "st": SingleFile(".st", structured_text, named=True),
    "json": SingleFile(".json", lambda calibration, _: json_document(calibration), named=False),
    "urscript": SingleFile(".script", lambda calibration, _: urscript_payload(calibration), named=False),
    "isg-load": SingleFile(".nc", lambda calibration, _: isg_load(calibration), named=False),
}

TARGETS = ("c", *SINGLE_FILES)


def export(
    result: Result,
    target: str,
    output: Path | str | None = None,
    *,
    force: bool = False,
    overwrite: bool = False,
) -> list[Path]:
    """Writes the calibrated model for a controller.

    Args:
        result: identified parameters.
        target: one of `TARGETS`.
        output: file, or folder for `c`; by default named after the case, in the current folder.
        force: whether to export in spite of warnings, which are written into the file.
        overwrite: replace what an earlier export wrote.

    Returns:
        The files, the one that matters first.

    Raises:
        HexciteError: the target is unknown, cannot carry the model or cannot be written.
        FileProblem: the result carries warnings and `force` is not set.
    """
    place = None if output is None else Path(output)
    return export_calibration(calibration_of(result, force), target, place, overwrite)


def export_calibration(calibration: Calibration, target: str, output: Path | None, overwrite: bool) -> list[Path]:
    """Writes a calibration for a target; arguments, files and errors as `export`."""
    if target == "c":
        return _c_folder(calibration, output, overwrite)
    if target not in SINGLE_FILES:
        raise HexciteError(f"target {target!r} is unknown; choose {', '.join(TARGETS)}")
    kind = SINGLE_FILES[target]
    file = output_place(output, Path(f"{default_name(calibration)}{kind.suffix}"), overwrite)
    check_file(file, [kind.suffix], [Path(calibration.result.source)], overwrite)
    text = kind.text(calibration, checked_name(file.stem, file) if kind.named else file.stem)
    with atomic_file(file) as part:
        part.write_text(text, encoding="utf-8")
    return [file]


def _c_folder(calibration: Calibration, output: Path | None, overwrite: bool) -> list[Path]:
    name = default_name(calibration)
    folder = output_place(output, Path(f"{name}-c"), overwrite)
    if folder.suffix in (".c", ".h"):
        raise FileProblem(folder, f"--to c writes a folder with {name}.h and {name}.c", "name a folder with -o")
    names = [f"{name}.c", f"{name}.h"]
    kind = FolderKind("a C model", frozenset((*names, f"{name}.o")))  # what a compiler leaves there may go too
    check_folder(folder, kind, [Path(calibration.result.source)], overwrite)
    sources = c_sources(calibration, name)
    with atomic_folder(folder, kind, overwrite) as part:
        (part / names[0]).write_text(sources.source, encoding="ascii")
        (part / names[1]).write_text(sources.header, encoding="ascii")
    return [folder / n for n in names]
