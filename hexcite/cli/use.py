"""`hexcite force`, `tare`, `payload` and `export`: identified parameters in use."""

from pathlib import Path
from typing import Annotated, Any

import typer

import hexcite as hx
from cases.base.atomic import write_text
from cases.base.errors import Code, HexciteError
from cases.base.folder_kinds import RESULT
from cases.base.options import default_of
from cases.base.output_places import check_file, check_folder, output_place
from cases.base.text_formats import json_text
from hexcite.cli.console import Json, Overwrite, OwnCase, Stale, answered, argument, option, out, status
from hexcite.cli.declared import takes
from identification.options import Frame, LoadFrame
from postprocessors.options import DespiteWarnings, ExportFrame, ExportTarget, PayloadTarget


@takes()
def export(
    result: Annotated[Path, argument("Result folder of hexcite identify or tare.")],
    target: ExportTarget,
    case: OwnCase = None,
    frame: ExportFrame = default_of(ExportFrame),
    preview: Annotated[bool, option("Print what would be written, and write nothing.", "--preview")] = False,
    force: DespiteWarnings = default_of(DespiteWarnings),
    output: Annotated[Path | None, out("File to write; for c a folder.")] = None,
    stale: Stale = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Write the model, or the load that it found."""
    identified = hx.Result.load(result, None if case is None else hx.load_case(case), stale)
    warnings = [*identified.warnings, *identified.remarks]
    case_name, model = identified.case.name, identified.model.number
    answer = {"target": target, "case": case_name, "model": model, "warnings": warnings}
    if preview:
        texts = dict(hx.preview(identified, target, frame=frame))
        answered(answer | {"texts": texts}, json, *(text.rstrip("\n") for text in texts.values()))
        return
    names = [str(file) for file in hx.export(identified, target, output, frame=frame, force=force, overwrite=overwrite)]
    warning_lines = (f"warning, also in the file: {warning}" for warning in warnings)
    answer = {"file": names[0], "files": names, **answer}
    answered(answer, json, *warning_lines, f"model {model} of case {case_name} written: {', '.join(names)}")


Parameters = Annotated[Path, option("Result folder of hexcite identify.", "--parameters")]


@takes()
def force(
    recordings: Annotated[
        list[Path], argument("One run: a file, several files of it in any order, or a folder of hexcite run.")
    ],
    parameters: Parameters,
    case: OwnCase = None,
    frame: Frame = default_of(Frame),
    output: Annotated[Path | None, out("CSV file to write; RECORDING-force.csv by default.")] = None,
    stale: Stale = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Compute external force and moment, with their deviations.

    A table by the recorder's clock, and beside it a page with the curves.
    """
    from cases.recording_format import WRENCH
    from identification.results.frames import frame_named

    file = output_place(output, Path(f"{recordings[0].resolve().stem}-force.csv"), overwrite)
    inputs = [path for place in recordings for path in (place, *(place.glob("*") if place.is_dir() else ()))]
    check_file(file, [".csv"], inputs, overwrite)
    check_file(page := file.with_suffix(".html"), [".html"], inputs, overwrite)
    in_frame = frame_named(frame)
    result = hx.force(*_read(recordings, parameters, case, stale), frame=in_frame)
    result.save(file, overwrite)
    hx.report(result, page)
    answer: dict[str, Any] = {
        "force": str(file),
        "report": str(page),
        "frame": in_frame,
        "samples": len(result.t),
        "rms": {name: float(v) for name, v in zip(WRENCH, result.rms, strict=True)},
        "peak": {name: float(v) for name, v in zip(WRENCH, result.peak, strict=True)},
        "expanded_k2": {name: float(v) for name, v in zip(WRENCH, result.typical_expanded, strict=True)},
        "budget": result.budget,
        "not_counted": list(result.not_counted),
        "warnings": list(result.warnings),
    }
    answered(answer, json, f"written: {file}, behind the filter of the case, and its page {page}", result)


def _read(recordings: list[Path], parameters: Path, case: str | None, stale: bool) -> "tuple[hx.Recording, hx.Result]":
    """The run, and the result whose parameters are used; its case stands in where no other is named."""
    from identification.recording.recording import record_of
    from identification.results.result import case_of_result

    named = None if case is None else hx.load_case(case)
    if named is None and record_of(recordings[0]) is None:
        named = case_of_result(parameters)
    run = hx.Recording.load(recordings, named, stale)
    return run, hx.Result.load(parameters, run.case, stale)


def tare(
    recordings: Annotated[list[Path], argument("Recording of a standstill without contact, in one or several files.")],
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
    folder = output_place(output, Path(f"{parameters.resolve().stem}-tared"), overwrite)
    check_folder(folder, RESULT, [*recordings, parameters], overwrite)
    run, saved = _read(recordings, parameters, case, stale)
    tared = hx.tare(run, saved)
    tared.save(folder, overwrite)
    answered({"result": str(folder), **tared.record.to_json()}, json, f"result written: {folder}", tared)


@takes()
def payload(
    before: Annotated[
        Path,
        argument("Without the payload: result folder of hexcite identify, or a recording, which is identified first."),
    ],
    after: Annotated[Path, argument("The same with it.")],
    more_before: Annotated[
        list[Path] | None,
        option("One more file of the recording without it, such as that of the joints. Repeatable.", "--before"),
    ] = None,
    more_after: Annotated[
        list[Path] | None, option("One more file of the recording with it. Repeatable.", "--after")
    ] = None,
    reference: Annotated[
        list[str] | None,
        option("A value that it should have, with its expanded uncertainty (k = 2): m=19.93+-0.01kg. Repeatable."),
    ] = None,
    case: OwnCase = None,
    frame: LoadFrame = default_of(LoadFrame),
    target: PayloadTarget = default_of(PayloadTarget),
    preview: Annotated[bool, option("Print what --to would write, and write nothing.", "--preview")] = False,
    force: DespiteWarnings = default_of(DespiteWarnings),
    output: Annotated[
        Path | None, out("JSON file to write, with a page beside it; with --to the file of the target.")
    ] = None,
    stale: Stale = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Compute a payload from runs without and with it.

    Mass, centre of gravity and inertia, as far as both results determine them. With -o they are written, with the
    fingerprints of both results and a page beside them, or with --to for the robot or simulator that has to know them.
    With --reference: E_n of each, the difference over the root of both squared U (k = 2); exit code 1 where one is
    above 1.
    """
    if preview and target is None:
        raise HexciteError(
            problem="--preview shows what --to would write, and there is none",
            remedy="add --to with a target, such as --to urscript, or leave --preview out",
            code=Code.CONTRADICTION,
        )
    places = [[before, *(more_before or ())], [after, *(more_after or ())]]
    if target is None and output is not None:
        for file, suffix in ((output, ".json"), (output.with_suffix(".html"), ".html")):
            check_file(file, [suffix], [place for run in places for place in run], overwrite)
    with status("identifying", json):
        difference = hx.payload(*_two_runs(places, None if case is None else hx.load_case(case), stale))
    answer = difference.to_json()
    texts: list[object] = [difference]
    body = None
    if frame is not None:
        from identification.results.frames import frame_named

        body = difference.in_frame(frame_named(frame))
        answer["in_frame"] = body.to_json()
        texts.append(body)
    verdict = None
    if reference:
        from hexcite.cli.method_options import verdict_of_references

        verdict = verdict_of_references(reference, difference.parameters, difference.empty.model.number)
        answer["reference"] = verdict.to_json()
        texts.append(verdict)
    if preview and target is not None:
        answer["texts"] = shown = dict(hx.preview(difference, target, frame=frame))
        texts += [text.rstrip("\n") for text in shown.values()]
    elif target is not None:
        files = hx.export(difference, target, output, frame=frame, force=force, overwrite=overwrite)
        answer["file"] = str(files[0])
        texts.append(f"payload written: {files[0]}")
    elif output is not None:
        from hexcite.reports.payload import payload_page

        write_text(output, json_text(answer))
        write_text(page := output.with_suffix(".html"), payload_page(difference, body, verdict))
        answer |= {"file": str(output), "report": str(page)}
        texts.append(f"payload written: {output}, and its page {page}")
    answered(answer, json, *texts)
    if verdict is not None and not verdict.passed:
        raise typer.Exit(1)


def _two_runs(
    places: list[list[Path]], case: "hx.Case | None", stale: bool
) -> "tuple[hx.Result | hx.Recording, hx.Result | hx.Recording]":
    """What stands at two places, each a result folder, or all files of a recording.

    Where no case is named, a recording that does not know its own takes that of the other one.
    """
    from identification.recording.recording import record_of

    results = [(run[0] / "result.json").is_file() for run in places]
    for run, is_result in zip(places, results, strict=True):
        if is_result and len(run) > 1:
            raise HexciteError(
                place=run[1],
                problem=f"is one more file of a recording, and {run[0]} is a result",
                remedy="name the files of the recording, or the result alone",
                code=Code.CONTRADICTION,
            )
    know_their_case = [
        is_result or record_of(run[0]) is not None for run, is_result in zip(places, results, strict=True)
    ]
    loaded: dict[int, hx.Result | hx.Recording] = {}
    for k in sorted(range(len(places)), key=lambda k: not know_their_case[k]):
        run = places[k]
        loaded[k] = hx.Result.load(run[0], case, stale) if results[k] else hx.Recording.load(run, case, stale)
        case = case or loaded[k].case
    return loaded[0], loaded[1]
