"""From columns in a file's units and names to channels in SI: units, signs, order, offsets, mounting, clocks.

Values that no measurement can have are refused with their place; doubts about numbers that a sensor can give are
findings: `identification.runs.sample_checks`.
"""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from cases.errors import RecordingError
from cases.machine import POSE
from cases.recording_format import (
    ACCELEROMETER,
    CLOCK,
    DRIVES,
    OVERRIDE,
    ROTATION,
    SHIFTED,
    STRUTS,
    TRIGGER,
    RecordingFormat,
    Role,
    units_of,
)
from cases.schema import Case
from cases.units import MM, Array, Flags, Indices
from identification.formats.table import (
    UNIFORMITY,
    Channel,
    ColumnTable,
    Stream,
    crowded,
    listed,
    lost_samples,
    shown,
)
from identification.formats.text import without


def stream_of(table: ColumnTable, case: Case, origin: Fraction) -> Stream:
    """Channels of a table in SI; samples that were lost, a few at a time, are rows of it too.

    `origin` becomes time 0, see `start_of`. Raises RecordingError where a value cannot be what it should, or columns
    are missing.
    """
    t = None
    if table.stamps is not None:
        t = (table.stamps - table.stamps[0]) * table.tick + float(start_of(table) - origin)
    table, missing, missing_in = _marked(table)
    rotation = _group(table, ROTATION)
    override = _single(table, OVERRIDE)
    if override is not None:
        _require_override(table, override)
    trigger = _single(table, TRIGGER)
    accelerometer = table.form.accelerometer
    readings = None if accelerometer is None else _group(table, ACCELEROMETER)
    stream = Stream(
        source=table.source,
        t=t,
        struts=_struts(table, case),
        rotations=None if rotation is None else rotation.reshape(-1, 3, 3),
        forces=_group(table, case.sensor_frame.channels),
        trigger=None if trigger is None else _switch(table, trigger),
        override=override,
        poses=_group(table, POSE),
        specific_forces=None if readings is None or accelerometer is None else readings @ accelerometer.matrix.T,
        lines=table.lines,
        missing=missing,
        missing_in=missing_in,
    )
    if not stream.channels:
        wanted = (STRUTS[0], POSE[0], ROTATION[0], case.sensor_frame.channels[0])
        unmounted = "has readings of an accelerometer; say in [recording.accelerometer] of the case how it is mounted"
        raise RecordingError(
            table.source, unmounted if ACCELEROMETER[0] in table.values else without(table.names, table.form, wanted)
        )
    _require_rotations(stream)
    if STRUTS[0] in table.values:
        _require_reach(stream, case, table.form)
    _require_gravity(stream, case)
    return _with_lost_rows(stream)


def start_of(table: ColumnTable) -> Fraction:
    """Time of the first sample [s], exact: a double has too few digits for epochs in ns.

    Raises RecordingError where columns of one clock are shifted by different times.
    """
    assert table.stamps is not None
    shifts = {
        table.form.clock.offset_s.get(name, 0.0) for name, columns in SHIFTED.items() if {*columns} & {*table.values}
    }
    if len(shifts) > 1:
        raise RecordingError(
            table.source,
            "its columns share a clock, recording.clock.offset_s shifts them by different times",
            "give them one offset",
        )
    # the tick is a decimal fraction of a second, which limit_denominator finds behind its binary rounding
    tick = Fraction(table.tick).limit_denominator(10**12)
    return Fraction(table.stamps[0].item()) * tick + Fraction(max(shifts, default=0.0))


def _group(table: ColumnTable, channels: tuple[str, ...]) -> Array | None:
    """Columns that belong together in SI units, shape (n, k); None if the file has none of them."""
    present = [ours in table.values for ours in channels]
    if not any(present):
        return None
    if not all(present):
        missing = table.form.file_name(channels[present.index(False)])
        raise RecordingError(
            table.source,
            f"column {missing} is missing",
            f"it has {listed(table.names)}: add it or map its name in [recording.columns] of the case",
        )
    group = np.empty((len(channels), table.rows)).T  # each channel in one piece, for it is worked on channel by channel
    for k, ours in enumerate(channels):
        np.multiply(table.values[ours], table.form.factor(ours), out=group[:, k])
    return group


def _single(table: ColumnTable, ours: str) -> Array | None:
    """A column of its own in SI units, shape (n,); None if the file has none such."""
    column = _group(table, (ours,))
    return None if column is None else column[:, 0]


def _struts(table: ColumnTable, case: Case) -> Array | None:
    """Strut lengths of a hexapod, positions of the joints of a chain."""
    if case.chain is not None:
        positions = _group(table, case.chain.columns)
        for joint, column in zip(case.chain.joints, () if positions is None else positions.T, strict=False):
            if joint.kind == "continuous":  # as if its encoder counted turns: from row to row less than half a turn
                rows = np.flatnonzero(np.isfinite(column))
                column[rows] = np.unwrap(column[rows])
        return positions
    struts, drives = _group(table, STRUTS), _group(table, DRIVES)
    if drives is None:
        return struts
    if struts is not None:
        raise RecordingError(
            table.source, "has strut lengths and drive positions", "take one of them out of [recording.columns]"
        )
    if (how := table.form.drives) is None:
        raise RecordingError(
            table.source, "has drive positions", "say in [recording.drives] of the case how they move the struts"
        )
    return np.array(how.sign) * drives[:, how.index] + how.offset


# Rotation matrices are printed with a few digits; beyond this they are not rotations (transposed columns, wrong order).
ORTHOGONALITY = 1e-3
# A motion changes the usual specific force of a run by less; a wrong unit (g for m/s^2) by a factor of ten.
_GRAVITY = 3.0
# Nothing that is measured is so large in any unit, not even ticks of 100 ns since 1601.
_MOST = 1e20
MOST_OVERRIDE = 3.0  # controls offer 120 to 200 %
_FIRST = 10_000  # rows that show a wrong unit as well as all of them


def require_clock(table: ColumnTable) -> None:
    """Raises RecordingError at the first time stamp that cannot be of a clock, or not later than the one above it."""
    stamps = table.stamps
    if stamps is None:
        return
    possible = np.abs(stamps) < _MOST
    if not possible.all():
        row = int(np.argmin(possible))
        raise RecordingError(table.place(row, CLOCK), f"{stamps[row]} is not a time stamp", "remove the row")
    later = stamps[1:] > stamps[:-1]
    if later.all():
        return
    row = int(np.argmin(later)) + 1
    unit = table.form.clock_unit
    now, then = (f"{v:.6f} s" if unit == "s" else f"{v} {unit}" for v in (stamps[row].item(), stamps[row - 1].item()))
    raise RecordingError(
        table.place(row, CLOCK),
        f"{now} comes after {then}",
        "time must increase: sort the rows or remove the repeated part",
    )


def _require_override(table: ColumnTable, override: Array) -> None:
    """Raises RecordingError at the first feed override, shape (n,), that no control has."""
    wrong = (override < 0.0) | (override > MOST_OVERRIDE)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise RecordingError(
            table.place(row, OVERRIDE),
            f"{100 * override[row]:g} % is not a feed override, they are 0 to {100 * MOST_OVERRIDE:g} %",
            "state recording.units.override = '1' if it is a ratio",
        )


LEVELS = 0.2  # of the way between two levels that a switch may be off either: noise of a voltage
OFF = 0.3  # share of the level on, up to which the level off of a voltage may be


def switched(values: Array) -> Flags | None:
    """Whether a switch is on: 0 and 1, or a voltage near one of two levels, shape (n,); None if it is not a switch."""
    low, high = float(np.min(values)), float(np.max(values))
    if low == high:
        return values > 0.0
    near = np.minimum(values - low, high - values) <= LEVELS * (high - low)
    return values > (low + high) / 2 if near.all() and abs(low) <= OFF * high else None


def _switch(table: ColumnTable, trigger: Array) -> Flags:
    """Whether the trigger is on, shape (n,); raises RecordingError where it has more than two levels."""
    flags = switched(trigger)
    if flags is not None:
        return flags
    usual = float(np.median(trigger[trigger > 0.0])) if (trigger > 0.0).any() else 1.0
    row = int(np.argmax((trigger != 0.0) & (trigger != usual)))
    raise RecordingError(
        table.place(row, TRIGGER),
        f"{trigger[row]:g} is neither 0 nor {usual:g}, and the values have more than two levels",
        "export the trigger as a switch, or leave the column out",
    )


def _require_rotations(stream: Stream) -> None:
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


def _require_reach(stream: Stream, case: Case, form: RecordingFormat) -> None:
    """Raises RecordingError where struts fit the workspace in another unit, but not in the one that is declared."""
    if stream.struts is None or case.workspace is None:
        return
    low, high = case.workspace.strut_length
    middle = float(np.median(np.abs(stream.struts[:_FIRST])))
    if low <= middle <= high:
        return
    written = middle / form.factor(STRUTS[0])
    for unit, factor in units_of(Role.STRUTS).items():
        if low <= written * factor <= high:
            raise RecordingError(
                f"{stream.source}, {stream.lines.place(0)}",
                f"struts of {middle / MM:.4g} mm where the workspace has {low / MM:g} to {high / MM:g} mm",
                f"they seem to be in {unit}: set recording.units.struts = '{unit}'",
            )


def _require_gravity(stream: Stream, case: Case) -> None:
    """Raises RecordingError where an accelerometer does not measure gravity, as with a wrong scale."""
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
_SWITCHING: tuple[Channel, ...] = ("trigger", "override", "rotations")  # a lost sample gets their last value


def _marked(table: ColumnTable) -> tuple[ColumnTable, Flags | None, tuple[str, ...]]:
    """A table in which all is finite, rows in which a value stands for nothing, shape (n,), and its columns."""
    values: dict[str, Array] = {}
    missing = np.zeros(table.rows, dtype=bool)
    columns: tuple[str, ...] = ()
    for ours, column in table.values.items():
        if column.size and column.min() > -_MOST and column.max() < _MOST:  # both are false where one is NaN
            continue
        good = np.asarray(np.abs(column) < _MOST)
        share = 1.0 - float(good.mean())
        if share > MOST_MISSING:
            row = int(np.argmin(good))
            raise RecordingError(
                table.place(row, ours),
                f"{column[row]} is not a measured value, nor are {100 * share:.3g} % of this column's rows, at "
                f"most {100 * MOST_MISSING:g} % may be missing",
                "record again, or give what is sampled less often in a file of its own",
            )
        values[ours] = spread(column[good], np.flatnonzero(good), np.arange(len(good)), ours in _KEPT)
        missing |= ~good
        columns = (*columns, shown(table.form.file_name(ours)))
    if not columns:
        return table, None, ()
    return replace(table, values={**table.values, **values}), missing, columns


def _with_lost_rows(stream: Stream) -> Stream:
    """The stream with rows for samples that were lost, a few at a time, so that a filter can pass them."""
    if stream.t is None or len(stream.t) < MOST_PUT_BACK:
        return stream
    steps = np.diff(stream.t)
    usual = float(np.median(steps))
    gaps = lost_samples(stream.t, step=usual)
    if np.any((np.abs(steps - usual) > UNIFORMITY * usual) & (gaps == 0)) or crowded(gaps > 0) is not None:
        return stream  # not at one rate: the reason is given where a rate is needed
    count = np.r_[0, np.where(gaps <= MOST_PUT_BACK, gaps, 0)]
    if not count.any():
        return stream
    own = np.arange(len(stream.t)) + np.cumsum(count)  # where the rows that are there stand in the result
    rows = np.arange(own[-1] + 1)
    present = np.zeros(len(rows), dtype=bool)
    present[own] = True
    more: dict[Any, Any] = {n: spread(v, own, rows, n in _SWITCHING) for n, v in stream.channels.items()}
    missing = ~present
    if stream.missing is not None:
        missing[own] = stream.missing
    lines = replace(stream.lines, inserted=tuple(np.flatnonzero(~present).tolist()))
    t = np.interp(rows, own, stream.t)
    return replace(stream, t=t, lines=lines, missing=missing, **more)


def spread(values: Array, own: Indices, rows: Indices, last: bool) -> Array:
    """Values at all rows: straight lines between those that are there, or the last of them."""
    if last:
        return np.asarray(values[np.maximum(np.searchsorted(own, rows, side="right") - 1, 0)])
    columns = [np.interp(rows, own, column) for column in values.reshape(len(values), -1).T]
    return np.stack(columns, axis=1).reshape(len(rows), *values.shape[1:])
