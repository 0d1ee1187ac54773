"""The layout of an unknown text file: separator, decimal sign, where numbers begin and end, which line names them."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from cases.errors import RecordingError
from identification.formats.table import TextFormat, is_number, unreadable
from identification.formats.text import SIZE, read_head

_SEPARATORS = (";", "\t", "|", ",", " ")
_SAMPLE = 200  # lines from which the fields are known
_NUMERIC = 0.7  # share of a column's fields, from which on it is numeric
_TAIL = 1 << 14  # bytes at the end in which lines without numbers are looked for
_UNIT = re.compile(
    r"[\[(]?(s|ms|us|µs|ns|mm|m|um|µm|nm|cm|in|N|kN|mN|Nm|N\*m|N m|Nmm|kNm|deg|°|rad|mrad|%|-|V|mm/s|m/s)?[\])]?"
)


@dataclass(frozen=True, slots=True)
class TextLayout:
    """How a text file is laid out."""

    format: Literal["csv", "halsampler", "twincat-scope"]  # as `recording.format` names it
    dialect: TextFormat  # separator, decimal sign and encoding
    header_rows: int  # lines above the numbers
    names_row: int  # which of them holds the names, counted from 1; 0: none does
    names: tuple[str, ...]  # names of the columns; numbered where the file has none
    units: tuple[str, ...]  # units of the columns, where a line of the header holds them; else empty
    numeric: tuple[bool, ...]  # whether each column holds numbers
    trailing_rows: int  # lines below the numbers
    cut_off: bool  # whether the last line ends early

    @property
    def settings(self) -> dict[str, Any]:
        """What differs from `csv` by default, as `[recording]` has it."""
        settings: dict[str, Any] = {} if self.format == "csv" else {"format": self.format}
        usual = {"csv": ",", "halsampler": " "}.get(self.format, self.dialect.delimiter)
        if self.dialect.delimiter != usual:
            settings["delimiter"] = self.dialect.delimiter
        if self.dialect.decimal != "." or self.format == "twincat-scope":
            settings["decimal"] = self.dialect.decimal
        if self.format == "csv":
            settings |= {"header_rows": self.header_rows} if self.header_rows != 1 else {}
            settings |= {"names_row": self.names_row} if self.names_row not in (0, self.header_rows) else {}
            settings |= {"trailing_rows": self.trailing_rows} if self.trailing_rows else {}
        return settings | ({"encoding": self.dialect.encoding} if self.dialect.encoding != "utf-8" else {})


def layout_of(file: Path) -> TextLayout:
    """The layout of a text file, from its beginning and its end.

    Raises:
        RecordingError: it cannot be read, or holds no table of numbers that the readers know.
    """
    raw = read_head(file)
    if len(raw) > 1 and file.stat().st_size > SIZE // 4:
        raw = raw[:-1]  # what was read ends somewhere in this line
    encoding, lines = _decoded(file, raw)
    while lines and not lines[-1].strip():
        lines.pop()
    scope = next((d for d in "\t;," if lines[0].split(d)[0] == "Name" and d in lines[0]), None)
    dialect, numeric = _dialect(file, lines, encoding, scope)
    count = len(numeric)
    first = next(k for k, line in enumerate(lines) if _is_row(dialect, line, numeric))
    head = [[cell.strip() for cell in dialect.split(line)] for line in lines[:first]]
    names_row = max(k for k, row in enumerate(head, 1) if row[:1] == ["Name"]) if scope else _names_row(head, count)
    names = tuple(head[names_row - 1]) if names_row else tuple(f"column {k}" for k in range(1, count + 1))
    below = (row for row in head[names_row:] if len(row) == count and any(row))
    units = next((tuple(row) for row in below if all(map(_UNIT.fullmatch, row))), ())
    blank_at_end = dialect.delimiter == " " and not first and lines[0].endswith(" ")
    trailing, cut_off = _below(file, dialect, numeric)
    form: Literal["csv", "halsampler", "twincat-scope"] = (
        "twincat-scope" if scope else "halsampler" if blank_at_end else "csv"
    )
    return TextLayout(form, dialect, first, names_row, names, units, numeric, trailing, cut_off)


def _decoded(file: Path, raw: Sequence[bytes]) -> tuple[str, list[str]]:
    for encoding in ("utf-8", "cp1252"):
        try:
            lines = [line.decode(encoding) for line in raw]
        except UnicodeDecodeError:
            continue
        if not any("\0" in line for line in lines):
            return encoding, lines
    raise RecordingError(file, "is not text", "export the recording as CSV or Parquet")


def _dialect(file: Path, lines: Sequence[str], encoding: str, scope: str | None) -> tuple[TextFormat, tuple[bool, ...]]:
    """The dialect in which most columns are numbers, and which of them are."""
    sample = [line for line in lines if line.strip()][-_SAMPLE:-1] or list(lines[-1:])
    best, most = None, 1
    numeric: tuple[bool, ...] = ()
    for separator in _SEPARATORS if scope is None else (scope,):
        for decimal in ".,":
            if decimal == separator:
                continue
            dialect = TextFormat(separator, decimal, ("", " "), encoding)
            rows = [dialect.split(line) for line in sample]
            count = Counter(len(row) for row in rows).most_common(1)[0][0]
            same = [row for row in rows if len(row) == count]
            columns = [[row[k] for row in same] for k in range(count)]
            numbers = tuple(_share(dialect, c) >= _NUMERIC and any(map(str.strip, c)) for c in columns)
            if sum(numbers) > most and len(same) > len(rows) / 2:
                best, most, numeric = dialect, sum(numbers), numbers
    if best is None or (best.delimiter == " " and any("  " in line.strip() for line in sample)):
        aligned = sum(len(n := line.split()) > 1 and all(map(is_number, n)) for line in sample) > len(sample) / 2
        reason = "its columns are aligned by several blanks" if aligned else "no table of numbers is found in it"
        raise RecordingError(file, reason, "export with one character, such as a comma, between two fields")
    return best, numeric


def _share(dialect: TextFormat, fields: Sequence[str]) -> float:
    return sum(dialect.is_number(field) for field in fields) / max(len(fields), 1)


def _is_row(dialect: TextFormat, line: str, numeric: Sequence[bool]) -> bool:
    """Whether a line is one of the table's: as many fields, numbers where others have such, not all of them empty."""
    fields = dialect.split(line)
    numbers = [field for field, number in zip(fields, numeric, strict=False) if number]
    return len(fields) == len(numeric) and any(map(str.strip, numbers)) and all(map(dialect.is_number, numbers))


def _names_row(head: Sequence[Sequence[str]], count: int) -> int:
    """The line of the header that names most columns differently, counted from 1; 0 where there is none."""
    distinct = [len(set(row)) if len(row) == count else 0 for row in head]
    return distinct.index(max(distinct)) + 1 if any(distinct) else 0


def _below(file: Path, dialect: TextFormat, numeric: Sequence[bool]) -> tuple[int, bool]:
    """Lines without numbers at the end of a file, and whether the last is a row that ends early."""
    try:
        with file.open("rb") as stream:
            stream.seek(max(file.stat().st_size - _TAIL, 0))
            data = stream.read()
    except OSError as error:
        raise unreadable(file, error) from error
    lines = data.decode(dialect.encoding, "replace").splitlines()
    while lines and not lines[-1].strip():
        lines.pop()
    trailing = next((k for k, line in enumerate(reversed(lines)) if _is_row(dialect, line, numeric)), 0)
    short = dialect.split(lines[-1]) if trailing == 1 else []
    return trailing, 1 < len(short) < len(numeric) and dialect.is_number(short[0])
