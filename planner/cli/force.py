"""`hexcite force`, `tare`, `payload` and `export`: identified parameters in use."""

from pathlib import Path
from typing import Annotated, Any

import hexcite as hx
from cases.files import RESULT, check_file, check_folder, output_place
from planner.cli.console import Json, Overwrite, OwnCase, Stale, answered, argument, option, out, print_table


def export(
    result: Annotated[Path, argument("Result folder of hexcite identify or tare.")],
    to: Annotated[
        str,
        option("c (C99), linuxcnc (HAL component), st (IEC 61131-3), isg-load (#LIMIT LOAD), urscript, json.", "--to"),
    ],
    case: OwnCase = None,
    force: Annotated[bool, option("Export a result with warnings; they are written into the file.", "--force")] = False,
    output: Annotated[Path | None, out("File to write; for c a folder.")] = None,
    stale: Stale = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Write the calibrated model for a controller."""
    identified = hx.Result.load(result, None if case is None else hx.load_case(case), stale)
    files = hx.export(identified, to, output, force=force, overwrite=overwrite)
    warnings = [*identified.warnings, *identified.remarks]
    names, case_name, model = [str(file) for file in files], identified.case.name, identified.model.number
    answer = {"file": names[0], "files": names, "target": to, "case": case_name, "model": model, "warnings": warnings}
    if answered(answer, json):
        return
    for warning in warnings:
        print(f"warning, also in the file: {warning}")
    print(f"model {model} of case {case_name} written: {', '.join(names)}")


Parameters = Annotated[Path, option("Result folder of hexcite identify.", "--parameters")]


def force(
    recording: Annotated[Path, argument("Recording: a CSV file, or a folder of hexcite run.")],
    parameters: Parameters,
    case: OwnCase = None,
    output: Annotated[Path | None, out("CSV file to write; RECORDING-force.csv by default.")] = None,
    stale: Stale = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Compute external force and moment over a recording."""
    from cases.recording_format import WRENCH

    file = output_place(output, Path(f"{recording.resolve().stem}-force.csv"), overwrite)
    inputs = [recording, *recording.glob("*")] if recording.is_dir() else [recording]
    check_file(file, [".csv"], inputs, overwrite)
    result = hx.force(*_read(recording, parameters, case, stale))
    result.save(file, overwrite)
    answer: dict[str, Any] = {
        "force": str(file),
        "samples": len(result.t),
        "rms": {name: float(v) for name, v in zip(WRENCH, result.rms, strict=True)},
        "peak": {name: float(v) for name, v in zip(WRENCH, result.peak, strict=True)},
        "warnings": list(result.warnings),
    }
    if answered(answer, json):
        return
    units = [name.partition("_")[2].replace("Nm", "N m") for name in WRENCH]
    components = zip(WRENCH, result.rms, result.peak, units, strict=True)
    rows = [[name[:2], f"{rms:.4g}", f"{peak:.4g}", unit] for name, rms, peak, unit in components]
    print_table("External force and moment in {P}", ("component", "rms", "peak", "unit"), rows)
    for warning in answer["warnings"]:
        print(f"warning: {warning}")
    print(f"written: {file} ({len(result.t)} samples, behind the filter of the case)")


def _read(recording: Path, parameters: Path, case: str | None, stale: bool) -> "tuple[hx.Recording, hx.Result]":
    """The run, and the result whose parameters are used; its case stands in where no other is named."""
    from identification.outcome import case_of_result
    from identification.recording import record_of, require_recording

    require_recording(recording)
    named = None if case is None else hx.load_case(case)
    if named is None and not record_of(recording):
        named = case_of_result(parameters)
    run = hx.Recording.load(recording, named, stale)
    return run, hx.Result.load(parameters, run.case, stale)


def tare(
    recording: Annotated[Path, argument("Recording of a standstill without contact.")],
    parameters: Parameters,
    case: OwnCase = None,
    output: Annotated[Path | None, out("Result folder to write; RESULT-tared by default.")] = None,
    stale: Stale = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Identify the sensor offsets anew from a short standstill.

    All other parameters stay as they are.
    """
    from identification.parameters import offset_columns

    folder = output_place(output, Path(f"{parameters.resolve().stem}-tared"), overwrite)
    check_folder(folder, RESULT, [recording, parameters], overwrite)
    run, saved = _read(recording, parameters, case, stale)
    tared = hx.tare(run, saved)
    tared.save(folder, overwrite)
    if answered({"result": str(folder), **tared.record.to_json()}, json):
        return
    rows = [
        [
            f"f_q0_{k}",
            f"{tared.values[place] - saved.values[place]:+.4g}",
            f"{tared.covariance[place, place] ** 0.5:.2g}",
        ]
        for k, place in enumerate(offset_columns(saved.model), 1)
    ]
    for remark in (*run.remarks, *saved.remarks):
        print(f"warning: {remark}")
    print_table("Offsets", ("offset", "change", "std"), rows)
    print(f"result written: {folder}")


def payload(
    before: Annotated[Path, argument("Result folder without the payload.")],
    after: Annotated[Path, argument("Result folder with it.")],
    case: OwnCase = None,
    stale: Stale = False,
    json: Json = False,
) -> None:
    """Compute the payload from results without and with it.

    Mass, centre of gravity and inertia, as far as both results determine them.
    """
    from planner.cli.identification import PARAMETER_COLUMNS, parameter_rows

    old = hx.Result.load(before, None if case is None else hx.load_case(case), stale)
    found = hx.payload(old, hx.Result.load(after, old.case, stale))
    answer: dict[str, Any] = {
        "parameters": {name: value._asdict() for name, value in found.parameters.items()},
        "warnings": list(found.warnings),
    }
    if answered(answer, json):
        return
    print_table("Payload", PARAMETER_COLUMNS, parameter_rows(found.parameters))
    for warning in answer["warnings"]:
        print(f"warning: {warning}")
