"""Numbers of a text's rows, read by pyarrow.

What pyarrow cannot read is written anew, a few megabytes at a time: words for switches and missing values, rows that
end early. The first line that is not a row of the table is named.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from identification.recording.formats import dates
from identification.recording.formats.content import PART, Block, Content, Section, blocks_of
from identification.recording.formats.table import shown
from identification.recording.formats.text_layout import Layout, not_text
from identification.recording.formats.words import EMPTY, MISSING, OFF, ON, is_switch, regular

_PEEK = 1 << 16  # bytes of the first rows that show which columns are switches in words
_FEW = 20  # rows that show which clocks are dates
Columns = dict[int, pa.ChunkedArray]
"""Position of a field -> its values in all rows."""


class WantedFields(NamedTuple):
    """Fields of a row that are read, by position."""

    positions: tuple[int, ...]  # all of them, ascending
    clocks: frozenset[int]
    switches: frozenset[int]  # may hold the states of a switch in words
    dates: frozenset[int] = frozenset()  # clocks whose stamps are dates or times of day


def concatenated(columns: Sequence[pa.ChunkedArray]) -> pa.ChunkedArray:
    """One column from parts of it, some of which may hold integers or nothing."""
    kinds = {column.type for column in columns}
    kind = columns[0].type if len(kinds) == 1 and not pa.types.is_null(columns[0].type) else pa.float64()
    return pa.chunked_array([chunk for column in columns for chunk in column.cast(kind).chunks], type=kind)


def columns_of(content: Content, section: Section, layout: Layout, wanted: WantedFields) -> Columns:
    """The wanted columns of a section: numbers as float64, stamps as int64 or float64, as the text writes them."""
    words = _in_words(content, section, layout, wanted.switches)
    if not layout.aligned:
        names = range(len(layout.fields))
        try:
            source = _opened(content).get_stream(section.start, section.end - section.start)
            return _columns(source, PART, layout, names, wanted, words)
        except (pa.ArrowException, UnicodeDecodeError):
            pass  # a line of it is not as pyarrow expects it
    last = section.first + section.rows - 1
    parts = [_block(content, block, layout, wanted, words, last) for block in blocks_of(content, section)]
    nothing = {k: pa.chunked_array([], pa.float64()) for k in wanted.positions}
    return {k: concatenated([part[k] for part in parts or [nothing]]) for k in wanted.positions}


def _opened(content: Content) -> pa.NativeFile:
    return pa.OSFile(str(content.file)) if content.data is None else pa.BufferReader(content.data)


def _block(
    content: Content, block: Block, layout: Layout, wanted: WantedFields, words: frozenset[int], last: int
) -> Columns:
    """The wanted columns of a part of a section whose last line has the number `last`; raises RecordingError."""
    data = squeezed(block[1]) if layout.aligned else block[1]
    try:
        names = range(len(layout.fields))
        return _columns(pa.BufferReader(data), len(data), layout, names, wanted, words)
    except (pa.ArrowException, UnicodeDecodeError):
        data = _rewritten(content.file, block, layout, wanted, last)
    if not data.strip():
        return {k: pa.chunked_array([], pa.float64()) for k in wanted.positions}
    return _columns(pa.BufferReader(data), len(data), layout, wanted.positions, wanted, frozenset())


def _columns(
    source: pa.NativeFile, size: int, layout: Layout, names: Iterable[int], wanted: WantedFields, words: frozenset[int]
) -> Columns:
    """The wanted columns of lines, by position; raises ArrowInvalid where one is not as expected.

    Args:
        size: bytes that are read at a time; the kind of stamps follows from the first ones.
        names: positions of the fields that the lines have.
        words: fields that hold the states of a switch in words.
    """
    kinds = {str(k): pa.bool_() if k in words else pa.float64() for k in wanted.positions if k not in wanted.clocks}
    kinds |= {str(k): pa.string() for k in wanted.dates}
    table = pacsv.read_csv(
        source,
        read_options=pacsv.ReadOptions(column_names=[str(k) for k in names], use_threads=False, block_size=size),
        parse_options=pacsv.ParseOptions(delimiter=layout.form.separator),
        convert_options=pacsv.ConvertOptions(
            column_types=kinds,
            include_columns=[str(k) for k in wanted.positions],
            null_values=list(EMPTY if layout.hold else MISSING),
            true_values=list(ON),
            false_values=list(OFF),
            strings_can_be_null=True,
            decimal_point=layout.form.decimal or ".",
        ),
    )
    columns = {k: table.column(str(k)) for k in wanted.positions}
    for k in wanted.clocks - wanted.dates:
        if columns[k].type not in (pa.int64(), pa.float64(), pa.null()):
            raise pa.ArrowInvalid("a time stamp is not a number")
    return columns | {k: columns[k].cast(pa.float64()) for k in words}


def _in_words(content: Content, section: Section, layout: Layout, switches: frozenset[int]) -> frozenset[int]:
    """Those of some fields that hold the states of a switch in words, by the first rows."""
    if not switches:
        return switches
    with content.opened() as stream:
        stream.seek(section.start)
        data = stream.read(min(_PEEK, section.end - section.start))
    rows = [layout.split(line.decode("latin-1")) for line in data.split(b"\n")[:-1]]
    return frozenset(k for k in switches if any(len(row) > k and is_switch(row[k]) for row in rows))


def fields_of_dates(content: Content, layout: Layout, clocks: Iterable[int]) -> frozenset[int]:
    """Those of some fields that hold dates or times of day, by the first rows."""
    fields = frozenset(clocks)
    if not fields or not layout.sections:
        return frozenset()
    with content.opened() as stream:
        stream.seek(layout.sections[0].start)
        data = stream.read(min(_PEEK, layout.sections[0].end - layout.sections[0].start))
    rows = [layout.split(line.decode(layout.form.encoding, "replace")) for line in data.split(b"\n")[:_FEW]]
    return frozenset(k for k in fields if any(len(row) > k and dates.is_stamp(row[k]) for row in rows))


def first_of(content: Content, layout: Layout, field: int) -> str:
    """A field of the first row; empty where there is none."""
    if not layout.sections:
        return ""
    with content.opened() as stream:
        stream.seek(layout.sections[0].start)
        line = stream.read(min(_PEEK, layout.sections[0].end - layout.sections[0].start)).split(b"\n", 1)[0]
    row = layout.split(line.decode(layout.form.encoding, "replace"))
    return row[field].strip() if field < len(row) else ""


def squeezed(data: bytes) -> bytes:
    """Lines of aligned columns with one blank between two fields."""
    letters = np.frombuffer(data, dtype=np.uint8)
    blank = (letters == ord(" ")) | (letters == ord("\t"))
    before = np.r_[True, blank[:-1] | (letters[:-1] == ord("\n"))]  # whether a line or another blank precedes
    remaining = letters[~(blank & before)].copy()
    remaining[remaining == ord("\t")] = ord(" ")
    after = np.r_[(remaining[1:] == ord("\n")) | (remaining[1:] == ord("\r")), True]
    return bytes(remaining[~((remaining == ord(" ")) & after)].tobytes())


def _rewritten(file: Path, block: Block, layout: Layout, wanted: WantedFields, last: int) -> bytes:
    """The wanted fields of lines as pyarrow reads them; raises RecordingError at the first that is not of the table."""
    first, data = block
    form, width, rows = layout.form, len(layout.fields), []
    for number, line in enumerate(data.split(b"\n"), first):
        if layout.is_no_row(line):
            continue
        place = f"{file}, line {number}"
        if not line.rstrip(b"\r").strip(b"\0"):
            raise RecordingError(
                place=place,
                problem=phrase("binary_zero", "is binary zero, as after a crash while recording"),
                remedy=phrase("cut_file_there", "cut the file off there"),
                code=Code.DAMAGED,
            )
        try:
            fields = layout.split(line.rstrip(b"\r").decode(form.encoding, "replace" if layout.uneven else "strict"))
        except UnicodeDecodeError:
            raise not_text(place, form) from None
        if layout.uneven:
            fields += [""] * (width - len(fields))
        if len(fields) < width or (any(map(str.strip, fields[width:])) and not layout.remarks):
            remedy = "correct or remove the row, or state delimiter, decimal and trailing_rows in [recording]"
            if number == last and len(fields) < width and not data.endswith(b"\n"):
                remedy = "the file is cut off in its last line: remove that line"
            raise RecordingError(
                place=place,
                problem=phrase(
                    "other_width", "expected {expected} columns, got {got}", expected=width, got=len(fields)
                ),
                remedy=remedy,
                code=Code.DAMAGED,
            )
        row = []
        for k in wanted.positions:
            value = fields[k] if k in wanted.dates else regular(fields[k], form, k in wanted.switches)
            if value is None:
                problem = f"{shown(fields[k])!r} is not a number with a decimal {form.decimal or '.'!r}"
                remedy = "correct or remove the row, or set recording.decimal in the case"
                raise RecordingError(
                    place=f"{place}, {shown(layout.label(k))}", problem=problem, remedy=remedy, code=Code.WRONG_KIND
                )
            row.append(value)
        rows.append(form.separator.join(row) if len(row) > 1 or row[0] else "nan")
    return "\n".join(rows).encode()
