"""From a file to tables: the case names the format, the file's first bytes tell Parquet."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cases.errors import RecordingError
from cases.recording import RecordingFormat
from identification.formats import delimited, halsampler, sinumerik, twincat
from identification.formats.blocks import require_file, unreadable
from identification.formats.table import Array, Stamps, Table

MOST_NUMBERS = 60_000_000  # read at once: 0.5 GB, an hour of 14 channels at 1 kHz
_PARQUET = b"PAR1"

_READERS: dict[str, Callable[[Path, RecordingFormat], Iterator[Table]]] = {
    "csv": delimited.tables,
    "halsampler": halsampler.tables,
    "twincat-scope": twincat.tables,
    "sinumerik-trace": sinumerik.tables,
}


def read_batches(file: Path, form: RecordingFormat) -> Iterator[Table]:
    """Reads a file batch by batch, in memory that does not grow with its length.

    Args:
        file: the file.
        form: how it is written.

    Returns:
        Tables in the file's order; those of one clock have the same columns. Formats with several clocks in a file
        give one table for each of them and batch.

    Raises:
        RecordingError: it cannot be read, with the place and the remedy.
    """
    require_file(file)
    try:
        with file.open("rb") as stream:
            start = stream.read(len(_PARQUET))
    except OSError as error:
        raise unreadable(file, error) from error
    if start == _PARQUET:
        from identification.formats import parquet  # costs 50 ms, and few need it

        return parquet.tables(file, form)
    return _READERS[form.format](file, form)


def read_tables(file: Path, form: RecordingFormat, held: int = 0) -> tuple[Table, ...]:
    """Reads a whole file: one table for each clock in it.

    Args:
        file: the file.
        form: how it is written.
        held: numbers of the run's other files that are in memory already.

    Raises:
        RecordingError: it cannot be read, or the run holds more than `MOST_NUMBERS`.
    """
    piles: dict[tuple[str, ...], _Pile] = {}
    numbers = held
    for table in read_batches(file, form):
        pile = piles.setdefault(tuple(table.values), _Pile(table))
        pile.add(table)
        numbers += table.rows * len(table.values)
        if numbers > MOST_NUMBERS:
            others = " and the files before it hold" if held else ": holds"
            raise RecordingError(
                f"{file}{others} too much to be read at once (this one {file.stat().st_size / 1e9:.2g} GB; at most "
                f"{MOST_NUMBERS // len(table.values):,} rows of {len(table.values)} columns); cut the run into parts, "
                "or put time, struts and forces into one file, which may be of any length (--estimator gauss-markov, "
                "without --prior, --biases, --period, --accelerated, --flexible, --plan)"
            )
    return tuple(pile.joined() for pile in piles.values())


class _Pile:
    """Batches of one clock, column by column: joined so that each number is held twice for a moment only."""

    def __init__(self, first: Table) -> None:
        self._first = first
        self._values: dict[str, list[Array]] = {name: [] for name in first.values}
        self._stamps: list[Stamps] = []
        self._skipped: list[int] = []

    def add(self, table: Table) -> None:
        for name, column in table.values.items():
            self._values[name].append(column)
        if table.stamps is not None:
            self._stamps.append(table.stamps)
        self._skipped += table.lines.skipped

    def joined(self) -> Table:
        values = {name: np.concatenate(self._values.pop(name)) for name in list(self._values)}
        stamps: Any = np.concatenate(self._stamps) if self._stamps else None
        lines = replace(self._first.lines, skipped=tuple(self._skipped))
        return replace(self._first, values=values, stamps=stamps, lines=lines)
