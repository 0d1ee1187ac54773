"""`hexcite pool`, `history`, `accept` and `certificate`: results together, over time, judged, and signed for."""

from pathlib import Path
from typing import Annotated, Any, cast

import typer

import hexcite as hx
from cases.base.errors import Code
from cases.base.folder_kinds import RESULT
from cases.base.options import default_of
from cases.base.output_places import check_file, check_folder, output_place
from hexcite.cli import console
from hexcite.cli.advice import advice
from hexcite.cli.console import argument, option, out
from hexcite.cli.declared import takes
from identification.options import LoadFrame


@takes()
def pool(
    results: Annotated[list[Path], argument("Result folders of runs of the same machine with the same load.")],
    case: console.OwnCase = None,
    frame: LoadFrame = default_of(LoadFrame),
    output: Annotated[Path | None, out("Result folder to write; pooled by default.")] = None,
    stale: console.Stale = False,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Make one estimate of several runs; test if they agree.

    Tolerances that all runs have in common are counted once. What is written is a result: export, force, payload and
    pool read it.
    """
    folder = output_place(output, Path("pooled"), overwrite)
    check_folder(folder, RESULT, results, overwrite)
    named = None if case is None else hx.load_case(case)
    pooled = hx.pool([hx.Result.load(result, named, stale) for result in results])
    texts: list[object] = [f"result written: {folder}, with its report {folder}/report.html", pooled]
    in_frame: dict[str, Any] = {}
    if frame is not None:
        from identification.results.frames import frame_named

        body = pooled.in_frame(frame_named(frame))
        in_frame["in_frame"] = body.to_json()
        texts.append(body)
    console.save_with_page(pooled, RESULT, folder, overwrite)
    answer = {"result": str(folder), "report": str(folder / "report.html"), **pooled.record.to_json(), **in_frame}
    console.answered(answer, json, *texts)


def history(
    places: Annotated[list[Path], argument("Result folders, or folders in which results lie, at any depth.")],
    machine: Annotated[
        str | None, option("Name of the machine's case, where there are results of several.", "--case")
    ] = None,
    output: Annotated[Path | None, out("Page to write; CASE-history.html by default.")] = None,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Show a machine's results over time: leaps and drifts.

    A leap is a change between two results that follow each other, with the same payload, beyond what their own noise
    and the tolerances allow.
    """
    changes = hx.history(places, machine)
    file = output_place(output, Path(f"{changes.case}-history.html"), overwrite)
    check_file(file, (".html",), places, overwrite)
    hx.report(changes, file)
    console.answered({"report": str(file), **changes.to_json()}, json, f"page written: {file}", changes)


def accept(
    result: Annotated[Path, argument("Result folder of hexcite identify or pool.")],
    case: Annotated[
        str | None, option("Case with the limits, [accept], where they are not in the result's own.", "--case")
    ] = None,
    stale: console.Stale = False,
    json: console.Json = False,
) -> None:
    """Say whether a result passes its limits.

    Limits stand in [accept] of the case; without it, noise is judged beside what the case states, mass beside nominal,
    and the run beside its plan. Exit code 1: it failed.
    """
    named = None if case is None else hx.load_case(case)
    loaded = hx.Result.load(result, named, stale)
    verdict = hx.accept(loaded)
    answer = {"result": str(result), **verdict.to_json()}
    console.answered(answer, json, verdict, *advice(answer))
    if not verdict.passed:
        raise typer.Exit(1)


def certificate(
    result: Annotated[Path, argument("Result folder; with --verify the certificate.")],
    case: console.OwnCase = None,
    operator: Annotated[str | None, option("Who recorded and evaluated; by default [certificate] of the case.")] = None,
    conditions: Annotated[str | None, option("Temperature, tool and the like; by default those of the case.")] = None,
    number: Annotated[str, option("Number of the certificate.")] = "",
    language: Annotated[str, option("Language of its pages: en or de.")] = "en",
    verify: Annotated[bool, option("Say whether a certificate is as it was issued.", "--verify")] = False,
    of: Annotated[Path | None, option("With --verify: the result that it has to be of.", "--result")] = None,
    output: Annotated[Path | None, out("PDF file to write; RESULT-certificate.pdf by default.")] = None,
    stale: console.Stale = False,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Write the certificate of a result as A4 pages, or verify one.

    It states parameters with U (k = 2), what U counts and does not count, verdicts, and the fingerprints of case, plan,
    program, recording and result. Exit code 1 of --verify: it was changed, or is of another result or recording.
    """
    named = None if case is None else hx.load_case(case)
    if verify:
        verification = hx.verify_certificate(result, None if of is None else hx.Result.load(of, named, stale))
        answer = {"certificate": str(result), "stated": dict(verification.stated), "compared": dict(verification.lines)}
        console.answered(answer, json, verification)
        return
    if of is not None:
        raise hx.HexciteError(
            place="--result",
            problem="goes with --verify",
            remedy="leave one out, or add the other",
            code=Code.CONTRADICTION,
        )
    file = output_place(output, Path(f"{result.resolve().stem}-certificate.pdf"), overwrite)
    check_file(file, (".pdf",), [result], overwrite)
    loaded = hx.Result.load(result, named, stale)
    texts = {key: text for key, text in (("operator", operator), ("conditions", conditions)) if text is not None}
    from cases.certificate import CertificateOf

    about = (loaded.case.certificate or CertificateOf()).model_copy(update=texts)
    hx.certificate(loaded, file, about, number, overwrite, cast(Any, language))  # which it looks at itself
    console.answered({"certificate": str(file)}, json, f"certificate written: {file}")
