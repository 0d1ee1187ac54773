"""How the recordings of a machine are written: file format, names, units, clock, drives, accelerometer."""

from collections.abc import Iterable, Mapping
from enum import StrEnum
from fnmatch import fnmatch
from functools import cached_property
from operator import attrgetter
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr, model_validator

from cases.base.phrases import phrase, said
from cases.base.unit_names import ANGLES, FORCES, LENGTHS, MOMENTS, SHARES, TIMES, Units
from cases.base.units import MS, Array
from cases.machine import POSE
from cases.orientation import CONVENTIONS, QUATERNION, ROTATION, ways_to_write
from cases.tables import Number, Part, Positive, Six, Vector, frozen, si, spelled

CLOCK, TRIGGER, OVERRIDE = "t_s", "trigger", "override_percent"
STRUTS = tuple(f"l{k}_mm" for k in range(1, 7))
DRIVES = tuple(f"q{k}_mm" for k in range(1, 7))
JOINT_ANGLES = tuple(f"q{k}_deg" for k in range(1, 13))
JOINT_WAYS = tuple(f"q{k}_mm" for k in range(7, 13))  # of a chain; those before are the names of drives too
ACCELEROMETER = ("ax", "ay", "az")
BAR_FORCES = tuple(f"f{k}_N" for k in range(1, 7))
WRENCH = ("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm")
COLUMNS = (
    CLOCK, *STRUTS, *DRIVES, *JOINT_ANGLES, *JOINT_WAYS, *POSE, *QUATERNION, *ROTATION, *ACCELEROMETER, *BAR_FORCES,
    *WRENCH, TRIGGER, OVERRIDE,
)  # fmt: skip


def motion_columns(coordinates: tuple[str, ...]) -> tuple[str, ...]:
    """Columns of `motion.csv`: coordinates, rates and accelerations over time."""
    return (CLOCK, *coordinates, *(f"v_{c}_s" for c in coordinates), *(f"acc_{c}_s2" for c in coordinates))


def setpoint_columns(coordinates: tuple[str, ...], struts: bool) -> tuple[str, ...]:
    """Columns of a table of set points: the motion, of a pose that of the struts behind it, and the trigger."""
    behind = (*STRUTS, *(f"ld{k}_mm_s" for k in range(1, 7)), *(f"ldd{k}_mm_s2" for k in range(1, 7))) if struts else ()
    return (*motion_columns(coordinates), *behind, TRIGGER)


class Role(StrEnum):
    """What columns hold that have units: one entry of `units` covers all of them."""

    STRUTS = "struts"
    DRIVES = "drives"
    JOINTS = "joints"
    POSITIONS = "positions"
    ANGLES = "angles"
    FORCES = "forces"
    MOMENTS = "moments"
    OVERRIDE = "override"


# The columns of each role, and the units they may have.
_ROLES: tuple[tuple[Role, Iterable[str], Units], ...] = (
    (Role.STRUTS, STRUTS, LENGTHS),
    (Role.DRIVES, (*DRIVES, *JOINT_WAYS), LENGTHS),
    (Role.JOINTS, JOINT_ANGLES, ANGLES),
    (Role.POSITIONS, POSE[:3], LENGTHS),
    (Role.ANGLES, POSE[3:], ANGLES),
    (Role.FORCES, (*BAR_FORCES, *WRENCH[:3]), FORCES),
    (Role.MOMENTS, WRENCH[3:], MOMENTS),
    (Role.OVERRIDE, (OVERRIDE,), SHARES),
)
ROLE_UNITS: Mapping[Role, Units] = {role: units for role, _, units in _ROLES}
ROLE_OF = {column: role for role, columns, _ in _ROLES for column in columns}


_ORTHOGONALITY = (
    1e-3  # of a mounting matrix, which is typed by hand with a few digits: beyond this it is not a rotation
)
TICKS = TIMES  # units of time stamps [s]


Separator = Annotated[
    str, spelled(r"[^\w\"'.+\-\r\n]", phrase("one_character", "one character that no number has, such as a semicolon"))
]
Count = Annotated[int, Field(strict=True, ge=0)]
FormatName = Literal["csv", "halsampler", "twincat-scope", "sinumerik-trace", "lvm"]
StreamName = Literal["struts", "pose", "rotation", "accelerometer", "forces"]
SHIFTED: Mapping[StreamName, tuple[str, ...]] = {
    "struts": (*STRUTS, *DRIVES, *JOINT_ANGLES, *JOINT_WAYS), "pose": POSE, "rotation": (*ROTATION, *QUATERNION),
    "accelerometer": ACCELEROMETER, "forces": (*BAR_FORCES, *WRENCH),
}  # fmt: skip
"""Columns whose clock `clock.offset_s` may shift, by the names that it uses."""


class Clock(Part):
    """The time stamps of a file."""

    unit: Literal["s", "ms", "us", "ns", "filetime", "min", "h", "d"] | None = None
    """Unit of a stamp; `filetime`: 100 ns, `d`: days. By default s; of `twincat-scope` ms."""
    nanoseconds: str | None = None
    """The file's name of a second column of the stamps, where they are in two: seconds, and nanoseconds on top."""
    period_ms: Positive | None = None
    """Time between rows, for files without stamps."""
    offset_s: dict[StreamName, Number] = Field(default_factory=dict)
    """Added to the stamps of a stream: where clocks count from different epochs, or stamps are late. Streams of one
    file may have different ones."""

    @property
    def period(self) -> float | None:
        """Time between rows [s]."""
        return None if self.period_ms is None else self.period_ms * MS


class Drives(Part):
    """Struts from drive positions: strut k = sign_k * drive order_k + offset_k."""

    order: tuple[Count, Count, Count, Count, Count, Count] = (1, 2, 3, 4, 5, 6)
    """Number of the drive that moves each strut."""
    sign: tuple[Number, Number, Number, Number, Number, Number]
    """1 where a strut grows with its drive's position, -1 where it shrinks."""
    offset_mm: Six
    """Length of each strut at drive position 0."""

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        if sorted(self.order) != [1, 2, 3, 4, 5, 6]:
            raise ValueError(
                phrase(
                    "order_once", "order = {order} does not name each of the drives 1 to 6 once", order=list(self.order)
                )
            )
        if any(abs(s) != 1.0 for s in self.sign):
            raise ValueError(
                phrase(
                    "signs_only",
                    "sign = {sign} may hold 1 and -1 only; scale with recording.units",
                    sign=list(self.sign),
                )
            )
        return self

    @property
    def index(self) -> list[int]:
        """Column of the drive that moves each strut, counted from 0."""
        return [k - 1 for k in self.order]

    offset: ClassVar = si("offset_mm")  # strut lengths at drive position 0, shape (6,) [m]


class Accelerometer(Part):
    """A three-axis accelerometer on the platform; it reads specific force, at rest minus gravity."""

    scale_m_s2: Positive
    """Acceleration at a reading of 1."""
    mounting: tuple[Vector, Vector, Vector]
    """Rotation, row by row: specific force in {P} = mounting times reading."""

    @model_validator(mode="after")
    def _turns(self) -> Self:
        matrix = np.array(self.mounting)
        error = max(np.abs(matrix @ matrix.T - np.eye(3)).max(), abs(np.linalg.det(matrix) - 1.0))
        if not error <= _ORTHOGONALITY:
            raise ValueError(
                phrase(
                    "not_a_rotation",
                    "mounting is not a rotation (off by {error}); rows must be orthonormal, right-handed",
                    error=f"{error:.3g}",
                )
            )
        return self

    @cached_property
    def matrix(self) -> Array:
        """Matrix from readings to specific force in {P}, shape (3, 3) [m/s^2]."""
        return frozen(np.array(self.mounting) * self.scale_m_s2)


class TextFile(Part):
    """How files of text are laid out; these keys do not apply to Parquet files and ROS 2 bags."""

    format: FormatName = "csv"
    """What wrote the file; `csv` is any table of text. Files that say themselves what they are need no format."""
    delimiter: Separator | None = None
    """Character between two fields; by default a comma; of `halsampler` a blank, of Scope what the file has."""
    decimal: Literal[".", ","] | None = None
    """Decimal sign; by default a point."""
    header_rows: Count | None = None
    """Lines above the first row of numbers."""
    names_row: Annotated[int, Field(strict=True, ge=1)] | None = None
    """Which of them holds the names of the columns; by default the last."""
    trailing_rows: Count = 0
    """Lines below the last row of numbers."""
    column_names: tuple[str, ...] | None = None
    """Names of the file's columns in their order, for files that have none."""
    encoding: Literal["utf-8", "cp1252"] = "utf-8"
    """Encoding of the text; UTF-16 with its mark needs none."""
    empty: Literal["missing", "hold", "apart"] | None = None
    """What an empty field stands for: `missing`, no value; `hold`, the last one; `apart`, nothing, for rows of several
    recorders or topics stand among each other. By default missing, in traces of a SINUMERIK the last one."""

    @property
    def separator(self) -> str:
        """Character between two fields, where it is not looked for in the file."""
        return self.delimiter or (" " if self.format == "halsampler" else ",")


class Trigger(Part):
    """The trigger, where it is a bit of a column, or its column has another name."""

    column: str | None = None
    """Name that the file has for its column."""
    bit: Annotated[int, Field(strict=True, ge=0, le=52)] | None = None
    """Which bit of whole numbers it is, counted from 0; by default the column is a switch."""


class FileFormat(TextFile):
    """How a file is read: its layout, names, units, orientations and clock."""

    columns: dict[str, str] = Field(default_factory=dict)
    """Our column name -> the file's, for files that use other names."""
    units: dict[Role, str] = Field(default_factory=dict)
    """What columns hold, `struts`, `forces` and the like -> the file's unit; by default that of its labels, else of our
    names."""
    scale: dict[str, Number] = Field(default_factory=dict)
    """Our column name -> what a 1 in the file is in the unit of that name: of counts of a converter, or where a sign
    turns."""
    offset: dict[str, Number] = Field(default_factory=dict)
    """Our column name -> what a 0 in the file is in the unit of that name."""
    orientation: str | None = None
    """How the file writes orientations; by default `xyz extrinsic`, roll, pitch and yaw, where it has angles."""
    clock: Clock = Clock()
    """The time stamps."""
    trigger: Trigger | None = None
    """Where the trigger is a bit among others."""
    drives: Drives | None = None
    """Where the file holds drive positions instead of strut lengths."""
    accelerometer: Accelerometer | None = None
    """Where the file holds readings of an accelerometer."""
    ros: dict[Literal["joints", "wrench", "time", "frame"], str] = Field(default_factory=dict)
    """Topics of a bag of ROS that hold the run, `sensor_msgs/JointState` as `joints` and `geometry_msgs/WrenchStamped`,
    the raw one, as `wrench`; by default the only ones of their kind. `time = "receipt"`: the bag's own time counts, for
    headers without one. `frame`: what headers of wrenches call the axes of the sensor; others are refused."""

    @model_validator(mode="after")
    def _times(self) -> Self:
        if (time := self.ros.get("time", "header")) not in ("header", "receipt"):
            raise ValueError(
                phrase("ros_time", "ros.time = {time} is not known; give 'header' or 'receipt'", time=repr(time))
            )
        return self

    @model_validator(mode="after")
    def _known_names(self) -> Self:
        for ours in self.columns:
            if ours not in COLUMNS:
                raise ValueError(
                    phrase(
                        "no_such_column",
                        "columns: {ours} is none of our columns; they are {columns}",
                        ours=repr(ours),
                        columns=", ".join(COLUMNS),
                    )
                )
        if self.trigger is not None and self.trigger.column is not None and TRIGGER in self.columns:
            raise ValueError(
                phrase(
                    "trigger_twice", "columns.trigger and trigger.column both name the trigger's column; leave one out"
                )
            )
        for theirs in self.columns.values():
            if list(self.columns.values()).count(theirs) > 1:
                raise ValueError(
                    phrase(
                        "column_twice",
                        "columns maps {theirs} to two of our columns; give each column one meaning",
                        theirs=repr(theirs),
                    )
                )
        for role, unit in self.units.items():
            if ROLE_UNITS[role].symbol(unit) is None:
                raise ValueError(
                    phrase(
                        "no_such_unit",
                        "units.{role} = {unit} is not known; give {units}",
                        role=role,
                        unit=repr(unit),
                        units=", ".join(ROLE_UNITS[role]),
                    )
                )
        return self

    @model_validator(mode="after")
    def _known_meaning(self) -> Self:
        for key, table, without in (("scale", self.scale, (TRIGGER,)), ("offset", self.offset, (TRIGGER, CLOCK))):
            for ours in table:
                if ours not in COLUMNS or ours in without:
                    numbers = ", ".join(column for column in COLUMNS if column not in without)
                    raise ValueError(
                        phrase(
                            "not_numbers",
                            "{key}: {ours} is none of our columns of numbers; they are {numbers}",
                            key=key,
                            ours=repr(ours),
                            numbers=numbers,
                        )
                    )
        if zero := next((ours for ours, value in self.scale.items() if value == 0.0), None):
            raise ValueError(
                phrase(
                    "scale_zero",
                    "scale.{column} is 0, which makes all values equal; give what a 1 in the file is",
                    column=zero,
                )
            )
        if self.scale.get(CLOCK, 1.0) < 0.0:
            raise ValueError(phrase("scale_backwards", "scale.{column} is below 0; time increases", column=CLOCK))
        if self.orientation is not None and self.orientation not in CONVENTIONS:
            raise ValueError(
                phrase(
                    "no_such_orientation",
                    "orientation = {name} is not known; {remedy}",
                    name=repr(self.orientation),
                    remedy=said(ways_to_write(self.orientation)),
                )
            )
        return self

    @model_validator(mode="after")
    def _nothing_left_to_guess(self) -> Self:
        if self.names_row is not None and self.names_row > (self.header_rows or 0):
            raise ValueError(
                phrase(
                    "names_row_outside",
                    "names_row = {row} is not among header_rows = {rows} lines",
                    row=self.names_row,
                    rows=self.header_rows or 0,
                )
            )
        clock = () if self.column_names and self.file_name(CLOCK) in self.column_names else ("clock.period_ms",)
        needed = {
            "halsampler": ("column_names", *clock),
            "sinumerik-trace": ("delimiter", "decimal", "header_rows", "clock.unit"),
        }  # fmt: skip
        for key in needed.get(self.format, ()):
            if attrgetter(key)(self) is None:
                raise ValueError(
                    phrase(
                        "format_lacks",
                        "{key} is missing; files of {format} do not say it, or differ in it: state it",
                        key=key,
                        format=self.format,
                    )
                )
        return self

    def stated_name(self, ours: str) -> str | None:
        """Name that is stated for one of our columns; None where none is."""
        if ours == TRIGGER and self.trigger is not None and self.trigger.column is not None:
            return self.trigger.column
        return self.columns.get(ours)

    def file_name(self, ours: str) -> str:
        """Name that files have for one of our columns."""
        return self.stated_name(ours) or ours

    def factor(self, ours: str) -> float:
        """SI value of a 1 in a column: by its scale, else its role in `units`, else the unit of its name."""
        if (role := ROLE_OF.get(ours)) is None:
            return self.scale.get(ours, 1.0)
        units = ROLE_UNITS[role]
        if ours in self.scale:
            return self.scale[ours] * units[units.usual]
        return units[units.symbol(self.units.get(role, units.usual)) or units.usual]

    def shift(self, ours: str) -> float:
        """SI value of a 0 in a column."""
        units = ROLE_UNITS.get(ROLE_OF[ours]) if ours in ROLE_OF else None
        return self.offset.get(ours, 0.0) * (1.0 if units is None else units[units.usual])

    @property
    def clock_unit(self) -> str:
        """Unit of the time stamps."""
        return self.clock.unit or ("ms" if self.format == "twincat-scope" else "s")

    @property
    def tick(self) -> float:
        """Duration of one unit of the time stamps [s]."""
        return TICKS[self.clock_unit]


class FileOfRun(FileFormat):
    """How one of several files of a run is written, where they are not alike; what is not stated has its default."""

    match: str | None = None
    """Pattern of the file's name, such as `forces*.csv`; by default the table is for files that have its columns."""
    _number: int = PrivateAttr(default=0)

    @property
    def number(self) -> int:
        """Which of the tables it is, from 0, among the ways in which a file may be written."""
        return self._number

    def as_number(self, number: int, **update: object) -> Self:
        """The same with its number, and with other values."""
        table = self.model_copy(update=update)
        table._number = number
        return table

    @model_validator(mode="after")
    def _of_files_alone(self) -> Self:
        for key in ("drives", "accelerometer"):
            if getattr(self, key) is not None:
                raise ValueError(
                    phrase(
                        "of_the_machine",
                        "{key} belongs to the machine, not to a file; state it as recording.{key}",
                        key=key,
                    )
                )
        return self


class RecordingFormat(FileFormat):
    """How recordings of this case are read; units are those that labels state, else those of our column names."""

    filter_cutoff_Hz: Positive | None = None
    """Zero-phase low-pass on forces and struts alike; needed where accelerations are differentiated."""
    rate_Hz: Positive = 1000.0
    """Rows per second of the recordings, or averages of so many: what predicted standard deviations count on."""
    files: tuple[FileOfRun, ...] = ()
    """Files of a run that are written in other ways, one table each."""

    def ways(self, name: str) -> tuple[FileFormat, ...]:
        """How a file of this name may be written: by the tables that name it, else those that name none, and this."""
        machine = {"drives": self.drives, "accelerometer": self.accelerometer}
        tables = [form.as_number(k, **machine, ros=self.ros | form.ros) for k, form in enumerate(self.files)]
        named = tuple(form for form in tables if form.match is not None and fnmatch(name, form.match))
        return named or (*(form for form in tables if form.match is None), self.model_copy(update={"files": ()}))

    def file_name(self, ours: str) -> str:
        """Name that files have for one of our columns."""
        return next((name for form in (self, *self.files) if (name := form.stated_name(ours))), ours)

    def place(self, key: str, ours: str) -> str:
        """Where a key for a column of ours stands: in the table of `files` that names the column, if one does."""
        named = [k for k, form in enumerate(self.files, 1) if ours in {*form.columns, *(form.column_names or ())}]
        return f"recording.files[{named[0]}].{key}" if len(named) == 1 else f"recording.{key}"
