"""Parquet: files with a column a channel, named as in `csv`; clocks are numbers or Parquet's own time stamps."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.base.units import Array
from cases.recording_format import CLOCK, TICKS, FileFormat
from identification.recording.formats.table import ColumnTable, Lines, Stamps, require_room, shown, unreadable
from identification.recording.formats.text_layout import Field, select, without

if TYPE_CHECKING:
    import pyarrow as pa


def parquet_tables(file: Path, form: FileFormat) -> list[ColumnTable]:
    """Reads a file; raises RecordingError with the place and the remedy."""
    import pyarrow as pa
    import pyarrow.parquet as pq  # costs 50 ms, and few need it

    try:
        with pq.ParquetFile(file) as parquet:
            names, rows = tuple(parquet.schema_arrow.names), parquet.metadata.num_rows
            chosen = select(file, [Field(name) for name in names], form)
            clock = [names[chosen.pop(CLOCK)]] if CLOCK in chosen else []
            if not chosen:
                raise RecordingError(place=file, problem=without(names, form), code=Code.MISSING)
            if not rows:
                raise RecordingError(
                    place=file,
                    problem=phrase("no_rows", "has columns but no rows"),
                    remedy=phrase("record_again", "record again"),
                    code=Code.TOO_FEW,
                )
            require_room(file, rows, len(chosen))
            table = parquet.read(columns=[*(names[k] for k in chosen.values()), *clock])
    except (pa.ArrowException, OSError, ValueError) as error:
        if isinstance(error, RecordingError):
            raise
        if isinstance(error, OSError) and error.errno is not None:
            raise unreadable(file, error) from error
        reason = shown(" ".join(str(error).split()) or type(error).__name__, 120)
        raise RecordingError(
            place=file,
            problem=phrase("parquet_damaged", "is a damaged Parquet file ({reason})", reason=reason),
            remedy=phrase("copy_or_export", "copy or export it again"),
            code=Code.DAMAGED,
        ) from error
    values = {ours: _numbers(file, names[k], table) for ours, k in chosen.items()}
    stamps, tick = _stamps(file, clock[0], table, form.tick) if clock else (None, 0.0)
    if stamps is None and form.clock.period is not None:
        stamps, tick = np.arange(rows), form.clock.period
    return [ColumnTable(str(file), form, names, values, stamps, tick, Lines(1, word="row"), bool(clock))]


def _numbers(file: Path, name: str, table: "pa.Table") -> Array:
    import pyarrow as pa

    column = table.column(name)
    kind = column.type
    if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_boolean(kind)):
        raise RecordingError(
            place=f"{file}, {shown(name)}",
            problem=phrase("parquet_kind", "holds {kind}, not numbers", kind=shown(str(kind))),
            remedy=phrase("export_double", "export it as double"),
            code=Code.WRONG_KIND,
        )
    return np.asarray(column.cast(pa.float64(), safe=False).to_numpy())


def _stamps(file: Path, name: str, table: "pa.Table", tick: float) -> tuple[Stamps, float]:
    """Time stamps, and the duration of one unit of them [s]."""
    import pyarrow as pa

    column = table.column(name)
    kind = column.type
    if column.null_count:
        row = int(np.argmin(column.is_valid().to_numpy()))
        raise RecordingError(
            place=f"{file}, {shown(name)}",
            problem=phrase("parquet_no_value", "has no value in row {row}", row=row + 1),
            remedy=phrase("remove_row", "remove the row"),
            code=Code.MISSING,
        )
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        return column.cast(pa.int64()).to_numpy(), TICKS[kind.unit]
    if pa.types.is_integer(kind):
        return column.cast(pa.int64()).to_numpy(), tick
    return _numbers(file, name, table), tick
