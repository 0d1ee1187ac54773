"""`hexcite compare`: plans, runs and results side by side, with a recommendation."""

from pathlib import Path
from typing import Annotated, Any

import typer

from planner.cli.console import Json, Overwrite, Stale, print_json, print_table, status


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

    Told are cost, information and standard deviations, and which to prefer.

    A result belongs to the run it was made of, a run to the plan whose path it followed.
    """
    answer = run_comparison(folders, output, json, overwrite, case, stale)
    if json:
        print_json(answer)


def run_comparison(
    folders: list[Path],
    output: Path | None,
    quiet: bool,
    overwrite: bool = False,
    case: str | None = None,
    stale: bool = False,
) -> dict[str, Any]:
    """Reads, compares, writes the page, prints unless `quiet`; returns the JSON answer."""
    from cases.errors import HexciteError
    from cases.files import COMPARISON, atomic_folder, check_folder, json_text, output_place
    from planner.comparison.advising import groups, recommend
    from planner.comparison.entries import read_entry
    from planner.reports.compare import compare_figure, compare_page, warnings_of
    from planner.reports.page import render
    from planner.reports.plots import save_figure

    for k, folder in enumerate(folders):
        if any(folder.resolve() == other.resolve() for other in folders[:k]):
            raise HexciteError(f"{folder}: is named twice; name each folder once")
    output = output_place(output, Path("hexcite-comparison"), overwrite)
    check_folder(output, COMPARISON, folders, overwrite)
    with status("comparing", quiet):
        found = groups([read_entry(folder, case, stale) for folder in folders])
        advice = recommend(found)
        entries = [e for g in found for e in g]
        answer: dict[str, Any] = {
            "rows": [e.to_json() for e in entries],
            "groups": [[e.name for e in g] for g in found],
            "recommendation": advice._asdict(),
            "warnings": list(warnings_of(entries)),
        }
        with atomic_folder(output, COMPARISON, overwrite) as part:
            (part / "comparison.json").write_text(json_text(answer), encoding="utf-8")
            (part / "report.html").write_text(render(compare_page(found, advice)), encoding="utf-8")
            save_figure(compare_figure(found), part / "plots", "standard_deviations")
    answer = {"report": str(output / "report.html")} | answer
    if not quiet:
        _show(answer, found)
    return answer


def _show(answer: dict[str, Any], found: Any) -> None:
    from planner.reports.compare import EXECUTION, execution_rows, figure_rows, parameter_columns, parameter_rows

    entries = [e for g in found for e in g]
    names = [e.name for e in entries]
    print_table("Figures; criteria of the mean information, reference scaling", ("", *names), figure_rows(entries))
    title = "Parameters side by side; std of plans and runs is predicted"
    print_table(title, parameter_columns(entries), parameter_rows(entries))
    if rows := execution_rows(found):
        print_table("Planned and executed", EXECUTION, rows)
    for warning in answer["warnings"]:
        print(f"warning: {warning}")
    for sentence in answer["recommendation"]["sentences"]:
        print(f"recommendation: {sentence}")
    print(f"report written: {answer['report']}")
