"""Lines of text to columns of numbers, by pyarrow; what it cannot read is explained by `diagnosis`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.csv as pacsv

from identification.formats.blocks import Block
from identification.formats.diagnosis import Dialect, explain
from identification.formats.table import Lines


@dataclass(frozen=True, slots=True)
class Fields:
    """Which fields of each line are wanted.

    Args:
        names: of all fields, as the file calls them, in their order.
        numbers: positions of measured values.
        stamps: positions of clocks; they stay integers where the file writes integers.
    """

    names: Sequence[str]
    numbers: Sequence[int]
    stamps: Sequence[int]


def parse(file: Path, block: Block, fields: Fields, dialect: Dialect) -> Mapping[int, pa.ChunkedArray]:
    """The wanted columns of a block by position: numbers as float64, stamps as int64 or float64.

    Raises:
        RecordingError: a line or a value cannot be read; the message names it.
    """
    wanted = [*fields.numbers, *(k for k in fields.stamps if k not in fields.numbers)]
    names = [str(k) for k in range(len(fields.names))]
    try:
        table = pacsv.read_csv(
            pa.BufferReader(block.data),
            # one thread: batches are small, and so the first of several errors is the one that is reported
            read_options=pacsv.ReadOptions(column_names=names, use_threads=False),
            parse_options=pacsv.ParseOptions(delimiter=dialect.delimiter),
            convert_options=pacsv.ConvertOptions(
                column_types={str(k): pa.float64() for k in fields.numbers},
                include_columns=[str(k) for k in wanted],
                null_values=list(dialect.missing),
                strings_can_be_null=bool(dialect.missing),
                decimal_point=dialect.decimal,
            ),
        )
    except (pa.ArrowException, UnicodeDecodeError) as error:
        raise explain(file, block, fields.names, wanted, dialect, str(error)) from error
    columns = {k: table.column(str(k)) for k in wanted}
    for k in fields.stamps:
        if pa.types.is_null(columns[k].type):
            columns[k] = columns[k].cast(pa.float64())
        if not (pa.types.is_int64(columns[k].type) or pa.types.is_float64(columns[k].type)):
            raise explain(file, block, fields.names, wanted, dialect, f"column {k} holds no numbers")
    return columns


def lines_of(block: Block, rows: int) -> Lines:
    """Where the rows of a block stand: pyarrow leaves blank lines out."""
    count = block.data.count(b"\n") + (not block.data.endswith(b"\n"))
    if count == rows:
        return Lines(block.first_line)
    blank = [k for k, line in enumerate(block.data.split(b"\n")[:count]) if not line.rstrip(b"\r")]
    return Lines(block.first_line, tuple(block.first_line + k for k in blank))
