"""Values that were not measured (empty, NaN, infinite), and samples that a recorder lost.

Their rows are marked, and what stands there means nothing: few lost samples in a row get rows of their own.

The straight line between the neighbours keeps every later step finite; what switches, and rotation matrices, keep
their last value. Which rows an estimate may use is decided by the mark alone (`plausibility`).
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import RecordingError
from cases.recording import OVERRIDE, ROTATION, TRIGGER, RecordingFormat
from identification.formats.clock import UNIFORMITY, crowded, lost_samples
from identification.formats.stream import Channel, Stream
from identification.formats.table import Array, Table, shown

Rows = NDArray[np.bool_]

# Nothing that is measured is so large in any unit, not even ticks of 100 ns since 1601.
_MOST = 1e20
MOST_MISSING = 0.3  # of a column's rows; one with more is sampled at another rate, or is broken
_KEPT = frozenset((*ROTATION, TRIGGER, OVERRIDE))
MOST_PUT_BACK = 3  # samples in a row
_SWITCHING: tuple[Channel, ...] = ("trigger", "override", "rotations")  # keep their last value


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
        RecordingError: a column lacks too many values to be a channel with some damage.
    """
    values: dict[str, Array] = {}
    missing = np.zeros(table.rows, dtype=bool)
    columns: tuple[str, ...] = ()
    for ours, column in table.values.items():
        if column.size and column.min() > -_MOST and column.max() < _MOST:  # neither holds where one is NaN
            continue
        good = np.asarray(np.abs(column) < _MOST)
        name = shown(form.file_name(ours))
        share = 1.0 - float(good.mean())
        if share > MOST_MISSING:
            row = int(np.argmin(good))
            raise RecordingError(
                f"{table.source}, {table.lines.place(row)}, {name}: {column[row]} is not a measured value, nor are "
                f"{100 * share:.3g} % of this column's rows, at most {100 * MOST_MISSING:g} % may be missing; record "
                "again, or give what is sampled less often in a file of its own"
            )
        values[ours] = _filled(column, good, ours in _KEPT)
        missing |= ~good
        columns = (*columns, name)
    if not columns:
        return Marked(table, None, ())
    return Marked(replace(table, values={**table.values, **values}), missing, columns)


def _filled(column: Array, good: Rows, kept: bool) -> Array:
    rows = np.arange(len(column))
    places = np.flatnonzero(good)
    if not kept:
        return np.where(good, column, np.interp(rows, places, column[places]))
    return np.asarray(column[places[np.maximum(np.searchsorted(places, rows, side="right") - 1, 0)]])


def with_lost_rows(stream: Stream) -> Stream:
    """The stream with rows for samples that were lost, a few at a time: so a filter can pass them.

    Longer gaps stay gaps. Stamps that a host gives jitter; of these nothing can be said about single samples.
    """
    if stream.t is None or len(stream.t) < MOST_PUT_BACK:
        return stream
    steps = np.diff(stream.t)
    usual = float(np.median(steps))
    lost = lost_samples(stream.t, step=usual)
    if np.any((np.abs(steps - usual) > UNIFORMITY * usual) & (lost == 0)) or crowded(lost > 0) is not None:
        return stream  # not at one rate: the reason is told where a rate is needed
    count = np.r_[0, np.where(lost <= MOST_PUT_BACK, lost, 0)]
    if not count.any():
        return stream
    own = np.arange(len(stream.t)) + np.cumsum(count)  # where the rows that are there stand in the result
    rows = np.arange(own[-1] + 1)
    there = np.zeros(len(rows), dtype=bool)
    there[own] = True
    more: dict[Any, Any] = {n: _spread(v, own, rows, n in _SWITCHING) for n, v in stream.channels.items()}
    missing = ~there
    if stream.missing is not None:
        missing[own] = stream.missing
    lines = replace(stream.lines, inserted=tuple(np.flatnonzero(~there).tolist()))
    t = np.interp(rows, own, stream.t)
    return replace(stream, t=t, lines=lines, missing=missing, **more)


def _spread(values: Array, own: NDArray[np.int64], rows: NDArray[np.int64], kept: bool) -> Array:
    """Values at all rows: straight lines between those that are there, or the last of them."""
    last = np.clip(np.searchsorted(own, rows, side="right") - 1, 0, len(own) - 1)
    if kept:
        return np.asarray(values[last])
    following = np.minimum(last + 1, len(own) - 1)
    share = np.clip((rows - own[last]) / np.maximum(own[following] - own[last], 1), 0.0, 1.0)
    share = share.reshape(-1, *(1,) * (values.ndim - 1))
    result = values[last] + share * (values[following] - values[last])
    result[own] = values
    return np.asarray(result)
