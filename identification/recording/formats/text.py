"""Tables as text, one row a sample: a table for each clock of the file."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.recording_format import CLOCK, TRIGGER
from identification.recording.formats import dates
from identification.recording.formats.content import Content, lines_of
from identification.recording.formats.table import ColumnTable, Lines, Stamps, listed, require_room, shown
from identification.recording.formats.text_layout import Layout
from identification.recording.formats.text_numbers import (
    Columns,
    WantedFields,
    columns_of,
    concatenated,
    fields_of_dates,
)

_LATE = 2  # samples by which the last of channels with one clock may differ


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
    wanted = WantedFields(
        tuple(sorted({*positions.values(), *parts_of_stamps})),
        frozenset(parts_of_stamps),
        frozenset(positions[ours] for ours in switches if ours in positions),
        fields_of_dates(content, layout, clocks),
    )
    if not wanted.positions:
        raise RecordingError(
            place=content.file,
            problem=phrase("no_numbers", "holds no columns of numbers"),
            remedy=phrase("export_rows", "export it again, one row a sample"),
            code=Code.WRONG_KIND,
        )
    parts = [columns_of(content, section, layout, wanted) for section in layout.sections]
    counts = [len(next(iter(part.values()))) for part in parts]
    if not sum(counts):
        raise RecordingError(
            place=content.file,
            problem=phrase("header_only", "has a header but no rows"),
            remedy=phrase("record_or_export", "record or export it again"),
            code=Code.TOO_FEW,
        )
    lines = _lines(content, layout, counts)
    columns = {k: concatenated([part[k] for part in parts]) for k in wanted.positions}
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
            remedy=phrase("again_with_times", "record or export it again, with the time of each row"),
            code=Code.WRONG_KIND,
        )


_Clock = tuple[Stamps | None, float]
"""Stamps of a channel, and the duration of one unit of them [s]; without a clock None and 0."""


def _table(
    content: Content, layout: Layout, positions: Mapping[str, int], columns: Columns, own: _Clock, lines: Lines
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
                place=place,
                problem=phrase("clock_gap", "a clock has no value but goes on below"),
                remedy=phrase("remove_row", "remove the row"),
                code=Code.CLOCK,
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
            remedy=phrase("mend_row_or_period", "correct or remove the row, or state recording.clock.period_ms"),
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
            place=place,
            problem=problem,
            remedy=phrase("correct_clock", "correct recording.clock in the case"),
            code=Code.CLOCK,
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
    difference = max(len(stamps), len(others)) - common
    return tick == other_tick and difference <= _LATE and np.array_equal(stamps[:common], others[:common])


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
