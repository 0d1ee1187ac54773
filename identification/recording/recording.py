"""Recorded runs in SI units: read from files of any format with every damage explained, written whole.

Columns (CONVENTIONS): `t_s` (absent: each row is an averaged standstill), struts `l1_mm`..`l6_mm` (of a chain its
joints `q1_deg`.. or `q1_mm`..; or drive positions `q1_mm`.., a pose `x_mm`..`c_deg`, a rotation matrix `r11`..`r33`
sensor to world), forces `f1_N`..`f6_N` or `fx_N`..`mz_Nm`, optionally an accelerometer `ax`..`az`, `trigger` 0/1,
`override_percent` of the feed. The case's `[recording]` maps file formats, other names, units and clocks. A run may
come as several files with their own clocks.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from cases.base.doors import checks
from cases.base.errors import FileProblem, RecordingError
from cases.base.files import RUN, atomic_folder, check_folder, json_text, read_json
from cases.base.units import Array, Indices, as_html
from cases.basis import CONTENT, KEPT, case_of, content_of, recording_basis, require_unchanged
from cases.orientation import ROTATION
from cases.recording_format import ACCELEROMETER, CLOCK, OVERRIDE, ROLE_OF, TRIGGER, Role
from cases.schema import Case
from cases.tables import own_units
from identification.recording.formats.clocks import lost_samples
from identification.recording.formats.table import Channel, Stream, told, unreadable
from identification.texts import efficiency_text, share_text


@dataclass(frozen=True, slots=True, repr=False)
class Recording(Stream):
    """A run: the samples of the forces, with all channels of their clock, and streams of other clocks."""

    forces: Array  # forces of the sensors, shape (n, 6) [N, or N and N m]
    others: tuple[Stream, ...] = ()  # what was sampled by other clocks, on the same time axis
    # weights of averaged standstills: what forces and model of each are multiplied by in a fit, shape (n,)
    weights: Array | None = None
    averaged: float = 1.0  # samples of the forces that were averaged over an interval of the motion
    case: Case | None = None  # case that it is from; None where that is not known
    paths: tuple[Path, ...] = ()  # paths of the files that it was read from
    record: Mapping[str, Any] = field(default_factory=dict)  # what `recording.json` says; empty where there is none
    remarks: tuple[str, ...] = ()  # what has changed in the case since, where it is evaluated nevertheless

    def __post_init__(self) -> None:
        """Checks what is given, as of a stream; RecordingError names what is wrong."""
        if self.forces is None:
            raise RecordingError("Recording: forces", "is None", "give numbers of shape (n, 6), one row a sample")
        object.__setattr__(self, "paths", _paths(self.paths))
        for name, right, remedy in (
            ("case", isinstance(self.case, Case | None), "hx.load_case loads one"),
            ("record", isinstance(self.record, Mapping), "leave it out"),
            ("averaged", isinstance(self.averaged, Real) and float(self.averaged) >= 1.0, "give 1 or more samples"),
        ):
            if not right:
                raise RecordingError(f"Recording: {name}", f"is {told(getattr(self, name))}", remedy)
        others = tuple(self.others) if isinstance(self.others, list | tuple) else (self.others,)
        if odd := [told(other) for other in others if not isinstance(other, Stream)]:
            raise RecordingError("Recording: others", f"holds {odd[0]}", "give streams of other clocks")
        object.__setattr__(self, "others", others)
        Stream.__post_init__(self)

    def save(self, folder: Path | str, overwrite: bool = False) -> None:
        """Makes a folder with recording.csv and recording.json.

        Raises:
            RecordingError: the run has several clocks, or its case is not known.
            FileProblem: the folder holds something else, or cannot be written.
        """
        if self.case is None:
            raise RecordingError(self.source, "does not say which case it is of", "read it with its case")
        if self.others:
            raise RecordingError(self.source, "has several clocks, and one table has one", "keep its files")
        place = Path(folder)
        check_folder(place, RUN, self.paths, overwrite)
        record = dict(self.record) or about_case(self.case) | {"source": self.source}
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
        if not record:
            raise RecordingError(
                place, "does not say which machine it is from", "name it with --case, or a folder of hexcite run"
            )
        file = place / "recording.json"
        own = case_of(file, record, AGAIN)
        remarks = require_unchanged(file, record, recording_basis(own), own, stale, AGAIN)
        return replace(read(paths, own), remarks=remarks)

    def __repr__(self) -> str:
        """A few lines: where it is from, how long, which channels."""
        size = f"{len(self.forces)} samples"
        if self.t is not None and len(self.t) > 1:
            size += f" in {float(self.t[-1] - self.t[0]):.2f} s"
        lines = [f"Recording {self.source}: {size}", f"channels: {', '.join(self.channels)}"]
        lines += [f"with another clock: {', '.join(s.channels)} ({s.source})" for s in self.others]
        return "\n".join(lines + (_of_run(self.record) if "executed_s" in self.record else []))

    _repr_html_ = as_html

    @property
    def lost(self) -> Indices:
        """How many samples were lost between each row and the next, shape (n - 1,)."""
        return lost_samples(self.t)

    def stream_with(self, channel: Channel) -> Stream | None:
        """The stream that has a channel; None where the run has no such channel."""
        return next((s for s in (self, *self.others) if channel in s.channels), None)


def _paths(paths: object) -> tuple[Path, ...]:
    """Paths of files; raises RecordingError where they are none."""
    given = paths if isinstance(paths, list | tuple) else (paths,)
    if not all(isinstance(path, str | PathLike) for path in given):
        raise RecordingError("Recording: paths", f"is {told(paths)}", "give the paths of its files, or none")
    return tuple(Path(path) for path in given)


def _of_run(record: Mapping[str, Any]) -> list[str]:
    """What a controller made of a program, from `recording.json`."""
    peaks = ", ".join(f"{name} {share_text(share, 0)}" for name, share in record["peaks_of_limit"].items())
    excitation = f"excitation took {record['executed_s']:.3f} s of {record['planned_s']:.3f} s planned, strayed "
    excitation += f"{record['path_error_mm']:.3f} mm from the path"
    if record["d_efficiency"] is not None:
        excitation += f", D-efficiency {efficiency_text(record['d_efficiency'])} as executed"
    return [
        f"executed on {record['controller']}; sensors and encoders are simulated",
        f"reached of the limits: {peaks}",
        *record["exceeded"],
        *([record["remark"]] if record["remark"] else []),
        excitation,
    ]


SCHEMA_VERSION = 1
AGAIN = "run the program again"
# 1e-8 mm and 1e-6 N: below every encoder and converter, and short to read
_DECIMALS: dict[Role | None, int] = {Role.FORCES: 6, Role.MOMENTS: 6, Role.STRUTS: 8, Role.DRIVES: 8, Role.JOINTS: 8}
CLOCK_DECIMALS, FINE = 9, 12  # decimals of the time, and of all other columns
PERCENT = 0.01


def read(paths: Path | str | Sequence[Path | str], case: Case) -> Recording:
    """The recording in a file, in several files of one run, or in a folder of `hexcite run`.

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
    record = record_of(places[0]) if len(places) == 1 else {}
    own = {part.name: getattr(main, part.name) for part in fields(main)}
    return Recording(**own, others=tuple(others), case=case, paths=tuple(places), record=record)


def record_of(path: Path) -> Mapping[str, Any]:
    """Entries of recording.json in a folder, or none; raises RecordingError, FileProblem where it is damaged."""
    try:
        path.stat()
    except (OSError, ValueError) as error:
        raise unreadable(path, error) from error
    file = path / "recording.json"
    if not (path.is_dir() and file.is_file()):
        return {}
    record = read_json(file, "hexcite run")
    if record.pop(CONTENT, None) not in (None, content_of(record)):  # version 0.2 stated none
        raise FileProblem(file, "was changed by hand", AGAIN)
    for key, kind in _KINDS.items():
        if not kind(record[key]) if key in record else "executed_s" in record:
            raise FileProblem(file, f"entry {key} is missing or damaged", AGAIN)
    return record


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


_KINDS: Mapping[str, Callable[[Any], bool]] = {
    **dict.fromkeys(("executed_s", "planned_s", "path_error_mm"), _is_number),
    "d_efficiency": lambda value: value is None or _is_number(value),
    **dict.fromkeys(("controller", "remark"), lambda value: isinstance(value, str)),
    "peaks_of_limit": lambda value: isinstance(value, dict) and all(map(_is_number, value.values())),
    "exceeded": lambda value: isinstance(value, list) and all(isinstance(line, str) for line in value),
}
"""Of what kind the entries of recording.json are that are shown; where one of them is there, all are."""


def poses_of_record(record: Mapping[str, Any], coordinates: int) -> Array | None:
    """Poses that a program measured, shape (n, coordinates); None where it measured none. Raises FileProblem."""
    if not (entry := record.get("poses_m_rad")):
        return None
    with suppress(TypeError, ValueError):
        poses = np.array(entry, dtype=float)
        if poses.shape[1:] == (coordinates,) and np.isfinite(poses).all():
            return poses
    raise FileProblem("recording.json: poses_m_rad", f"are not poses of {coordinates} numbers", AGAIN)


def about_case(case: Case) -> dict[str, Any]:
    """What `recording.json` says of the case."""
    return {
        "schema_version": SCHEMA_VERSION,
        "case": case.name,
        "case_file": case.origin,
        "case_hash": case.hash,
        KEPT: recording_basis(case),
    }


def write_recording(file: Path, recording: Recording, case: Case) -> None:
    """Writes one table in our column names as CSV; write into an atomic folder."""
    import pyarrow as pa
    import pyarrow.csv as pacsv

    table = {} if recording.t is None else {CLOCK: np.round(recording.t, CLOCK_DECIMALS)}
    groups = (
        (case.drive_columns, recording.struts),
        (ROTATION, recording.rotations),
        (case.sensor_frame.channels, recording.forces),
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
