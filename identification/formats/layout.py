"""An unknown text file: its separator, decimal sign and header, and what its columns mean by their names."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cases.errors import RecordingError
from cases.machine import POSE
from cases.recording_format import (
    ACCELEROMETER,
    BAR_FORCES,
    CLOCK,
    COLUMNS,
    DRIVES,
    OVERRIDE,
    ROLE_UNITS,
    ROTATION,
    STRUTS,
    TICKS,
    TRIGGER,
    WRENCH,
    RecordingFormat,
)
from cases.units import Array
from identification.formats.table import is_value, split
from identification.formats.text import LONGEST_LINE, cells, read_head, section_of, table_of

_SEPARATORS = (";", "\t", "|", ",", " ")
_SAMPLE = 200  # lines from which the fields are known
_NUMERIC = 0.7  # share of a column's fields, from which on it is numeric


def look_at_text(file: Path) -> tuple[list[str], list[str], dict[int, Array], dict[str, Any]]:
    """Names, units, values of columns of numbers by position, settings that read the file; raises RecordingError."""
    raw = read_head(file)
    if len(raw) > 1 and file.stat().st_size >= LONGEST_LINE:
        raw = raw[:-1]  # what was read ends somewhere in this line
    encoding, lines = _decoded(file, raw)
    scope = next((d for d in "\t;," if lines[0].startswith(f"Name{d}")), None)
    form, numeric = _dialect(file, lines, encoding, scope)
    first = next(k for k, line in enumerate(lines) if _is_row(form, line, numeric))
    head = [cells(line, form) for line in lines[:first]]
    names_row = max(k for k, row in enumerate(head, 1) if row[:1] == ["Name"]) if scope else _names_row(head, numeric)
    names = head[names_row - 1] if names_row else [f"column {k}" for k in range(1, len(numeric) + 1)]
    below = (row for row in head[names_row:] if len(row) == len(names) and any(row))
    units = next(
        (row for row in below if all(not cell or unit_of(cell) or cell.strip("[()] ") in "-V" for cell in row)),
        [""] * len(names),
    )
    settings: dict[str, Any] = {}
    if scope:
        settings = {"format": "twincat-scope", "decimal": form.decimal}
    elif not names_row and lines[0].endswith(" "):
        settings = {"format": "halsampler", "column_names": names[:-1]}
    else:
        settings |= {"delimiter": form.separator} if form.separator != "," else {}
        settings |= {"decimal": form.decimal} if form.decimal != "." else {}
        settings |= {"header_rows": first} if first != bool(names_row) else {}
        settings |= {"names_row": names_row} if names_row not in (0, first) else {}
        settings |= {} if names_row else {"column_names": names}
    settings |= {"encoding": encoding} if encoding != "utf-8" else {}
    wanted = {str(k): k for k, number in enumerate(numeric) if number and names[k]}
    below_rows = 1 if scope else 0  # a line EOF may stand there
    values = table_of(file, section_of(file, first, below_rows, len(wanted)), names, wanted, form, None).values
    return names, units, {wanted[k]: column for k, column in values.items() if np.isfinite(column).any()}, settings


def _decoded(file: Path, raw: Sequence[bytes]) -> tuple[str, list[str]]:
    for encoding in ("utf-8", "cp1252"):
        try:
            lines = [line.decode(encoding) for line in raw]
        except UnicodeDecodeError:
            continue
        if not any("\0" in line for line in lines):
            return encoding, lines
    raise RecordingError(file, "is not text", "export the recording as CSV or Parquet")


def _dialect(file: Path, lines: Sequence[str], encoding: str, scope: str | None) -> tuple[RecordingFormat, list[bool]]:
    """The separator and decimal sign by which most columns are numbers, and which of them are."""
    sample = [line for line in lines if line.strip()][-_SAMPLE:-1]
    best, numeric = None, [True]
    for separator in _SEPARATORS if scope is None else (scope,):
        for decimal in ".,":
            if decimal == separator:
                continue
            form = RecordingFormat(delimiter=separator, decimal=decimal, encoding=encoding)
            rows = [split(line, separator) for line in sample]
            count = Counter(map(len, rows)).most_common(1)[0][0] if rows else 0
            columns = list(zip(*(row for row in rows if len(row) == count), strict=True))
            numbers = [
                any(map(str.strip, column)) and sum(is_value(field, form) for field in column) >= _NUMERIC * len(column)
                for column in columns
            ]
            if sum(numbers) > sum(numeric):
                best, numeric = form, numbers
    if best is None or (best.separator == " " and any("  " in line.strip() for line in sample)):
        problem = "holds no table of numbers with one character between two fields"
        raise RecordingError(file, problem, "export it with a comma or semicolon between the fields")
    return best, numeric


def _is_row(form: RecordingFormat, line: str, numeric: Sequence[bool]) -> bool:
    """Whether a line is one of the table's: as many fields, numbers where others have such, not all of them empty."""
    fields = split(line, form.separator)
    numbers = [field for field, number in zip(fields, numeric, strict=False) if number]
    return (
        len(fields) == len(numeric) and any(map(str.strip, numbers)) and all(is_value(field, form) for field in numbers)
    )


def _names_row(head: Sequence[Sequence[str]], numeric: Sequence[bool]) -> int:
    """The line of the header that names most columns differently, counted from 1; 0 where there is none."""
    distinct = [len(set(row)) if len(row) == len(numeric) else 0 for row in head]
    return distinct.index(max(distinct)) + 1 if any(distinct) else 0


_UNITS = {
    "µm": "um", "µs": "us", "μm": "um", "μs": "us", "sec": "s", "msec": "ms", "°": "deg", "grad": "deg", "N*m": "Nm",
    "N m": "Nm", "N·m": "Nm", "N*mm": "Nmm",
}  # fmt: skip
_KNOWN = {*TICKS, *(unit for units in ROLE_UNITS.values() for unit in units)} - {"filetime", "1"}
_BRACKETED = re.compile(r"[\[(<]\s*([^\])>]*?)\s*[\])>]")
_SUFFIX = re.compile(r"(?<=[A-Za-z0-9])[_ /]+([A-Za-zµμ%/]+)$")
_NOT_MEASURED = re.compile(r"soll|target|cmd|command|setp|desired|_ref|vel|speed|geschw|ld_?\d|qd_?\d")
_GROUPS = (STRUTS, DRIVES, POSE, ROTATION, ACCELEROMETER, BAR_FORCES, WRENCH, (CLOCK,), (TRIGGER,), (OVERRIDE,))
"""Columns that belong together: one of them is nothing without the others."""
# Names without separators -> a group, and the number in it of the first that the pattern can name.
_PATTERNS: tuple[tuple[str, tuple[str, ...], int], ...] = (
    (r"^(?:t|ts|time|zeit|timestamp|stamp|zeitstempel|elapsed.*)$", (CLOCK,), 1),
    (r"^(?:trig.*|ttl.*|gate|marker|.*digitalout.*|.*aout.*)$", (TRIGGER,), 1),
    (r"^(?:ovr|.*override.*)$", (OVERRIDE,), 1),
    (r"^(?:r|rot)([123])([123])$", ROTATION, 1),
    (r"^(?:a|roll|phi)$", POSE, 4),
    (r"^(?:b|pitch|theta)$", POSE, 5),
    (r"^(?:c|yaw|psi)$", POSE, 6),
    (r"(?:^|[^a-z])(?:r|rot)([xyz])$", POSE, 4),
    (r"^([xyz])(?:pos|act|ist)?$", POSE, 1),
    (r"(?:^f|force|kraft|ftf)([xyz])$", WRENCH, 1),
    (r"(?:^m|^t|moment|torque|drehmoment|ftt)([xyz])$", WRENCH, 4),
    (r"(?:^a|acc|accel)([xyz])$", ACCELEROMETER, 1),
    (r"wrench\D*(\d)$", WRENCH, 1),
    (r"(?:strut|leg|bein|strebe)\D*(\d)|^(?:l|len|length|laenge)(\d)", STRUTS, 1),
    (r"(?:force|kraft|loadcell|dms)\D*(\d)|^(?:f|fs|lc|sensor)(\d)", BAR_FORCES, 1),
    (r"(?:axis|achse|drive|antrieb|joint|motor|actpos|enc)\D*(\d)|(?:^|actual)(?:q|j)(\d)", DRIVES, 1),
)


def matched(
    names: Sequence[str], units: Sequence[str], joints: Mapping[str, str] | None = None
) -> tuple[dict[str, int], dict[str, str]]:
    """Our columns among a file's, and the units that names state.

    Args:
        units: units of the file's columns, or empty.
        joints: name of each joint of a chain, from the base -> our column; None: the machine is not a chain.

    Returns:
        Our name -> position in the file; our name -> unit. Groups that are not whole are left out.
    """
    groups: dict[tuple[str, ...], dict[int, int]] = {}
    stated: dict[int, str] = {}
    for k, name in enumerate(names):
        bare, unit = _without_unit(name, units[k] if units else "")
        if (meaning := _meaning(name, bare)) is not None:
            groups.setdefault(meaning[0], {}).setdefault(meaning[1], k)
        if unit is not None:
            stated[k] = unit
    if joints is not None:
        own = tuple(joints.values())
        groups[own] = _of_joints(names, groups.pop(DRIVES, {}), joints)
    places: dict[str, int] = {}
    for columns, numbered in groups.items():
        first = 0 if 0 in numbered else 1
        if all(number in numbered for number in range(first, first + len(columns))):
            places |= {ours: numbered[number] for number, ours in enumerate(columns, first)}
    return places, {ours: stated[k] for ours, k in places.items() if k in stated}


def unit_of(text: str) -> str | None:
    """A unit as hexcite writes it, in brackets or not; None where it is not known."""
    unit = _UNITS.get(text := text.strip("[]() "), text)
    return unit if unit in _KNOWN else None


def _without_unit(name: str, unit: str) -> tuple[str, str | None]:
    """A column's name in small letters without its unit, and the unit that it, or a line of units, states."""
    if any(name in group for group in _GROUPS):
        return name, None
    bracket = _BRACKETED.search(name)
    symbol = unit_of(unit) or (unit_of(bracket[1]) if bracket else None)
    bare = _BRACKETED.sub("", name).strip()
    suffix = _SUFFIX.search(bare)
    if symbol is None and suffix and (symbol := unit_of(suffix[1])):
        bare = bare[: suffix.start()]
    return bare.lower(), symbol


def _meaning(name: str, bare: str) -> tuple[tuple[str, ...], int] | None:
    """The group that a column is of, and its number there; numbers of some files count from 0."""
    for group in _GROUPS:
        if name in group:
            return group, group.index(name) + 1
    if name in COLUMNS or _NOT_MEASURED.search(bare):  # joints of a chain are found by `_of_joints`
        return None
    key = re.sub(r"[_ .\-#/]+", "", bare)
    for pattern, group, first in _PATTERNS:
        if match := re.search(pattern, key):
            found = [part for part in match.groups() if part is not None]
            if group is ROTATION:
                return group, 3 * int(found[0]) + int(found[1]) - 3
            if not found:
                return group, first
            return group, int(found[0]) if found[0].isdigit() else first + "xyz".index(found[0])
    return None


def _of_joints(names: Sequence[str], numbered: Mapping[int, int], joints: Mapping[str, str]) -> dict[int, int]:
    """Number of each joint of a chain -> its column: by our name or the joint's, else by the number in its name."""
    places: dict[int, int] = {}
    first = 0 if 0 in numbered else 1
    for number, (joint, ours) in enumerate(joints.items()):
        called = [k for k, name in enumerate(names) if name == ours] or [
            k
            for k, name in enumerate(names)
            if joint.lower() in name.lower() and not _NOT_MEASURED.search(name.lower())
        ]
        place = called[0] if len(called) == 1 else numbered.get(number + first)
        if place is not None:
            places[number + 1] = place
    return places
