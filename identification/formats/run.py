"""From files to a run: each file in its format, streams told apart by their columns, on one time axis."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cases.errors import RecordingError
from cases.recording import RecordingFormat
from cases.recording_columns import POSE, ROTATION, STRUTS
from cases.schema import Case
from identification.formats.assembly import force_columns, start_of, streams_of
from identification.formats.checks import require_stamps
from identification.formats.header import without
from identification.formats.missing import require_measured
from identification.formats.reading import read_batches as read_table_batches
from identification.formats.reading import read_tables
from identification.formats.stream import Recording, Stream, either
from identification.formats.table import Table


def read_recording(path: Path, case: Case) -> Recording:
    """Reads a recording: a file in the case's format, or the folder that `hexcite run` wrote.

    Args:
        path: file or folder.
        case: says which columns to expect and how the file writes them.

    Raises:
        RecordingError: anything that keeps the run from being used, with line, column, value and remedy.
    """
    return read_run([path], case)


def read_run(paths: Sequence[Path], case: Case) -> Recording:
    """Reads the files of one run, told apart by their columns.

    Args:
        paths: in any order; at least one.
        case: says which columns to expect and how the files write them.

    Returns:
        The run; files whose samples coincide are joined.

    Raises:
        RecordingError: anything that keeps the run from being used; several files of one kind; no common time.
    """
    if not paths:
        raise RecordingError("no recording is named; give the files of one run")
    tables: list[tuple[Table, RecordingFormat]] = []
    for path in paths:
        file, form = _file_of(path, case.recording)
        held = sum(table.rows * len(table.values) for table, _ in tables)
        tables += [(table, form) for table in read_tables(file, form, held)]
    for table, form in tables:
        require_stamps(table, form)  # before the first of them is taken for the run's beginning
        require_measured(table, form)
    starts = [start_of(table, form) for table, form in tables if table.stamps is not None]
    origin = min(starts, default=None)
    streams = [stream for table, form in tables for stream in streams_of([table], case, form, origin)]
    _require_whole(streams, case, [name for table, _ in tables for name in table.names])
    streams = _joined(streams)
    _require_one_time(streams)
    main = next(s for s in streams if s.forces is not None)
    if case.setup == "1a" and main.forces is not None:  # the frame stands where it stands
        main = replace(main, rotations=np.tile(np.eye(3), (len(main.forces), 1, 1)))
    if main.struts is None and main.poses is not None:
        main = _with_kinematics(main, main.poses, case)
    assert main.forces is not None
    others = tuple(s for s in streams if s.forces is None)
    return Recording(
        main.source, main.t, main.struts, main.rotations, main.forces, main.trigger, main.strut_velocities, main.poses,
        main.specific_forces, others, main.lines, override=main.override, missing=main.missing,
        missing_in=main.missing_in, case=case, paths=tuple(paths),
    )  # fmt: skip


def read_batches(path: Path, case: Case) -> Iterator[Stream]:
    """Reads one file of any length, some ten thousand rows at a time.

    Args:
        path: file or folder.
        case: says which columns to expect and how the file writes them.

    Returns:
        Streams in the file's order, on one time axis.

    Raises:
        RecordingError: as `read_recording`, once the place is reached.
    """
    file, form = _file_of(path, case.recording)
    return streams_of(read_table_batches(file, form), case, form)


def files_of(paths: Sequence[Path]) -> list[Path]:
    """The files that paths mean: a folder of `hexcite run` means the recording in it."""
    return [_file_of(path, None)[0] for path in paths]


def _file_of(path: Path, form: RecordingFormat | None) -> tuple[Path, RecordingFormat]:
    """The file that a path means, and how it is written: what `hexcite run` wrote has our names and units."""
    try:
        if path.is_dir():
            parquet = path / "recording.parquet"
            path = parquet if parquet.is_file() else path / "recording.csv"
        ours = path.stem == "recording" and path.with_name("recording.json").is_file()
    except OSError:  # a name that the system refuses; the reader explains it
        ours = False
    return path, RecordingFormat() if ours or form is None else form


def _require_whole(streams: Sequence[Stream], case: Case, names: Sequence[str]) -> None:
    """Raises RecordingError unless there are forces and a pose, each channel once."""
    form = case.recording
    owner: dict[str, str] = {}
    for stream in streams:
        for channel in stream.channels:
            if channel in owner:
                where = "and is given twice" if owner[channel] == stream.source else f"as {owner[channel]} does"
                raise RecordingError(
                    f"{stream.source}: has {channel.replace('_', ' ')}, {where}; give the files of one run, each once"
                )
            owner[channel] = stream.source
    sources = ", ".join(dict.fromkeys(s.source for s in streams))
    if "forces" not in owner:
        wanted = [form.file_name(c) for c in force_columns(case)]
        raise RecordingError(f"{sources}: no forces: {without(wanted, names)}")
    if case.setup != "1a" and not {"struts", "poses", "rotations"} & owner.keys():
        wanted = [form.file_name(c) for c in (STRUTS if case.machine is not None else (*ROTATION, *POSE))]
        raise RecordingError(f"{sources}: no pose: {without(wanted, names)}")


def _joined(streams: Sequence[Stream]) -> list[Stream]:
    """Streams whose samples coincide as one."""
    joined: list[Stream] = []
    for stream in streams:
        same = next((k for k, s in enumerate(joined) if _coincide(s, stream)), None)
        if same is None:
            joined.append(stream)
        else:
            more: dict[Any, Any] = {**stream.channels}
            missing = either(joined[same].missing, stream.missing)
            names = (*joined[same].missing_in, *stream.missing_in)
            joined[same] = replace(joined[same], missing=missing, missing_in=names, **more)
    return joined


def _coincide(one: Stream, other: Stream) -> bool:
    if one.t is None or other.t is None:
        return one.t is other.t and one.rows == other.rows
    return np.array_equal(one.t, other.t)


def _require_one_time(streams: Sequence[Stream]) -> None:
    """Raises RecordingError unless the streams of a run overlap in time."""
    first = streams[0]
    for stream in streams[1:]:
        if stream.t is None or first.t is None:
            without_clock, other = (stream, first) if stream.t is None else (first, stream)
            reason = "has no time stamps" if other.t is not None else f"has {stream.rows} standstills"
            against = "has" if other.t is not None else f"has {first.rows}"
            raise RecordingError(
                f"{without_clock.source}: {reason}, {other.source} {against}; give files of one run, recorded together"
            )
    spans = [(float(s.t[0]), float(s.t[-1]), s.source) for s in streams if s.t is not None]
    start, _, late = max(spans, default=(0.0, 0.0, ""))
    end, early = min(((end, source) for _, end, source in spans), default=(0.0, ""))
    if len(spans) > 1 and start >= end:
        raise RecordingError(
            f"{late}: starts {start - end:.6g} s after {early} ends; give the files of one run, or state how their "
            "clocks differ in recording.clock.offset_s"
        )


def _with_kinematics(stream: Stream, poses: np.ndarray, case: Case) -> Stream:
    """The stream with what follows from its poses: strut lengths (7), or, without a machine, rotations."""
    if case.machine is not None:
        from identification.hexapod import Hexapod

        return replace(stream, struts=Hexapod.of(case).strut_lengths(poses))
    from scipy.spatial.transform import Rotation

    return replace(stream, rotations=Rotation.from_euler("xyz", poses[:, 3:]).as_matrix())
