"""`hexcite look`: what a recording of unknown format holds, and the settings that read it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from planner.cli.console import Json, Overwrite, print_json, print_table, status

if TYPE_CHECKING:
    from identification.formats.looked import Column, Look


def look(
    recording: Annotated[Path, typer.Argument(help="File of unknown format: text or Parquet.")],
    case: Annotated[
        str | None,
        typer.Option(help="Built-in name, folder or file: by its machine units are known, and what is missing."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Picture to write; RECORDING-look.svg by default.")
    ] = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Propose how a file of unknown format is read, and draw it.

    Nothing is changed: compare the proposal with what you know, and paste it into the case file.
    """
    from cases.files import atomic_file, check_file, output_place
    from cases.loading import load_case
    from identification.formats.look import look as look_at

    file = output_place(output, Path(f"{recording.stem}-look.svg"), overwrite)
    check_file(file, (".svg", ".png", ".pdf"), [recording], overwrite)
    with status("looking", json):
        found = look_at(recording, None if case is None else load_case(case))
        from planner.reports.look_plot import look_figure

        with atomic_file(file) as part:
            look_figure(found).savefig(part, format=file.suffix[1:].lower())
    if json:
        print_json(_answer(found) | {"picture": str(file)})
    else:
        _show(found, file)


def _answer(found: "Look") -> dict[str, Any]:
    columns = [{"name": c.name, "meaning": c.ours, "unit": c.unit, "guessed": c.guessed} for c in found.columns]
    return {
        "recording": str(found.file),
        "reads": found.reads,
        "rows": found.rows,
        "rate_Hz": found.rate,
        "columns": columns,
        "settings": dict(found.settings),
        "odd": list(found.odd),
    }


def _show(found: "Look", file: Path) -> None:
    head = ("column", "meaning", "unit", "smallest", "largest", "taken from")
    print_table(f"{found.file.name}: {found.rows} rows", head, [_row(column) for column in found.columns], False)
    print(f"rows per second: {'not known' if found.rate is None else f'{found.rate:.5g}'}")
    for odd in found.odd:
        print(f"look at: {odd}")
    print(f"\n{found.toml}\n")
    print(f"picture written: {file}")
    if found.reads:
        print("the file is read with this table; paste it into case.toml in place of its [recording]")
    else:
        print("the file is not read with this table yet: complete it as said above, then identify, or look again")


def _row(column: "Column") -> list[str]:
    from numpy import nanmax, nanmin

    values = column.values
    ends = [f"{nanmin(values):.6g}", f"{nanmax(values):.6g}"] if len(values) else ["text", ""]
    source = "" if column.ours is None else "values: a guess" if column.guessed else "name"
    return [column.name, column.ours or "-", column.unit, *ends, source]
