"""The values of a case file as fields: shown with what they mean, written back and nothing else."""

import hashlib
import re
import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import Any

import tomlkit

from cases.base.errors import HexciteError
from cases.base.files import atomic_file, toml_value
from cases.scaffold import explanations
from cases.schema import Case, load_case
from cases.tables import CASE_FILE, Part, built_in_cases

Place = tuple[str | int, ...]
"""Keys, and numbers in lists of tables, from the top of a file to a value."""
FIXED = frozenset({"schema_version", "name", "template"})  # what a form does not change
_COMMA = re.compile(r"[+-]?\d+,\d+")  # a decimal sign


class Refused(ValueError):
    """A value that cannot be, with the place where it stands; a sentence."""


@dataclass(frozen=True)
class Entry:
    """One value: its name in forms, its text, what it means, and whether it is still that of the example."""

    name: str
    key: str
    text: str
    words: str
    example: bool
    flag: bool  # whether it is true or false


@dataclass(frozen=True)
class Section:
    """The values of one table."""

    name: str
    words: str
    entries: tuple[Entry, ...]


def digest(content: str) -> str:
    """Fingerprint of a file's text, by which a form knows that it was changed meanwhile."""
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def sections(content: str, case: Case | None) -> tuple[Section, ...]:
    """The values of a case file by table, in their order; empty where it is not TOML."""
    try:
        data = tomllib.loads(content)
    except tomllib.TOMLDecodeError:
        return ()
    example = dict(_leaves((), _template(data.get("template"))))
    tables: dict[str, list[Entry]] = {}
    for place, value in _leaves((), data):
        if place[0] in FIXED:
            continue
        table, key = _table_of(place)
        words = _words(case, table).get(key.split(".")[0], "")
        same = place in example and example[place] == value
        shown = value if isinstance(value, str) else toml_value(value)
        tables.setdefault(table, []).append(Entry(named(place), key, str(shown), words, same, isinstance(value, bool)))
    return tuple(Section(name, _about(case, name), tuple(entries)) for name, entries in tables.items())


def _template(name: Any) -> Mapping[str, Any]:
    file = built_in_cases().get(name) if isinstance(name, str) else None
    return {} if file is None else tomllib.loads(file.read_text(encoding="utf-8"))


def _leaves(place: Place, value: Any) -> Iterator[tuple[Place, Any]]:
    """Values that are no tables, each with its place."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _leaves((*place, key), inner)
    elif isinstance(value, list) and value and all(isinstance(each, Mapping) for each in value):
        for k, inner in enumerate(value):
            yield from _leaves((*place, k), inner)
    elif isinstance(value, bool | int | float | str | list):
        yield place, value


def named(place: Place) -> str:
    """The name of a value in a form: machine.chain.joints[0].name."""
    text = ""
    for key in place:
        text += f"[{key}]" if isinstance(key, int) else f".{key}" if text else key
    return text


def _table_of(place: Place) -> tuple[str, str]:
    """The table that a value is shown in, of two keys at most or an entry of a list, and its key there."""
    numbers = [k for k, key in enumerate(place[:-1]) if isinstance(key, int)]
    cut = numbers[0] + 1 if numbers else min(2 if len(place) > 3 or place[0] == "controller" else 1, len(place) - 1)
    return named(place[:cut]), named(place[cut:])


def _part(case: Case | None, table: str) -> Part | None:
    try:
        part = attrgetter(re.sub(r"\[\d+\]", "", table))(case) if table else case
    except AttributeError:
        return None
    if isinstance(part, tuple) and part:
        part = part[0]
    return part if isinstance(part, Part) else None


def _words(case: Case | None, table: str) -> Mapping[str, str]:
    if not table:
        return explanations(Case)
    part = _part(case, table)
    return {} if part is None else explanations(type(part))


def _about(case: Case | None, table: str) -> str:
    part = _part(case, table) if table else None
    return "" if part is None else " ".join((type(part).__doc__ or "").split())


def edited(content: str, given: Mapping[str, str]) -> str:
    """The text of a case file with other values, comments and order as they are; raises Refused."""
    document = tomlkit.parse(content)
    places = {named(place): (place, value) for place, value in _leaves((), tomllib.loads(content))}
    wanted = dict[Place, Any]()
    for name, text in given.items():
        if name not in places or places[name][0][0] in FIXED:
            raise Refused(f"{name}: there is no such value")
        place, before = places[name]
        after = _value(name, text, before)
        if after == before:
            continue
        wanted[place] = after
        holder: Any = document
        for key in place[:-1]:
            holder = holder[key]
        holder[place[-1]] = after
    text = tomlkit.dumps(document)
    if dict(_leaves((), tomllib.loads(text))) != dict(places.values()) | wanted:
        raise Refused("these values cannot be replaced alone as the file is written; edit it by hand")
    return text


def _value(name: str, text: str, before: Any) -> Any:
    """What was typed, as a value of the kind that stood there; numbers with a comma as decimal sign too."""
    text = text.strip()
    if isinstance(before, str):
        if len(text) > 2000 or any(ord(letter) < 32 for letter in text):
            raise Refused(f"{name}: is too long, or has control characters")
        return text
    if _COMMA.fullmatch(text):
        text = text.replace(",", ".")
    try:
        value = tomllib.loads(f"value = {text}\n")
    except (tomllib.TOMLDecodeError, RecursionError):
        value = {}
    kinds: tuple[type, ...] = (
        (bool,) if isinstance(before, bool) else (list,) if isinstance(before, list) else (int, float)
    )
    after = value.get("value")
    if len(value) != 1 or not isinstance(after, kinds) or (bool not in kinds and isinstance(after, bool)):
        kind = "true or false" if bool in kinds else "a list such as [1.0, 2.0]" if list in kinds else "a number"
        raise Refused(f"{name}: {text!r} is not {kind}")
    return float(after) if isinstance(before, float) and isinstance(after, int) else after


def case_of(content: str, file: Path) -> Case:
    """The case of a text that is not written yet; raises HexciteError, which names the file that it is for."""
    with tempfile.TemporaryDirectory(prefix="hexcite-page-") as folder:
        part = Path(folder) / CASE_FILE
        part.write_text(content, encoding="utf-8")
        try:
            return load_case(str(part))
        except HexciteError as error:
            raise Refused("; ".join(error.lines).replace(str(part), file.parent.name + "/" + CASE_FILE)) from error


def save(file: Path, content: str) -> None:
    """Writes a case file as a whole, with the rights that it had."""
    mode = file.stat().st_mode
    with atomic_file(file) as part:
        part.write_text(content, encoding="utf-8")
    file.chmod(mode)
