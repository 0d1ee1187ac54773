"""Pages of the reference that follow from the code: commands, Python names, keys of the case file."""

import re
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import hexcite
from cases.base.unit_names import QUANTITIES
from cases.orientation import CONVENTIONS
from cases.scaffold import explanations
from cases.schema import Case
from cases.tables import LARGEST, Part

FORMULAS = {
    "What is measured": (
        "automethod:: identification.model.model.Model.expression",
        "autofunction:: identification.model.model.expected_forces",
    ),
    "How it moves": (
        "automethod:: identification.motion.curves.FourierMotion.at",
        "autofunction:: identification.machines.rotations.rate_matrix",
        "autofunction:: identification.machines.rotations.twist",
        "autofunction:: identification.machines.rotations.twist_rate",
        "autofunction:: identification.machines.rotations.gibbs",
    ),
    "What is estimated": (
        "autofunction:: identification.estimation.fit.gauss_markov",
        "autofunction:: identification.estimation.estimators.per_channel",
        "autofunction:: identification.estimation.estimators.independent_poses",
        "autofunction:: identification.estimation.estimators.huber",
        "autofunction:: identification.estimation.priors.conflict_of",
        "autofunction:: identification.results.verdicts.en",
    ),
    "What is optimised": (
        "autofunction:: identification.estimation.criteria.information",
        "autofunction:: identification.estimation.criteria.reference_scaling",
        "autofunction:: identification.estimation.criteria.executed_information",
        "autoclass:: identification.estimation.criteria.Criterion",
    ),
}


def write_reference(folder: Path) -> None:
    """Writes the pages that follow from the code, each only where it changes."""
    pages = {
        "commands.md": commands_page(), "python.md": python_page(), "case.md": case_page(), "units.md": units_page(),
        "formulas.md": formulas_page(),
    }  # fmt: skip
    for name, text in pages.items():
        file = folder / name
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


def commands_page() -> str:
    """Every command with its arguments and options, as typer writes them."""
    words = "-m typer hexcite.cli utils docs --name hexcite --title Commands"
    command = [sys.executable, *words.split()]
    page = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    codes = "Exit codes: 0 done; 1 refused, with one line that says why; 2 wrong usage; 130 interrupted.\n"
    return page.replace("**Usage**", f"{codes}\n**Usage**", 1)


def python_page() -> str:
    """Every public name of `hexcite` with its docstring."""
    lines = ["# Python", "", "`import hexcite as hx` is the library. Values are in SI and radians.", ""]
    for name in dir(hexcite):
        thing = getattr(hexcite, name)
        if isinstance(thing, str):
            lines += [f"## hx.{name}", "", "The version of what is installed, a text.", ""]
            continue
        where = f"{thing.__module__}.{thing.__qualname__}"
        directive = f"autoclass:: {where}\n   :members:" if isinstance(thing, type) else f"autofunction:: {where}"
        lines += [f"## hx.{name}", "", "```{eval-rst}", f".. {directive}", "```", ""]
    return "\n".join(lines)


def formulas_page() -> str:
    """The functions in which the measurement, the estimate and what is optimised are written."""
    lines = ["# Formulas in the source", ""]
    lines += ["The functions that hold the [model](../explanation/model.md), as they say it themselves. Numbers in"]
    lines += ["brackets are [equations of the paper](paper.md).", ""]
    for title, directives in FORMULAS.items():
        lines += [f"## {title}", ""]
        for directive in directives:
            # no index: what is public stands in the reference of Python too
            lines += ["```{eval-rst}", f".. {directive}", "   :no-index:", "```", ""]
    return "\n".join(lines)


def case_page() -> str:
    """Every table of the case file with key, allowed values, default and meaning."""
    schema = Case.model_json_schema()
    classes = {part.__name__: part for part in _parts(Part)}
    places: dict[str, list[str]] = {}
    _walk("Case", "", schema, places)
    lines = ["# The case file", "", "`case.toml` describes one machine: TOML, one table for each part. Units stand in"]
    lines += ["the keys. Unknown keys are errors. `hexcite case check` names everything that cannot be.", ""]
    for name, paths in places.items():
        table = schema if name == "Case" else schema["$defs"][name]
        told, required = explanations(classes[name]), table.get("required", ())
        rows = [
            (f"`{key}`", _allowed(value), _default(value, key in required), _cell(told.get(key, "")))
            for key, value in table["properties"].items()
        ]
        also = f" Also: {', '.join(f'`{path}`' for path in paths[1:])}." if paths[1:] else ""
        lines += [f"({_anchor(name)})=", f"## {f'`[{paths[0]}]`' if paths[0] else 'Top level'}", ""]
        lines += [_cell(classes[name].__doc__ or "") + also, ""]
        lines += [*_table(("key", "allowed", "default", "meaning"), rows), ""]
    return "\n".join(lines)


def units_page() -> str:
    """Units and conventions of orientations that recordings may have."""
    lines = [
        "# Units and orientations of recordings",
        "",
        "What `recording.units`, labels and rows of units may state.",
    ]
    lines += [
        "Small and capital letters count where they decide (mN, MN); products may be written with `*`, `.`, `-`, a"
    ]
    lines += ["blank or nothing between their factors. A force in kg or lb is the weight of that mass.", ""]
    head = ("symbol", "SI value", "also written")
    for units in QUANTITIES:
        rows = [(f"`{symbol}`", f"{units[symbol]:.9g}", _spellings(units.spellings(symbol))) for symbol in units]
        lines += [f"## {units.quantity.capitalize()}", "", *_table(head, rows), ""]
    lines += [
        "## Orientations",
        "",
        "Values of `recording.orientation`. R turns vectors of the sensor or platform into the base;",
    ]
    lines += ["a, b, c are the columns `a_deg`, `b_deg`, `c_deg`, in the order of the convention.", ""]
    rows = [(f"`{c.name}`", _cell(c.words), _cell(c.users)) for c in CONVENTIONS.values()]
    return "\n".join([*lines, *_table(("name", "what the numbers are", "who writes it"), rows), ""])


def _spellings(every: Sequence[str], shown: int = 6) -> str:
    more = ", and their other combinations" if len(every) > shown else ""
    return _cell(", ".join(every[:shown]) + more)


def _walk(name: str, path: str, schema: Mapping[str, Any], places: dict[str, list[str]]) -> None:
    """Notes where in the file each table stands, the outer ones first."""
    places.setdefault(name, []).append(path)
    table = schema if name == "Case" else schema["$defs"][name]
    for key, value in table["properties"].items():
        for inner in re.findall(r"#/\$defs/(\w+)", str(value)):
            if inner in schema["$defs"] and "properties" in schema["$defs"][inner]:
                _walk(inner, f"{path}.{key}".lstrip("."), schema, places)


def _parts(part: type[Part]) -> Iterator[type[Part]]:
    for inner in part.__subclasses__():
        yield inner
        yield from _parts(inner)


def _anchor(name: str) -> str:
    return f"table-{name.lower()}"


def _default(value: Mapping[str, Any], required: bool) -> str:
    if required:
        return "required"
    default = value.get("default")
    return "" if default is None or default == [] or isinstance(default, dict) else f"`{default}`"


def _allowed(value: Mapping[str, Any]) -> str:
    """What a JSON schema allows, in words."""
    if "$ref" in value:
        return f"a [table](#{_anchor(value['$ref'].rpartition('/')[2])})"
    if "anyOf" in value:
        return ", or ".join(_allowed(v) for v in value["anyOf"] if v.get("type") != "null")
    if "oneOf" in value:
        return ", or ".join(_allowed(v) for v in value["oneOf"])
    if "const" in value:
        return f"`{value['const']}`"
    if "enum" in value:
        return ", ".join(f"`{v}`" for v in value["enum"])
    kind = value.get("type")
    if kind == "array":
        entries = value.get("prefixItems") or [value.get("items", {})]
        count = len(entries) if "prefixItems" in value else value.get("minItems")
        many = (
            f"{count} times " if "prefixItems" in value else f"a list (at least {count}) of " if count else "a list of "
        )
        return many + _allowed(entries[0])
    if kind == "object":
        return "a table of " + (_allowed(value.get("additionalProperties", {})) or "values")
    return {"number": "number", "integer": "whole number", "string": "text"}.get(str(kind), "") + _range(value)


def _range(value: Mapping[str, Any]) -> str:
    words = {"exclusiveMinimum": "above", "minimum": "at least", "exclusiveMaximum": "below", "maximum": "at most"}
    told = [f"{word} {value[k]:g}" for k, word in words.items() if k in value and abs(value[k]) < LARGEST]
    return f" {', '.join(told)}" if told else ""


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    if not rows:
        return []
    lines = (head, tuple("---" for _ in head), *rows)
    return ["| " + " | ".join(line) + " |" for line in lines]


def _cell(text: str) -> str:
    """A text on one line, with nothing that Markdown takes for itself."""
    return " ".join(text.split()).replace("|", "\\|").replace("<", "\\<").replace("*", "\\*")
