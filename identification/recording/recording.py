"""Recorded runs in SI units: read from files of any format with every damage explained, written whole.

Columns (CONVENTIONS): `t_s` (absent: each row is an averaged standstill), struts `l1_mm`..`l6_mm` (of a chain its
joints `q1_deg`.. or `q1_mm`..; or drive positions `q1_mm`.., a pose `x_mm`..`c_deg`, a rotation matrix `r11`..`r33`
sensor to world), forces `f1_N`..`f6_N` or `fx_N`..`mz_Nm`, optionally an accelerometer `ax`..`az`, `trigger` 0/1,
`override_percent` of the feed. The case's `[recording]` maps file formats, other names, units and clocks. A run may
come as several files with their own clocks.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from cases.base.atomic import atomic_folder
from cases.base.doors import checks
from cases.base.errors import Code, FileProblem, HexciteError, RecordingError, option
from cases.base.file_reading import read_json
from cases.base.folder_kinds import RUN
from cases.base.output_places import check_folder
from cases.base.phrases import phrase
from cases.base.renamed import renamed
from cases.base.text_formats import json_text
from cases.base.units import Array, Indices, as_html
from cases.basis import CONTENT, case_of, content_of, recording_basis, require_unchanged
from cases.orientation import ROTATION
from cases.recording_format import ACCELEROMETER, CLOCK, OVERRIDE, ROLE_OF, TRIGGER, Role
from cases.schema import Case
from cases.tables import own_units
from identification.recording.formats.clocks import lost_samples
from identification.recording.formats.table import Channel, Stream, told, unreadable
from identification.recording.record import AGAIN, Executed, RunRecord
from identification.texts import efficiency_text, share_text


@renamed(struts="drives")
@dataclass(frozen=True, slots=True, repr=False)
class Recording(Stream):
    """A run: the samples of the forces, with all channels of their clock, and streams of other clocks.

    >>> run = hx.Recording.load("empty")
    >>> run.t.shape, run.drives.shape, run.forces.shape
    ((5356,), (5356, 6), (5356, 6))
    >>> f"{run.executed.executed_s:.3f} s"
    '4.355 s'
    """

    forces: Array  # forces of the sensors, shape (n, 6) [N, or N and N m]
    others: tuple[Stream, ...] = ()  # what was sampled by other clocks, on the same time axis
    # weights of averaged standstills: what forces and model of each are multiplied by in a fit, shape (n,)
    weights: Array | None = None
    averaged: float = 1.0  # samples of the forces that were averaged over an interval of the motion
    case: Case | None = None  # case that it is from; None where that is not known
    paths: tuple[Path, ...] = ()  # paths of the files that it was read from
    record: RunRecord | None = None  # what `recording.json` says; None where there is none
    remarks: tuple[str, ...] = ()  # what has changed in the case since, where it is evaluated nevertheless

    def machine_case(self, case: Case | None = None) -> Case:
        """The case of its machine: another one that is given, else its own; RecordingError where there is none."""
        machine = self.case if case is None else case
        if machine is None:
            raise RecordingError(
                place=self.source,
                problem="does not say which machine it is from",
                remedy="give its case",
                code=Code.MISSING,
            )
        return machine

    def __post_init__(self) -> None:
        """Checks what is given, as of a stream; RecordingError names what is wrong."""
        if self.forces is None:
            raise RecordingError(
                place="Recording: forces",
                problem="is None",
                remedy="give numbers of shape (n, 6), one row a sample",
                code=Code.MISSING,
            )
        object.__setattr__(self, "paths", _paths(self.paths))
        for name, right, remedy in (
            ("case", isinstance(self.case, Case | None), "hx.load_case loads one"),
            ("record", isinstance(self.record, RunRecord | Mapping | None), "leave it out"),
            ("averaged", isinstance(self.averaged, Real) and float(self.averaged) >= 1.0, "give 1 or more samples"),
        ):
            if not right:
                raise RecordingError(
                    place=f"Recording: {name}",
                    problem=f"is {told(getattr(self, name))}",
                    remedy=remedy,
                    code=Code.WRONG_KIND,
                )
        if isinstance(self.record, Mapping):  # as in version 0.2
            object.__setattr__(self, "record", _record(self.record, "Recording: record") if self.record else None)
        others = tuple(self.others) if isinstance(self.others, list | tuple) else (self.others,)
        if odd := [told(other) for other in others if not isinstance(other, Stream)]:
            raise RecordingError(
                place="Recording: others",
                problem=f"holds {odd[0]}",
                remedy="give streams of other clocks",
                code=Code.WRONG_KIND,
            )
        object.__setattr__(self, "others", others)
        Stream.__post_init__(self)

    def save(self, folder: Path | str, overwrite: bool = False) -> None:
        """Makes a folder with recording.csv and recording.json.

        Raises:
            RecordingError: the run has several clocks, or its case is not known.
            FileProblem: the folder holds something else, or cannot be written.
        """
        if self.case is None:
            raise RecordingError(
                place=self.source,
                problem="does not say which case it is of",
                remedy="read it with its case",
                code=Code.MISSING,
            )
        if self.others:
            raise RecordingError(
                place=self.source,
                problem="has several clocks, and one table has one",
                remedy="keep its files",
                code=Code.NOT_SUPPORTED,
            )
        place = Path(folder)
        check_folder(place, RUN, self.paths, overwrite)
        record = (self.record or RunRecord.of_case(self.case, source=self.source)).to_json()
        with atomic_folder(place, RUN, overwrite) as part:
            write_recording(part / "recording.csv", self, self.case)
            (part / "recording.json").write_text(json_text(record | {CONTENT: content_of(record)}), encoding="utf-8")

    @classmethod
    @checks
    def load(
        cls, paths: Path | str | Sequence[Path | str], case: Case | None = None, stale: bool = False
    ) -> "Recording":
        """The recording of a folder, with the case that it names, or of files of one run, with a case that is given.

        Args:
            case: instead of the one that the folder names, as it is today.
            stale: read it although its case has changed since.

        Raises:
            RecordingError: it does not say which machine it is from, or cannot be used.
            FileProblem: its case has changed, and `stale` is not set.
        """
        place = Path(paths) if isinstance(paths, Path | str) else Path(paths[0])
        if case is not None:
            return read(paths, case)
        record = record_of(place)
        if record is None:
            raise RecordingError(
                place=place,
                problem="does not say which machine it is from",
                remedy=f"name it with {option('case')}, or a folder of hexcite run",
                code=Code.MISSING,
            )
        file = place / "recording.json"
        entries = record.to_json()
        case_of_run = case_of(file, entries, AGAIN)
        remarks = require_unchanged(file, entries, recording_basis(case_of_run), case_of_run, stale, AGAIN)
        return replace(read(paths, case_of_run), remarks=remarks)

    def __repr__(self) -> str:
        """A few lines: where it is from, how long, which channels."""
        size = f"{len(self.forces)} samples"
        if self.t is not None and len(self.t) > 1:
            size += f" in {float(self.t[-1] - self.t[0]):.2f} s"
        lines = [f"Recording {self.source}: {size}", f"channels: {', '.join(self.channels)}"]
        lines += [f"with another clock: {', '.join(s.channels)} ({s.source})" for s in self.others]
        executed = None if self.record is None else self.record.executed
        return "\n".join(lines + ([] if executed is None else _of_run(executed)))

    _repr_html_ = as_html

    @property
    def executed(self) -> Executed:
        """What a controller made of its program.

        Raises:
            RecordingError: no controller of hexcite ran it.
        """
        if self.record is None or self.record.executed is None:
            raise RecordingError(
                place=self.source,
                problem="is not a run of hexcite",
                remedy="hexcite run makes one",
                code=Code.WRONG_KIND,
            )
        return self.record.executed

    @property
    def lost(self) -> Indices:
        """How many samples were lost between each row and the next, shape (n - 1,)."""
        return lost_samples(self.t)

    @property
    def motion(self) -> Stream | None:
        """What moved, by its own clock: `.t` with `.drives`, `.poses` or `.rotations`; None where nothing did.

        This recording itself where one clock has all, else the one of `others` that has it: `drives` of a recording are
        None where drives and forces are not sampled together, as in bags of ROS.

        >>> run = hx.Recording.load("empty")
        >>> run.motion.drives.shape == run.drives.shape
        True
        """
        channels: tuple[Channel, ...] = ("drives", "poses", "rotations")
        streams = (stream for channel in channels if (stream := self.stream_with(channel)) is not None)
        return next(streams, None)

    def stream_with(self, channel: Channel) -> Stream | None:
        """The stream that has a channel; None where the run has no such channel."""
        return next((s for s in (self, *self.others) if channel in s.channels), None)


def _paths(paths: object) -> tuple[Path, ...]:
    """Paths of files; raises RecordingError where they are none."""
    places = paths if isinstance(paths, list | tuple) else (paths,)
    if not all(isinstance(path, str | PathLike) for path in places):
        raise RecordingError(
            place="Recording: paths",
            problem=f"is {told(paths)}",
            remedy="give the paths of its files, or none",
            code=Code.WRONG_KIND,
        )
    return tuple(Path(path) for path in places)


def _of_run(run: Executed) -> list[str]:
    """What a controller made of a program, in words."""
    peaks = ", ".join(f"{name} {share_text(share, 0)}" for name, share in run.peaks_of_limit.items())
    excitation = f"excitation took {run.executed_s:.3f} s of {run.planned_s:.3f} s planned, strayed "
    excitation += f"{run.path_error_mm:.3f} mm from the path"
    if run.d_efficiency is not None:
        excitation += f", D-efficiency {efficiency_text(run.d_efficiency)} as executed"
    return [
        f"executed on {run.controller}; sensors and encoders are simulated",
        f"reached of the limits: {peaks}",
        *run.exceeded,
        *([run.remark] if run.remark else []),
        excitation,
    ]


# 1e-8 mm and 1e-6 N: below every encoder and converter, and short to read
_DECIMALS: dict[Role | None, int] = {Role.FORCES: 6, Role.MOMENTS: 6, Role.STRUTS: 8, Role.DRIVES: 8, Role.JOINTS: 8}
CLOCK_DECIMALS, FINE = 9, 12  # decimals of the time, and of all other columns
PERCENT = 0.01


def read(paths: Path | str | Sequence[Path | str], case: Case) -> Recording:
    """The recording in a file, in several files of one run, or in a folder of `hexcite run`.

    >>> hx.read("empty", hx.load_case("hexapod")).forces.shape[1]
    6

    Args:
        paths: paths in any order.
        case: says which columns to expect and how the files write them.

    Raises:
        RecordingError: anything that prevents the use of the run, with line, column, value and remedy.
    """
    import pyarrow as pa

    from identification.recording.formats.reading import read_run  # plans simulate, and load no reader

    places = [Path(paths)] if isinstance(paths, Path | str) else [Path(path) for path in paths]
    main, *others = read_run(places, case)
    pa.default_memory_pool().release_unused()  # as much again as the recording, which it keeps for its next table
    record = record_of(places[0]) if len(places) == 1 else None
    values = {part.name: getattr(main, part.name) for part in fields(main)}
    return Recording(**values, others=tuple(others), case=case, paths=tuple(places), record=record)


def record_of(path: Path) -> RunRecord | None:
    """What recording.json in a folder says, or None; raises RecordingError, FileProblem where it is damaged."""
    try:
        path.stat()
    except (OSError, ValueError) as error:
        raise unreadable(path, error) from error
    file = path / "recording.json"
    if not (path.is_dir() and file.is_file()):
        return None
    record = read_json(file, "hexcite run")
    if record.pop(CONTENT, None) not in (None, content_of(record)):  # version 0.2 stated none
        raise FileProblem(
            place=file, problem=phrase("recording_changed", "was changed by hand"), remedy=AGAIN, code=Code.CHANGED
        )
    return _record(record, file) if record else None


def _record(entries: Mapping[str, Any], place: object) -> RunRecord:
    try:
        return RunRecord.of_json(entries)
    except HexciteError as error:
        raise FileProblem(
            place=place, problem=f"entry {error.place} {error.problem}", remedy=AGAIN, code=Code.DAMAGED
        ) from error


def write_recording(file: Path, recording: Recording, case: Case) -> None:
    """Writes one table in our column names as CSV; write into an atomic folder.

    Forces of rows that stand for nothing (`missing`) are written as nan, so that they are missing in the file as well.
    """
    import pyarrow as pa
    import pyarrow.csv as pacsv

    table = {} if recording.t is None else {CLOCK: np.round(recording.t, CLOCK_DECIMALS)}
    forces = np.where(recording.bad[:, None], np.nan, recording.forces)
    groups = (
        (case.drive_columns, recording.drives),
        (ROTATION, recording.rotations),
        (case.sensor_frame.channels, forces),
        (ACCELEROMETER, recording.specific_forces),
        ((OVERRIDE,), None if recording.override is None else recording.override / PERCENT),
    )
    for names, values in groups:
        if values is not None:
            columns = (values.reshape(-1, len(names)) / own_units(names)).T
            for name, column in zip(names, columns, strict=True):
                table[name] = np.round(column, _DECIMALS.get(ROLE_OF.get(name), FINE))
    if recording.trigger is not None:
        table[TRIGGER] = recording.trigger.astype(np.int8)
    pacsv.write_csv(pa.table(table), file, pacsv.WriteOptions(quoting_style="none"))
