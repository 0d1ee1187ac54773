"""From a calibration to files: which targets there are, what each is called, and how it appears as a whole or not."""

import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cases.errors import ExecutionError, FileProblem, HexciteError
from cases.files import FolderKind, atomic_file, atomic_folder, check_file, check_folder, output_place
from identification.outcome import Result
from postprocessors.export.c99 import c_sources, linuxcnc_component
from postprocessors.export.calibration import Calibration, calibration_of, checked_name, default_name
from postprocessors.export.document import json_document
from postprocessors.export.isg import isg_load
from postprocessors.export.structured_text import structured_text

SYSTEM_PATH = "/usr/bin:/bin:/usr/sbin:/sbin"
"""Where compilers are looked for: halcompile belongs to the system's Python, not to ours."""

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2")
TIME_LIMIT = 120.0  # [s]; it takes one


def tool_missing(program: str, packages: str) -> str | None:
    """Why a compiler cannot be run, with the remedy; None if it can."""
    if shutil.which(program, path=SYSTEM_PATH) is None:
        return f"{program} is missing; install {packages}, or export without --build"
    return None


def halcompile_missing() -> str | None:
    """Why HAL components cannot be compiled, with the remedy; None if they can."""
    for program, packages in (
        ("halcompile", "the package linuxcnc-uspace-dev"),
        ("gcc", "the packages gcc and libc6-dev"),
        ("make", "the package make"),
    ):
        if (missing := tool_missing(program, packages)) is not None:
            return missing
    return None


def build_object(source: Path) -> Path:
    """Compiles a C file to an object file beside it.

    Raises:
        ExecutionError: gcc is missing or refuses the file.
    """
    if (missing := tool_missing("gcc", "the packages gcc and libc6-dev")) is not None:
        raise ExecutionError(f"{source.name}: cannot be compiled: {missing}")
    target = source.with_suffix(".o")
    _run(["gcc", *STRICT, "-c", "-o", target.name, source.name], source)
    return target


def build_component(source: Path) -> Path:
    """Compiles a HAL component to a realtime module beside it.

    Raises:
        ExecutionError: halcompile is missing or refuses the file.
    """
    if (missing := halcompile_missing()) is not None:
        raise ExecutionError(f"{source.name}: cannot be compiled: {missing}")
    _run(["halcompile", "--compile", source.name], source)
    return source.with_suffix(".so")


def _run(command: list[str], source: Path) -> None:
    try:
        done = subprocess.run(
            command,
            cwd=source.parent,
            env={"PATH": SYSTEM_PATH, "LC_ALL": "C"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=TIME_LIMIT,
        )
    except subprocess.TimeoutExpired as error:
        raise ExecutionError(f"{source.name}: {command[0]} did not end within {TIME_LIMIT:g} s; report this") from error
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines()
        said = next((line for line in lines if "error" in line.lower()), f"exit code {done.returncode}")
        raise ExecutionError(f"{source.name}: {command[0]} refuses it ({said.strip()}); check its installation")


@dataclass(frozen=True, slots=True)
class SingleFile:
    """A target that is one file.

    Args:
        suffix: of the file, where none is given.
        text: what it holds, from the calibration and the name of the model.
        named: whether the file's name becomes the name of the model.
        build: compiles it, where that makes sense; the file that results.
    """

    suffix: str
    text: Callable[[Calibration, str], str]
    named: bool
    build: Callable[[Path], Path] | None = None


SINGLE_FILES = {
    "linuxcnc": SingleFile(".comp", linuxcnc_component, named=True, build=build_component),
    "st": SingleFile(".st", structured_text, named=True),
    "json": SingleFile(".json", lambda calibration, _: json_document(calibration), named=False),
    "isg-load": SingleFile(".nc", lambda calibration, _: isg_load(calibration), named=False),
}

TARGETS = ("c", *SINGLE_FILES)


def export(
    result: Result,
    target: str,
    output: Path | str | None = None,
    *,
    force: bool = False,
    build: bool = False,
    overwrite: bool = False,
) -> list[Path]:
    """Writes the calibrated model for a controller.

    Args:
        result: identified parameters.
        target: one of `TARGETS`.
        output: file, or folder for `c`; by default named after the case, in the current folder.
        force: in spite of warnings, which are written into the file.
        build: compile it too; what does not compile is not written.
        overwrite: replace what an earlier export wrote.

    Returns:
        The files, the one that matters first.

    Raises:
        HexciteError: the target is unknown, cannot carry the model, cannot be compiled or cannot be written.
        FileProblem: the result carries warnings and `force` is not set.
    """
    place = None if output is None else Path(output)
    return export_calibration(calibration_of(result, force), target, place, build, overwrite)


def export_calibration(
    calibration: Calibration, target: str, output: Path | None, build: bool, overwrite: bool = False
) -> list[Path]:
    """Writes a calibration for a target.

    Args:
        calibration: what is written.
        target: one of `TARGETS`.
        output: file, or folder for `c`; by default named after the case, in the current folder.
        build: compile it too; what does not compile is not written.
        overwrite: replace what an earlier export wrote.

    Returns:
        The files, the one that matters first.

    Raises:
        HexciteError: the target is unknown, cannot carry the model, cannot be compiled or cannot be written.
    """
    if target == "c":
        return _c_folder(calibration, output, build, overwrite)
    if target not in SINGLE_FILES:
        raise HexciteError(f"target {target!r} is unknown; choose {', '.join(TARGETS)}")
    return _single_file(calibration, target, output, build, overwrite)


def _single_file(
    calibration: Calibration, target: str, output: Path | None, build: bool, overwrite: bool
) -> list[Path]:
    kind = SINGLE_FILES[target]
    file = output_place(output, Path(f"{default_name(calibration)}{kind.suffix}"), overwrite)
    check_file(file, [kind.suffix], [Path(calibration.result.source)], overwrite)
    name = checked_name(file.stem, file) if kind.named else file.stem
    if build and kind.build is None:
        raise HexciteError(f"--build: nothing is compiled for --to {target}; leave it out")
    text = kind.text(calibration, name)
    if not build or kind.build is None:
        with atomic_file(file) as part:
            part.write_text(text, encoding="utf-8")
        return [file]
    with tempfile.TemporaryDirectory(prefix="hexcite-export-") as folder:
        source = Path(folder) / file.name
        source.write_text(text, encoding="utf-8")
        made = kind.build(source)
        built = file.with_name(made.name)
        check_file(built, [made.suffix], overwrite=overwrite)
        with atomic_file(built) as part, atomic_file(file) as text_part:
            shutil.copyfile(made, part)
            shutil.copyfile(source, text_part)
    return [file, built]


def _c_folder(calibration: Calibration, output: Path | None, build: bool, overwrite: bool) -> list[Path]:
    name = default_name(calibration)
    folder = output_place(output, Path(f"{name}-c"), overwrite)
    if folder.suffix in (".c", ".h"):
        raise FileProblem(f"{folder}: --to c writes a folder with {name}.h and {name}.c; name a folder with -o")
    names = [f"{name}.c", f"{name}.h", *([f"{name}.o"] if build else [])]
    kind = FolderKind("a C model", frozenset((*names, f"{name}.o")))
    check_folder(folder, kind, [Path(calibration.result.source)], overwrite)
    sources = c_sources(calibration, name)
    with atomic_folder(folder, kind, overwrite) as part:
        (part / names[0]).write_text(sources.source, encoding="ascii")
        (part / names[1]).write_text(sources.header, encoding="ascii")
        if build:
            build_object(part / names[0])
    return [folder / n for n in names]
