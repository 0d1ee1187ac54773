"""The layout of an unknown text file: separator, decimal sign, where numbers begin and end, which line names them."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cases.errors import RecordingError
from cases.recording_format import RecordingFormat
from identification.formats.looked import Column
from identification.formats.naming import unit_of
from identification.formats.table import is_number, is_value, split, unreadable
from identification.formats.text import LONGEST_LINE, cells, read_head, section_of, table_of

_SEPARATORS = (";", "\t", "|", ",", " ")
_SAMPLE = 200  # lines from which the fields are known
_NUMERIC = 0.7  # share of a column's fields, from which on it is numeric
_TAIL = 1 << 14  # bytes at the end in which lines without numbers are looked for


def look_at_text(file: Path) -> tuple[list[Column], dict[str, Any], list[str]]:
    """Columns of a text file with the units in its header, settings for `[recording]` that read it, and what is odd.

    Raises RecordingError where it holds no table of numbers that the readers know.
    """
    raw = read_head(file)
    if len(raw) > 1 and file.stat().st_size >= LONGEST_LINE:
        raw = raw[:-1]  # what was read ends somewhere in this line
    encoding, lines = _decoded(file, raw)
    while lines and not lines[-1].strip():
        lines.pop()
    scope = next((d for d in "\t;," if lines[0].split(d)[0] == "Name" and d in lines[0]), None)
    form, numeric = _dialect(file, lines, encoding, scope)
    count = len(numeric)
    first = next(k for k, line in enumerate(lines) if _is_row(form, line, numeric))
    head = [cells(line, form) for line in lines[:first]]
    names_row = max(k for k, row in enumerate(head, 1) if row[:1] == ["Name"]) if scope else _names_row(head, count)
    names = head[names_row - 1] if names_row else [f"column {k}" for k in range(1, count + 1)]
    below = (row for row in head[names_row:] if len(row) == count and any(row))
    units = next(
        (row for row in below if all(not cell or unit_of(cell) or cell.strip("[()] ") in "-V" for cell in row)),
        [""] * len(names),
    )
    blank_at_end = not scope and form.separator == " " and not first and lines[0].endswith(" ")
    trailing, cut_off = _below(file, form, numeric)
    odd = []
    if cut_off:
        odd = ["the last line ends early: the recorder was stopped while it wrote; the settings leave this line out"]
    elif trailing and not scope and not blank_at_end:
        odd = [f"lines without numbers at the end: {trailing}; the settings leave them out"]
    settings: dict[str, Any] = {}
    if scope or blank_at_end:
        settings["format"] = "twincat-scope" if scope else "halsampler"
    elif form.separator != ",":
        settings["delimiter"] = form.separator
    if form.decimal != "." or scope:
        settings["decimal"] = form.decimal
    if not settings.get("format"):
        settings |= {"header_rows": first} if first != 1 else {}
        settings |= {"names_row": names_row} if names_row not in (0, first) else {}
        settings |= {"trailing_rows": trailing} if trailing else {}
    settings |= {"encoding": encoding} if encoding != "utf-8" else {}
    wanted = {str(k): k for k in range(count) if numeric[k] and (names[k] or not names_row)}
    lines_of_numbers = section_of(file, first, trailing, len(wanted))
    values = table_of(file, lines_of_numbers, names, wanted, form, None).values if wanted else {}
    numbers = {wanted[k]: column for k, column in values.items() if np.isfinite(column).any()}
    if blank_at_end and not numeric[-1]:
        names = names[:-1]
    if not names_row:
        settings["column_names"] = names
    columns = [Column(name, None, units[k], False, numbers.get(k, np.zeros(0))) for k, name in enumerate(names)]
    return columns, settings, odd


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
    sample = [line for line in lines if line.strip()][-_SAMPLE:-1] or list(lines[-1:])
    best, most = None, 1
    numeric: list[bool] = []
    for separator in _SEPARATORS if scope is None else (scope,):
        for decimal in ".,":
            if decimal == separator:
                continue
            form = RecordingFormat(delimiter=separator, decimal=decimal, encoding=encoding)
            rows = [split(line, separator) for line in sample]
            count = Counter(len(row) for row in rows).most_common(1)[0][0]
            same = [row for row in rows if len(row) == count]
            columns = [[row[k] for row in same] for k in range(count)]
            numbers = [
                sum(is_value(field, form) for field in column) >= _NUMERIC * len(column) and any(map(str.strip, column))
                for column in columns
            ]
            if sum(numbers) > most and len(same) > len(rows) / 2:
                best, most, numeric = form, sum(numbers), numbers
    if best is None or (best.separator == " " and any("  " in line.strip() for line in sample)):
        aligned = sum(len(n := line.split()) > 1 and all(map(is_number, n)) for line in sample) > len(sample) / 2
        reason = "its columns are aligned by several blanks" if aligned else "no table of numbers is found in it"
        raise RecordingError(file, reason, "export with one character, such as a comma, between two fields")
    return best, numeric


def _is_row(form: RecordingFormat, line: str, numeric: Sequence[bool]) -> bool:
    """Whether a line is one of the table's: as many fields, numbers where others have such, not all of them empty."""
    fields = split(line, form.separator)
    numbers = [field for field, number in zip(fields, numeric, strict=False) if number]
    return (
        len(fields) == len(numeric) and any(map(str.strip, numbers)) and all(is_value(field, form) for field in numbers)
    )


def _names_row(head: Sequence[Sequence[str]], count: int) -> int:
    """The line of the header that names most columns differently, counted from 1; 0 where there is none."""
    distinct = [len(set(row)) if len(row) == count else 0 for row in head]
    return distinct.index(max(distinct)) + 1 if any(distinct) else 0


def _below(file: Path, form: RecordingFormat, numeric: Sequence[bool]) -> tuple[int, bool]:
    """Lines without numbers at the end of a file, and whether the last is a row that ends early."""
    try:
        with file.open("rb") as stream:
            stream.seek(max(file.stat().st_size - _TAIL, 0))
            data = stream.read()
    except OSError as error:
        raise unreadable(file, error) from error
    lines = data.decode(form.encoding, "replace").splitlines()
    while lines and not lines[-1].strip():
        lines.pop()
    trailing = next((k for k, line in enumerate(reversed(lines)) if _is_row(form, line, numeric)), 0)
    short = split(lines[-1], form.separator) if trailing == 1 else []
    return trailing, 1 < len(short) < len(numeric) and is_value(short[0], form)
