"""From columns in a file's units and names to channels in SI: units, signs, order, offsets, mounting, clocks."""

from fractions import Fraction

import numpy as np

from cases.chain import Chain
from cases.errors import RecordingError
from cases.recording_format import (
    ACCELEROMETER,
    BAR_FORCES,
    DRIVES,
    JOINT_ANGLES,
    JOINT_WAYS,
    OVERRIDE,
    POSE,
    ROTATION,
    STRUTS,
    TEMPERATURE,
    TRIGGER,
    WRENCH,
    RecordingFormat,
    StreamName,
)
from cases.schema import Case
from identification.formats.checks import (
    marked,
    require_gravity,
    require_increasing,
    require_override,
    require_reach,
    require_rotations,
    require_switch,
    with_lost_rows,
)
from identification.formats.delimited import without
from identification.formats.table import Array, ColumnTable, listed
from identification.recording import Stream

# Columns whose clock `recording.clock.offset_s` may shift, by the names it uses.
_SHIFTED: dict[StreamName, tuple[str, ...]] = {
    "struts": (*STRUTS, *DRIVES, *JOINT_ANGLES, *JOINT_WAYS),
    "pose": POSE,
    "rotation": ROTATION,
    "accelerometer": ACCELEROMETER,
    "forces": (*BAR_FORCES, *WRENCH),
}


def stream_of(table: ColumnTable, case: Case, form: RecordingFormat, origin: Fraction) -> Stream:
    """Channels of a table in SI.

    Args:
        origin: what becomes time 0, see `start_of`.

    Raises:
        RecordingError: a value cannot be what it should, columns are missing, or time runs backwards.
    """
    if table.stamps is None:
        return _stream(table, None, case, form)
    require_increasing(table, form)
    t = (table.stamps - table.stamps[0]) * table.tick + float(start_of(table, form) - origin)
    return with_lost_rows(_stream(table, t, case, form))


def start_of(table: ColumnTable, form: RecordingFormat) -> Fraction:
    """Time of the first sample [s], exact: epochs in ns leave no digits for a double to round.

    Raises:
        RecordingError: columns of one clock are shifted by different times.
    """
    assert table.stamps is not None
    shifts = {form.clock.offset_s.get(name, 0.0) for name, columns in _SHIFTED.items() if {*columns} & {*table.values}}
    if len(shifts) > 1:
        raise RecordingError(
            table.source,
            "its columns share a clock, recording.clock.offset_s shifts them by different times",
            "give them one offset",
        )
    # the tick is a decimal fraction of a second, which limit_denominator finds behind its binary rounding
    tick = Fraction(table.tick).limit_denominator(10**12)
    return Fraction(table.stamps[0].item()) * tick + Fraction(max(shifts, default=0.0))


def _stream(source: ColumnTable, t: Array | None, case: Case, form: RecordingFormat) -> Stream:
    table, missing, missing_in = marked(source, form)
    forces = _group(table, form, case.sensor_frame.channels)
    rotation = _group(table, form, ROTATION)
    trigger = _group(table, form, (TRIGGER,))
    override = _group(table, form, (OVERRIDE,))
    if override is not None:
        require_override(table, override[:, 0], form)
    temperature = _group(table, form, (TEMPERATURE,))
    stream = Stream(
        source=table.source,
        t=t,
        struts=_struts(table, case, form),
        rotations=None if rotation is None else rotation.reshape(-1, 3, 3),
        forces=forces,
        trigger=None if trigger is None else require_switch(table, trigger[:, 0], form),
        override=None if override is None else override[:, 0],
        temperature=None if temperature is None else temperature[:, 0],
        poses=_group(table, form, POSE),
        specific_forces=_specific_forces(table, form),
        lines=table.lines,
        missing=missing,
        missing_in=missing_in,
    )
    if not stream.channels:
        raise RecordingError(table.source, _nothing(table, case.sensor_frame.channels, form))
    require_rotations(stream)
    if STRUTS[0] in table.values:
        require_reach(stream, case, form)
    require_gravity(stream, case)
    return stream


def _nothing(table: ColumnTable, forces: tuple[str, ...], form: RecordingFormat) -> str:
    """What to say of a file in which nothing serves the case."""
    if ACCELEROMETER[0] in table.values:
        return "has readings of an accelerometer; say in [recording.accelerometer] of the case how it is mounted"
    return without([form.file_name(c) for c in (STRUTS[0], POSE[0], ROTATION[0], forces[0])], table.names)


def _group(table: ColumnTable, form: RecordingFormat, channels: tuple[str, ...]) -> Array | None:
    """Columns that belong together in SI units, shape (n, k); None if the file has none of them."""
    present = [ours in table.values for ours in channels]
    if not any(present):
        return None
    if not all(present):
        missing = form.file_name(channels[present.index(False)])
        raise RecordingError(
            table.source,
            f"column {missing} is missing",
            f"it has {listed(table.names)}: add it or map its name in [recording.columns] of the case",
        )
    group = np.empty((len(channels), table.rows)).T  # each channel in one piece, for it is worked on channel by channel
    for k, ours in enumerate(channels):
        np.multiply(table.values[ours], form.factor(ours), out=group[:, k])
    return group


def _struts(table: ColumnTable, case: Case, form: RecordingFormat) -> Array | None:
    """Strut lengths of a hexapod, positions of the joints of a chain."""
    if case.chain is not None:
        return _unwrapped(_group(table, form, case.chain.columns), case.chain)
    struts, drives = _group(table, form, STRUTS), _group(table, form, DRIVES)
    if drives is None:
        return struts
    if struts is not None:
        raise RecordingError(
            table.source, "has strut lengths and drive positions", "take one of them out of [recording.columns]"
        )
    if form.drives is None:
        raise RecordingError(
            table.source, "has drive positions", "say in [recording.drives] of the case how they move the struts"
        )
    return np.array(form.drives.sign) * drives[:, form.drives.index] + form.drives.offset


def _unwrapped(positions: Array | None, chain: Chain) -> Array | None:
    """Joints that turn without end as if their encoder counted turns: from row to row less than half a turn."""
    if positions is None:
        return None
    for k, joint in enumerate(chain.joints):
        if joint.kind == "continuous":
            rows = np.flatnonzero(np.isfinite(positions[:, k]))
            positions[rows, k] = np.unwrap(positions[rows, k])
    return positions


def _specific_forces(table: ColumnTable, form: RecordingFormat) -> Array | None:
    """In the axes of {P}; without an accelerometer in the case such columns are somebody else's."""
    if form.accelerometer is None:
        return None
    readings = _group(table, form, ACCELEROMETER)
    return None if readings is None else np.asarray(readings @ form.accelerometer.matrix.T)
