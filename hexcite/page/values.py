"""The values of a case file as fields: shown with what they mean, written back and nothing else."""

import copy
import hashlib
import re
import tomllib
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from cases.base.atomic import atomic_file
from cases.base.errors import CaseError, HexciteError, Write
from cases.base.phrases import Phrase, said
from cases.base.places import Place, places_of
from cases.base.text_formats import toml_value
from cases.contradictions import Doubt
from cases.editing import at, case_of_text, with_values, write_keys
from cases.readiness import readiness
from cases.schema import NO_TITLE, Case
from cases.table_problems import AT_KEY
from cases.tables import CASE_FILE, Part, is_needed
from hexcite.page.keys import (
    SIMULATED_BODY,
    choices_of,
    example_of,
    is_text,
    leaves,
    missing,
    part_of,
    typical,
    words_of,
)
from hexcite.page.refusals import Refusal, Refused, RefusedFields
from hexcite.page.units import Spelling, noun, spellings

FIXED = frozenset({"schema_version", "name", "template"})  # what a form does not change
_COMMA = re.compile(r"[+-]?\d+,\d+")  # a decimal sign
_NUMBER = re.compile(r"[+-]?(\d+(\.\d+)?)([eE][+-]?\d+)?")


@dataclass(frozen=True)
class Entry:
    """One value, or one that may be added.

    Args:
        name: in forms.
        noun: its key without the unit, in words.
        mark: whose it is: "mine", "example" (that of the case that this one was begun from), "typical", or "missing".
        needed: whether its table cannot do without it.
        doubts: sentences of the case's check about it.
        owners: names of the classes whose key it is.
    """

    name: str
    key: str
    noun: str
    text: str
    words: str
    mark: str
    choices: tuple[str, ...]
    spellings: tuple[Spelling, ...]
    needed: bool = False
    doubts: tuple[str, ...] = ()
    owners: tuple[str, ...] = ()

    @property
    def around(self) -> str:
        """The table that it stands in, in words: of a letter that says nothing alone."""
        return re.sub(r"\[\d+\]", "", self.name.split(".")[-2]).replace("_", " ") if "." in self.name else self.noun


@dataclass(frozen=True)
class Section:
    """The values of one table, and keys that it may have as well."""

    name: str
    words: str
    entries: tuple[Entry, ...]
    more: tuple[Entry, ...] = ()
    owners: tuple[str, ...] = ()

    @property
    def nouns(self) -> tuple[str, ...]:
        """What is in it; of what may be added where there is nothing else."""
        shown = self.entries or self.more
        return tuple(dict.fromkeys(entry.noun if len(entry.noun) > 1 else entry.around for entry in shown))

    @property
    def calls(self) -> bool:
        """Whether something in it is needed or doubtful."""
        return any(entry.needed or entry.doubts for entry in (*self.entries, *self.more))


@dataclass(frozen=True)
class Written:
    """The text of a case file with other values, and those that stand there otherwise than they were typed."""

    text: str
    converted: tuple[str, ...]


def digest(content: str) -> str:
    """Fingerprint of a file's text, by which a form knows that it was changed meanwhile."""
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def sections(content: str, case: Case | None) -> tuple[Section, ...]:
    """The values of a case file by table, in their order, then tables that it may have; empty where it is not TOML."""
    try:
        data = tomllib.loads(content)
    except tomllib.TOMLDecodeError:
        return ()
    example = example_of(data)
    begun = dict(leaves((), example)) if data.get("template") else {}
    doubts = () if case is None else case.doubts
    entries: dict[str, list[Entry]] = {}
    more: dict[str, list[Entry]] = {}
    for place, value in leaves((), data):
        if place[0] not in FIXED:
            part = part_of(place[:-1], data)
            mark = "mine"
            if (place in begun and begun[place] == value) or (place == ("title",) and value == NO_TITLE):
                mark = "example"
            elif part is not None and place[-1] in part.model_fields and not data.get("template"):
                mark = "typical" if _usual(data, example, place, part) == value else "mine"
            entries.setdefault(_table_of(place)[0], []).append(_entry(place, value, part, mark, doubts))
    nominal = data.get("nominal") or {}
    lacks = () if case is None else readiness(case)["plan"]
    for place, value in missing(data, case, content).items():
        entry = _entry(place, value, part_of(place[:-1], data), "missing")
        if not _asked(place[:-1], data, lacks):
            entry = replace(entry, needed=False)
        if place[:-1] == SIMULATED_BODY and place[-1] in nominal:
            entry = replace(entry, needed=False)  # not stated, it is that of [nominal]
        more.setdefault(_table_of(place)[0], []).append(entry)
    tables = dict.fromkeys([*entries, *more])
    return tuple(_section(name, data, entries.get(name, ()), more.get(name, ())) for name in tables)


def _asked(table: Place, data: Mapping[str, Any], lacks: Iterable[str]) -> bool:
    """Whether a case has a table, or a plan needs it, so that keys which it cannot do without are to be stated."""
    if at(data, table) is not None:
        return True
    for lack in (place for place in map(_place, lacks) if place == table[: len(place)]):
        part, inner = part_of(lack, data), table[len(lack) : len(lack) + 1]
        field = part.model_fields.get(str(inner[0])) if part is not None and inner else None
        if not inner or (field is not None and field.is_required()):
            return True
    return False


def _usual(data: Mapping[str, Any], example: Mapping[str, Any], place: Place, part: type[Part]) -> Any:
    """The value that would be proposed if there were none; None of texts and zeros, which many machines have."""
    value = typical(data, example, place, part)
    plain = isinstance(value, str | bool) or value in (None, 0.0) or (isinstance(value, list) and not any(value))
    return None if plain else value


def _entry(place: Place, value: Any, part: type[Part] | None, mark: str, doubts: Iterable[Doubt] = ()) -> Entry:
    key = str(place[-1])
    value_text = "" if value is None else value if isinstance(value, str) else toml_value(value)
    doubts_of_key = tuple(doubt for doubt in doubts if place in places_of(doubt))
    listed = isinstance(value, list) and all(isinstance(each, str) for each in value)
    choices = ("true", "false") if isinstance(value, bool) else () if listed else choices_of(part, key)
    ways = () if isinstance(value, str) else spellings(key, () if part is None else part.model_fields.keys())
    field = None if part is None else part.model_fields.get(key)
    needed = mark == "missing" and field is not None and is_needed(field)
    words = words_of(part).get(key, "")
    return Entry(
        named(place), key, noun(key), str(value_text), words, mark, choices, ways, needed, doubts_of_key, _owners(part)
    )


def named(place: Place) -> str:
    """The name of a value in a form: machine.chain.joints[0].name."""
    text = ""
    for key in place:
        text += f"[{key}]" if isinstance(key, int) else f".{key}" if text else key
    return text


def _table_of(place: Place) -> tuple[str, str]:
    """The table that a value is shown in, of two keys at most or an entry of a list, and its key there."""
    numbers = [k for k, key in enumerate(place[:-1]) if isinstance(key, int)]
    two = len(place) > 3 or place[0] in ("controller", "limits") or place[:2] == ("machine", "chain")
    cut = numbers[0] + 1 if numbers else min(2 if two else 1, len(place) - 1)
    return named(place[:cut]), named(place[cut:])


def _place(table: str) -> Place:
    return tuple(int(key) if key.isdigit() else key for key in re.findall(r"\w+", table))


def _section(name: str, data: Mapping[str, Any], entries: Iterable[Entry], more: Iterable[Entry]) -> Section:
    part = part_of(_place(name), data) if name else None
    words = "" if part is None else " ".join((part.__doc__ or "").split())
    return Section(name, words, tuple(entries), tuple(more), _owners(part))


def _owners(part: type[Part] | None) -> tuple[str, ...]:
    return () if part is None else tuple(base.__name__ for base in part.__mro__ if issubclass(base, Part))


def edited(content: str, fields: Mapping[str, str], file: Path = Path(CASE_FILE)) -> Written:
    """The text of a case file with other values, comments and order as they are; raises Refused, where fields cannot
    be RefusedFields with all of them.

    Args:
        fields: `v.NAME` the text of a value, `u.NAME` the name of the spelling that it is in, `on.NAME` any text where
            a key, or all of a table, is to be added with the text `w.NAME`.
    """
    tables, converted, refused = changed(content, fields)
    if refused:
        raise RefusedFields(refused)
    try:
        return Written(with_values(file, content, tables), converted)
    except HexciteError as error:
        raise Refused.of(error.sentences) from error


class Remark(NamedTuple):
    """A sentence on a case, names of the fields that it is about, and texts of fields that it proposes."""

    sentence: str
    fields: tuple[str, ...]
    take: Mapping[str, str]


def remarks(case: Case | None, data: Mapping[str, Any]) -> tuple[Remark, ...]:
    """What a person should look at in a case, with the fields of its form."""
    there = {place for place, _ in leaves((), data)}
    return tuple(_remark(each, there) for each in (() if case is None else case.remarks))


def _remark(sentence: Phrase, there: Collection[Place]) -> Remark:
    if not isinstance(sentence, Doubt):
        return Remark(sentence, (), {})
    take = {named(write.place): toml_value(write.value) for write in sentence.writes if write.place in there}
    fields = tuple(named(place) for place in places_of(sentence) if place in there)
    return Remark(sentence, fields, take if len(take) == len(sentence.writes) else {})


class Changed(NamedTuple):
    """The tables of a case file with the values of a form that can be."""

    tables: dict[str, Any]
    converted: tuple[str, ...]  # values that stand there otherwise than they were typed
    refused: Mapping[str, Refused]  # by their fields; in the tables they are as before


def changed(content: str, fields: Mapping[str, str]) -> Changed:
    """The tables of a case file with other values; fields as of `edited`. Raises Refused for a field of no value."""
    data = tomllib.loads(content)
    tables, converted, refused = copy.deepcopy(data), _Conversions(), dict[str, Refused]()
    there = {named(place): (place, value) for place, value in leaves((), data)}
    on = [name[3:] for name in fields if name.startswith("on.")]
    more = missing(data, None, content) if on else {}
    offered = {named(place): (place, value) for place, value in more.items()}
    for field, text in fields.items():
        kind, _, name = field.partition(".")
        if kind not in ("v", "w"):
            continue
        values = there if kind == "v" else offered
        if kind == "w" and not on:
            continue
        if name not in values or values[name][0][0] in FIXED:
            raise Refused("no_such_value", place=name)
        place, before = values[name]
        part = part_of(place[:-1], data)
        if kind == "w" and not any(name == each or (name.startswith(f"{each}.") and text.strip()) for each in on):
            continue
        if before is None:
            before = "" if is_text(part, str(place[-1])) else _ANY
        ways = {way.name: way for way in spellings(str(place[-1]), () if part is None else part.model_fields.keys())}
        way = ways.get(fields.get(f"u.{name}", ""), next(iter(ways.values()), None))
        try:
            after = _value(name, text, before)
        except Refused as error:
            refused[field] = error
            continue
        if way is not None and (way.factor != 1.0 or way.key != place[-1]):
            after = _scaled(after, way.factor)
            converted.append((*place[:-1], way.key), f"= {toml_value(after)} ({text.strip()} {way.unit})")
            _drop(tables, place)
            place = (*place[:-1], way.key)
        elif kind == "v" and after == before:
            continue
        elif not isinstance(after, str) and _reads_otherwise(text, after):
            converted.append(place, f"= {toml_value(after)} ({text.strip()})")
        _put(tables, place, after)
    return Changed(tables, converted.lines(), refused)


class _Conversions:
    """Values that stand in the file otherwise than they were typed, those of several entries of a list together."""

    def __init__(self) -> None:
        self._places: dict[tuple[str, str], list[Place]] = {}

    def append(self, place: Place, what: str) -> None:
        """Adds one: its place, and what became of it."""
        self._places.setdefault((re.sub(r"\[\d+\]", "[..]", named(place)), what), []).append(place)

    def lines(self) -> tuple[str, ...]:
        """A line for each, of several that are alike one with the number of them."""
        return tuple(
            f"{named(places[0])} {what}" if len(places) == 1 else f"{len(places)} x {name} {what}"
            for (name, what), places in self._places.items()
        )


def write_motion_box(file: Path, box: Mapping[str, Any]) -> None:
    """Writes ends of `[limits.motion]`, by key or by name of a joint; raises Refused where they do not fit the case."""
    motion = at(tomllib.loads(file.read_text(encoding="utf-8")), ("limits", "motion")) or {}
    joints = {joint.get("name"): (k, joint) for k, joint in enumerate(motion.get("joints", ()))}
    writes = []
    for key, ends in box.items():
        place: Place = ("limits", "motion", key)
        if key in joints:
            k, joint = joints[key]
            place = ("limits", "motion", "joints", k, next(name for name in joint if name.startswith("position_")))
        elif key not in motion:
            raise Refused("no_such_value", place=f"limits.motion.{key}")
        writes.append(Write(place, [float(end) for end in ends]))
    try:
        write_keys(file, writes)
    except HexciteError as error:
        raise Refused.of(error.sentences) from error


_ANY = object()  # a number or a list, where nothing stood before


def _scaled(value: Any, factor: float) -> Any:
    """A number, or each of a list, in another unit; twelve digits, so that whole numbers stay whole."""
    if isinstance(value, list):
        return [_scaled(each, factor) for each in value]
    return float(f"{float(value) * factor:.12g}") if isinstance(value, int | float) else value


def _drop(data: Any, place: Place) -> None:
    holder = at(data, place[:-1])
    if isinstance(holder, dict):
        holder.pop(place[-1], None)


def _put(data: Any, place: Place, value: Any) -> None:
    """Puts a value where it belongs; tables and lists around it are made."""
    for key, following in pairwise(place):
        empty: Any = [] if isinstance(following, int) else {}
        if isinstance(key, int):
            while len(data) <= key:
                data.append({})
            data = data[key]
        else:
            data = data.setdefault(key, empty)
    data[place[-1]] = value


def _value(name: str, text: str, before: Any) -> Any:
    """What was typed, as a value of the kind that stood there; numbers with a comma as decimal sign too."""
    text = text.strip()
    if isinstance(before, str):
        if len(text) > 2000 or any(ord(letter) < 32 for letter in text):
            raise Refused("no_line", place=name)
        return text
    numbers = before is _ANY or (isinstance(before, list) and all(map(_plain, before)))
    try:
        value = tomllib.loads(f"value = {_list(text, before) if numbers else _point(text)}\n")
    except (tomllib.TOMLDecodeError, RecursionError):
        value = {}
    kinds: tuple[type, ...] = (int, float)
    if before is _ANY:
        kinds = (int, float, list)
    elif isinstance(before, bool | list):
        kinds = (type(before),)
    after = value.get("value")
    if len(value) != 1 or not isinstance(after, kinds) or (bool not in kinds and isinstance(after, bool)):
        key = "no_true_or_false" if bool in kinds else "no_list" if kinds == (list,) else "no_number"
        raise Refused(key, place=name, text=text)
    whole = isinstance(before, float) or before is _ANY
    return float(after) if whole and isinstance(after, int) and not isinstance(after, bool) else after


def _reads_otherwise(text: str, value: Any) -> bool:
    """Whether the numbers of a value are not those that a reader sees in what was typed, in their order."""
    seen = [part for part in re.split(r"[\s,;\[\]]+", text) if part]
    numbers = value if isinstance(value, list) else [value]
    plain = all(map(_NUMBER.fullmatch, seen)) and all(map(_plain, numbers))
    return toml_value(value) != text.strip() if not plain else [float(part) for part in seen] != numbers


def _plain(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _point(text: str) -> str:
    """A number with a point where it was typed with a comma."""
    return text.replace(",", ".") if _COMMA.fullmatch(text) else text


def _list(text: str, before: Any) -> str:
    """A list of numbers as people write it, as TOML has it; what can be read in two ways stays, and is refused.

    Semicolons or blanks part numbers that may have decimal commas or points: `0,5; 120; 240`. Commas part numbers where
    a blank follows each (`0, 120, 240`), and without any blanks where there are three or more, as many as before.
    `±60` and `+-60` are two ends, `200` stands for each of three or more that were equal before, and two dots stand
    between two ends (`-60 .. 60`).
    """
    own = text[1:-1].strip() if text[:1] == "[" and text[-1:] == "]" else text
    count = len(before) if isinstance(before, list) else 0
    if count == 2 and (ends := re.fullmatch(r"(?:±|\+/?-)\s*([\d.,]+)", own)):
        parts = [f"-{_point(ends[1])}", _point(ends[1])]
    elif count == 2 and (ends := re.fullmatch(r"(\S+)\s*\.\.\.?\s*(\S+)", own)):
        parts = [_point(ends[1]), _point(ends[2])]
    elif count > 2 and before[0] and len(set(before)) == 1 and _NUMBER.fullmatch(_point(own)):
        parts = [_point(own)] * count
    elif ";" in own:
        parts = [_point(part.strip()) for part in own.split(";")]
    elif own != text or (before is _ANY and not re.search(r"\s", own)):
        return _point(text)
    elif "," not in own:
        parts = own.split()
    else:
        apart = re.fullmatch(r"[^,]*(,\s+[^,]*)*", own) is not None
        tight = re.search(r"\s", own) is None and isinstance(before, list) and 2 < len(before) == own.count(",") + 1
        parts = [part.strip() for part in own.split(",")] if apart or tight else []
    return f"[{', '.join(parts)}]" if len(parts) > 1 and all(map(_NUMBER.fullmatch, parts)) else text


def case_of(content: str, file: Path, given: Collection[str] = ()) -> Case:
    """The case of a text that is not written yet; raises Refused, which names the file that it is for.

    Args:
        given: names of the form's fields.
    """
    try:
        return case_of_text(content, Path(file.parent.name, CASE_FILE))
    except CaseError as error:
        raise at_fields(tomllib.loads(content), error, given) from error
    except HexciteError as error:
        raise Refused.of(error.sentences) from error


def at_fields(data: Mapping[str, Any], error: CaseError, given: Collection[str] = ()) -> RefusedFields:
    """The problems of a case at the fields that they are about; what is about none has its file before it.

    Args:
        data: tables of the case, with what was typed.
        given: names of the form's fields, `w.NAME` those of keys that were not there.
    """
    there = {named(place) for place, _ in leaves((), data)}
    fields, others = dict[str, Refusal](), list[Refusal]()
    for problem, sentence in zip(map(said, error.problems or ("",)), error.sentences, strict=False):
        names = [named(each) for place in places_of(problem) for each in (place, place[:-1])]  # of a list its entries
        name = next((each for each in names if each in there), "")
        field = f"w.{name}" if f"w.{name}" in given and f"v.{name}" not in given else f"v.{name}"
        if name and field not in fields:
            keyed = problem.code == AT_KEY
            key, words = (problem.values["key"], problem.values["words"]) if keyed else ("", problem)
            fields[field] = Refused("", sentence=words, place=key)
        else:
            others.append(Refused("", sentence=sentence))
    return RefusedFields(fields, others)


def save(file: Path, content: str) -> None:
    """Writes a case file as a whole, with the rights that it had."""
    mode = file.stat().st_mode
    with atomic_file(file) as part:
        part.write_text(content, encoding="utf-8")
    file.chmod(mode)
