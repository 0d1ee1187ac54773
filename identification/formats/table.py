"""What a reader makes of a file: columns of numbers that share their rows, and where in the file each row stands."""

from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Stamps = NDArray[np.float64] | NDArray[np.int64]

_SHOWN_NAMES = 40
_SHOWN_CHARACTERS = 40


@dataclass(frozen=True, slots=True)
class Lines:
    """Where in its file each row stands.

    Args:
        first: number of the line of the first row, counted from 1.
        skipped: numbers of lines behind it that hold no row, ascending.
        word: what the file's rows are called.
        every: distance of the samples among the file's rows.
        inserted: rows that stand in no line, counted from 0 and ascending, before only each so-manyth is taken.
    """

    first: int = 2
    skipped: tuple[int, ...] = ()
    word: str = "line"
    every: int = 1
    inserted: tuple[int, ...] = ()

    def later(self, row: int, every: int = 1) -> "Lines":
        """Of the rows from one on, counted from 0, or of each so-manyth of them."""
        start = row * self.every
        count = bisect_right(self.inserted, start)
        inserted = tuple(k - start for k in self.inserted[count:])
        return replace(self, first=self.first + start - count, every=self.every * every, inserted=inserted)

    def place(self, row: int) -> str:
        """Place of a row, counted from 0, as a message names it; one that stands in no line has that before it."""
        line = self.first + row * self.every - bisect_right(self.inserted, row * self.every)
        for skipped in self.skipped:
            if skipped > line:
                break
            line += 1
        return f"{self.word} {line}"


@dataclass(frozen=True, slots=True)
class ColumnTable:
    """Columns of a file that share their rows, in the file's units.

    Args:
        source: the file, for messages.
        names: all columns that the file has, as it calls them.
        values: our column name -> numbers, shape (n,); missing ones are NaN. Only columns that we know.
        stamps: stamps of the clock, shape (n,), as the file counts; integers where it writes such. None: no clock.
        tick: duration of one unit of the stamps [s].
        lines: where the rows stand.
    """

    source: str
    names: tuple[str, ...]
    values: Mapping[str, Array]
    stamps: Stamps | None
    tick: float
    lines: Lines

    @property
    def rows(self) -> int:
        """Number of rows."""
        columns = [*self.values.values(), *([] if self.stamps is None else [self.stamps])]
        return len(columns[0]) if columns else 0


def shown(text: str, limit: int = _SHOWN_CHARACTERS) -> str:
    """Text from a file as a message can show it: printable and short."""
    clean = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
    return clean if len(clean) <= limit else clean[: limit - 2] + ".."


def listed(names: Iterable[str]) -> str:
    """Names from a file as a message can list them."""
    kept = [shown(n) for n in names if n.strip()]
    more = f" and {len(kept) - _SHOWN_NAMES} more" if len(kept) > _SHOWN_NAMES else ""
    return (", ".join(kept[:_SHOWN_NAMES]) or "no names") + more
