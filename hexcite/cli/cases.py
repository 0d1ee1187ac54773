"""`hexcite cases`, and `hexcite case` with `new`, `check`, `show` and `set`."""

from pathlib import Path
from typing import Annotated

import typer

import hexcite as hx
from cases.base.atomic import atomic_file
from cases.base.errors import Code, Write
from cases.base.output_places import check_file, output_place
from cases.base.text_formats import toml_value
from hexcite.cli import console
from hexcite.cli.console import argument, option, out
from identification.texts import aligned

app = typer.Typer(help="Work with the description of a machine.", no_args_is_help=True, rich_markup_mode=None)


def list_cases(json: console.Json = False) -> None:
    """List the built-in cases."""
    from cases.tables import built_in_cases

    rows = [
        {"name": c.name, "setup": c.setup, "title": c.title, "file": str(file)}
        for name, file in built_in_cases().items()
        for c in [hx.load_case(name)]
    ]
    table = aligned(("case", "setup", "what it is"), *([r["name"], r["setup"], r["title"]] for r in rows))
    setups = "setup: the sensors' frame stands (1a), moves (1b), sensors in the struts (2x), a sensor at a flange (R)"
    console.answered({"cases": rows}, json, *table, setups)


@app.command("check")
def check(
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    propose: Annotated[bool, option("Look for a motion box that is within reach as a whole.", "--propose")] = False,
    json: console.Json = False,
) -> None:
    """Validate a case and say how much of its motion box is reachable."""
    with console.status("looking for a box", json or not propose):
        checked = hx.check_case(case, propose)
    if console.answered({"ok": True, **checked.to_json()}, json):
        return
    console.say(checked)


@app.command("show")
def show(
    case: Annotated[str, argument("Built-in name, folder or case file.")],
    output: Annotated[Path | None, out("Picture to write: .svg, .png or .pdf; SVG by default.")] = None,
    overwrite: console.Overwrite = False,
    json: console.Json = False,
) -> None:
    """Draw the machine at home, with the frames of sensor, flange and tool; joints without home stand at 0."""
    from cases.tables import find_case

    loaded = hx.load_case(case)
    if loaded.chain is None:
        loaded.need_motion("the picture of the machine")
    file = output_place(output, Path(f"{loaded.name}-machine.svg"), overwrite)
    check_file(file, (".svg", ".png", ".pdf"), [find_case(case)], overwrite)
    with console.status("drawing", json):
        from hexcite.reports.drawing.plots import case_figure

        with atomic_file(file) as part:
            case_figure(loaded).savefig(part, format=file.suffix[1:].lower())
    if not console.answered({"ok": True, "figure": str(file)}, json):
        console.say(f"picture written: {file}")


@app.command("new")
def new(
    name: Annotated[str, argument("Name of the machine: small letters, digits and underscores.")],
    like: Annotated[
        str | None, option("Case to begin from: built in (hexapod by default), or one of your own.", "--like")
    ] = None,
    urdf: Annotated[Path | None, option("Robot to begin from: a URDF file.", "--urdf")] = None,
    flange: Annotated[str | None, option("Link of the URDF that carries the sensor.", "--flange")] = None,
    sensor: Annotated[
        str | None, option("Link of the URDF whose frame is the sensor's; that of the flange by default.", "--sensor")
    ] = None,
    bodies: Annotated[
        bool, option("Keep links and tool apart, by the collision geometry of the URDF.", "--bodies")
    ] = False,
    output: Annotated[Path | None, out("Folder to make; NAME by default.")] = None,
    json: console.Json = False,
) -> None:
    """Begin the description of one's own machine.

    The case file is filled in section by section; it tells how.
    """

    if urdf is not None and like is not None:
        raise typer.BadParameter("a case begins from another case or from a URDF file; give --like or --urdf")
    if urdf is None and (bodies or (flange or sensor) is not None):
        raise typer.BadParameter("--flange, --sensor and --bodies are about a URDF file; give --urdf too")
    if urdf is None:
        file, notes = hx.new_case(name, like or "hexapod", output), tuple[str, ...]()
    else:
        from hexcite._new_arm import begin_arm

        file, notes = begin_arm(name, urdf, flange, output, sensor, bodies)
    fill = "fill it in from top to bottom with your machine's values"
    if urdf is not None:
        fill = "to identify, say how the sensor reads and is mounted; to plan, fill in the rest from top to bottom"
    written = f"case written: {file}; {fill}"
    check = f"hexcite case check {file.parent} says what is missing, and what cannot be"
    odd = [f"look at {note}" for note in notes]
    console.answered({"ok": True, "case": str(file), "notes": list(notes)}, json, *odd, written, check)


@app.command("set")
def set_keys(
    case: Annotated[str, argument("Folder or file of a case of one's own.")],
    keys: Annotated[
        list[str],
        argument(
            "Keys with values as TOML has them: recording.columns.l1_mm='\"LOAD\"'; entries of lists are counted from "
            "1: machine.chain.joints[2].rpy_deg='[0, 0, 90]'. A key without a value is taken away."
        ),
    ],
    json: console.Json = False,
) -> None:
    """Write keys into a case file; all else in it, comments too, stays.

    Nothing is written where the case cannot be as it would be then. The earlier file is kept beside it, as case-1.toml.
    """
    from cases.editing import write_keys
    from cases.tables import built_in_cases, find_case

    file = find_case(case)
    if file in built_in_cases().values():
        raise hx.HexciteError(
            place=case,
            problem="is built in, and stays as it is",
            remedy="hexcite case new begins your own from it",
            code=Code.EXISTS,
        )
    written = write_keys(file, [key_of(text) for text in keys])
    changes = [{"key": key, "before": before, "after": after} for key, before, after in written.changes]
    earlier = None if written.earlier is None else str(written.earlier)
    lines = [f"{key}: {toml_shown(before)} -> {toml_shown(after)}" for key, before, after in written.changes]
    last = f"case written: {file}; as it was before: {earlier}" if earlier else f"{file} has these values already"
    console.answered({"ok": True, "case": str(file), "earlier": earlier, "changes": changes}, json, *lines, last)


def key_of(text: str) -> Write:
    """A key with its value, as typed; raises HexciteError where it cannot be understood."""
    import re
    import tomllib

    name, equals, value = text.partition("=")
    place = list[str | int]()
    for part in name.strip().split("."):
        matched = re.fullmatch(r"([A-Za-z0-9_-]+)((?:\[[1-9]\d{0,5}\])*)", part)
        if matched is None:
            raise hx.HexciteError(
                place=text,
                problem="is not a key with a value",
                remedy="write it as table.key=VALUE",
                code=Code.WRONG_KIND,
            )
        place += [matched[1], *(int(number) - 1 for number in re.findall(r"\d+", matched[2]))]
    if not equals:
        return Write(tuple(place), None)
    try:
        (parsed,) = tomllib.loads(f"value = {value.strip()}\n").values()
    except (tomllib.TOMLDecodeError, ValueError, RecursionError) as error:
        remedy = "write numbers plainly, texts in quotes, lists in brackets"
        raise hx.HexciteError(
            place=text, problem=f"its value is not TOML ({error})", remedy=remedy, code=Code.WRONG_KIND
        ) from error
    return Write(tuple(place), parsed)


def toml_shown(value: object) -> str:
    """A value of a case as TOML has it."""
    return "not stated" if value is None else toml_value(value)
