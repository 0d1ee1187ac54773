"""One table of a case file replaced by another, and nothing else: comments, order and layout of the rest stay."""

import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from cases.base.errors import FileProblem
from cases.base.files import atomic_file, read_whole

Change = tuple[str, Any, Any]
"""Dotted key, value before and value after; None: it is not there."""


_SECTIONS = ("columns", "files")  # tables of these names get sections of their own, others are written in one line
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
    edited = _edited(file, text, table, values)
    above, below = _around(text, table)
    alone = edited.startswith(above) and edited.endswith(below)
    if not alone or _parsed(edited) != {**before, table: dict(values)}:
        raise FileProblem(file, f"[{table}] cannot be replaced alone as it is written there", "paste the table by hand")
    mode = file.stat().st_mode
    with atomic_file(file) as part:
        part.write_bytes(edited.encode())
    file.chmod(mode)
    return changes


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
        raise FileProblem(file, f"{name} = {value!r} is not a table", f"write [{name}] in its place")
    return value


def _changes(name: str, before: Mapping[str, Any], after: Mapping[str, Any]) -> Iterator[Change]:
    for key in dict.fromkeys((*before, *after)):
        old, new = before.get(key), after.get(key)
        if isinstance(old, dict) and isinstance(new, dict):
            yield from _changes(f"{name}.{key}", old, new)
        elif old != new:
            yield f"{name}.{key}", old, new


def _around(text: str, table: str) -> tuple[str, str]:
    """The text above the first section of a table, and that below its last, headers of other sections first."""
    headers = [*re.finditer(r"^[ \t]*\[+[ \t]*([^\]\n]+?)[ \t]*\]", text, re.MULTILINE)]
    own = [k for k, header in enumerate(headers) if re.split(r"\s*\.\s*", header[1])[0] == table]
    if not own:
        return "", ""
    below = headers[own[-1] + 1].start() if own[-1] + 1 < len(headers) else len(text)
    return text[: headers[own[0]].start()], text[below:]


def _edited(file: Path, text: str, table: str, values: Mapping[str, Any]) -> str:
    """The text with a table replaced."""
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    crlf = "\r\n" in text and "\n" not in text.replace("\r\n", "")
    mark = _MARK if text.startswith(_MARK) else ""
    plain = text.removeprefix(mark)
    try:
        document = tomlkit.parse(plain.replace("\r\n", "\n") if crlf else plain)
        if table not in document:
            document[table] = tomlkit.table()
        _replace(document[table], values)
        edited = tomlkit.dumps(document)
    except (TOMLKitError, TypeError, AttributeError, KeyError) as error:
        raise FileProblem(file, f"[{table}] cannot be replaced alone ({error})", "paste the table by hand") from error
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
        elif key not in table or table[key].unwrap() != value:
            table[key] = _item(value, key in _SECTIONS and isinstance(table, tomlkit.items.Table))
    last = _last_section(table)
    for item in below:
        last.add(item)


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
    taken = [item for _, item in body[blank:]]
    del body[blank:]
    return taken


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
