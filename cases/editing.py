"""Tables and keys of a case file replaced by others, and nothing else: comments, order and layout of the rest stay."""

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from cases.base.atomic import atomic_file
from cases.base.errors import CaseError, Code, FileProblem, Write
from cases.base.file_reading import read_whole
from cases.base.places import Place, placed

if TYPE_CHECKING:
    from cases.schema import Case

Change = tuple[str, Any, Any]
"""Dotted key, value before and value after; None: it is not there."""


_SECTIONS = ("columns", "files")  # tables of these names get sections of their own, others are written in one line
MOST_KEPT = 1000  # earlier versions of a case file that are kept beside it
_MARK = "\ufeff"  # of UTF-8, as Windows editors write it


def changes_of(file: Path, table: str, values: Mapping[str, Any]) -> tuple[Change, ...]:
    """What would change in a file if a table of it became `values`; raises CaseError where it cannot be read."""
    return tuple(_changes(table, _table(file, _content(file)[1], table), values))


def write_table(file: Path, table: str, values: Mapping[str, Any]) -> tuple[Change, ...]:
    """Makes a table of a TOML file `values`, and writes the file as a whole or not at all; returns what changed.

    Keys whose values stay keep their place and their comments. Raises CaseError where the file cannot be read, and
    FileProblem where it cannot be written, or is written in a way in which only this table cannot be changed.
    """
    text, before = _content(file)
    changes = tuple(_changes(table, _table(file, before, table), values))
    if not changes:
        return ()
    edited = _edited(file, text, {table: values})
    above, below = _around(text, table)
    alone = edited.startswith(above) and edited.endswith(below)
    if not alone or _parsed(edited) != {**before, table: dict(values)}:
        raise FileProblem(
            place=file,
            problem=f"[{table}] cannot be replaced alone as it is written there",
            remedy="paste the table by hand",
            code=Code.NOT_SUPPORTED,
        )
    _write(file, edited)
    return changes


class Rewritten(NamedTuple):
    """What became of a case file."""

    changes: tuple[Change, ...]
    earlier: Path | None  # the file as it was before; None where nothing changed


def write_keys(file: Path, writes: Iterable[Write]) -> Rewritten:
    """Writes keys into a case file, as a whole or not at all; the earlier file is kept beside it, numbered.

    Args:
        file: of a case.
        writes: places with their values; tables on the way to a place are made where there are none.

    Raises:
        CaseError: the file cannot be read, has no such entry of a list, or is not a case with these values.
        FileProblem: it cannot be written, or is written in a way in which these keys cannot be changed alone.
    """
    text, before = _content(file)
    after = deepcopy(before)
    for place, value, *_ in writes:
        _set(file, after, tuple(place), value)
        if value is None:
            _without_empty(after, tuple(place[:-1]))
    changes = tuple(_changes("", before, after))
    if not changes:
        return Rewritten((), None)
    edited = with_values(file, text, after)
    case_of_text(edited, file)
    earlier = _kept(file)
    _write(file, edited)
    return Rewritten(changes, earlier)


def case_of_text(text: str, file: Path) -> "Case":
    """The case of a text that is not written yet; raises CaseError, which names the file that it is for."""
    from cases.schema import Case
    from cases.tables import tables_in, tables_of  # NumPy, which `hexcite --help` does without

    return tables_of(Case, file, tables_in(text.encode(), file))


def _set(file: Path, values: Any, place: tuple[str | int, ...], value: Any) -> None:
    """Sets a value of nested tables; None takes it away."""
    for k, part in enumerate(place):
        table = values.get(part) if isinstance(values, dict) else None
        if isinstance(part, int):
            if not isinstance(values, list) or not 0 <= part < len(values):
                raise CaseError(
                    file=file,
                    key=placed(place[: k + 1]),
                    problem="there is no such entry",
                    remedy="write it by hand",
                    code=Code.UNKNOWN,
                )
            table = values[part]
        elif not isinstance(values, dict):
            raise CaseError(
                file=file,
                key=placed(place[: k + 1]),
                problem="is not in a table there",
                remedy="write it by hand",
                code=Code.WRONG_KIND,
            )
        if k < len(place) - 1:
            if table is None:
                if value is None:
                    return
                table = values[part] = {}
            values = table
        elif value is None:
            values.pop(part, None)
        else:
            values[part] = deepcopy(value)


def _without_empty(values: Any, place: tuple[str | int, ...]) -> None:
    """Takes away the tables on a place in which nothing is left."""
    while place:
        holder = values
        for part in place[:-1]:
            holder = holder.get(part, {}) if isinstance(holder, dict) else holder[part]
        if not isinstance(holder, dict) or holder.get(place[-1]) != {}:
            return
        del holder[place[-1]]
        place = place[:-1]


def _kept(file: Path) -> Path:
    """A copy of a file beside it, under the first number that is free."""
    content = file.read_bytes()
    for k in range(1, MOST_KEPT):
        earlier = file.with_name(f"{file.stem}-{k}{file.suffix}")
        try:
            with open(earlier, "xb") as stream:
                stream.write(content)
            return earlier
        except FileExistsError:
            continue
        except OSError as error:
            raise FileProblem.of(error) from error
    raise FileProblem(
        place=file,
        problem=f"has {MOST_KEPT - 1} earlier versions beside it",
        remedy="move them away",
        code=Code.NOT_WRITABLE,
    )


def _write(file: Path, text: str) -> None:
    """Writes a file as a whole, with the rights that it had."""
    mode = file.stat().st_mode
    with atomic_file(file) as part:
        part.write_bytes(text.encode())
    file.chmod(mode)


def with_values(file: Path, text: str, wanted: Mapping[str, Any]) -> str:
    """The text of a TOML file with other values in it; what stays equal keeps its place and its comments.

    A key that stands in the text as a comment is switched on where it stands. Raises FileProblem where the file is
    written in a way in which only these values cannot be changed.
    """
    text = _switched_on(text, wanted)
    before = _parsed(text) or {}
    keys = [key for key in {**before, **wanted} if before.get(key) != wanted.get(key)]
    edited = _edited(file, text, {key: wanted.get(key) for key in keys})
    if _parsed(edited) != wanted:
        raise FileProblem(
            place=file,
            problem="these keys cannot be replaced alone as it is written there",
            remedy="write them by hand",
            code=Code.NOT_SUPPORTED,
        )
    return edited


_HEADER = re.compile(r"(#[ \t]?)?(\[\[?)[ \t]*([\w.-]+)[ \t]*\]\]?(?=[ \t]*(#|\r?$))")
_COMMENTED = re.compile(r"#[ \t]?(\w+)[ \t]*=[ \t]*(.*?)(\r?)$")
_TO_DO = "TO BE FILLED IN"  # what comments say of values that no example has


def commented(text: str) -> dict[Place, Any]:
    """Values of keys that a TOML file has as comments, but for those that are still to be filled in."""
    examples = dict[Place, Any]()
    lines = text.split("\n")
    for _, place, value, header, remark in _comments(text):
        if not remark.startswith(_TO_DO) and _TO_DO not in lines[header]:
            examples[place] = (_parsed(f"value = {value}") or {}).get("value")
    return {place: value for place, value in examples.items() if value is not None}


def _comments(text: str) -> Iterator[tuple[int, Place, str, int, str]]:
    """Keys in comments: line, place, what stands there, line of the header above, and the remark behind it."""
    counts, table, header, listed, number = dict[str, int](), "", 0, False, 0
    for k, line in enumerate(text.split("\n")):
        if header_match := _HEADER.match(line):
            header, listed, table = k, header_match[2] == "[[", header_match[3]
            number = counts[table] = counts.get(table, -1) + 1
        elif table and (commented := _COMMENTED.match(line)):
            value, _, remark = commented[2].partition(" # ")
            parents: Place = (*table.split("."), number) if listed else tuple(table.split("."))
            yield k, (*parents, commented[1]), value, header, remark


def _switched_on(text: str, wanted: Mapping[str, Any]) -> str:
    """The text with those keys that it has as comments, each where it stands, as far as this gives wanted values."""
    from cases.base.text_formats import toml_value

    before, lines = _parsed(text) or {}, text.split("\n")
    for k, place, _, header, remark in _comments(text):
        value = at(wanted, place)
        if value is None or isinstance(value, Mapping) or at(before, place) is not None:
            continue
        lines[header] = re.sub(r"^#[ \t]?", "", lines[header])
        remark = "" if not remark.strip() or remark.startswith(_TO_DO) else f" # {remark.rstrip()}"
        lines[k] = f"{place[-1]} = {toml_value(value)}{remark}" + ("\r" if lines[k].endswith("\r") else "")
    after = "\n".join(lines)
    parsed = _parsed(after)
    return after if parsed is not None and _within(parsed, {**wanted}) else text


def at(values: Any, place: Place) -> Any:
    """The value at a place; None where there is none."""
    for key in place:
        if isinstance(key, int):
            values = values[key] if isinstance(values, list) and key < len(values) else None
        else:
            values = values.get(key) if isinstance(values, Mapping) else None
    return values


def _within(part: Any, whole: Any) -> bool:
    """Whether tables have no keys, and lists of tables no entries, that others do not have; values may differ."""
    if isinstance(part, Mapping) and isinstance(whole, Mapping):
        return all(key in whole and _within(part[key], whole[key]) for key in part)
    if isinstance(part, list) and isinstance(whole, list) and any(isinstance(each, Mapping) for each in part):
        return len(part) == len(whole) and all(map(_within, part, whole))
    return isinstance(part, Mapping) == isinstance(whole, Mapping)


def _parsed(text: str) -> dict[str, Any] | None:
    """The values of TOML, with a mark of UTF-8 or without; None where it is not TOML."""
    try:
        return tomllib.loads(text.removeprefix(_MARK).replace("\r\n", "\n"))
    except tomllib.TOMLDecodeError:
        return None


def _content(file: Path) -> tuple[str, dict[str, Any]]:
    """Text and values of a file; raises CaseError where it cannot be read."""
    from cases.tables import MOST_BYTES, content_of_tables  # NumPy, which `hexcite --help` does without

    values = content_of_tables(file)
    return read_whole(file, MOST_BYTES).decode(), values


def _table(file: Path, content: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    value = content.get(name, {})
    if not isinstance(value, dict):
        raise FileProblem(
            place=file,
            problem=f"{name} = {value!r} is not a table",
            remedy=f"write [{name}] in its place",
            code=Code.WRONG_KIND,
        )
    return value


def _changes(name: str, before: Mapping[str, Any], after: Mapping[str, Any]) -> Iterator[Change]:
    for key in dict.fromkeys((*before, *after)):
        old, new = before.get(key), after.get(key)
        if isinstance(old, dict) and isinstance(new, dict):
            yield from _changes(f"{name}.{key}" if name else key, old, new)
        elif old != new:
            yield f"{name}.{key}" if name else key, old, new


def _around(text: str, table: str) -> tuple[str, str]:
    """The text above the first section of a table, and that below its last, headers of other sections first."""
    headers = [*re.finditer(r"^[ \t]*+\[++([^\]\n]++)\]", text, re.MULTILINE)]
    positions = [k for k, header in enumerate(headers) if header[1].partition(".")[0].strip() == table]
    if not positions:
        return "", ""
    below = headers[positions[-1] + 1].start() if positions[-1] + 1 < len(headers) else len(text)
    return text[: headers[positions[0]].start()], text[below:]


def _edited(file: Path, text: str, values: Mapping[str, Any]) -> str:
    """The text with tables and values at its top replaced."""
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    crlf = "\r\n" in text and "\n" not in text.replace("\r\n", "")
    mark = _MARK if text.startswith(_MARK) else ""
    plain = text.removeprefix(mark)
    try:
        document = tomlkit.parse(plain.replace("\r\n", "\n") if crlf else plain)
        for key, value in values.items():
            if value is None:
                del document[key]
            elif isinstance(value, Mapping):
                if key not in document:
                    document[key] = tomlkit.table()
                _replace(document[key], value)
            else:
                document[key] = _item(value, False)
        edited = tomlkit.dumps(document)
    except (TOMLKitError, TypeError, AttributeError, KeyError) as error:
        tables = " and ".join(f"[{key}]" for key in values)
        raise FileProblem(
            place=file,
            problem=f"{tables} cannot be replaced alone ({error})",
            remedy="write that by hand",
            code=Code.NOT_SUPPORTED,
        ) from error
    return mark + (edited.replace("\n", "\r\n") if crlf else edited)


def _replace(table: Any, values: Mapping[str, Any]) -> None:
    """Makes a table of tomlkit's hold values; what is equal is not touched."""
    import tomlkit

    below = _taken_from(_last_section(table))
    for key in [key for key in table if key not in values]:
        del table[key]
    for key, value in values.items():
        if isinstance(value, Mapping) and isinstance(table.get(key), Mapping):
            _replace(table[key], value)
        elif _of_tables(value) and _of_tables(table.get(key)) and len(value) == len(table[key]):
            for inner, entries in zip(table[key], value, strict=True):
                if inner.unwrap() != entries:
                    _replace(inner, entries)
        elif key not in table or table[key].unwrap() != value:
            table[key] = _item(value, key in _SECTIONS and isinstance(table, tomlkit.items.Table))
    last = _last_section(table)
    for item in below:
        last.add(item)


def _of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(each, Mapping) for each in value)


def _last_section(table: Any) -> Any:
    """The last section of a table: its own, or that of the last table in it."""
    import tomlkit

    if isinstance(table, tomlkit.items.Table):
        inner = [item for _, item in table.value.body if isinstance(item, tomlkit.items.Table)]
        return _last_section(inner[-1]) if inner else table
    return None


def _taken_from(section: Any) -> list[Any]:
    """Blank lines at the end of a section and what stands below them, taken from it: they belong to what follows."""
    body = [] if section is None else section.value.body
    end = len(body)
    while end and body[end - 1][0] is None:
        end -= 1
    blank = next((k for k in range(end, len(body)) if not body[k][1].as_string().strip()), len(body))
    items = [item for _, item in body[blank:]]
    del body[blank:]
    return items


def _item(value: Any, section: bool) -> Any:
    """A value as an item of tomlkit's: tables in one line, or as a section."""
    import tomlkit

    if section and isinstance(value, list | tuple) and value and all(isinstance(v, Mapping) for v in value):
        tables = tomlkit.aot()
        for inner in value:
            tables.append(_item(inner, True))
        return tables
    if isinstance(value, list | tuple):
        array = tomlkit.array()
        for inner in value:
            array.append(_item(inner, False))
        return array
    if not isinstance(value, Mapping):
        return tomlkit.item(value)
    item: Any = tomlkit.table() if section else tomlkit.inline_table()
    for key, inner in value.items():
        item[key] = _item(inner, section and key in _SECTIONS)
    return item
