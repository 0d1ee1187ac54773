"""Tables as text, one row a sample: their layout as a value, and their numbers, read by pyarrow.

What pyarrow cannot read is written anew, a few megabytes at a time: words for switches and missing values, rows that
end early. The first line that is not a row of the table is named.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv as pacsv

from cases.base.errors import Code, RecordingError
from cases.base.phrases import Phrase, phrase
from cases.recording_format import CLOCK, COLUMNS, TRIGGER, FileFormat
from identification.recording.formats import dates
from identification.recording.formats.content import PART, Block, Content, Section, blocks_of, lines_of
from identification.recording.formats.table import ColumnTable, Lines, Stamps, listed, require_room, shown
from identification.recording.formats.words import EMPTY, MISSING, OFF, ON, is_switch, regular, split

_REMARKS = (b"#", b"%", b"//")  # how a line begins that is a remark among rows
_TYPICAL = ("t_s", "l1_mm", "q1_mm", "x_mm", "r11", "ax", "f1_N", "fx_N")
_PEEK = 1 << 16  # bytes of the first rows that show which columns are switches in words
_FEW = 20  # rows that show which clocks are dates
_LATE = 2  # samples by which the last of channels with one clock may differ


@dataclass(frozen=True, slots=True)
class Field:
    """A field of each row."""

    name: str  # as the file calls it; empty where it does not
    also: tuple[str, ...] = ()  # other names that the file has for it
    unit: str = ""  # as a row of units has it
    clock: int | None = None  # position of the field with its time stamps, where the format says which
    step: float | None = None  # time between its rows, where the format states that [s]


@dataclass(frozen=True, slots=True)
class Layout:
    """Where a text has its table, and what the fields of its rows are."""

    form: FileFormat  # how the case describes it; separator, decimal sign and encoding are those of the text
    fields: tuple[Field, ...]
    sections: tuple[Section, ...]  # the rows; several where headers stand between them
    names_row: int = 0  # line that names the fields, counted from 1; 0: none does
    starts: tuple[float, ...] = (0.0,)  # what the stamps of each section count from [s]
    tick: float = 1.0  # duration of a unit of the stamps [s]
    period: float | None = None  # time between rows where no field is a clock [s]; None: there is no clock
    aligned: bool = False  # any number of blanks between two fields
    uneven: bool = False  # rows end with the last channel that goes on
    remarks: bool = False  # text may follow behind the last field
    no_rows: tuple[bytes, ...] = ()  # words that stand in a line of their own and are not a row
    hold: bool = False  # whether a field that is empty has its last value
    apart: bool = False  # whether rows of several clocks stand among each other, and fields of the others are empty
    header: tuple[str, ...] = ()  # the lines above the rows

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns, without those of clocks."""
        clocks = {field.clock for field in self.fields}
        return tuple(field.name for k, field in enumerate(self.fields) if field.name and k not in clocks)

    def label(self, position: int) -> str:
        """What a message calls a field."""
        timed = [field.name for field in self.fields if field.clock == position and field.name]
        return f"time of {timed[0]}" if timed else self.fields[position].name or f"column {position + 1}"

    def split(self, line: str) -> list[str]:
        """The fields of a line."""
        return line.split() if self.aligned else split(line, self.form.separator)

    def is_no_row(self, line: bytes) -> bool:
        """Whether a line is blank, holds nothing but a word that is not a row, or a remark."""
        blanks = b" \t\r" if self.aligned else b" \t\r".replace(self.form.separator.encode(), b"")
        word = line.strip(blanks)
        if not word or word in self.no_rows:
            return True
        return word.startswith(_REMARKS) and len(self.split(word.decode("latin-1"))) != len(self.fields)


def cells(line: str, form: FileFormat) -> list[str]:
    """Fields of a header line."""
    return [name.strip() for name in split(line, form.separator)]


def decoded(file: Path, lines: Sequence[bytes], form: FileFormat) -> list[str]:
    """Header lines as text; raises RecordingError where one is not."""
    try:
        return [line.decode(form.encoding) for line in lines]
    except UnicodeDecodeError:
        raise _not_text(file, form) from None


def select(file: Path, fields: Sequence[Field], form: FileFormat) -> dict[str, int]:
    """Our columns among those of a file, each with its position; raises RecordingError where one is there twice."""
    positions, mapped = {}, set(form.columns.values())
    clocks = {field.clock for field in fields} - {None}
    for ours in COLUMNS:
        theirs = form.file_name(ours)
        if theirs in mapped and ours not in form.columns:
            continue  # the case gives the column of that name another meaning
        if ours == CLOCK and clocks:
            continue  # the format says which it is
        places = [k for k, field in enumerate(fields) if field.name == theirs and k not in clocks]
        places = places or [k for k, field in enumerate(fields) if theirs in field.also and k not in clocks]
        if len(places) > 1:
            others = [name for k in places for name in fields[k].also[:1]]
            remedy = f"use their other names, such as {listed(others)}" if others else "rename or remove one"
            often = "twice" if len(places) == 2 else f"{len(places)} times"
            raise RecordingError(
                place=file, problem=f"column {shown(theirs)} is there {often}", remedy=remedy, code=Code.WRONG_KIND
            )
        if places:
            positions[ours] = places[0]
    return positions


def without(names: Iterable[str], form: FileFormat, wanted: Sequence[str] = _TYPICAL) -> Phrase:
    """What to say of a file with columns of some names that has none of those, by our names, that are wanted."""
    columns = listed(map(form.file_name, wanted))
    return phrase(
        "none_of_columns",
        "none of the columns {columns}; it has {there}: name them so or map them in [recording.columns], or state "
        "separator and header in [recording] of the case, as hexcite look proposes",
        columns=columns,
        there=listed(names),
    )


def tables(
    content: Content, layout: Layout, chosen: Mapping[str, int], switches: Iterable[str] = (TRIGGER,)
) -> Iterator[ColumnTable]:
    """The table of each clock of a text; raises RecordingError where a line cannot be read, or there is none.

    Args:
        chosen: the fields that are wanted, our name -> position.
        switches: those of them that may hold the states of a switch in words.
    """
    positions = {ours: k for ours, k in chosen.items() if ours != CLOCK}
    clock_of = {
        ours: chosen.get(CLOCK) if (clock_of_column := layout.fields[k].clock) is None else clock_of_column
        for ours, k in positions.items()
    }
    clocks = sorted({clock for clock in clock_of.values() if clock is not None})
    parts_of_stamps = [*clocks, *_nanoseconds(content, layout, chosen)]
    require_room(content.file, sum(section.rows for section in layout.sections), len(positions) + len(clocks))
    wanted = _Wanted(
        tuple(sorted({*positions.values(), *parts_of_stamps})),
        frozenset(parts_of_stamps),
        frozenset(positions[ours] for ours in switches if ours in positions),
        _of_dates(content, layout, clocks),
    )
    if not wanted.positions:
        raise RecordingError(
            place=content.file,
            problem=phrase("no_numbers", "holds no columns of numbers"),
            remedy=phrase("export_rows", "export it again, one row a sample"),
            code=Code.WRONG_KIND,
        )
    parts = [_section(content, section, layout, wanted) for section in layout.sections]
    counts = [len(next(iter(part.values()))) for part in parts]
    if not sum(counts):
        raise RecordingError(
            place=content.file,
            problem=phrase("header_only", "has a header but no rows"),
            remedy=phrase("record_or_export", "record or export it again"),
            code=Code.TOO_FEW,
        )
    lines = _lines(content, layout, counts)
    columns = {k: _concatenated([part[k] for part in parts]) for k in wanted.positions}
    stamps = {k: _stamps(content, layout, k, columns[k], counts, lines) for k in parts_of_stamps}
    if len(parts_of_stamps) > len(clocks):
        stamps = {clocks[0]: _in_two_columns(content, layout, [stamps[k] for k in parts_of_stamps], lines)}
    own_of = {ours: _own_clock(layout, k, clock_of[ours], stamps, columns[k], counts) for ours, k in positions.items()}
    units = {ours: layout.fields[k].unit for ours, k in chosen.items() if layout.fields[k].unit}
    recorded = False
    for group in _groups(own_of):
        shared = min((own_of[ours] for ours in group), key=lambda own: np.inf if own[0] is None else len(own[0]))
        if shared[0] is None or len(shared[0]):  # else it is a channel that was not recorded
            recorded = True
            table = _table(content, layout, {ours: positions[ours] for ours in group}, columns, shared, lines)
            table = replace(table, unit_cells=units, header=layout.header)
            yield from _apart(table) if layout.apart else [table]
    if not recorded:
        empty = "has time stamps in no row" if clocks else "has values in no row"
        raise RecordingError(
            place=content.file,
            problem=empty,
            remedy="record or export it again, with the time of each row",
            code=Code.WRONG_KIND,
        )


class _Wanted(NamedTuple):
    """Fields of a row that are read, by position."""

    positions: tuple[int, ...]  # all of them, ascending
    clocks: frozenset[int]
    switches: frozenset[int]  # may hold the states of a switch in words
    dates: frozenset[int] = frozenset()  # clocks whose stamps are dates or times of day


_Clock = tuple[Stamps | None, float]
"""Stamps of a channel, and the duration of one unit of them [s]; without a clock None and 0."""
_Columns = dict[int, pa.ChunkedArray]


def _table(
    content: Content, layout: Layout, positions: Mapping[str, int], columns: _Columns, own: _Clock, lines: Lines
) -> ColumnTable:
    """Channels that share their clock, as numbers."""
    stamps, tick = own
    values = {}
    for ours, k in positions.items():
        column = columns[k] if stamps is None else columns[k].slice(0, len(stamps))
        if layout.hold:
            column = pc.fill_null_forward(column)
        values[ours] = column.to_numpy()
    stamped = any(layout.fields[k].clock is not None for k in positions.values()) or layout.form.file_name(CLOCK) in (
        field.name for field in layout.fields
    )
    return ColumnTable(str(content.file), layout.form, layout.names, values, stamps, tick, lines, stamped)


def _apart(table: ColumnTable) -> Iterator[ColumnTable]:
    """A table for the columns that have their values in the same rows, and of these rows alone."""
    groups: dict[bytes, list[str]] = {}
    for ours, column in table.values.items():
        groups.setdefault(np.isfinite(column).tobytes(), []).append(ours)
    for mask, group in groups.items():
        rows = np.frombuffer(mask, dtype=bool)
        if rows.any():
            yield replace(
                table,
                values={ours: table.values[ours][rows] for ours in group},
                stamps=None if table.stamps is None else table.stamps[rows],
                lines=table.lines.without(np.flatnonzero(~rows).tolist()),
            )


def _own_clock(
    layout: Layout,
    position: int,
    clock: int | None,
    stamps: "Mapping[int, _Clock]",
    column: pa.ChunkedArray,
    counts: Sequence[int],
) -> _Clock:
    """The clock of a channel: stamps in a field, or rows at equal steps."""
    if clock is not None:
        return stamps[clock]
    step = layout.fields[position].step or layout.period
    if step is None:
        return None, 0.0
    rows = np.concatenate([np.arange(n) + start / step for n, start in zip(counts, layout.starts, strict=True)])
    if not any(layout.starts):
        rows = np.arange(sum(counts))
    if layout.uneven:
        valid = np.flatnonzero(column.is_valid().to_numpy())
        rows = rows[: valid[-1] + 1 if len(valid) else 0]
    return rows, step


def _stamps(
    content: Content, layout: Layout, position: int, column: pa.ChunkedArray, counts: Sequence[int], lines: Lines
) -> "_Clock":
    """A clock in a field, of one that ends earlier than others up to its last sample; raises RecordingError."""
    valid = column.is_valid().to_numpy()
    count = int(valid.sum()) if layout.uneven else len(column)
    if not valid[:count].all():
        place = f"{content.file}, {lines.place(int(np.argmin(valid)))}"
        if layout.uneven:
            raise RecordingError(
                place=place, problem="a clock has no value but goes on below", remedy="remove the row", code=Code.CLOCK
            )
        place = f"{place}, {shown(layout.label(position))}"
        raise RecordingError(
            place=place,
            problem=phrase("no_stamp", "is empty where a time stamp is needed"),
            remedy=phrase("remove_row", "remove the row"),
            code=Code.CLOCK,
        )
    column = column.slice(0, count)
    if pa.types.is_string(column.type):
        if (dated := dates.stamps_of(column)) is not None:
            return dated, dates.TICK
        row = dates.first_unread(column)
        place = f"{content.file}, {lines.place(row)}, {shown(layout.label(position))}"
        problem = f"{shown(str(column[row]))!r} is not a time stamp like those above it"
        raise RecordingError(
            place=place,
            problem=problem,
            remedy="correct or remove the row, or state recording.clock.period_ms",
            code=Code.CLOCK,
        )
    stamps = np.asarray(column.to_numpy())
    if any(layout.starts):
        stamps = stamps + np.repeat(layout.starts, counts)[:count] / layout.tick
    return stamps, layout.tick


_A_SECOND = 1_000_000_000  # [ns]


def _nanoseconds(content: Content, layout: Layout, chosen: Mapping[str, int]) -> list[int]:
    """Position of the field that adds nanoseconds to the stamps, where the case states one.

    Raises RecordingError where it is not there, or the seconds are not.
    """
    name = layout.form.clock.nanoseconds
    if name is None or CLOCK not in chosen:
        return []
    places = [k for k, field in enumerate(layout.fields) if name in (field.name, *field.also)]
    if len(places) != 1:
        problem = f"has no column {shown(name)}" if not places else f"has several columns {shown(name)}"
        remedy = "correct recording.clock.nanoseconds in the case"
        raise RecordingError(
            place=content.file, problem=f"{problem}; it has {listed(layout.names)}", remedy=remedy, code=Code.WRONG_KIND
        )
    return places


def _in_two_columns(content: Content, layout: Layout, parts: Sequence[_Clock], lines: Lines) -> _Clock:
    """Stamps of whole seconds and nanoseconds on top; raises RecordingError where they are not such."""
    (whole, _), (part, _) = parts
    assert whole is not None
    assert part is not None
    column, odd = layout.form.clock.nanoseconds, (part < 0) | (part >= _A_SECOND) | (part != np.floor(part))
    if odd.any() or layout.form.tick != 1.0:
        row = int(np.argmax(odd))
        problem = f"{part[row].item():g} is not a count of nanoseconds within a second"
        if layout.form.tick != 1.0:
            problem = "adds nanoseconds to stamps that are not in seconds"
        place = f"{content.file}, {lines.place(row)}, {shown(str(column))}"
        raise RecordingError(
            place=place, problem=problem, remedy="correct recording.clock in the case", code=Code.CLOCK
        )
    return whole.astype(np.int64) * _A_SECOND + part.astype(np.int64), 1.0 / _A_SECOND


def _groups(clocks: Mapping[str, _Clock]) -> list[tuple[str, ...]]:
    """Channels that share their clock: the same one, or equal ones; their last samples may be missing."""
    groups: dict[str, tuple[str, ...]] = {}
    for ours, clock in clocks.items():
        first = next((other for other in groups if _alike(clocks[other], clock)), ours)
        groups[first] = (*groups.get(first, ()), ours)
    return [*groups.values()]


def _alike(one: _Clock, other: _Clock) -> bool:
    (stamps, tick), (others, other_tick) = one, other
    if stamps is None or others is None or stamps is others:
        return stamps is others
    common = min(len(stamps), len(others))
    late = max(len(stamps), len(others)) - common
    return tick == other_tick and late <= _LATE and np.array_equal(stamps[:common], others[:common])


def _lines(content: Content, layout: Layout, counts: Sequence[int]) -> Lines:
    """Where the rows of all sections stand."""
    skipped: list[int] = []
    end = layout.sections[0].first
    for section, rows in zip(layout.sections, counts, strict=True):
        skipped += range(end, section.first)
        end = section.first + section.rows
        if rows != section.rows:
            data = lines_of(content, section).split(b"\n")[: section.rows]
            skipped += [number for number, line in enumerate(data, section.first) if layout.is_no_row(line)]
    return Lines(layout.sections[0].first, tuple(skipped))


def _concatenated(columns: Sequence[pa.ChunkedArray]) -> pa.ChunkedArray:
    """One column from parts of it, some of which may hold integers or nothing."""
    kinds = {column.type for column in columns}
    kind = columns[0].type if len(kinds) == 1 and not pa.types.is_null(columns[0].type) else pa.float64()
    return pa.chunked_array([chunk for column in columns for chunk in column.cast(kind).chunks], type=kind)


def _section(content: Content, section: Section, layout: Layout, wanted: _Wanted) -> _Columns:
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
    return {k: _concatenated([part[k] for part in parts or [nothing]]) for k in wanted.positions}


def _opened(content: Content) -> pa.NativeFile:
    return pa.OSFile(str(content.file)) if content.data is None else pa.BufferReader(content.data)


def _block(
    content: Content, block: Block, layout: Layout, wanted: _Wanted, words: frozenset[int], last: int
) -> _Columns:
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
    source: pa.NativeFile, size: int, layout: Layout, names: Iterable[int], wanted: _Wanted, words: frozenset[int]
) -> _Columns:
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


def _of_dates(content: Content, layout: Layout, clocks: Iterable[int]) -> frozenset[int]:
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


def _rewritten(file: Path, block: Block, layout: Layout, wanted: _Wanted, last: int) -> bytes:
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
            raise _not_text(place, form) from None
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


def _not_text(place: Path | str, form: FileFormat) -> RecordingError:
    return RecordingError(
        place=place,
        problem=f"is not {form.encoding.upper()} text",
        remedy="save the file as UTF-8",
        code=Code.UNREADABLE,
    )
