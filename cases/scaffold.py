"""The beginning of a case file for one's own machine: another case, its keys explained where it is built in."""

import ast
import inspect
import json
import re
import sys
import textwrap
import tomllib
from collections.abc import Mapping, Sequence
from functools import cache
from itertools import pairwise
from operator import attrgetter
from pathlib import Path
from threading import Lock

import numpy as np

from cases.base.atomic import write_text
from cases.base.errors import WITH_OUTPUT, CaseError, Code, FileProblem, printable
from cases.base.phrases import phrase
from cases.base.text_formats import toml_value
from cases.base.units import MM
from cases.bounds import Bounds
from cases.editing import with_values
from cases.schema import NO_TITLE, Case, load_case
from cases.tables import CASE_FILE, Part, built_in_cases, find_case
from cases.tolerances import TYPICAL, Tolerances, tolerable_keys
from cases.urdf import Arm

_NAME = re.compile(r"[a-z][a-z0-9_]*")

_SIMULATED_BODY = (
    "The simulated body is that of [nominal]. A table [simulation.parameters.body] with mass_kg, centre_of_gravity_mm "
    "or inertia_kg_m2 states another one."
)
_WIDTH = 110  # characters of a comment


def new_case(name: str, like: str = "hexapod", folder: Path | str | None = None) -> Path:
    """Writes `folder/case.toml`, the case `like` under another name, to be filled in; returns its path.

    A built-in case gets explanations of its keys; a case of one's own is copied as it is.

    >>> hx.new_case("mill").as_posix()
    'mill/case.toml'

    Args:
        name: small letters, digits and underscores.
        like: a built-in name, or folder or file of a case.
        folder: folder to make; named after the case unless given.

    Raises:
        CaseError: a name that a case cannot have, or no such case.
        FileProblem: the folder holds a case, or cannot be written.
    """
    file = new_place(name, folder)
    case = load_case(like)
    if like not in built_in_cases():
        place = find_case(like)
        text = place.read_text(encoding="utf-8")
        write_text(file, with_values(place, text, tomllib.loads(text) | {"name": name}))
        return file
    lines = _comment(
        f"{name}: begun from the case {like}; every number is that case's until you replace it. Keys carry units. "
        "{B} is the frame of the base, {P} that of the platform. `hexcite case check` says what cannot be, `hexcite "
        "look` proposes the table [recording]. Delete tables of controllers that you do not have."
    )
    texts = {"name": name, "title": NO_TITLE, "source": "where these values come from"}
    comments, latest, skipped = explanations(Case), "", False
    for line in find_case(like).read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            continue  # the built-in case's own words on its sources
        table = re.match(r"\[([a-z_.]+)\]", line)
        if table and table[1] == "simulation.parameters.body" and case.nominal is not None:
            lines += [*_comment(_SIMULATED_BODY), ""]
            skipped = True
        elif table:
            skipped = False
        if skipped:
            continue
        if table:
            line = table[0]  # what follows it is about the built-in case's source
            part = attrgetter(table[1])(case)
            comments = explanations(type(part)) if isinstance(part, Part) else {}
            if isinstance(part, Part):
                lines += _comment(" ".join((type(part).__doc__ or "").split()))
                if optional := sorted(type(part).model_fields.keys() - part.model_fields_set):
                    lines += _comment(f"It may also have {', '.join(optional)}.")
        elif key := re.match(r"(\w+) = ", line):
            words = comments.get(key[1], "")
            lines += _comment(words if words != latest else "")
            latest = words
            line = f'{key[1]} = "{texts[key[1]]}"' if key[1] in texts else re.sub(r"\] # .*", "]", line)
            if key[1] == "title" and comments == explanations(Case):
                lines += [line, *_comment(comments["template"])]
                line = f'template = "{like}"'
        lines.append(line)
    lines += ["", *_tolerances(case.tolerable), *_bounds(case)]
    write_text(file, "\n".join(lines).replace("\n\n\n", "\n\n") + "\n")
    return file


def _tolerances(keys: Sequence[str]) -> list[str]:
    """The table of tolerances with these keys as comments, with values to begin from."""
    words = explanations(Tolerances)
    about = (
        "How far the machine may be from all this: deviations of results count what is stated here, and say what is "
        "not. Standard deviations, or limits as { limit = 0.05 }. Typical values, to be replaced by those of drawing "
        "and data sheets:"
    )
    rows = [f"# {key} = {TYPICAL[key]:g} # {words[key]}" for key in TYPICAL if key in keys]
    return [*_comment(about), "# [tolerances]", *rows]


def _bounds(case: Case) -> list[str]:
    """The table of bounds as comments, around the nominal body; none where no body is identified."""
    if case.setup == "1a":
        return []
    words, body = explanations(Bounds), case.nominal
    mass, centre = (30.0, np.zeros(3)) if body is None else (body.mass_kg, np.round(body.centre_of_gravity / MM))

    def box(reach: float) -> str:
        sides = (f"{axis}_mm = [{c - reach:.1f}, {c + reach:.1f}]" for axis, c in zip("xyz", centre, strict=True))
        return f"{{ {', '.join(sides)} }}"

    rows = {
        "mass_kg": f"[{0.9 * mass:.3g}, {1.1 * mass:.3g}]",
        "centre_of_gravity_mm": box(10.0),
        "body_mm": box(300.0),
    }
    about = " ".join((Bounds.__doc__ or "").split())
    lines = [line for key, row in rows.items() for line in (*_comment(words[key]), f"# {key} = {row}")]
    return ["", *_comment(f"{about} To be replaced by yours:"), "# [bounds]", *lines]


def _comment(text: str) -> list[str]:
    return textwrap.wrap(text, _WIDTH, initial_indent="# ", subsequent_indent="# ")


def arm_text(
    name: str,
    arm: Arm,
    urdf: str,
    flange: str | None,
    sensor: str | None,
    bodies: bool,
    touching: Sequence[tuple[str, str]],
) -> str:
    """Text of the case of an arm; keys that no URDF has are there as comments, and so is what is odd about the file.

    Args:
        urdf: name of its file.
        flange: link that carries the sensor.
        sensor: link whose frame is the sensor's; that of the flange unless given.
        bodies: whether its bodies are kept apart; else they are comments.
        touching: names of those that are not kept apart.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    templates = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    templates.filters |= {"keys": _keys, "comment": lambda text: "\n".join(_comment(printable(text)))}
    templates.filters["commented"] = lambda text: "\n".join(f"# {line}" for line in text.splitlines())
    templates.filters["toml"] = toml_value
    templates.filters["bodies"] = lambda bodies: toml_value(
        [json.loads(b.model_dump_json(exclude_unset=True)) for b in bodies]
    )
    turns = [joint.turns for joint, _ in arm.joints]
    return templates.get_template("arm.toml.jinja").render(
        arm._asdict(),
        name=name,
        urdf=urdf,
        flange_link=flange,
        sensor_link=sensor or flange,
        keep_apart=bodies,
        touching=[list(pair) for pair in touching],
        tolerances="\n".join(_tolerances(tolerable_keys(turns, False, False, True, True, True))),
    )


def _keys(table: Part) -> str:
    """TOML of what a table states, its name first; 12 decimals, so that right angles and millimetres read as such."""
    text = table.model_dump_json(exclude_unset=True, exclude_none=True)
    entries = json.loads(text, parse_float=lambda number: round(float(number), 12) + 0.0)
    return "\n".join(f"{key} = {toml_value(entries[key])}" for key in sorted(entries, key=lambda key: key != "name"))


def new_place(name: str, folder: Path | str | None) -> Path:
    """The case file to write; raises CaseError for a name that no case can have, FileProblem where it exists."""
    if not _NAME.fullmatch(name):
        raise CaseError(
            file=name or "''",
            problem=phrase("no_case_name", "is not a name of a case"),
            remedy=phrase("use_small_letters", "use small letters, digits and underscores, a letter first"),
            code=Code.WRONG_KIND,
        )
    if name in built_in_cases():
        raise CaseError(
            file=name,
            problem=phrase("built_in_name", "is the name of a built-in case"),
            remedy=phrase("choose_another", "choose another one"),
            code=Code.EXISTS,
        )
    file = Path(name if folder is None else folder) / CASE_FILE
    if file.exists():
        raise FileProblem(
            place=file,
            problem=phrase("case_exists", "exists"),
            remedy=phrase("folder_or_edit", "choose another folder{output}, or edit that file", output=WITH_OUTPUT),
            code=Code.EXISTS,
        )
    return file


_PARSING = Lock()
"""Python 3.11 makes syntax trees in one thread at a time only (SystemError: recursion depth mismatch)."""


@cache
def _classes(module: str) -> dict[str, ast.ClassDef]:
    """The classes of a module as they are written, parsed once for all of them."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}


@cache
def explanations(part: type[Part]) -> Mapping[str, str]:
    """What each key of a table means: the string that stands below its field in the class, or below one before it."""
    words: dict[str, str] = {}
    for base in (base for base in reversed(part.__mro__) if issubclass(base, Part)):
        meaning = ""
        with _PARSING:
            fields = [*ast.iter_child_nodes(_classes(base.__module__)[base.__name__]), ast.Pass()]
        for field, text in pairwise(fields):
            if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
                if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
                    meaning = " ".join(str(text.value.value).split())
                words[field.target.id] = meaning
    return words
