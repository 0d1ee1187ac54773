"""A text file in blocks of whole lines, so that memory does not grow with its length, and these as columns of numbers.

pyarrow reads the numbers; what it cannot read is told by one message with line, column, value and remedy.
"""

import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.csv as pacsv

from cases.errors import RecordingError
from identification.formats.table import Lines, require_file, shown, unreadable

SIZE = 1 << 22  # bytes read at a time
# What is kept back for the end of the file, so that its trailing rows are never handed out: a hundred long lines.
_KEPT = 1 << 16
_LONGEST_LINE = 1 << 20  # bytes; a recording of a thousand channels stays far below
_MARK = b"\xef\xbb\xbf"  # of UTF-8, as Windows editors write it
_NOT_TEXT = {
    b"\xff\xfe": "UTF-16 text; save it as UTF-8",
    b"\xfe\xff": "UTF-16 text; save it as UTF-8",
    b"PK\x03\x04": "a ZIP archive or a workbook of a spreadsheet; unpack it, or save it as CSV",
    b"\x1f\x8b": "compressed; unpack it",
}


_NUMBER = re.compile(r"\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\s*|\s*[+-]?(nan|inf(inity)?)\s*", re.I)
_DECIMAL_COMMAS = re.compile(r"[0-9],[0-9]")


@dataclass(frozen=True, slots=True)
class TextFormat:
    """How a text file writes its numbers."""

    delimiter: str  # delimiter between the fields of a line
    decimal: str = "."  # sign, point or comma
    missing: tuple[str, ...] = ()  # fields that stand for no value; without them an empty field is an error
    encoding: str = "utf-8"  # encoding of the text

    def split(self, line: str) -> list[str]:
        """The fields of a line."""
        try:
            return next(csv.reader([line], delimiter=self.delimiter), [])
        except csv.Error:
            return line.split(self.delimiter)

    def is_number(self, text: str) -> bool:
        """Whether a field can be read."""
        if text in self.missing:
            return True
        if self.decimal == ",":
            return "." not in text and is_number(text.replace(",", ".", 1))
        return is_number(text)


def is_number(text: str) -> bool:
    """Whether text is a number with a decimal point."""
    return _NUMBER.fullmatch(text) is not None


@dataclass(frozen=True, slots=True)
class TextBlock:
    """Whole lines of a file."""

    first_line: int  # number of the first of them, counted from 1
    data: bytes  # the lines; only the very last of the file may lack its line break


def read_head(file: Path) -> list[bytes]:
    """The first lines of a text file without line breaks and byte order mark: more than any header has.

    Raises:
        RecordingError: there is no such file, or it is not text.
    """
    require_file(file)
    try:
        with file.open("rb") as stream:
            data = stream.read(_LONGEST_LINE)
    except OSError as error:
        raise unreadable(file, error) from error
    for mark, kind in _NOT_TEXT.items():
        if data.startswith(mark):
            raise RecordingError(file, f"is not a CSV table but {kind}")
    lines = data.removeprefix(_MARK).split(b"\n")
    if not any(line.strip() for line in lines):
        raise RecordingError(file, "is empty, it has blank lines only", "record again")
    return [line.removesuffix(b"\r") for line in lines]


def read_blocks(
    file: Path, header_rows: int = 0, trailing_rows: int = 0, size: int = SIZE, kept: int = _KEPT
) -> Iterator[TextBlock]:
    """Whole lines of a text file, block by block, without header, trailing rows and blank lines at the end.

    Args:
        file: a text file, see `read_head`.
        header_rows: lines at its start to leave out.
        trailing_rows: lines at its end to leave out, blank ones not counted.
        size: bytes to read at a time.
        kept: bytes at the end that hold the trailing rows.

    Raises:
        RecordingError: it cannot be read, or has a line without end.
    """
    for block in _all_blocks(file, trailing_rows, size, kept):
        above = header_rows + 1 - block.first_line
        if above <= 0:
            yield block
            continue
        rows = block.data.split(b"\n", above)
        if len(rows) > above and rows[-1]:
            yield TextBlock(header_rows + 1, rows[-1])


def _all_blocks(file: Path, trailing_rows: int, size: int, reserve: int) -> Iterator[TextBlock]:
    line, rest = 1, b""
    try:
        with file.open("rb") as stream:
            rest = stream.read(len(_MARK)).removeprefix(_MARK)
            while chunk := stream.read(size):
                rest += chunk
                end = max(len(rest) - reserve, 0)
                cut = rest.rfind(b"\n", 0, end) + 1
                if cut:
                    yield TextBlock(line, rest[:cut])
                    line += rest.count(b"\n", 0, cut)
                    rest = rest[cut:]
                elif end > _LONGEST_LINE:
                    raise RecordingError(
                        f"{file}, line {line}", "is longer than a million characters", "not a CSV table"
                    )
    except OSError as error:
        raise unreadable(file, error) from error
    if data := _without_end(rest, trailing_rows):
        yield TextBlock(line, data)


def _without_end(data: bytes, trailing_rows: int) -> bytes:
    """The lines above blank ones at the end and above the last rows that are not blank."""
    lines = data.splitlines(keepends=True)
    while lines:
        blank = not lines[-1].strip(b" \t\r\n\x1a")
        if not blank and trailing_rows == 0:
            break
        trailing_rows -= not blank
        lines.pop()
    return b"".join(lines)


def parse(
    file: Path,
    block: TextBlock,
    dialect: TextFormat,
    fields: Sequence[str],
    numbers: Iterable[int],
    stamps: Sequence[int],
) -> Mapping[int, pa.ChunkedArray]:
    """The wanted columns of a block by position: numbers as float64, stamps as int64 or float64.

    Args:
        fields: names of all fields of a line, as the file calls them.
        numbers: positions of measured values.
        stamps: positions of clocks; they stay integers where the file writes integers.

    Raises:
        RecordingError: a line or a value cannot be read; the message names it.
    """
    positions = list(dict.fromkeys([*numbers, *stamps]))
    names = [str(k) for k in range(len(fields))]
    try:
        table = pacsv.read_csv(
            pa.BufferReader(block.data),
            # one thread: batches are small, and so the first of several errors is the one that is reported
            read_options=pacsv.ReadOptions(column_names=names, use_threads=False),
            parse_options=pacsv.ParseOptions(delimiter=dialect.delimiter),
            convert_options=pacsv.ConvertOptions(
                column_types={str(k): pa.float64() for k in numbers},
                include_columns=[str(k) for k in positions],
                null_values=list(dialect.missing),
                strings_can_be_null=bool(dialect.missing),
                decimal_point=dialect.decimal,
            ),
        )
    except (pa.ArrowException, UnicodeDecodeError) as error:
        raise explain(file, block, fields, positions, dialect, str(error)) from error
    columns = {k: table.column(str(k)) for k in positions}
    for k in stamps:
        if pa.types.is_null(columns[k].type):
            columns[k] = columns[k].cast(pa.float64())
        if not (pa.types.is_int64(columns[k].type) or pa.types.is_float64(columns[k].type)):
            raise explain(file, block, fields, positions, dialect, f"column {k} holds no numbers")
    return columns


def lines_of(block: TextBlock, rows: int) -> Lines:
    """Where the rows of a block stand: pyarrow leaves blank lines out."""
    count = block.data.count(b"\n") + (not block.data.endswith(b"\n"))
    if count == rows:
        return Lines(block.first_line)
    blank = [k for k, line in enumerate(block.data.split(b"\n")[:count]) if not line.rstrip(b"\r")]
    return Lines(block.first_line, tuple(block.first_line + k for k in blank))


def explain(
    file: Path, block: TextBlock, names: Sequence[str], wanted: Sequence[int], dialect: TextFormat, cause: str
) -> RecordingError:
    """The error for a block that could not be read: its first line that is to blame.

    Args:
        file: file that the block is from.
        wanted: positions of the fields that must be numbers.
        cause: what the parser said, for damage that is not understood here.
    """
    for number, raw, ends in _lines(block):
        place = f"{file}, line {number}"
        if not raw.strip(b"\0"):
            return RecordingError(place, "is binary zero, as after a crash while recording", "cut the file off there")
        try:
            text = raw.decode(dialect.encoding)
        except UnicodeDecodeError:
            return not_text(place, dialect)
        fields = dialect.split(text)
        if len(fields) != len(names):
            return RecordingError(
                place, f"expected {len(names)} columns, got {len(fields)}", _why(fields, names, dialect, text, ends)
            )
        for k in wanted:
            if not dialect.is_number(fields[k]):
                return RecordingError(f"{place}, {shown(names[k])}", _not_a_number(fields[k], dialect))
    reason = shown(cause.splitlines()[0] if cause else "", 120)
    return RecordingError(file, f"is not a CSV table: {reason}", "correct that line")


def not_text(place: str, dialect: TextFormat) -> RecordingError:
    """The error for bytes that the file's encoding does not know."""
    return RecordingError(place, f"is not {dialect.encoding.upper()} text", "save the file as UTF-8")


def _lines(block: TextBlock) -> Iterator[tuple[int, bytes, bool]]:
    """Number, text and whether it ends with a line break, of each line that is not blank."""
    lines = block.data.split(b"\n")
    for k, line in enumerate(lines):
        if line.rstrip(b"\r"):
            yield block.first_line + k, line.rstrip(b"\r"), k < len(lines) - 1


def _why(fields: Sequence[str], names: Sequence[str], dialect: TextFormat, text: str, ends: bool) -> str:
    if len(fields) < len(names) and not ends:
        return "the file is cut off in its last line: remove that line"
    if len(fields) > len(names) and dialect.delimiter == "," and _DECIMAL_COMMAS.search(text):
        return "does it have decimal commas? export with semicolons and set recording.delimiter and recording.decimal"
    if len(fields) > len(names) and dialect.delimiter == " " and "  " in text:
        return "there are several blanks between numbers: export with one character between them"
    return "correct or remove the row"


def _not_a_number(text: str, dialect: TextFormat) -> str:
    if not text.strip():
        return "is empty where a number is needed; correct or remove the row"
    value = f"{shown(text)!r} is not a number"
    if dialect.decimal == "." and text.count(",") == 1 and is_number(text.replace(",", ".")):
        return f"{value}: it has a decimal comma; set recording.decimal = ',' in the case, or export with points"
    if dialect.decimal == "," and is_number(text):
        return f"{value}: it has a decimal point; set recording.decimal = '.' in the case, or export with commas"
    return f"{value}; correct or remove the row"
