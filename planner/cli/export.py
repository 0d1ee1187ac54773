"""`hexcite export`: the calibrated model for a controller."""

from pathlib import Path
from typing import Annotated, Any

import typer

from planner.cli.console import Json, Overwrite, Stale, print_json


def export(
    result: Annotated[Path, typer.Argument(help="Result folder of hexcite identify or tare.")],
    to: Annotated[
        str,
        typer.Option(
            "--to",
            help="c (C99), linuxcnc (HAL component), st (IEC 61131-3), isg-load (#LIMIT LOAD), urscript, json.",
        ),
    ],
    case: Annotated[str | None, typer.Option(help="Built-in name, folder or file; a result knows its own.")] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Export a result with warnings; they are written into the file.")
    ] = False,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="File to write; for c a folder.")] = None,
    stale: Stale = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Write the calibrated model for a controller."""
    from cases.errors import HexciteError
    from postprocessors.export.calibration import load_calibration
    from postprocessors.export.targets import TARGETS
    from postprocessors.export.targets import export_calibration as write

    if to not in TARGETS:
        raise HexciteError(f"target {to!r} is unknown; choose {', '.join(TARGETS)}")
    calibration = load_calibration(result, case, force, stale)
    files = write(calibration, to, output, overwrite)
    answer: dict[str, Any] = {
        "file": str(files[0]),
        "files": [str(file) for file in files],
        "target": to,
        "case": calibration.case.name,
        "model": calibration.model.number,
        "warnings": list(calibration.warnings),
    }
    if json:
        print_json(answer)
        return
    for warning in calibration.warnings:
        print(f"warning, also in the file: {warning}")
    print(f"model {calibration.model.number} of case {calibration.case.name} written: {', '.join(answer['files'])}")
