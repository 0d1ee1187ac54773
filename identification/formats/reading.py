"""From files to the streams of a run: each in its format, recognised by its columns, on one time axis.

The first bytes say whether a file is Parquet, the first lines what wrote a text, unless the case states it.
"""

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from cases.errors import RecordingError
from cases.machine import POSE
from cases.orientation import ROTATION
from cases.recording_format import RecordingFormat
from cases.schema import Case
from identification.formats import binary, known
from identification.formats.assembly import require_clock, start_of, stream_of
from identification.formats.quantities import with_units
from identification.formats.table import ColumnTable, Stream, require_file, require_room, unreadable
from identification.formats.text import without

_PARQUET = b"PAR1"


def read_tables(file: Path, form: RecordingFormat) -> tuple[ColumnTable, ...]:
    """Reads a file: one table for each clock in it; raises RecordingError with the place and the remedy."""
    reader: Callable[[Path, RecordingFormat], Iterable[ColumnTable]]
    if is_bag(file):
        reader = binary.bag_tables
    elif is_parquet(file):
        reader = binary.parquet_tables
    else:
        reader = known.read
    return tuple(with_units(table) for table in reader(file, form))


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
        raise RecordingError("no recording is named; give the files of one run")
    tables: list[ColumnTable] = []
    for path in paths:
        file, form = _file_of(path, case)
        others = sum(table.rows * len(table.values) for table in tables)
        tables += (own := read_tables(file, form))
        require_room(file, max(table.rows for table in own), sum(len(table.values) for table in own), others)
    for table in tables:
        require_clock(table)  # before the first of them is taken for the run's beginning
    origin = min((start_of(table) for table in tables if table.stamps is not None), default=Fraction(0))
    streams = [stream_of(table, case, origin) for table in tables]
    _require_whole(streams, case, [name for table in tables for name in table.names])
    findings = tuple(finding for stream in streams for finding in stream.findings)
    streams = _joined([replace(stream, findings=()) for stream in streams])
    _require_one_time(streams)
    main = next(s for s in streams if s.forces is not None)
    if case.setup == "1a" and main.forces is not None:  # the frame does not move
        main = replace(main, rotations=np.tile(np.eye(3), (len(main.forces), 1, 1)))
    if main.struts is None and main.poses is not None and case.hexapod is not None:
        from identification.hexapod import Hexapod

        main = replace(main, struts=Hexapod.of(case).strut_lengths(main.poses))
    return replace(main, findings=findings), *(s for s in streams if s.forces is None)


_STORED = (".mcap", ".db3")  # of a bag


def is_bag(path: Path) -> bool:
    """Whether a path is the folder of a bag."""
    return os.path.isdir(path) and os.path.isfile(path / "metadata.yaml")  # False for names that no system takes


def bag_of(path: Path) -> Path:
    """The folder of the bag whose file a path is; else the path itself."""
    return path.parent if path.suffix in _STORED and is_bag(path.parent) else path


def files_of(paths: Sequence[Path]) -> list[Path]:
    """The files that paths mean: a folder of `hexcite run` means the recording in it, a bag all of its files."""
    places = [_file_of(path, None)[0] for path in paths]
    return [file for place in places for file in (sorted(place.iterdir()) if is_bag(place) else [place])]


def _file_of(path: Path, case: Case | None) -> tuple[Path, RecordingFormat]:
    """The file or bag that a path means, and how it is written: what `hexcite run` wrote has our names and units."""
    try:
        path = bag_of(path)
        if is_bag(path):
            return path, RecordingFormat() if case is None else binary.bag_format(case)
        if path.is_dir():
            parquet = path / "recording.parquet"
            path = parquet if parquet.is_file() else path / "recording.csv"
        ours = path.stem == "recording" and path.with_name("recording.json").is_file()
    except OSError:  # a name that the system refuses; the reader explains it
        ours = False
    return path, RecordingFormat() if ours or case is None else case.recording


def _require_whole(streams: Sequence[Stream], case: Case, names: Sequence[str]) -> None:
    """Raises RecordingError unless there are forces and a pose, each channel once."""
    form = case.recording
    owner: dict[str, str] = {}
    for stream in streams:
        for channel in stream.channels:
            if channel in owner:
                reason = f"has {channel.replace('_', ' ')}, as {owner[channel]} does"
                raise RecordingError(stream.source, reason, "give the files of one run, each once")
            owner[channel] = stream.source
    sources = ", ".join(dict.fromkeys(s.source for s in streams))
    if "forces" not in owner:
        raise RecordingError(sources, f"no forces: {without(names, form, case.sensor_frame.channels)}")
    if case.setup != "1a" and not {"struts", "poses", "rotations"} & owner.keys():
        columns = case.drive_columns if case.machine is not None else (*ROTATION, *POSE)
        raise RecordingError(sources, f"no pose: {without(names, form, columns)}")


def _joined(streams: Sequence[Stream]) -> list[Stream]:
    """Streams whose samples coincide as one."""
    result: list[Stream] = []
    for stream in streams:
        times = stream.t if stream.t is not None else stream.rows
        same = next((k for k, s in enumerate(result) if np.array_equal(s.rows if s.t is None else s.t, times)), None)
        if same is None:
            result.append(stream)
        else:
            more: dict[Any, Any] = {**stream.channels}
            masks = [s.missing for s in (result[same], stream) if s.missing is not None]
            missing = np.any(masks, axis=0) if masks else None
            names = (*result[same].missing_in, *stream.missing_in)
            result[same] = replace(result[same], missing=missing, missing_in=names, **more)
    return result


def _require_one_time(streams: Sequence[Stream]) -> None:
    """Raises RecordingError unless the streams of a run overlap in time."""
    if len(streams) == 1:
        return
    if any(stream.t is None for stream in streams):
        sources = ", ".join(stream.source for stream in streams)
        reason = "have no common rows, and not all of them have time stamps"
        raise RecordingError(sources, reason, "give files of one run, recorded together")
    spans = [(float(s.t[0]), float(s.t[-1]), s.source) for s in streams if s.t is not None]
    start, _, latest = max(spans)
    end, early = min((end, source) for _, end, source in spans)
    if start >= end:
        raise RecordingError(
            latest,
            f"starts {start - end:.6g} s after {early} ends",
            "give the files of one run, or state how their clocks differ in recording.clock.offset_s",
        )
