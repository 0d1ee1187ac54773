"""From columns in a file's units and names to channels in SI: units, signs, order, offsets, mounting, clocks.

Values that no measurement can have are refused with their place; doubts about numbers that a sensor can give are
findings: `identification.samples.sample_checks`.
"""

import re
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import numpy as np

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.base.unit_names import LENGTHS
from cases.base.units import MM, Array, Flags
from cases.machine import POSE, MotionLimits, turned
from cases.orientation import ANGLES, CONVENTIONS, OF_ANGLES, QUATERNION, ROLL_PITCH_YAW, ROTATION, Convention
from cases.recording_format import (
    ACCELEROMETER,
    CLOCK,
    COLUMNS,
    DRIVES,
    OVERRIDE,
    STRUTS,
    TRIGGER,
)
from cases.schema import Case
from identification.finding import Finding, Kind, note
from identification.recording.formats import dates
from identification.recording.formats.clocks import Unsteady
from identification.recording.formats.names.misnamed import require_own_values
from identification.recording.formats.sampling import on_equal_steps, spread
from identification.recording.formats.table import LARGEST, MOST_MISSING, ColumnTable, Stream, listed, shown
from identification.recording.formats.table_clock import start_of
from identification.recording.formats.text_layout import without
from identification.recording.formats.triggers import trigger_of


def stream_of(table: ColumnTable, case: Case, origin: Fraction) -> Stream:
    """Channels of a table in SI, at equal steps; samples that were lost, a few at a time, are rows of it too.

    `origin` becomes time 0, see `start_of`. Raises RecordingError where a value cannot be what it should, or columns
    are missing.
    """
    t = None
    if table.stamps is not None:
        t = (table.stamps - table.stamps[0]) * table.tick + float(start_of(table) - origin)
    table, missing, missing_in = _marked(table)
    require_own_values(table, case, None if case.hexapod is None else lengths_of_struts(case))
    (flags, of_trigger), override = trigger_of(table), _single(table, OVERRIDE)
    poses, rotations = _pose(table, case)
    if override is not None:
        ratio = "state recording.units.override = '1' if it is a ratio"
        table.require(OVERRIDE, (override >= 0.0) & (override <= MOST_OVERRIDE), "is not a feed override", ratio)
    readings = None if (mounted := table.form.accelerometer) is None else _group(table, ACCELEROMETER)
    struts, orientations = _struts(table, case)
    stream = Stream(
        source=table.source,
        t=t,
        drives=struts,
        rotations=rotations,
        forces=_group(table, case.sensor_frame.channels),
        trigger=flags,
        override=override,
        poses=poses,
        specific_forces=None if readings is None or mounted is None else readings @ mounted.matrix.T,
        lines=table.lines,
        missing=missing,
        missing_in=missing_in,
        findings=(*table.findings, *(_of_convention(table) if poses is not None or rotations is not None else ())),
    )
    stream = replace(stream, findings=(*stream.findings, *of_trigger, *orientations))
    if not stream.channels:
        columns = (STRUTS[0], POSE[0], ROTATION[0], case.sensor_frame.channels[0])
        unmounted = "has readings of an accelerometer; say in [recording.accelerometer] of the case how it is mounted"
        raise RecordingError(
            place=table.source,
            problem=unmounted if ACCELEROMETER[0] in table.values else without(table.names, table.form, columns),
            code=Code.MISSING,
        )
    if STRUTS[0] in table.values and STRUTS[0] not in {**table.form.scale, **table.form.offset}:
        _require_reach(stream, case, table.factors[STRUTS[0]])
    if stream.specific_forces is not None:
        read = float(np.median(np.linalg.norm(stream.specific_forces[:_FIRST], axis=1)))
        gravity = float(np.linalg.norm(case.gravity))
        if not 1.0 / _OTHER_UNIT <= read / gravity <= _OTHER_UNIT:
            problem = f"the accelerometer reads {read:.3g} m/s^2 where gravity is {gravity:.3g} m/s^2"
            raise RecordingError(
                place=table.source,
                problem=problem,
                remedy="correct recording.accelerometer.scale_m_s2 in the case",
                code=Code.UNIT,
            )
    sampled = on_equal_steps(stream, table.form.clock.period if table.stamped else None)
    if isinstance(sampled, Unsteady):
        assert table.stamps is not None
        value = table.stamps[sampled.row].item()
        stamp = dates.written(value) if table.tick == dates.TICK != table.form.tick else value
        raise RecordingError(
            place=table.place(sampled.row, CLOCK),
            problem=f"{stamp} {sampled.problem}",
            remedy=sampled.remedy,
            code=Code.CLOCK,
        )
    return sampled


def _group(table: ColumnTable, channels: tuple[str, ...]) -> Array | None:
    """Columns that belong together in SI units, shape (n, k); None if the file has none of them."""
    present = [ours in table.values for ours in channels]
    if not any(present):
        return None
    if not all(present):
        raise _incomplete(table, channels[present.index(False)])
    group = np.empty((len(channels), table.rows)).T  # each channel in one piece, for it is worked on channel by channel
    for k, ours in enumerate(channels):
        np.multiply(table.values[ours], table.factors[ours], out=group[:, k])
        if shift := table.form.shift(ours):
            group[:, k] += shift
    return group


def _incomplete(table: ColumnTable, ours: str) -> RecordingError:
    """The error for a column that is missing beside others; columns that nothing reads, which it may be, come first."""
    read = {table.form.file_name(each) for each in table.values}
    there = sorted(table.names, key=read.__contains__)
    return RecordingError(
        place=table.source,
        problem=phrase("column_missing", "column {column} is missing", column=table.form.file_name(ours)),
        remedy=phrase(
            "add_or_map",
            "it has {there}: add it or map its name in [recording.columns] of the case",
            there=listed(there),
        ),
        code=Code.MISSING,
    )


def _single(table: ColumnTable, ours: str) -> Array | None:
    """A column of its own in SI units, shape (n,); None if the file has none such."""
    column = _group(table, (ours,))
    return None if column is None else column[:, 0]


def _pose(table: ColumnTable, case: Case) -> tuple[Array | None, Array | None]:
    """Poses of a hexapod, shape (n, 6) [m, rad], and orientations, shape (n, 3, 3); None where the table has none.

    A chain's pose follows from its joints, that of a sensor without a machine is its orientation; where a hexapod's
    struts were recorded too, these count.
    """
    if case.chain is not None or {STRUTS[0], DRIVES[0]} & table.values.keys():
        return None, None
    turns, positions = _orientation(table), None if case.hexapod is None else _group(table, POSE[:3])
    angles = {*ANGLES} & table.values.keys()
    if positions is None and not (angles and case.hexapod is not None):
        return None, turns
    if positions is None or turns is None:
        raise _incomplete(table, POSE[0] if positions is None else ANGLES[0])
    _require_place(table, positions, case)
    roll_pitch_yaw = _roll_pitch_yaw(turns)
    if table.stamps is not None:
        roll_pitch_yaw = np.unwrap(roll_pitch_yaw, axis=0)  # from row to row less than half a turn
    return np.hstack([positions, roll_pitch_yaw]), None


# How a table writes orientations whose case does not say it, by its columns; the first of them is used.
_UNSTATED = (ROLL_PITCH_YAW, CONVENTIONS["matrix"], CONVENTIONS["quaternion"])
_SAID = re.compile(r"roll|pitch|yaw")  # in a name, that angles are these
_SAME_TURN = 0.01  # [rad] between two orientations of one row that files write with few digits


def _orientation(table: ColumnTable) -> Array | None:
    """Orientations, shape (n, 3, 3); None where the table has none.

    Raises RecordingError where the table writes them twice, the case does not say which counts, and they differ.
    """
    stated = table.form.orientation
    columns = {*ANGLES, *QUATERNION, *ROTATION} & table.values.keys()
    if stated is not None:
        return _turns(table, CONVENTIONS[stated]) if columns else None
    present = [convention for convention in _UNSTATED if columns & {*convention.columns}]
    turns = [_turns(table, convention) for convention in present]
    for convention, others in zip(present[1:], turns[1:], strict=True):
        if _apart(turns[0], others) > _SAME_TURN:
            fitting = (c.name for c in OF_ANGLES if _apart(_turns(table, c), others) <= _SAME_TURN)
            names = [next(fitting, present[0].name) if present[0].columns == ANGLES else present[0].name]
            first, other = (shown(table.form.file_name(c.columns[0])) for c in (present[0], convention))
            problem = f"orientations from {first} on and from {other} on differ"
            remedy = " or ".join(f"'{name}'" for name in (*names, convention.name))
            raise RecordingError(
                place=table.source, problem=problem, remedy=f"state recording.orientation = {remedy}", code=Code.UNIT
            )
    return turns[0] if turns else None


def _of_convention(table: ColumnTable) -> Iterator[Finding]:
    """A note on how three angles of a file are read whose convention neither its names nor the case state."""
    labels = [table.form.file_name(ours) for ours in ANGLES if ours in table.values]
    labelled = all(label in COLUMNS or _SAID.search(label.casefold()) for label in labels)
    if labels and not labelled and table.form.orientation is None:
        names = ", ".join(map(shown, labels))
        sentence = f"{names} are read as {ROLL_PITCH_YAW.name!r}, {ROLL_PITCH_YAW.words}; if they are not, state "
        yield note(Kind.FORMAT, f"{sentence}recording.orientation, such as 'zyx intrinsic' or 'rotation vector'")


def _apart(turns: Array, others: Array) -> float:
    """Median angle between orientations of the same rows [rad]."""
    traces = np.einsum("nij,nij->n", turns[:_FIRST], others[:_FIRST])
    return float(np.median(np.arccos(np.clip((traces - 1.0) / 2.0, -1.0, 1.0))))


def _turns(table: ColumnTable, convention: Convention) -> Array:
    """Orientations that the table writes by a convention, shape (n, 3, 3); raises RecordingError."""
    values = _group(table, convention.columns)
    if values is None:
        raise _incomplete(table, convention.columns[0])
    first = convention.columns[0]
    if convention.form == "quaternion":
        good = np.abs(np.linalg.norm(values, axis=1) - 1.0) <= _UNIT_NORM
        order = "check the names of the columns qw, qx, qy, qz"
        table.require(first, good, "begins a quaternion whose norm is not 1", order)
    elif convention.form == "rotation vector":
        good = np.linalg.norm(values, axis=1) <= _MOST_TURN
        unit = "state recording.units.angles, 'deg' or 'rad'"
        table.require(first, good, "begins a rotation vector of more than a turn", unit)
    turns = convention.matrices(values)
    if convention.form == "matrix":
        error = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        error = np.maximum(error, np.abs(np.linalg.det(turns) - 1.0))
        order = "check order and sign of the columns r11..r33"
        table.require(first, error <= ORTHOGONALITY, "begins a matrix that is not a rotation", order)
    return turns


def _roll_pitch_yaw(turns: Array) -> Array:
    """Roll, pitch and yaw of rotation matrices, shape (n, 3) [rad]."""
    roll = np.arctan2(turns[:, 2, 1], turns[:, 2, 2])
    pitch = np.arcsin(np.clip(-turns[:, 2, 0], -1.0, 1.0))
    return np.column_stack([roll, pitch, np.arctan2(turns[:, 1, 0], turns[:, 0, 0])])


def _struts(table: ColumnTable, case: Case) -> tuple[Array | None, list[Finding]]:
    """Strut lengths of a hexapod, positions of the joints of a chain, and what to say of them."""
    if case.chain is not None:
        positions, leaping = _group(table, case.chain.columns), []
        for joint, column in zip(case.chain.joints, () if positions is None else positions.T, strict=False):
            # as if its encoder counted turns: from row to row less than half a turn
            endless = joint.kind == "continuous" or (joint.turns and table.stamps is not None)
            if endless and np.abs(np.diff(column)).max(initial=0.0) > np.pi:
                column[:] = np.unwrap(column)
                leaping += [joint.name] if joint.kind != "continuous" else []
        sentence = f"leaps of 360 deg in {', '.join(leaping)} are taken for those of a reading, not of the joint"
        return positions, [note(Kind.FORMAT, sentence)] if leaping else []
    struts, drives = _group(table, STRUTS), _group(table, DRIVES)
    if drives is None:
        return struts, []
    if struts is not None:
        raise RecordingError(
            place=table.source,
            problem=phrase("struts_and_drives", "has strut lengths and drive positions"),
            remedy=phrase("take_one_out", "take one of them out of [recording.columns]"),
            code=Code.CONTRADICTION,
        )
    if (how := table.form.drives) is None:
        raise RecordingError(
            place=table.source,
            problem=phrase("drives_alone", "has drive positions"),
            remedy=phrase("say_how_drives", "say in [recording.drives] of the case how they move the struts"),
            code=Code.MISSING,
        )
    return np.array(how.sign) * drives[:, how.index] + how.offset, []


# Rotation matrices are printed with a few digits; beyond this they are not rotations (transposed columns, wrong order).
ORTHOGONALITY = 1e-3
_UNIT_NORM = 0.01  # by which the norm of a quaternion of a few digits may differ from 1
_MOST_TURN = 2.0 * np.pi * 1.001  # [rad] of a rotation vector; controllers turn its sense where it exceeds half a turn
# A motion changes the usual specific force of a run by less; a wrong unit (g for m/s^2) by a factor of ten.
_OTHER_UNIT = 3.0
MOST_OVERRIDE = 3.0  # controls offer 120 to 200 %
_FIRST = 10_000  # rows that show a wrong unit as well as all of them


def _require_reach(stream: Stream, case: Case, factor: float) -> None:
    """Raises RecordingError where struts fit the machine in another unit, but not in that of the factor [m]."""
    if stream.drives is None or case.hexapod is None:
        return
    low, high = lengths_of_struts(case)
    middle = float(np.median(np.abs(stream.drives[:_FIRST])))
    if not middle:
        return  # found where the channel never changes
    distances = {unit: abs(np.log(middle / factor * value / np.sqrt(low * high))) for unit, value in LENGTHS.items()}
    nearest = min(distances, key=lambda unit: distances[unit])
    if not low <= middle <= high and low <= middle / factor * LENGTHS[nearest] <= high:
        problem = f"struts of {middle / MM:.4g} mm where the machine has {low / MM:.4g} to {high / MM:.4g} mm"
        remedy = f"they seem to be in {nearest}: set recording.units.struts = '{nearest}'"
        raise RecordingError(
            place=f"{stream.source}, {stream.lines.place(0)}", problem=problem, remedy=remedy, code=Code.WRONG_KIND
        )


def _require_place(table: ColumnTable, positions: Array, case: Case) -> None:
    """Raises RecordingError where positions, shape (n, 3) [m], are about home in another unit, but not in this one."""
    if case.hexapod is None or any(k in {**table.form.scale, **table.form.offset} for k in POSE[:3]):
        return
    home, middle = case.hexapod.home.vector[:3], np.median(positions[:_FIRST], axis=0)
    factor = table.factors[POSE[0]]
    nearest = unit_of_positions(middle / factor, case)
    if nearest is not None and float(np.linalg.norm(middle - home)) > _most_from_home(case):
        place = ", ".join(f"{value / MM:.4g}" for value in middle)
        problem = f"positions about {place} mm, where home is at {', '.join(f'{v / MM:.4g}' for v in home)} mm"
        remedy = f"they seem to be in {nearest}: set recording.units.positions = '{nearest}'"
        raise RecordingError(place=table.place(0, POSE[0]), problem=problem, remedy=remedy, code=Code.WRONG_KIND)


def unit_of_positions(middle: Array, case: Case) -> str | None:
    """The unit in which a position of the platform, shape (3,), is nearest to home; None where in none it is near."""
    if case.hexapod is None:
        return None
    home = case.hexapod.home.vector[:3]
    distances = {unit: float(np.linalg.norm(middle * value - home)) for unit, value in LENGTHS.items()}
    nearest = min(distances, key=lambda unit: distances[unit])
    return nearest if distances[nearest] <= _most_from_home(case) else None


def _most_from_home(case: Case) -> float:
    """How far from home a platform may be in a recording: half a usual strut [m]."""
    return sum(lengths_of_struts(case)) / 4.0


_AROUND_HOME = 2.5  # times the length at home that a strut may have where the case states no workspace


def lengths_of_struts(case: Case) -> tuple[float, float]:
    """Shortest and longest strut of a hexapod: those of its workspace, else what its home leaves possible [m]."""
    if case.workspace is not None:
        low, high = case.workspace.strut_length
        return float(low), float(high)
    assert case.hexapod is not None
    home = case.hexapod.home
    arms = case.hexapod.platform.points @ turned(home.vector[3:]).T
    usual = float(np.linalg.norm(home.vector[:3] + arms - case.hexapod.base.points, axis=1).mean())
    return usual / _AROUND_HOME, usual * _AROUND_HOME


_PAST_LIMITS = 2.0  # times the limits of a motion that a recording may turn


def can_turn(case: Case, angles: Array) -> bool:
    """Whether a hexapod may turn its platform so far: within its struts at home, not far past the limits of motions.

    Args:
        case: the hexapod.
        angles: shape (n, 3) [rad]; in which order they turn does not matter here.
    """
    assert case.hexapod is not None
    turns = angles[np.isfinite(angles).all(axis=1)]
    if not len(turns):
        return True
    motion = None if case.limits is None else case.limits.motion
    if isinstance(motion, MotionLimits):
        ends = np.radians([motion.a_deg, motion.b_deg, motion.c_deg])
        if np.abs(turns).max() > _PAST_LIMITS * np.abs(ends).max():
            return False
    low, high = lengths_of_struts(case)
    most = turns[np.argmax(np.linalg.norm(turns, axis=1))]
    upper = case.hexapod.home.vector[:3] + case.hexapod.platform.points @ turned(most).T
    lengths = np.linalg.norm(upper - case.hexapod.base.points, axis=1)
    return bool(lengths.min() >= low and lengths.max() <= high)


_KEPT = frozenset((*ROTATION, *QUATERNION, TRIGGER, OVERRIDE))


def _marked(table: ColumnTable) -> tuple[ColumnTable, Flags | None, tuple[str, ...]]:
    """A table in which all is finite, rows in which a value stands for nothing, shape (n,), and its columns."""
    values: dict[str, Array] = {}
    missing = np.zeros(table.rows, dtype=bool)
    columns: tuple[str, ...] = ()
    for ours, column in table.values.items():
        if column.size and column.min() > -LARGEST and column.max() < LARGEST:  # both are false where one is NaN
            continue
        good = np.asarray(np.abs(column) < LARGEST)
        if good.mean() < 1.0 - MOST_MISSING:
            problem = f"is not a measured value, like more than {100 * MOST_MISSING:g} % of this column's rows"
            table.require(ours, good, problem, "record again, or give a file of its own to what is sampled less often")
        values[ours] = spread(column[good], np.flatnonzero(good), np.arange(len(good)), ours in _KEPT)
        missing |= ~good
        columns = (*columns, shown(table.form.file_name(ours)))
    if not columns:
        return table, None, ()
    return replace(table, values={**table.values, **values}), missing, columns
