"""`hexcite compare`: plans, runs and results side by side, with a recommendation."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planner.cli.console import Json, Overwrite, Stale, print_json, print_table, status

if TYPE_CHECKING:
    from planner.comparison.advising import Comparison


def compare(
    folders: Annotated[list[Path], typer.Argument(help="Folders of plan, poses, run and identify, in any mix.")],
    case: Annotated[str | None, typer.Option(help="Built-in name, folder or file; the folders know theirs.")] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder to write; hexcite-comparison by default.")
    ] = None,
    stale: Stale = False,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Compare excitations before and after running them.

    Shows cost, information and standard deviations, and which to prefer.

    A result belongs to the run it was made of, a run to the plan that its program was written from.
    """
    from cases.files import COMPARISON, check_folder, output_place
    from cases.loading import load_case
    from planner.cli.console import save_with_page
    from planner.comparison.advising import compare as compared

    place = output_place(output, Path("hexcite-comparison"), overwrite)
    check_folder(place, COMPARISON, folders, overwrite)
    with status("comparing", json):
        found = compared(folders, None if case is None else load_case(case), stale)
        save_with_page(found, COMPARISON, place, overwrite)
    answer = {"report": str(place / "report.html")} | found.to_json()
    if json:
        print_json(answer)
    else:
        _show(answer, found)


def _show(answer: dict[str, Any], found: "Comparison") -> None:
    from planner.reports.compare import EXECUTION, execution_rows, figure_rows, parameter_columns, parameter_rows

    entries = found.entries
    names = [e.name for e in entries]
    print_table("Figures; criteria of the mean information, reference scaling", ("", *names), figure_rows(entries))
    title = "Parameters side by side; std of plans and runs is predicted"
    print_table(title, parameter_columns(entries), parameter_rows(entries))
    if rows := execution_rows(found.groups):
        print_table("Planned and executed", EXECUTION, rows)
    for warning in answer["warnings"]:
        print(f"warning: {warning}")
    print(f"report written: {answer['report']}")
    for sentence in answer["recommendation"]["sentences"]:
        print(f"recommendation: {sentence}")
