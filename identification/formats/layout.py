"""An unknown text file: its separator, decimal sign and header."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cases.errors import RecordingError
from cases.recording_format import RecordingFormat
from cases.units import Array
from identification.formats.meaning import unit_of
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
