"""From files to the streams of a run: each in its format, recognised by its columns, on one time axis.

The first bytes say whether a file is Parquet, the first lines what wrote a text, unless the case states it: for all
files, or in a table for each.
"""

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.base.units import Array
from cases.machine import POSE
from cases.orientation import ROTATION
from cases.recording_format import CLOCK, FileFormat, FileOfRun, RecordingFormat
from cases.schema import Case
from identification.recording.formats.assembly import stream_of
from identification.recording.formats.joining import on_one_axis
from identification.recording.formats.parquet import parquet_tables
from identification.recording.formats.quantities import with_units
from identification.recording.formats.recorders import known
from identification.recording.formats.ros.bags import bag_format, bag_tables
from identification.recording.formats.table import (
    ColumnTable,
    Stream,
    listed,
    require_file,
    require_room,
    shown,
    unreadable,
)
from identification.recording.formats.table_clock import by_clock, clocked, require_clock, start_of
from identification.recording.formats.text_layout import without

_PARQUET = b"PAR1"


def read_tables(
    file: Path, form: FileFormat, ranges: Array | None = None, more_bags: Sequence[Path] = ()
) -> tuple[ColumnTable, ...]:
    """Reads a file: one table for each clock in it; raises RecordingError with the place and the remedy.

    Args:
        file: the file.
        form: how it is written.
        ranges: of the force channels, as of `Sensors.range`, for what is said of shares of them.
        more_bags: further bags of the run, where the file is a bag.
    """
    tables: Iterable[ColumnTable]
    if is_bag(file):
        tables = bag_tables([file, *more_bags], form)
    elif is_parquet(file):
        tables = parquet_tables(file, form)
    else:
        tables = known.read(file, form)
    return tuple(with_units(table, ranges) for table in tables)


def is_parquet(file: Path) -> bool:
    """Whether a file is Parquet; raises RecordingError where it cannot be read."""
    require_file(file)
    try:
        with file.open("rb") as stream:
            return stream.read(len(_PARQUET)) == _PARQUET
    except OSError as error:
        raise unreadable(file, error) from error


def read_run(paths: Sequence[Path], case: Case) -> tuple[Stream, ...]:
    """The streams of one run from its files in any order, that of the forces first; columns say what they hold.

    What reading made known of any of them are findings of the first. Files whose samples coincide are joined. Raises
    RecordingError for anything that prevents the use of the run.
    """
    if not paths:
        raise RecordingError(problem="no recording is named", remedy="give the files of one run", code=Code.MISSING)
    tables: list[ColumnTable] = []
    for path, more_bags in bags_together(paths):
        file, ways = _file_of(path, case, more_bags)
        others = sum(table.rows * len(table.values) for table in tables)
        tables += (tables_of_file := _read_in_one_of(file, ways, case, more_bags))
        require_room(
            file,
            max(table.rows for table in tables_of_file),
            sum(len(table.values) for table in tables_of_file),
            others,
        )
    for table in tables:
        with _in_table_of(table):
            require_clock(table)  # before the first of them is taken for the run's beginning
    parts: list[ColumnTable] = []
    for table in tables:
        with _in_table_of(table):
            parts += by_clock(clocked(table))
    tables = parts
    origin = min((start_of(table) for table in tables if table.stamps is not None), default=Fraction(0))
    streams: list[Stream] = []
    for table in tables:
        with _in_table_of(table):
            streams += [stream_of(table, case, origin)]
    _require_whole(streams, case, [name for table in tables for name in table.names])
    findings = tuple(finding for stream in streams for finding in stream.findings)
    stated = [bool(table.form.clock.offset_s) for table in tables]
    streams, of_clocks = on_one_axis([replace(stream, findings=()) for stream in streams], stated)
    main = next(s for s in streams if s.forces is not None)
    if case.setup == "1a" and main.forces is not None:  # the frame does not move
        main = replace(main, rotations=np.tile(np.eye(3), (len(main.forces), 1, 1)))
    if main.drives is None and main.poses is not None and case.hexapod is not None:
        from identification.machines.hexapod import Hexapod

        main = replace(main, drives=Hexapod.of(case).strut_lengths(main.poses))
    return replace(main, findings=(*findings, *of_clocks), origin=origin), *(s for s in streams if s.forces is None)


def written_columns(paths: Sequence[Path], case: Case, names: Sequence[str]) -> Array | None:
    """Columns of a run's files as they are written, in SI units, shape (n, k); None where no file has all of them.

    Raises RecordingError where a file cannot be read.
    """
    for path, more_bags in bags_together(paths):
        for table in _read_in_one_of(*_file_of(path, case, more_bags), case, more_bags):
            if {*names} <= table.values.keys():
                return np.column_stack([table.values[c] * table.factors[c] + table.form.shift(c) for c in names])
    return None


def tables_of_columns(paths: Sequence[Path], case: Case) -> dict[str, int]:
    """Our columns of a run's files that a table of `[[recording.files]]` reads -> its number, from 0.

    Raises RecordingError where a file cannot be read.
    """
    if not case.recording.files:
        return {}
    return {
        ours: table.form.number
        for path, more_bags in bags_together(paths)
        for table in _read_in_one_of(*_file_of(path, case, more_bags), case, more_bags)
        if isinstance(table.form, FileOfRun)
        for ours in (*table.values, *((CLOCK,) if table.stamps is not None else ()))
    }


_ROS_1 = b"#ROSBAG V"
_STORED = {
    ".mcap": b"\x89MCAP0\r\n",
    ".db3": b"SQLite format 3\0",
    **dict.fromkeys((".bag", ".BAG", ".active"), _ROS_1),
}
"""How the files of bags end, and begin: of ROS 2 as MCAP or SQLite, of ROS 1, and of one that was being recorded."""


def is_bag(path: Path) -> bool:
    """Whether a path is the folder of a bag, or the file of one by itself."""
    if os.path.isdir(path):  # False for names that no system takes
        return os.path.isfile(path / "metadata.yaml")
    mark = _STORED.get(path.suffix)
    if mark is None or not os.path.isfile(path):
        return False
    try:
        with path.open("rb") as stream:
            return stream.read(len(mark)) == mark
    except OSError:  # the reader says why
        return False


def bag_of(path: Path) -> Path:
    """The bag that a path means: the folder of a file with metadata.yaml beside it, the only file of one without.

    Any other path is returned as it is.
    """
    if path.suffix in _STORED and os.path.isfile(path) and is_bag(path.parent):
        return path.parent
    if os.path.isdir(path) and not is_bag(path):  # as after a recorder was stopped hard
        stored = [file for file in sorted(path.iterdir()) if file.suffix in _STORED and is_bag(file)]
        return stored[0] if len(stored) == 1 else path
    return path


def bags_together(paths: Sequence[Path]) -> list[tuple[Path, tuple[Path, ...]]]:
    """Paths of one run, each by itself, but for bags, which are read as one: the first of them with all others."""
    bags = [bag for path in paths if is_bag(bag := _bag_or_path(path))]
    if len(bags) < 2:
        return [(path, ()) for path in paths]
    first, *others = dict.fromkeys(bags)
    return [(first, tuple(others)), *((path, ()) for path in paths if _bag_or_path(path) not in bags)]


def _bag_or_path(path: Path) -> Path:
    """The bag that a path means, or the path as it is; also of names that the system refuses."""
    try:
        return bag_of(path)
    except OSError:
        return path


def recording_of(path: Path) -> Path:
    """The file or bag that a path means: of a folder that `hexcite run` wrote the recording in it."""
    place = bag_of(path)
    if place.is_dir() and not is_bag(place):
        candidates = [place / name for name in ("recording.parquet", "recording.csv")]
        return next((file for file in candidates if file.is_file()), candidates[-1])
    return place


def files_of(paths: Sequence[Path]) -> list[Path]:
    """The files that paths mean: a folder of `hexcite run` means the recording in it, a bag all of its files."""
    places = [_file_of(path, None)[0] for path in paths]
    return [file for place in places for file in (sorted(place.iterdir()) if place.is_dir() else [place])]


def _file_of(path: Path, case: Case | None, more_bags: Sequence[Path] = ()) -> tuple[Path, tuple[FileFormat, ...]]:
    """The file or bag that a path means, and how it may be written: what `hexcite run` wrote has our names."""
    try:
        path = recording_of(path)
        if is_bag(path):
            ways = () if case is None else case.recording.ways(path.name)
            return path, tuple(bag_format([path, *more_bags], form, case) for form in ways if case is not None)
        ours = path.stem == "recording" and path.with_name("recording.json").is_file()
    except OSError:  # a name that the system refuses; the reader explains it
        ours = False
    return path, (RecordingFormat(),) if ours or case is None else case.recording.ways(path.name)


def _read_in_one_of(
    file: Path, ways: Sequence[FileFormat], case: Case, more_bags: Sequence[Path] = ()
) -> tuple[ColumnTable, ...]:
    """The tables of a file by the first way in which it can be read, has all columns that are mapped, and is plausible.

    Raises RecordingError with what is wrong with each way, where there are several.
    """
    if len(ways) == 1:
        try:
            return read_tables(file, ways[0], case.sensors.range, more_bags)
        except RecordingError as error:
            patterns = [form.match for form in case.recording.files if form.match is not None]
            if isinstance(ways[0], FileOfRun):
                raise _in_its_table(error, ways[0]) from error
            if not patterns:
                raise
            raise error.beside([f"its name fits no match of [[recording.files]]: {listed(patterns)}"]) from error
    problems = []
    for form in ways:
        try:
            tables = read_tables(file, form, case.sensors.range, more_bags)
            for table in tables:  # numbers without names fit many a table, but not its switch, its lengths, its turns
                stream_of(table, case, Fraction(0))
        except RecordingError as error:
            problems.append(str(error).removeprefix(str(file)).lstrip(":, "))
            continue
        names = {name for table in tables for name in table.names}
        missing = [theirs for ours, theirs in form.columns.items() if theirs not in names and ours != CLOCK]
        if not missing:
            return tables
        problems.append(f"column {shown(missing[0])} is missing")
    reasons = "; ".join(f"{k}: {problem}" for k, problem in enumerate(problems, 1))
    remedy = f'give the table that is meant match = "{shown(file.name)}", then its mistake is named alone'
    raise RecordingError(
        place=file,
        problem=f"fits none of the {len(ways)} tables of [[recording.files]] and [recording]: {reasons}",
        remedy=remedy,
        code=Code.WRONG_KIND,
    )


@contextmanager
def _in_table_of(table: ColumnTable) -> Iterator[None]:
    """What is wrong with a file is said with the table of the case that reads it."""
    try:
        yield
    except RecordingError as error:
        named = _in_its_table(error, table.form)
        if named is error:
            raise
        raise named from error


def _in_its_table(error: RecordingError, form: FileFormat) -> RecordingError:
    """An error about a file, which names keys of `[recording]`, with the table in which those of this file stand."""
    if not isinstance(form, FileOfRun) or not _KEYS.search(error.message):
        return error
    return error.beside(
        [
            phrase(
                "in_its_table",
                "keys of this file stand in recording.files[{number}] of the case",
                number=form.number + 1,
            )
        ]
    )


_KEYS = re.compile(r"recording\.(?=[a-z_]+)|\[recording(?=[.\]])")


def _require_whole(streams: Sequence[Stream], case: Case, names: Sequence[str]) -> None:
    """Raises RecordingError unless there are forces and a pose, each channel once."""
    form = case.recording
    owner: dict[str, str] = {}
    for stream in streams:
        for channel in stream.channels:
            if channel in owner and channel != "trigger":  # by which clocks are joined
                reason = f"has {channel.replace('_', ' ')}, as {owner[channel]} does"
                raise RecordingError(
                    place=stream.source,
                    problem=reason,
                    remedy="give the files of one run, each once",
                    code=Code.CONTRADICTION,
                )
            owner[channel] = stream.source
    sources = ", ".join(dict.fromkeys(s.source for s in streams))
    if "forces" not in owner:
        raise RecordingError(
            place=sources,
            problem=phrase("no_forces", "no forces: {none}", none=without(names, form, case.sensor_frame.channels)),
            code=Code.MISSING,
        )
    if case.setup != "1a" and not {"drives", "poses", "rotations"} & owner.keys():
        columns = case.drive_columns if case.machine is not None else (*ROTATION, *POSE)
        raise RecordingError(
            place=sources,
            problem=phrase("no_pose", "no pose: {none}", none=without(names, form, columns)),
            code=Code.MISSING,
        )
