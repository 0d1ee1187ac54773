"""A table of setpoints as numbers: CSV below lines of `# key: value`, or Parquet with those in its metadata."""

import re
from typing import NamedTuple

import numpy as np

from cases.errors import ProgramError
from cases.units import DEG, MM
from identification.motion import Array

FORMAT = "hexcite setpoints 1"
COORDINATES = ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")
_STRUTS = tuple(f"l{k}" for k in range(1, 7))
COLUMNS = (
    "t_s",
    *COORDINATES,
    *(f"v_{c}_s" for c in COORDINATES),
    *(f"acc_{c}_s2" for c in COORDINATES),
    *(f"{s}_mm" for s in _STRUTS),
    *(f"{s[0]}d{s[1]}_mm_s" for s in _STRUTS),
    *(f"{s[0]}dd{s[1]}_mm_s2" for s in _STRUTS),
    "trigger",
)
UNITS = np.array([DEG if "deg" in c else MM if "mm" in c else 1.0 for c in COLUMNS])
LARGEST = 1e7  # mm, degrees and their rates: no machine has such numbers
PARQUET = b"PAR1"
METADATA = b"hexcite"
_HEADER = re.compile(r"#\s*(?P<key>[a-z_]+):\s*(?P<value>.*?)\s*$")
_STRANGE = re.compile(r"[^0-9.,+\-\n]")


class Table(NamedTuple):
    """A table as read.

    Args:
        first: line of its first row (Parquet: 1).
        header: keys and values.
        values: one row a cycle, the columns of `COLUMNS`, in the units of their names.
    """

    first: int
    header: dict[str, str]
    values: Array


def read_table(content: bytes, file: str, most: int) -> Table:
    """The numbers of a table.

    Args:
        content: of the file.
        file: its name, for messages.
        most: rows that the controller's memory holds.

    Raises:
        ProgramError: not such a table, or a cell that is no number; with line and column.
    """
    table = _parquet(content, file) if content[:4] == PARQUET else _csv(content, file)
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
        raise ProgramError(file, table.first + int(row), 0, f"{COLUMNS[column]} = {value:g} is no machine's number")
    if table.header.get("format") != FORMAT:
        raise ProgramError(file, 1, 0, f"does not begin with '# format: {FORMAT}'; is this a table of setpoints?")
    return table


def _csv(content: bytes, file: str) -> Table:
    text = content.decode("latin-1").replace("\r\n", "\n")
    lines = text.split("\n")
    header: dict[str, str] = {}
    number = 0
    while number < len(lines) and lines[number].startswith("#"):
        if match := _HEADER.match(lines[number]):
            header.setdefault(match["key"], match["value"])
        number += 1
    if number == len(lines) or lines[number].split(",") != list(COLUMNS):
        raise ProgramError(
            file, number + 1, 0, f"the columns are not {COLUMNS[0]},{COLUMNS[1]},..,{COLUMNS[-1]}; write all of them"
        )
    body = lines[number + 1 :]
    if body[-1:] != [""]:
        raise ProgramError(file, len(lines), 0, "the last line has no end; the file is truncated")
    body.pop()
    if match := _STRANGE.search("\n".join(body)):
        row, column = _place(body, match.start())
        bad = body[row][column]
        raise ProgramError(file, number + 2 + row, column + 1, f"{bad!r} is no part of a plain number; correct it")
    return Table(number + 2, header, _numbers(body, number + 2, file))


def _place(body: list[str], position: int) -> tuple[int, int]:
    for row, line in enumerate(body):
        if position <= len(line):
            return row, position
        position -= len(line) + 1
    raise AssertionError("a position outside the text")


def _numbers(body: list[str], first: int, file: str) -> Array:
    values = np.empty((len(body), len(COLUMNS)))
    for row, line in enumerate(body):
        cells = line.split(",")
        if len(cells) != len(COLUMNS):
            raise ProgramError(
                file, first + row, 0, f"{len(cells)} cells where {len(COLUMNS)} columns stand; correct it"
            )
        try:
            values[row] = cells
        except ValueError:
            bad = next(k for k, cell in enumerate(cells) if not re.fullmatch(r"[+-]?(?:\d+\.?\d*|\.\d+)", cell))
            column = sum(len(cell) + 1 for cell in cells[:bad]) + 1
            raise ProgramError(
                file, first + row, column, f"{COLUMNS[bad]} = {cells[bad]!r} is no number; correct it"
            ) from None
    return values


def _parquet(content: bytes, file: str) -> Table:
    import pyarrow as pa
    from pyarrow import parquet

    try:
        table = parquet.read_table(pa.BufferReader(content))
    except (pa.ArrowException, OSError, ValueError) as error:
        reason = str(error).splitlines()[0][:120] if str(error) else "damaged"
        raise ProgramError(file, 0, 0, f"is damaged Parquet ({reason}); write it again") from error
    if tuple(table.column_names) != COLUMNS:
        raise ProgramError(file, 0, 0, f"the columns are not {COLUMNS[0]}, {COLUMNS[1]}, .., {COLUMNS[-1]}; write all")
    wrong = next((f.name for f in table.schema if f.type != pa.float64()), None)
    if wrong is not None:
        raise ProgramError(file, 0, 0, f"column {wrong} does not hold 64-bit floats; write it so")
    said = (table.schema.metadata or {}).get(METADATA, b"").decode("latin-1")
    header = {m["key"]: m["value"] for line in reversed(said.split("\n")) if (m := _HEADER.match(line))}
    columns = [table.column(name).to_numpy() for name in COLUMNS]
    return Table(1, header, np.column_stack(columns))
