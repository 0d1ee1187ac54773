"""Parquet files: a column a channel, named as in `csv`; clocks are numbers or Parquet's own time stamps."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from cases.errors import RecordingError
from cases.recording_format import RecordingFormat
from identification.formats.delimited import select, unknown_columns
from identification.formats.table import Array, ColumnTable, Lines, Stamps, shown
from identification.formats.text import unreadable

_TICKS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def tables(file: Path, form: RecordingFormat) -> Iterator[ColumnTable]:
    """Reads a file, row group by row group.

    Args:
        form: what its columns are called and how its clock counts.

    Raises:
        RecordingError: it cannot be read, with the place and the remedy.
    """
    try:
        with pq.ParquetFile(file) as parquet:
            yield from _tables(file, parquet, form)
    except (pa.ArrowException, OSError, ValueError) as error:
        if isinstance(error, RecordingError):
            raise
        if isinstance(error, OSError) and error.errno is not None:
            raise unreadable(file, error) from error
        reason = shown(" ".join(str(error).split()) or type(error).__name__, 120)
        raise RecordingError(file, f"is a damaged Parquet file ({reason})", "copy or export it again") from error


def _tables(file: Path, parquet: pq.ParquetFile, form: RecordingFormat) -> Iterator[ColumnTable]:
    names = tuple(parquet.schema_arrow.names)
    selection = select(file, names, form)
    if not selection.values:
        raise RecordingError(file, unknown_columns(names, form))
    clock = [] if selection.clock is None else [names[selection.clock]]
    columns = [*(names[k] for k in selection.values.values()), *clock]
    count = 0
    for group in range(parquet.num_row_groups):
        batch = parquet.read_row_group(group, columns=columns)
        values = {ours: _numbers(file, names[k], batch) for ours, k in selection.values.items()}
        stamps, tick = _stamps(file, clock[0], batch, form.tick, count) if clock else (None, 0.0)
        if stamps is None and form.clock.period is not None:
            stamps, tick = np.arange(count, count + batch.num_rows), form.clock.period
        yield ColumnTable(str(file), names, values, stamps, tick, Lines(count + 1, word="row"))
        count += batch.num_rows
    if not count:
        raise RecordingError(file, "has columns but no rows", "record again")


def _numbers(file: Path, name: str, batch: pa.Table) -> Array:
    column = batch.column(name)
    kind = column.type
    if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_boolean(kind)):
        raise RecordingError(f"{file}, {shown(name)}", f"holds {shown(str(kind))}, not numbers", "export it as double")
    return np.asarray(column.cast(pa.float64(), safe=False).to_numpy())


def _stamps(file: Path, name: str, batch: pa.Table, tick: float, above: int) -> tuple[Stamps, float]:
    """Time stamps below so many rows, and the duration of one unit of them [s]."""
    column = batch.column(name)
    kind = column.type
    if column.null_count:
        row = int(np.argmin(column.is_valid().to_numpy()))
        raise RecordingError(f"{file}, {shown(name)}", f"has no value in row {above + row + 1}", "remove the row")
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        return column.cast(pa.int64()).to_numpy(), _TICKS[kind.unit]
    if pa.types.is_integer(kind):
        return column.cast(pa.int64()).to_numpy(), tick
    return _numbers(file, name, batch), tick
