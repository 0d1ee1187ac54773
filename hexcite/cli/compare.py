"""`hexcite compare` and `hexcite validate`: methods side by side."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import hexcite as hx
from cases.base.errors import Code, HexciteError
from cases.base.folder_kinds import COMPARISON, VALIDATION
from cases.base.output_places import check_folder, output_place
from hexcite.cli import console
from hexcite.cli.console import argument, option, out
from hexcite.cli.declared import takes
from hexcite.comparison.methods import METHOD_TABLES, ValidationOptions
from identification.texts import aligned

if TYPE_CHECKING:
    from hexcite.comparison.validation import Validation


def compare(
    folders: Annotated[list[Path], argument("Folders of plan, poses, run and identify, in any mix.")],
    case: console.OwnCase = None,
    output: Annotated[Path | None, out("Folder to write; hexcite-comparison by default.")] = None,
    stale: console.Stale = False,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Compare excitations before and after running them.

    Shows cost, information and standard deviations, and which to prefer.

    A result belongs to the run it was made of, whose figures then stand in its column, a run to the plan that its
    program was written from. Models of one run are compared by hexcite identify RUN --model all.
    """

    from hexcite.reports.compare import parameter_columns, parameter_rows

    place = output_place(output, Path("hexcite-comparison"), overwrite)
    check_folder(place, COMPARISON, folders, overwrite)
    with console.status("comparing", json):
        comparison = hx.compare(folders, None if case is None else hx.load_case(case), stale)
        console.save_with_page(comparison, COMPARISON, place, overwrite)
    answer = {"report": str(place / "report.html")} | comparison.to_json()
    table = aligned(parameter_columns(comparison.entries), *parameter_rows(comparison.entries))
    console.answered(answer, json, *table, f"report written: {answer['report']}", comparison)


@takes(ValidationOptions)
def validate(
    case: Annotated[str, argument("Built-in name, folder or case file, with payloads.")],
    results: Annotated[
        list[Path] | None,
        argument(
            "Results of a real machine: without weights, with the first one, and so on. Nothing is simulated then."
        ),
    ] = None,
    methods: Annotated[
        str | None, option(f"Methods, separated by commas, by default all: {', '.join(METHOD_TABLES)}.")
    ] = None,
    weights: Annotated[
        str | None, option("How many weights are mounted: 0,3,5; by default none, and each up to all.")
    ] = None,
    output: Annotated[Path | None, out("Folder to write; hexcite-validation by default.")] = None,
    stale: console.Stale = False,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
    **settings: Any,
) -> None:
    """Identify known weights by each method; compare with theory.

    They are mounted one after the other on the case's simulated machine; the answer says what that models.
    Interrupted, the same command uses the plans that are there. With results of runs with these weights on a real
    machine: what was added, beside what is known of it.
    """
    from hexcite.comparison.trials import mounted_weights, unfinished

    carried_out = hx.ValidationSettings(**settings)
    loaded = hx.load_case(case)
    names = None if methods is None else [name.strip() for name in methods.split(",") if name.strip()]
    place = output_place(output, Path("hexcite-validation"), overwrite)
    check_folder(place, VALIDATION, results or (), overwrite=overwrite)
    mounted = None if weights is None else mounted_weights(loaded, weights)
    if results:
        if names is not None or carried_out != hx.ValidationSettings():
            raise HexciteError(
                problem="results are of a machine that has run, and --methods, --on, --starts, --seed and --workers of "
                "one that is simulated",
                remedy="leave these options out, or the results",
                code=Code.CONTRADICTION,
            )
        validation = hx.validate_results([hx.Result.load(each, loaded, stale) for each in results], mounted)
        console.save_with_page(validation, VALIDATION, place, overwrite)
        _answer(validation, place, json)
        return
    with unfinished(place, loaded, carried_out) as work, console.status("validating", json) as remark:
        validation = hx.validate(
            loaded, tuple(METHOD_TABLES) if names is None else names, mounted, carried_out, folder=work, progress=remark
        )
        console.save_with_page(validation, VALIDATION, place, overwrite)
    _answer(validation, place, json)


def _answer(validation: "Validation", place: Path, json: bool) -> None:
    """The answer: a table a method, and what follows."""
    from hexcite.reports.validation import OFF_BY, TABLE_7, errors_of, table_7

    answer = {"report": str(place / "report.html")} | validation.to_json()
    if console.answered(answer, json):
        return
    console.say(f"machine: {validation.machine}")
    for method, text in validation.executed.items():
        if ";" in text:
            console.say(f"{method}: executed on {text}")
    for method, reason in validation.failed.items():
        console.say(f"NOT RUN: {method}: {reason}")
    for method in dict.fromkeys(trial.method for trial in validation.trials):
        trials = [trial for trial in validation.trials if trial.method == method]
        console.print_table(method, TABLE_7, table_7(trials))
        if validation.measured:
            console.print_table(OFF_BY, *errors_of(trials))
    for warning in validation.warnings if validation.measured else ():
        console.say(f"warning: {warning}")
    console.say(f"report written: {answer['report']}")
    for sentence in validation.sentences:
        console.say(sentence if validation.measured else f"recommendation: {sentence}")
