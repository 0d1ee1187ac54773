"""Tables as text, one row a sample, read by pyarrow; the first line that it cannot read is named."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv

from cases.errors import RecordingError
from cases.recording_format import CLOCK, COLUMNS, RecordingFormat
from identification.formats.labels import units_row
from identification.formats.table import (
    MISSING,
    Block,
    ColumnTable,
    Lines,
    is_value,
    lines_of,
    listed,
    require_file,
    require_room,
    shown,
    split,
    unreadable,
)

PART = 1 << 22  # bytes that are read at a time
LONGEST_LINE = 1 << 20  # bytes; a recording of a thousand channels stays far below
_MARK = b"\xef\xbb\xbf"  # of UTF-8, as Windows editors write it
_NOT_TEXT = (b"\xff\xfe", b"\xfe\xff", b"PK\x03\x04", b"\x1f\x8b")  # how UTF-16, ZIP (workbooks too) and gzip begin
_TYPICAL = ("t_s", "l1_mm", "q1_mm", "x_mm", "r11", "ax", "f1_N", "fx_N")


def read_head(file: Path) -> list[bytes]:
    """The first lines of a text file, more than any header has, without line breaks; raises RecordingError."""
    require_file(file)
    try:
        with file.open("rb") as stream:
            data = stream.read(LONGEST_LINE)
    except OSError as error:
        raise unreadable(file, error) from error
    if data.startswith(_NOT_TEXT):
        raise RecordingError(file, "is UTF-16 text, a workbook, an archive or compressed", "save it as CSV in UTF-8")
    lines = data.removeprefix(_MARK).split(b"\n")
    if not any(line.strip() for line in lines):
        raise RecordingError(file, "is empty, it has blank lines only", "record again")
    return [line.removesuffix(b"\r") for line in lines]


class Section(NamedTuple):
    """Lines of a file that lie below its header and above its trailing rows, and stay there until they are needed."""

    file: Path
    first: int  # number of its first line, counted from 1
    rows: int  # number of lines
    start: int  # where it starts and ends in the file [byte]
    end: int

    def text(self) -> Block:
        """The lines themselves."""
        with self.file.open("rb") as stream:
            stream.seek(self.start)
            return self.first, stream.read(self.end - self.start)


def section_of(file: Path, header_rows: int, trailing_rows: int, columns: int) -> Section:
    """The lines below a header, without trailing rows and blank lines at the end; raises RecordingError."""
    first = header_rows + 1
    try:
        with file.open("rb") as stream:
            for _ in range(header_rows):
                stream.readline(LONGEST_LINE)
            start = stream.tell() if header_rows else len(_MARK) * (stream.read(len(_MARK)) == _MARK)
            stream.seek(start)
            if len(stream.readline(LONGEST_LINE)) == LONGEST_LINE:
                raise RecordingError(f"{file}, line {first}", "is longer than a million characters", "not a CSV table")
            stream.seek(start)
            breaks = sum(part.count(b"\n") for part in iter(lambda: stream.read(PART), b""))
            require_room(file, 1 + breaks, columns)
            size, length, lines, tail = stream.tell(), LONGEST_LINE, b"", b""
            while not lines and len(tail) < size - start:  # more of the end, where all of it is left out
                stream.seek(max(size - length, start))
                tail = stream.read()
                lines, length = _without_end(tail, trailing_rows), 4 * length
    except OSError as error:
        raise unreadable(file, error) from error
    left_out = tail[len(lines) :]
    count = breaks - left_out.count(b"\n") + bool(lines and not lines.endswith(b"\n"))
    return Section(file, first, count, start, size - len(left_out))


def _without_end(data: bytes, trailing_rows: int) -> bytes:
    """The lines above blank ones at the end and above the last rows that are not blank."""
    end = len(data)
    while end:
        start = data.rfind(b"\n", 0, end - 1) + 1
        blank = not data[start:end].strip(b" \t\r\n\x1a")
        if not blank and trailing_rows == 0:
            break
        trailing_rows -= not blank
        end = start
    return data[:end]


def parse(
    file: Path,
    lines: Section | Block,
    form: RecordingFormat,
    fields: Sequence[str],
    numbers: Iterable[int],
    stamps: Sequence[int],
) -> dict[int, pa.ChunkedArray]:
    """The wanted columns of lines by position: numbers as float64, stamps as int64 or float64, as the file writes them.

    `fields` are the names of all fields of a line. Raises RecordingError with the line and value that cannot be read.
    """
    positions = list(dict.fromkeys([*numbers, *stamps]))
    names = [str(k) for k in range(len(fields))]
    if isinstance(lines, Section):
        source, size = pa.OSFile(str(file)).get_stream(lines.start, lines.end - lines.start), PART
    else:  # one block, so that the kind of stamps follows from all of them
        source, size = pa.BufferReader(lines[1]), len(lines[1])
    try:
        table = pacsv.read_csv(
            source,
            read_options=pacsv.ReadOptions(column_names=names, use_threads=False, block_size=size),
            parse_options=pacsv.ParseOptions(delimiter=form.separator),
            convert_options=pacsv.ConvertOptions(
                column_types={str(k): pa.float64() for k in numbers},
                include_columns=[str(k) for k in positions],
                null_values=list(MISSING),
                strings_can_be_null=True,
                decimal_point=form.decimal or ".",
            ),
        )
    except (pa.ArrowException, UnicodeDecodeError) as error:
        if isinstance(lines, Section):
            return parse(file, lines.text(), form, fields, numbers, stamps)
        for part in _halves(lines):  # the damage is in one of them
            parse(file, part, form, fields, numbers, stamps)
        raise _explained(file, lines, fields, positions, form, str(error)) from error
    columns = {k: table.column(str(k)) for k in positions}
    for k in stamps:
        if pa.types.is_null(columns[k].type):
            columns[k] = columns[k].cast(pa.float64())
        if not (pa.types.is_int64(columns[k].type) or pa.types.is_float64(columns[k].type)):
            text = lines.text() if isinstance(lines, Section) else lines
            raise _explained(file, text, fields, positions, form, f"column {k} holds no numbers")
    return columns


def _halves(block: Block) -> tuple[Block, ...]:
    """Two halves of many lines; none of few."""
    first, data = block
    middle = data.rfind(b"\n", 0, len(data) // 2) + 1
    if len(data) <= PART or not middle:
        return ()
    return (first, data[:middle]), (first + data.count(b"\n", 0, middle), data[middle:])


def decoded(file: Path, lines: Sequence[bytes], form: RecordingFormat) -> list[str]:
    """Header lines as text; raises RecordingError where one is not."""
    try:
        return [line.decode(form.encoding) for line in lines]
    except UnicodeDecodeError:
        raise _not_text(file, form) from None


def cells(line: str, form: RecordingFormat) -> list[str]:
    """Fields of a header line."""
    return [name.strip() for name in split(line, form.separator)]


def select(file: Path, names: Sequence[str], form: RecordingFormat) -> dict[str, int]:
    """Our columns among those of a file, each with its position; raises RecordingError where one is there twice."""
    positions, given = {}, set(form.columns.values())
    for ours in COLUMNS:
        theirs = form.file_name(ours)
        if theirs in given and ours not in form.columns:
            continue  # the case gives the column of that name another meaning
        if names.count(theirs) > 1:
            raise RecordingError(file, f"column {shown(theirs)} is there twice", "rename or remove one")
        if theirs in names:
            positions[ours] = names.index(theirs)
    return positions


def tables(file: Path, form: RecordingFormat) -> list[ColumnTable]:
    """Reads a file; raises RecordingError with the place and the remedy."""
    header_rows, names, units = _header(file, form)
    chosen = select(file, names, form)
    tick = form.tick if CLOCK in chosen else form.clock.period
    lines = section_of(file, header_rows, form.trailing_rows, len(chosen))
    table = table_of(file, lines, names, chosen, form, tick)
    return [replace(table, unit_cells={ours: units[k] for ours, k in chosen.items() if units})]


def table_of(
    file: Path,
    lines: Section | Block,
    names: Sequence[str],
    chosen: Mapping[str, int],
    form: RecordingFormat,
    tick: float | None,
) -> ColumnTable:
    """Turns lines of numbers into a table; raises RecordingError where a line cannot be read, or there is none.

    Args:
        chosen: the fields that are wanted, our name -> position; `CLOCK` is that of the time stamps.
        tick: duration of a unit of the time stamps, or, without such, between rows [s]; None: there is no clock.
    """
    if not (lines.rows if isinstance(lines, Section) else lines[1].strip()):
        raise RecordingError(file, "has a header but no rows", "record or export it again")
    positions = {ours: k for ours, k in chosen.items() if ours != CLOCK}
    at = chosen.get(CLOCK)
    columns = parse(file, lines, form, names, positions.values(), [] if at is None else [at])
    rows = len(next(iter(columns.values())))
    stamps = None if tick is None else np.arange(rows)
    if isinstance(lines, Section):
        places = Lines(lines.first) if lines.rows == rows else lines_of(lines.text(), rows)
    else:
        places = lines_of(lines, rows)
    if at is not None:
        clock = columns.pop(at)
        if clock.null_count:
            row = int(np.argmin(clock.is_valid().to_numpy()))
            place = f"{file}, {places.place(row)}, {shown(names[at])}"
            raise RecordingError(place, "is empty where a time stamp is needed", "remove the row")
        stamps = clock.to_numpy()
    values = {ours: columns.pop(k).to_numpy() for ours, k in positions.items()}  # each is copied, then let go
    return ColumnTable(str(file), form, tuple(names), values, stamps, tick or 0.0, places)


def _header(file: Path, form: RecordingFormat) -> tuple[int, list[str], list[str]]:
    """Number of header lines, names of the columns, and cells of a row of units; none where there is no such row."""
    rows = form.header_rows if form.header_rows is not None else int(form.column_names is None)
    lines = read_head(file)
    if len(lines) < rows:
        raise RecordingError(file, f"has {len(lines)} lines, no more than recording.header_rows = {rows}")
    header = decoded(file, lines[:rows], form)
    if form.column_names is not None:
        names = list(form.column_names)
        return rows, names, units_row([names, *(cells(line, form) for line in header)], 1)
    row = form.names_row or rows
    if row == 0:
        raise RecordingError(file, "recording.header_rows = 0 leaves no names", "list them in recording.column_names")
    names = cells(header[row - 1], form)
    if not any(form.file_name(ours) in names for ours in COLUMNS):
        raise RecordingError(file, without(names, form))
    return rows, names, units_row([cells(line, form) for line in header], row)


def without(names: Iterable[str], form: RecordingFormat, wanted: Sequence[str] = _TYPICAL) -> str:
    """What to say of a file with columns of some names that has none of those, by our names, that are wanted."""
    columns = listed(map(form.file_name, wanted))
    remedy = "name them so, or state names, separator and header in [recording] of the case, as hexcite look proposes"
    return f"none of the columns {columns}; it has {listed(names)}: {remedy}"


def _explained(
    file: Path, block: Block, names: Sequence[str], wanted: Sequence[int], form: RecordingFormat, cause: str
) -> RecordingError:
    """The error for lines that could not be read: the first to blame; `wanted` fields must be numbers."""
    first, data = block
    last = first + data.count(b"\n")
    for number, line in enumerate(data.split(b"\n"), first):
        place, raw = f"{file}, line {number}", line.rstrip(b"\r")
        if not raw:
            continue
        if not raw.strip(b"\0"):
            return RecordingError(place, "is binary zero, as after a crash while recording", "cut the file off there")
        try:
            fields = split(raw.decode(form.encoding), form.separator)
        except UnicodeDecodeError:
            return _not_text(place, form)
        if len(fields) != len(names):
            cut = "the file is cut off in its last line: remove that line"
            remedy = "correct or remove the row, or state delimiter, decimal and trailing_rows in [recording]"
            problem = f"expected {len(names)} columns, got {len(fields)}"
            return RecordingError(place, problem, cut if number == last and len(fields) < len(names) else remedy)
        for k in wanted:
            if not is_value(fields[k], form):
                problem = f"{shown(fields[k])!r} is not a number with a decimal {form.decimal or '.'!r}"
                remedy = "correct or remove the row, or set recording.decimal in the case"
                return RecordingError(f"{place}, {shown(names[k])}", problem, remedy)
    reason = shown(cause.splitlines()[0] if cause else "", 120)
    return RecordingError(file, f"is not a CSV table: {reason}", "correct that line")


def _not_text(place: Path | str, form: RecordingFormat) -> RecordingError:
    return RecordingError(place, f"is not {form.encoding.upper()} text", "save the file as UTF-8")
