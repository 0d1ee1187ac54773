"""From a file to tables in memory: the case names the format, the file's first bytes tell Parquet."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cases.errors import RecordingError
from cases.recording import RecordingFormat
from identification.formats import delimited, halsampler, twincat
from identification.formats.blocks import require_file, unreadable
from identification.formats.table import Array, Stamps, Table

BYTES = 40  # of memory that reading and evaluating a run take at most for each number in it
_PARQUET = b"PAR1"

_READERS: dict[str, Callable[[Path, RecordingFormat], Iterator[Table]]] = {
    "csv": delimited.tables,
    "halsampler": halsampler.tables,
    "twincat-scope": twincat.tables,
    "sinumerik-trace": delimited.tables,
}


def read_tables(file: Path, form: RecordingFormat, held: int = 0) -> tuple[Table, ...]:
    """Reads a file: one table for each clock in it.

    Args:
        file: the file.
        form: how it is written.
        held: numbers of the run's other files that are in memory already.

    Raises:
        RecordingError: it cannot be read, with the place and the remedy, or takes more than half of the free memory.
    """
    require_file(file)
    try:
        with file.open("rb") as stream:
            start = stream.read(len(_PARQUET))
    except OSError as error:
        raise unreadable(file, error) from error
    reader = _READERS[form.format]
    if start == _PARQUET:
        from identification.formats import parquet  # costs 50 ms, and few need it

        reader = parquet.tables
    most = free_memory() // (2 * BYTES)
    piles: dict[tuple[str, ...], _Pile] = {}
    numbers = held
    for table in reader(file, form):
        pile = piles.setdefault(tuple(table.values), _Pile(table))
        pile.add(table)
        numbers += table.rows * len(table.values)
        if numbers > most:
            others = " and the files before it" if held else ""
            raise RecordingError(
                f"{file}{others}: {file.stat().st_size / 1e9:.3g} GB in the file hold more than {most:,} numbers, and "
                f"to evaluate these takes more than half of the free memory ({2e-9 * BYTES * most:.3g} GB); cut the "
                f"run, at most {most // len(table.values):,} rows of {len(table.values)} columns fit, or free memory"
            )
    return tuple(pile.joined() for pile in piles.values())


def free_memory() -> int:
    """Memory that can be used without swapping [bytes]; where the system does not tell, as much as nobody has."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("MemAvailable:"))
    except (OSError, StopIteration):
        return 1 << 60


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
        values = {name: _whole(self._values.pop(name)) for name in list(self._values)}
        stamps: Any = _whole(self._stamps) if self._stamps else None
        lines = replace(self._first.lines, skipped=tuple(self._skipped))
        return replace(self._first, values=values, stamps=stamps, lines=lines)


def _whole(parts: list[Any]) -> Any:
    return parts[0] if len(parts) == 1 else np.concatenate(parts)
