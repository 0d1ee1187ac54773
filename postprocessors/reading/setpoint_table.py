"""A table of setpoints as numbers: CSV below lines of `# key: value`, or Parquet with those in its metadata."""

import re
from typing import NamedTuple

import numpy as np

from cases.errors import ProgramError
from cases.units import DEG, MM
from identification.motion import Array

FORMAT = "hexcite setpoints 1"
_STRUTS = tuple(f"l{k}" for k in range(1, 7))
LARGEST = 1e7  # mm, degrees and their rates: no machine has such numbers
PARQUET = b"PAR1"
METADATA = b"hexcite"
_HEADER = re.compile(r"#\s*(?P<key>[a-z_]+):\s*(?P<value>.*?)\s*$")
_STRANGE = re.compile(r"[^0-9.,+\-\n]")


def columns_of(coordinates: tuple[str, ...], struts: bool) -> tuple[str, ...]:
    """The columns of a table.

    Args:
        coordinates: names of the machine's, with their units.
        struts: whether it has struts too.
    """
    first, second = (f"{s[0]}d{s[1]}_mm_s" for s in _STRUTS), (f"{s[0]}dd{s[1]}_mm_s2" for s in _STRUTS)
    return (
        "t_s",
        *coordinates,
        *(f"v_{c}_s" for c in coordinates),
        *(f"acc_{c}_s2" for c in coordinates),
        *((*(f"{s}_mm" for s in _STRUTS), *first, *second) if struts else ()),
        "trigger",
    )


def units_of(columns: tuple[str, ...]) -> Array:
    """SI values of the columns' units, shape (columns,)."""
    return np.array([DEG if "deg" in c else MM if "mm" in c else 1.0 for c in columns])


class Table(NamedTuple):
    """A table as read.

    Args:
        first: line of its first row (Parquet: 1).
        header: keys and values.
        values: one row a cycle, the columns of `columns_of`, in the units of their names.
    """

    first: int
    header: dict[str, str]
    values: Array


def read_table(content: bytes, file: str, most: int, columns: tuple[str, ...]) -> Table:
    """The numbers of a table.

    Args:
        content: of the file.
        file: its name, for messages.
        most: rows that the controller's memory holds.
        columns: that the table must have.

    Raises:
        ProgramError: not such a table, or a cell that is no number; with line and column.
    """
    table = _parquet(content, file, columns) if content[:4] == PARQUET else _csv(content, file, columns)
    rows, _ = table.values.shape
    if rows > most:
        raise ProgramError(
            file, 0, 0, f"{rows} rows, the controller's memory holds {most} (most_rows); plan a shorter motion"
        )
    if rows < 2:
        raise ProgramError(file, 0, 0, "fewer than two rows; the file is truncated")
    bad = ~(np.abs(table.values) <= LARGEST)
    if bad.any():
        row, column = np.argwhere(bad)[0]
        value = table.values[row, column]
        raise ProgramError(file, table.first + int(row), 0, f"{columns[column]} = {value:g} is no machine's number")
    if table.header.get("format") != FORMAT:
        raise ProgramError(file, 1, 0, f"does not begin with '# format: {FORMAT}'; is this a table of setpoints?")
    return table


def _csv(content: bytes, file: str, columns: tuple[str, ...]) -> Table:
    text = content.decode("latin-1").replace("\r\n", "\n")
    lines = text.split("\n")
    header: dict[str, str] = {}
    number = 0
    while number < len(lines) and lines[number].startswith("#"):
        if match := _HEADER.match(lines[number]):
            header.setdefault(match["key"], match["value"])
        number += 1
    if number == len(lines) or lines[number].split(",") != list(columns):
        raise ProgramError(
            file, number + 1, 0, f"the columns are not {columns[0]},{columns[1]},..,{columns[-1]}; write all of them"
        )
    body = lines[number + 1 :]
    if body[-1:] != [""]:
        raise ProgramError(file, len(lines), 0, "the last line has no end; the file is truncated")
    body.pop()
    if match := _STRANGE.search("\n".join(body)):
        row, column = _place(body, match.start())
        bad = body[row][column]
        raise ProgramError(file, number + 2 + row, column + 1, f"{bad!r} is no part of a plain number; correct it")
    return Table(number + 2, header, _numbers(body, number + 2, file, columns))


def _place(body: list[str], position: int) -> tuple[int, int]:
    for row, line in enumerate(body):
        if position <= len(line):
            return row, position
        position -= len(line) + 1
    raise AssertionError("a position outside the text")


def _numbers(body: list[str], first: int, file: str, columns: tuple[str, ...]) -> Array:
    values = np.empty((len(body), len(columns)))
    for row, line in enumerate(body):
        cells = line.split(",")
        if len(cells) != len(columns):
            raise ProgramError(
                file, first + row, 0, f"{len(cells)} cells where {len(columns)} columns stand; correct it"
            )
        try:
            values[row] = cells
        except ValueError:
            bad = next(k for k, cell in enumerate(cells) if not re.fullmatch(r"[+-]?(?:\d+\.?\d*|\.\d+)", cell))
            column = sum(len(cell) + 1 for cell in cells[:bad]) + 1
            raise ProgramError(
                file, first + row, column, f"{columns[bad]} = {cells[bad]!r} is no number; correct it"
            ) from None
    return values


def _parquet(content: bytes, file: str, columns: tuple[str, ...]) -> Table:
    import pyarrow as pa
    from pyarrow import parquet

    try:
        table = parquet.read_table(pa.BufferReader(content))
    except (pa.ArrowException, OSError, ValueError) as error:
        reason = str(error).splitlines()[0][:120] if str(error) else "damaged"
        raise ProgramError(file, 0, 0, f"is damaged Parquet ({reason}); write it again") from error
    if tuple(table.column_names) != columns:
        raise ProgramError(file, 0, 0, f"the columns are not {columns[0]}, {columns[1]}, .., {columns[-1]}; write all")
    wrong = next((f.name for f in table.schema if f.type != pa.float64()), None)
    if wrong is not None:
        raise ProgramError(file, 0, 0, f"column {wrong} does not hold 64-bit floats; write it so")
    said = (table.schema.metadata or {}).get(METADATA, b"").decode("latin-1")
    header = {m["key"]: m["value"] for line in reversed(said.split("\n")) if (m := _HEADER.match(line))}
    return Table(1, header, np.column_stack([table.column(name).to_numpy() for name in columns]))
