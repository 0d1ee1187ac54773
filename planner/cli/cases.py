"""`hexcite cases`, `hexcite case new`, `hexcite case check` and `hexcite case show`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import hexcite as hx
from cases.errors import CaseError
from cases.files import atomic_file, check_file, output_place
from planner.cli import console
from planner.cli.console import argument, option, out

if TYPE_CHECKING:
    from planner.motion_box import MotionBox

app = typer.Typer(help="Work with the description of a machine.", no_args_is_help=True, rich_markup_mode=None)


def list_cases(json: console.Json = False) -> None:
    """List the built-in cases."""
    from cases.tables import built_in_cases

    rows = [
        {"name": c.name, "setup": c.setup, "title": c.title, "file": str(file)}
        for name, file in built_in_cases().items()
        for c in [hx.load_case(name)]
    ]
    if not console.answered({"cases": rows}, json):
        console.print_table(
            "Built-in cases",
            ("case", "setup", "what it is"),
            [[r["name"], r["setup"], r["title"]] for r in rows],
            False,
        )
        print(
            "setup, where sensors sit: 1a in a frame that stands, 1b in one that moves, 2x in the struts, R at a flange"
        )
        print("hexcite case new NAME --like CASE begins one of your own; hexcite case show CASE draws it")


@app.command("check")
def check(
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    propose: Annotated[bool, option("Find the largest reachable motion box.", "--propose")] = False,
    json: console.Json = False,
) -> None:
    """Validate a case and say how much of its motion box is reachable."""
    try:
        with console.status("searching the largest reachable box", json or not propose):
            checked = hx.check_case(case, propose)
    except CaseError as error:
        if json and len(error.problems) > 1:  # one line has them all; nothing stands on standard output
            raise CaseError(error.file, "", "; ".join(error.problems)) from error
        for problem in error.problems if len(error.problems) > 1 else ():
            print(problem)
        raise
    if console.answered({"ok": True, **checked.to_json()}, json):
        return
    print(checked)
    if checked.proposal is not None:
        _print_proposal(checked.proposal)


def _print_proposal(box: "MotionBox") -> None:
    """Prints the box as lines of a case file, with its figures."""
    from planner.precision import share_text

    if box.share == 1.0:
        print("Proposal: none is needed, the stated box is reachable.")
        return
    print(f"\nProposal: the largest reachable box found, {100 * box.share:.3g} % of the stated box's volume.")
    print(f"Verified at {box.poses} poses: the worst uses {share_text(box.worst)} of the limit {box.worst_limit}.")
    print("Replace these lines of [limits.motion] (relative to home; home may lie near a side):\n")
    print(box.toml())


@app.command("show")
def show(
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    output: Annotated[Path | None, out("Picture to write: .svg, .png or .pdf; SVG by default.")] = None,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Draw the machine at home."""
    from cases.tables import find_case

    loaded = hx.load_case(case)
    loaded.need_motion("the picture of the machine")
    file = output_place(output, Path(f"{loaded.name}-machine.svg"), overwrite)
    check_file(file, (".svg", ".png", ".pdf"), [find_case(case)], overwrite)
    with console.status("drawing", json):
        from planner.reports.plots import case_figure

        with atomic_file(file) as part:
            case_figure(loaded).savefig(part, format=file.suffix[1:].lower())
    if not console.answered({"ok": True, "figure": str(file)}, json):
        print(f"picture written: {file}")


@app.command("new")
def new(
    name: Annotated[str, argument("Name of the machine: small letters, digits and underscores.")],
    like: Annotated[str | None, option("Built-in case to begin from; hexapod by default.", "--like")] = None,
    urdf: Annotated[Path | None, option("Robot to begin from: a URDF file.", "--urdf")] = None,
    flange: Annotated[str | None, option("Link of the URDF that carries the sensor.", "--flange")] = None,
    output: Annotated[Path | None, out("Folder to make; NAME by default.")] = None,
    json: console.Json = False,
) -> None:
    """Begin the description of one's own machine.

    The case file is filled in section by section; it tells how.
    """

    if urdf is not None and like is not None:
        raise typer.BadParameter("a case begins from a built-in case or from a URDF file; give --like or --urdf")
    if urdf is None and flange is not None:
        raise typer.BadParameter("--flange names a link of a URDF file; give --urdf too")
    file = hx.new_case(name, like or "hexapod", output) if urdf is None else hx.new_arm(name, urdf, flange, output)
    if console.answered({"ok": True, "case": str(file)}, json):
        return
    print(f"case written: {file}")
    if urdf is not None:
        print(f"Geometry and speeds are those of {urdf.name}; fill in what it does not say, from top to bottom, then")
        print(f"    hexcite case check {file.parent}    # says what is missing, and what cannot be")
        return
    print("Its numbers are those of the built-in case: replace each table by your machine's, from top to bottom, then")
    print(f"    hexcite case check {file.parent}    # says what cannot be, with key, value and remedy")
    print(f"    hexcite case show {file.parent}     # draws the machine: compare with the drawing")
