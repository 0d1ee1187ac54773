"""`hexcite pool` and `accept`: several results together, and whether one is accepted."""

from pathlib import Path
from typing import Annotated

import typer

import hexcite as hx
from cases.base.files import RESULT, check_folder, output_place
from hexcite.cli import console
from hexcite.cli.console import argument, option, out


def pool(
    results: Annotated[list[Path], argument("Result folders of runs of the same machine with the same load.")],
    case: console.OwnCase = None,
    output: Annotated[Path | None, out("Result folder to write; pooled by default.")] = None,
    stale: console.Stale = False,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Make one estimate of several runs, and test whether they agree.

    Tolerances that all runs have in common are counted once. What is written is a result: export, force, payload and
    pool read it.
    """
    folder = output_place(output, Path("pooled"), overwrite)
    check_folder(folder, RESULT, results, overwrite)
    named = None if case is None else hx.load_case(case)
    pooled = hx.pool([hx.Result.load(result, named, stale) for result in results])
    console.save_with_page(pooled, RESULT, folder, overwrite)
    answer = {"result": str(folder), "report": str(folder / "report.html"), **pooled.record.to_json()}
    console.answered(answer, json, f"result written: {folder}, with its report {folder}/report.html", pooled)


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
    console.answered({"result": str(result), **verdict.to_json()}, json, verdict)
    if not verdict.passed:
        raise typer.Exit(1)
