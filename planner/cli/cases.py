"""`hexcite cases` and `hexcite case check`."""

from typing import Annotated, Any

import typer

from planner.cli.console import LIMIT_COLUMNS, Json, limit_rows, print_json, print_table

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
    from planner.case_figures import case_figures

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
