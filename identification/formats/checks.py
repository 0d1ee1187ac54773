"""What no measurement can be: named with its place before it becomes a result.

Doubts about numbers that a sensor can give are findings: `identification.findings`.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.errors import RecordingError
from cases.recording_format import CLOCK, OVERRIDE, ROTATION, STRUTS, TRIGGER, RecordingFormat, units_of
from cases.schema import Case
from cases.units import MM
from identification.formats.table import UNIFORMITY, Array, ColumnTable, crowded, lost_samples, shown
from identification.recording import Channel, Rows, Stream

# Rotation matrices are printed with a few digits; beyond this they are not rotations (transposed columns, wrong order).
ORTHOGONALITY = 1e-3
# A motion changes the usual specific force of a run by less; a wrong unit (g for m/s^2) by a factor of ten.
_GRAVITY = 3.0
# Nothing that is measured is so large in any unit, not even ticks of 100 ns since 1601.
_MOST = 1e20
MOST_OVERRIDE = 3.0  # controls offer 120 to 200 %
_FIRST = 10_000  # rows that tell a wrong unit as well as all of them


def require_stamps(table: ColumnTable, form: RecordingFormat) -> None:
    """Raises RecordingError at the first time stamp that is not a number, or none of a clock."""
    if table.stamps is None:
        return
    if np.issubdtype(table.stamps.dtype, np.integer):
        return
    stamps = table.stamps
    possible = np.abs(stamps) < _MOST
    if not possible.all():
        row = int(np.argmin(possible))
        raise RecordingError(
            f"{table.source}, {table.lines.place(row)}, {shown(form.file_name(CLOCK))}",
            f"{stamps[row]} is not a time stamp",
            "remove the row",
        )


def require_increasing(table: ColumnTable, form: RecordingFormat) -> None:
    """Raises RecordingError where a time stamp is not later than the one above it."""
    assert table.stamps is not None
    stamps = table.stamps
    later = stamps[1:] > stamps[:-1]
    if later.all():
        return
    row = int(np.argmin(later)) + 1
    unit = form.clock_unit
    now, then = (f"{v:.6f} s" if unit == "s" else f"{v} {unit}" for v in (stamps[row].item(), stamps[row - 1].item()))
    name = shown(form.file_name(CLOCK))
    raise RecordingError(
        f"{table.source}, {table.lines.place(row)}, {name}",
        f"{now} comes after {then}",
        "time must increase: sort the rows or remove the repeated part",
    )


def require_override(table: ColumnTable, override: Array, form: RecordingFormat) -> None:
    """Raises RecordingError at the first feed override, shape (n,), that no control has."""
    wrong = (override < 0.0) | (override > MOST_OVERRIDE)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise RecordingError(
            f"{table.source}, {table.lines.place(row)}, {shown(form.file_name(OVERRIDE))}",
            f"{100 * override[row]:g} % is not a feed override, they are 0 to {100 * MOST_OVERRIDE:g} %",
            "state recording.units.override = '1' if it is a ratio",
        )


LEVELS = 0.2  # of the way between two levels that a switch may be off either: noise of a voltage
OFF = 0.3  # share of the level on, up to which the level off of a voltage may be


def switched(values: Array) -> Rows | None:
    """Whether a switch is on: 0 and 1, or a voltage near one of two levels, shape (n,); None where it is no switch."""
    low, high = float(np.min(values)), float(np.max(values))
    if low == high:
        return values > 0.0
    near = np.minimum(values - low, high - values) <= LEVELS * (high - low)
    return values > (low + high) / 2 if near.all() and abs(low) <= OFF * high else None


def require_switch(table: ColumnTable, trigger: Array, form: RecordingFormat) -> Rows:
    """Whether the trigger is on, shape (n,).

    Raises:
        RecordingError: it has more than two levels; the message names the first value that is neither 0 nor the usual
            other one.
    """
    flags = switched(trigger)
    if flags is not None:
        return flags
    usual = float(np.median(trigger[trigger > 0.0])) if (trigger > 0.0).any() else 1.0
    row = int(np.argmax((trigger != 0.0) & (trigger != usual)))
    raise RecordingError(
        f"{table.source}, {table.lines.place(row)}, {shown(form.file_name(TRIGGER))}",
        f"{trigger[row]:g} is neither 0 nor {usual:g}, and the values have more than two levels",
        "export the trigger as a switch, or leave the column out",
    )


def require_rotations(stream: Stream) -> None:
    """Raises RecordingError at the first matrix that is not a rotation."""
    if stream.rotations is None:
        return
    rotations = stream.rotations
    error = np.abs(rotations @ rotations.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    error = np.maximum(error, np.abs(np.linalg.det(rotations) - 1.0))
    if not error.max() <= ORTHOGONALITY:
        row = int(np.argmin(error <= ORTHOGONALITY))
        raise RecordingError(
            f"{stream.source}, {stream.lines.place(row)}, r11..r33",
            f"not a rotation matrix (off by {error[row]:.3g}, at most {ORTHOGONALITY:g})",
            "check order and sign of the columns",
        )


def require_reach(stream: Stream, case: Case, form: RecordingFormat) -> None:
    """Raises RecordingError where struts fit the workspace in another unit, but not in the one that is declared."""
    if stream.struts is None or case.workspace is None:
        return
    low, high = case.workspace.strut_length
    middle = float(np.median(np.abs(stream.struts[:_FIRST])))
    if low <= middle <= high:
        return
    written = middle / form.factor(STRUTS[0])
    for unit, factor in units_of("struts").items():
        if low <= written * factor <= high:
            raise RecordingError(
                f"{stream.source}, {stream.lines.place(0)}",
                f"struts of {middle / MM:.4g} mm where the workspace has {low / MM:g} to {high / MM:g} mm",
                f"they seem to be in {unit}: set recording.units.struts = '{unit}'",
            )


def require_gravity(stream: Stream, case: Case) -> None:
    """Raises RecordingError where an accelerometer does not feel gravity, as with a wrong scale."""
    if stream.specific_forces is None:
        return
    magnitude = float(np.median(np.linalg.norm(stream.specific_forces[:_FIRST], axis=1)))
    gravity = float(np.linalg.norm(case.gravity))
    if not gravity / _GRAVITY <= magnitude <= gravity * _GRAVITY:
        raise RecordingError(
            f"{stream.source}, {stream.lines.place(0)}",
            f"the accelerometer reads {magnitude:.3g} m/s^2 where gravity is {gravity:.3g} m/s^2",
            "correct recording.accelerometer.scale_m_s2 in the case",
        )


MOST_MISSING = 0.3  # of a column's rows; one with more is sampled at another rate, or is broken
_KEPT = frozenset((*ROTATION, TRIGGER, OVERRIDE))
MOST_PUT_BACK = 3  # samples in a row
_SWITCHING: tuple[Channel, ...] = ("trigger", "override", "rotations")  # keep their last value


def marked(table: ColumnTable, form: RecordingFormat) -> tuple[ColumnTable, Rows | None, tuple[str, ...]]:
    """A table in which every value is finite, the rows in which one stands for nothing, and the columns in which.

    Rows have the shape (n,), None: there are none; columns are named as in the file.

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
                f"{table.source}, {table.lines.place(row)}, {name}",
                f"{column[row]} is not a measured value, nor are {100 * share:.3g} % of this column's rows, at "
                f"most {100 * MOST_MISSING:g} % may be missing",
                "record again, or give what is sampled less often in a file of its own",
            )
        values[ours] = _spread(column[good], np.flatnonzero(good), np.arange(len(good)), ours in _KEPT)
        missing |= ~good
        columns = (*columns, name)
    if not columns:
        return table, None, ()
    return replace(table, values={**table.values, **values}), missing, columns


def with_lost_rows(stream: Stream) -> Stream:
    """The stream with rows for samples that were lost, a few at a time: so a filter can pass them.

    Longer gaps stay gaps. Stamps that a host gives jitter; of these nothing can be said about single samples.
    """
    if stream.t is None or len(stream.t) < MOST_PUT_BACK:
        return stream
    steps = np.diff(stream.t)
    usual = float(np.median(steps))
    gaps = lost_samples(stream.t, step=usual)
    if np.any((np.abs(steps - usual) > UNIFORMITY * usual) & (gaps == 0)) or crowded(gaps > 0) is not None:
        return stream  # not at one rate: the reason is told where a rate is needed
    count = np.r_[0, np.where(gaps <= MOST_PUT_BACK, gaps, 0)]
    if not count.any():
        return stream
    own = np.arange(len(stream.t)) + np.cumsum(count)  # where the rows that are there stand in the result
    rows = np.arange(own[-1] + 1)
    present = np.zeros(len(rows), dtype=bool)
    present[own] = True
    more: dict[Any, Any] = {n: _spread(v, own, rows, n in _SWITCHING) for n, v in stream.channels.items()}
    missing = ~present
    if stream.missing is not None:
        missing[own] = stream.missing
    lines = replace(stream.lines, inserted=tuple(np.flatnonzero(~present).tolist()))
    t = np.interp(rows, own, stream.t)
    return replace(stream, t=t, lines=lines, missing=missing, **more)


def _spread(values: Array, own: NDArray[np.int64], rows: NDArray[np.int64], kept: bool) -> Array:
    """Values at all rows: straight lines between those that are there, or the last of them."""
    if kept:
        return np.asarray(values[np.maximum(np.searchsorted(own, rows, side="right") - 1, 0)])
    columns = [np.interp(rows, own, column) for column in values.reshape(len(values), -1).T]
    return np.stack(columns, axis=1).reshape(len(rows), *values.shape[1:])
