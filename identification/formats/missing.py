"""Values that were not measured (empty, NaN, infinite): their rows are marked, and what stands there means nothing.

The straight line between the neighbours keeps every later step finite; what switches, and rotation matrices, keep
their last value. Which rows an estimate may use is decided by the mark alone (`plausibility`).
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import RecordingError
from cases.recording import RecordingFormat
from cases.recording_columns import OVERRIDE, ROTATION, TRIGGER
from identification.formats.table import Array, Table, shown

Rows = NDArray[np.bool_]

# Nothing that is measured is so large in any unit, not even ticks of 100 ns since 1601.
_MOST = 1e20
MOST_MISSING = 0.3  # of a column's rows; one with more is sampled at another rate, or is broken
_KEPT = frozenset((*ROTATION, TRIGGER, OVERRIDE))


class Marked(NamedTuple):
    """A table with numbers only.

    Args:
        table: in which every value is finite.
        missing: rows in which one stands for nothing, shape (n,); None: there are none.
        columns: those in which they are, as the file calls them.
    """

    table: Table
    missing: Rows | None
    columns: tuple[str, ...]


def marked(table: Table, form: RecordingFormat) -> Marked:
    """A table with what was not measured marked and replaced.

    Raises:
        RecordingError: a column without any measured value.
    """
    values: dict[str, Array] = {}
    missing = np.zeros(table.rows, dtype=bool)
    columns: tuple[str, ...] = ()
    for ours, column in table.values.items():
        good = _measured(column)
        if good.all():
            continue
        name = form.file_name(ours)
        if not good.any():
            raise RecordingError(
                f"{table.source}, {table.lines.place(0)}, {shown(name)}: no measured value in {table.rows} rows; "
                "record that channel, take it out of the file, or cut the run there"
            )
        values[ours] = _filled(column, good, ours in _KEPT)
        missing |= ~good
        columns = (*columns, shown(name))
    if not columns:
        return Marked(table, None, ())
    return Marked(replace(table, values={**table.values, **values}), missing, columns)


def require_measured(table: Table, form: RecordingFormat) -> None:
    """Raises RecordingError where a column of a whole file lacks too many values to be a channel with some damage."""
    for ours, column in table.values.items():
        good = _measured(column)
        share = 1.0 - float(good.mean())
        if share > MOST_MISSING:
            row = int(np.argmin(good))
            raise RecordingError(
                f"{table.source}, {table.lines.place(row)}, {shown(form.file_name(ours))}: {column[row]} is not a "
                f"measured value, nor are {100 * share:.3g} % of this column's rows, at most {100 * MOST_MISSING:g} % "
                "may be missing; record again, or give what is sampled less often in a file of its own"
            )


def _measured(column: Array) -> Rows:
    return np.asarray(np.abs(column) < _MOST)


def _filled(column: Array, good: Rows, kept: bool) -> Array:
    rows = np.arange(len(column))
    places = np.flatnonzero(good)
    if not kept:
        return np.where(good, column, np.interp(rows, places, column[places]))
    return np.asarray(column[places[np.maximum(np.searchsorted(places, rows, side="right") - 1, 0)]])
