"""A text file of unknown layout: the settings with which it is read, and what it holds when it is read with them."""

from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.base.units import Array
from cases.recording_format import CLOCK, TICKS, FileFormat
from identification.recording.formats import dates
from identification.recording.formats.content import LONGEST_LINE, Content, content_of, section_of
from identification.recording.formats.names.meaning import known_among
from identification.recording.formats.recorders import halsampler, plain
from identification.recording.formats.recorders.known import TextFormat, described, format_of
from identification.recording.formats.recorders.plain import SAMPLE
from identification.recording.formats.ros.echoed import echoed_names
from identification.recording.formats.table import LARGEST, MOST_MISSING
from identification.recording.formats.text_layout import Layout, cells
from identification.recording.formats.words import (
    EMPTY,
    aligned_fields,
    is_missing,
    is_number,
    is_switch,
    is_value,
    split,
)

_SEPARATORS = (";", "\t", "|", ",", " ")
_NUMERIC = 0.7  # share of a column's fields, from which on it is numeric
_FEW = 20  # rows that show which columns are dates
_MOST_BELOW = 20  # lines below the rows that are looked for


@dataclass(frozen=True, slots=True)
class TextColumns:
    """What a text file holds when it is read with the settings that follow from it."""

    names: list[str]  # of all columns in the order of the file; empty where one has none
    units: list[str]  # as a row of units has them, or empty
    numbers: dict[int, Array]  # values of the columns of numbers by position; those of other clocks differ in length
    settings: dict[str, Any]  # of `[recording]`, without what columns mean
    clock: tuple[int, str] | None  # the column of time stamps where the format says which it is, and their unit
    dates: frozenset[int] = frozenset()  # columns of dates or times of day, whose numbers are ns from the first row
    header: tuple[str, ...] = ()  # lines above the rows


def look_at_text(file: Path, stated: FileFormat | None = None) -> TextColumns:
    """Columns of a text file; raises RecordingError where it holds no table of numbers.

    `stated`: how it is laid out; None: that is not known.
    """
    content = content_of(file)
    settings: dict[str, Any] = {}
    if stated is None:
        head = content.head()
        text_format = format_of(head, FileFormat())
        settings = _guessed(content, head) if text_format.guessed else {}
        form = FileFormat.model_validate(settings).model_copy(update={"format": text_format.name})
        layout = text_format.layout(content, head, form)
    else:
        text_format, layout = described(content, stated)
    rows = _sample(content, layout)
    numeric = [k for k, column in enumerate(zip(*rows, strict=True)) if _is_numeric(column, layout.form)]
    if not layout.sections:
        numeric = list(range(len(layout.fields)))
    clocks = sorted({field.clock for field in layout.fields if field.clock is not None})
    numeric_fields = {str(k): k for k in numeric if k not in clocks and (layout.fields[k].name or text_format.guessed)}
    apart = (
        text_format.guessed
        and stated is None
        and _stand_apart([[row[k] for row in rows] for k in numeric_fields.values()])
    )
    sparse = not apart and any(_is_sparse([row[k] for row in rows]) for k in numeric_fields.values())
    if apart or (sparse and text_format.guessed and stated is None):
        settings["empty"] = "apart" if apart else "hold"
    filled = replace(layout, hold=layout.hold or sparse, apart=layout.apart or apart)
    numbers: dict[int, Array] = {}
    clock: tuple[int, str] | None = None
    names, units = _names(layout, stated), [field.unit for field in layout.fields]
    names = ["" if k in clocks[1:] else name for k, name in enumerate(names)]
    for table in text_format.tables(content, filled, numeric_fields, [*numeric_fields]):
        numbers |= {numeric_fields[ours]: column for ours, column in table.values.items() if np.isfinite(column).any()}
        if table.stamps is None or clock is not None:
            continue
        clock_field = layout.fields[numeric_fields[next(iter(table.values))]].clock
        if clock_field is None:  # rows at equal steps
            names, units, clock_field = [*names, "time between rows"], [*units, "s"], len(names)
            clock, numbers[clock_field] = (clock_field, "s"), np.asarray(table.stamps * table.tick, dtype=float)
        elif text_format.name != "halsampler":  # which does not say how long a step takes
            clock = clock_field, next(unit for unit, tick in TICKS.items() if tick == table.tick)
            numbers[clock_field] = np.asarray(table.stamps, dtype=float)
    settings |= _stated(text_format, layout, clock) if stated is None else {}
    dated = {} if clock is not None else _dates(text_format, content, layout, rows, numeric_fields)
    lines = tuple(line.decode(layout.form.encoding, "replace") for line in content.head()[: layout.form.header_rows])
    measured = {k: np.where(np.abs(column) < LARGEST, column, np.nan) for k, column in numbers.items()}
    filled_columns = {k: column for k, column in measured.items() if np.isfinite(column).any()}
    return TextColumns(names, units, filled_columns | dated, settings, clock, frozenset(dated), lines)


def _dates(
    known: TextFormat, content: Content, layout: Layout, rows: Sequence[Sequence[str]], wanted: Mapping[str, int]
) -> dict[int, Array]:
    """Columns of dates or times of day by position, in ns from the first row."""
    columns = list(zip(*rows, strict=True)) if wanted else []
    dates_by_column: dict[int, Array] = {}
    for k, column in enumerate(columns):
        if k not in wanted.values() and all(dates.is_stamp(field) for field in column[:_FEW]):
            with suppress(RecordingError):  # one that is not like those above it is for the reader to name
                chosen = dict([next(iter(wanted.items()))]) | {CLOCK: k}
                for table in known.tables(content, layout, chosen, ()):
                    if table.stamps is not None:
                        dates_by_column[k] = np.asarray(table.stamps - table.stamps[0], dtype=float)
    return dates_by_column


def _stated(known: TextFormat, layout: Layout, clock: tuple[int, str] | None) -> dict[str, Any]:
    """What a case should state of a file whose format is known."""
    match known.name:
        case "lvm":
            return {"format": "lvm"}
        case "twincat-scope":
            unit = {"clock": {"unit": "filetime"}} if clock is not None and clock[1] == "filetime" else {}
            return {"format": "twincat-scope", "decimal": layout.form.decimal, **unit}
        case "halsampler":
            names = [field.name for field in layout.fields if field.name != halsampler.NUMBER]
            return {"format": "halsampler", "column_names": names}
        case _:
            return {}


def _names(layout: Layout, form: FileFormat | None) -> list[str]:
    """A name for each field: of those that a file has for it the ones that are stated, or by which most are known."""
    usual = [field.name for field in layout.fields]
    most = max((len(field.also) for field in layout.fields), default=0)
    other = [[field.also[k] if k < len(field.also) else field.name for field in layout.fields] for k in range(most)]
    best = max([usual, *other], key=known_among)
    mapped = set() if form is None else {*form.columns.values()}
    return [
        next((each for each in (field.name, *field.also) if each in mapped), name)
        for field, name in zip(layout.fields, best, strict=True)
    ]


def _sample(content: Content, layout: Layout) -> list[list[str]]:
    """Fields of the first rows."""
    if not layout.sections:
        return []
    section, width = layout.sections[0], len(layout.fields)
    with content.opened() as stream:
        stream.seek(section.start)
        data = stream.read(min(LONGEST_LINE, section.end - section.start))
    lines = data.split(b"\n")[: min(SAMPLE, section.rows)]
    rows = [layout.split(line.rstrip(b"\r").decode("latin-1")) for line in lines if not layout.is_no_row(line)]
    return [(row + [""] * width)[:width] for row in rows]


def _is_numeric(column: Sequence[str], form: FileFormat) -> bool:
    """Whether a column holds numbers or states of a switch, and not only words for no value."""
    filled = [field for field in column if not is_missing(field)]
    good = sum(is_value(field, form) or is_switch(field) for field in filled)
    return bool(filled) and good >= _NUMERIC * len(filled)


def _is_sparse(column: Sequence[str]) -> bool:
    """Whether a column begins with a value, and most fields below are empty."""
    empty = sum(field.strip() in EMPTY for field in column)
    return empty > MOST_MISSING * len(column) and column[0].strip() not in EMPTY


_TOGETHER = 3  # columns at least whose values stand in the same rows: a vector


def _stand_apart(columns: Sequence[Sequence[str]]) -> bool:
    """Whether rows of several clocks stand among each other: vectors whose values are in rows of their own.

    A value that stands only where it has changed has no such company, and comes in the first row.
    """
    rows_of = Counter(tuple(field.strip() not in EMPTY for field in column) for column in columns)
    groups = [np.array(rows) for rows, count in rows_of.items() if count >= _TOGETHER and any(rows) and not all(rows)]
    overlaps = [np.count_nonzero(a & b) for k, a in enumerate(groups) for b in groups[k + 1 :]]
    fewest = min((np.count_nonzero(rows) for rows in groups), default=0)
    return len(groups) > 1 and bool(max(overlaps) < fewest / 2)


def _guessed(content: Content, head: Sequence[bytes]) -> dict[str, Any]:
    """Settings that read a table of text, as far as they differ from the usual ones; raises RecordingError."""
    encoding, lines = _decoded(content.file, head)
    form, numeric = _dialect(content.file, lines, encoding)
    aligned = plain.is_aligned(_table_lines(lines), form.separator)
    first = next((k for k, line in enumerate(lines) if _is_row(form, line, numeric, aligned)), None)
    if first is None:
        problem = "has columns of numbers, but no line with a number in each of them"
        raise RecordingError(
            place=content.file,
            problem=problem,
            remedy=phrase("export_rows", "export it again, one row a sample"),
            code=Code.WRONG_KIND,
        )
    sample = [line for line in lines[first : first + SAMPLE] if line.strip()]
    names_row = _names_row(lines[:first], sample, form, aligned, len(numeric))
    if not names_row:
        _require_one_sign(content.file, lines[:first], form, len(numeric))
    settings: dict[str, Any] = {"delimiter": form.separator} if form.separator != "," else {}
    settings |= {"decimal": form.decimal} if form.decimal != "." else {}
    settings |= {"header_rows": first} if first != bool(names_row) else {}
    settings |= {"names_row": names_row} if names_row not in (0, first) else {}
    if below := _rows_below(content, first, form, numeric, aligned):
        settings["trailing_rows"] = below
    if not names_row:
        rows = [split(line, form.separator) for line in sample if _is_row(form, line, numeric, aligned)]
        numbered = [f"column {k}" for k in range(1, len(numeric) + 1)]
        settings["column_names"] = echoed_names(rows) or numbered
    return settings | ({"encoding": encoding} if encoding != "utf-8" else {})


def _decoded(file: Path, raw: Sequence[bytes]) -> tuple[str, list[str]]:
    for encoding in ("utf-8", "cp1252"):
        try:
            lines = [line.decode(encoding) for line in raw]
        except UnicodeDecodeError:
            continue
        if not any("\0" in line for line in lines):
            return encoding, lines
    raise RecordingError(
        place=file,
        problem=phrase("not_text", "is not text in UTF-8, UTF-16 with its mark, or cp1252"),
        remedy=phrase("save_or_export", "save text of another encoding as UTF-8; export other files as CSV or Parquet"),
        code=Code.UNREADABLE,
    )


def _table_lines(lines: Sequence[str]) -> list[str]:
    """Lines that are in the table, if there is one: the last ones that are not blank, the very last apart."""
    return [line for line in lines if line.strip()][-SAMPLE:-1]


def _dialect(file: Path, lines: Sequence[str], encoding: str) -> tuple[FileFormat, list[bool]]:
    """The separator and decimal sign by which most columns are numbers, in most rows, and which columns are."""
    sample = _table_lines(lines)
    best, numeric, most = None, [True], (1, len(sample))
    for separator in _SEPARATORS:
        aligned = plain.is_aligned(sample, separator)
        rows = [line.split() if aligned else split(line, separator) for line in sample]
        count, often = Counter(map(len, rows)).most_common(1)[0] if rows else (0, 0)
        columns = list(zip(*(row for row in rows if len(row) == count), strict=True))
        for decimal in ".,":
            if decimal == separator and not any(separator in field for row in rows for field in row):
                continue  # only fields in quotation marks can hold it
            form = FileFormat(delimiter=separator, decimal=decimal, encoding=encoding)
            numbers = [_is_numeric(column, form) for column in columns]
            if (sum(numbers), often) > most:
                best, numeric, most = form, numbers, (sum(numbers), often)
    if best is None:
        problem = "holds no table of numbers with a separator between two fields"
        raise RecordingError(
            place=file,
            problem=problem,
            remedy=phrase("export_csv", "export it as CSV, with a comma or semicolon between the fields"),
            code=Code.WRONG_KIND,
        )
    return best, numeric


def _is_row(form: FileFormat, line: str, numeric: Sequence[bool], aligned: bool) -> bool:
    """Whether a line is one of the table's: as many fields, numbers where others have such, one of them at least."""
    fields = aligned_fields(line, len(numeric)) if aligned else split(line, form.separator)
    if len(fields) != len(numeric):
        return False
    numbers = [field for field, number in zip(fields, numeric, strict=True) if number]
    real = [field for field in numbers if not is_missing(field) and not is_switch(field)]
    return bool(real) and all(is_value(field, form) or is_switch(field) for field in numbers)


def _names_row(header: Sequence[str], sample: Sequence[str], form: FileFormat, aligned: bool, width: int) -> int:
    """The line of the header that names the columns, counted from 1; 0 where there is none.

    It has a name for each field: of several such lines the one whose names are known best, and differ most.
    """
    best, row = (0, 0), 0
    for k, line in enumerate(header, 1):
        if not line.strip():
            continue
        names = [field.name for field in plain.named(header, k, sample, form, aligned)]
        if len(names) == width and not plain.is_headless(names) and not plain.is_units(names):
            score = known_among(names), len({name for name in names if name})
            if score > best:
                best, row = score, k
    return row


def _require_one_sign(file: Path, header: Sequence[str], form: FileFormat, width: int) -> None:
    """Raises RecordingError where a comma stands between fields and in numbers: which is which nobody can say."""
    names = max((sum(bool(name) and not is_number(name) for name in cells(line, form)) for line in header), default=0)
    if form.separator == "," and 2 < names < width:
        problem = f"has rows of {width} fields below {names} names: commas stand in numbers and between them"
        raise RecordingError(
            place=file,
            problem=problem,
            remedy=phrase("export_semicolons", "export it with semicolons between the fields, or with decimal points"),
            code=Code.WRONG_KIND,
        )


def _rows_below(content: Content, first: int, form: FileFormat, numeric: Sequence[bool], aligned: bool) -> int:
    """Lines of text below the rows; one that begins with a number is a row that is damaged."""
    section = section_of(content, first, 0)
    with content.opened() as stream:
        stream.seek(max(section.start, section.end - LONGEST_LINE))
        data = stream.read(section.end - stream.tell())
    lines = [line.decode("latin-1") for line in data.split(b"\n") if line.strip()][-_MOST_BELOW:]
    for count, line in enumerate(reversed(lines)):
        word = (line.split() if aligned else cells(line, form))[:1]
        if _is_row(form, line, numeric, aligned) or not word or is_value(word[0], form):
            return count
    return 0
