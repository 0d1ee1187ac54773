"""`hexcite cases`, `hexcite case new`, `hexcite case check` and `hexcite case show`."""

from pathlib import Path
from typing import Annotated, Any

import typer

from planner.cli.console import LIMIT_COLUMNS, Json, limit_rows, print_json, print_table, status

app = typer.Typer(help="Work with the description of a machine.", no_args_is_help=True, rich_markup_mode=None)


def list_cases(json: Json = False) -> None:
    """List the built-in cases."""
    from cases.loading import built_in_cases, load_case

    rows = [
        {"name": c.name, "setup": c.setup, "title": c.title, "file": str(file)}
        for name, file in built_in_cases().items()
        for c in [load_case(name)]
    ]
    if json:
        print_json({"cases": rows})
    else:
        print_table(
            "Built-in cases",
            ("case", "setup", "what it is", "file"),
            [[r["name"], r["setup"], r["title"], r["file"]] for r in rows],
            False,
        )


@app.command("check")
def check(case: Annotated[str, typer.Argument(help="Built-in name, folder or case file.")], json: Json = False) -> None:
    """Validate a case and tell what it can reach."""
    from planner.reports.case_figures import case_figures

    figures: dict[str, Any] = case_figures(case)
    if json:
        print_json({"ok": True, "figures": figures})
        return
    print(f"{figures['name']} is valid: {figures['title']} (setup {figures['setup']}, hash {figures['hash']})")
    print(f"sensor frame: condition {figures['frame_condition']:.3g} (moments in units of the frame's size)")
    if "limits_in_box" in figures:
        print(f"struts at home: {', '.join(f'{v:.1f}' for v in figures['home_struts_mm'])} mm")
        rows = limit_rows(figures["limits_in_box"])
        print_table(
            f"Worst of {figures['poses']} poses: home, and corners and middles of the motion box", LIMIT_COLUMNS, rows
        )
        if any(v["ratio"] > 1.0 for v in figures["limits_in_box"].values()):
            print("Not the whole box is within reach: plans are held to the limits above 100 % as well.")


@app.command("show")
def show(
    case: Annotated[str, typer.Argument(help="Built-in name, folder or case file.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Picture to write: .svg, .png or .pdf; SVG by default.")
    ] = None,
    json: Json = False,
) -> None:
    """Draw the machine at home and the reach of its struts and joints."""
    from cases.files import atomic_file, check_file
    from cases.loading import find_case, load_case

    loaded = load_case(case)
    loaded.need_machine("the picture of the machine")
    file = output if output is not None else Path(f"{loaded.name}-machine.svg")
    check_file(file, (".svg", ".png", ".pdf"), [find_case(case)])
    with status("drawing", json):
        from planner.reports.case_plots import case_figure

        figure = case_figure(loaded)
        with atomic_file(file) as part:
            figure.savefig(part, format=file.suffix[1:].lower())
    if json:
        print_json({"ok": True, "figure": str(file)})
    else:
        print(f"picture written: {file}")


@app.command("new")
def new(
    name: Annotated[str, typer.Argument(help="Name of the machine: small letters, digits and underscores.")],
    like: Annotated[str, typer.Option("--like", help="Built-in case to begin from.")] = "hexapod",
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder to make; NAME by default.")] = None,
    json: Json = False,
) -> None:
    """Begin the description of one's own machine.

    The case file is filled in section by section; it tells how.
    """
    from cases.scaffold import new_case

    file = new_case(name, like, output if output is not None else Path(name))
    if json:
        print_json({"ok": True, "case": str(file)})
        return
    print(f"case written: {file}")
    print("Its numbers are those of the built-in case: replace each table by your machine's, from top to bottom, then")
    print(f"    hexcite case check {file.parent}    # says what cannot be, with key, value and remedy")
    print(f"    hexcite case show {file.parent}     # draws the machine: compare with the drawing")
