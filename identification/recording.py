"""Recorded runs: read with every damage explained, written whole or not at all.

Columns (CONVENTIONS): `t_s` (absent: each row is an averaged standstill), struts `l1_mm`..`l6_mm` (of a chain its
joints `q1_deg`.. or `q1_mm`..; or drive positions `q1_mm`.., a pose `x_mm`..`c_deg`, a rotation matrix `r11`..`r33`
sensor to world), forces `f1_N`..`f6_N` or `fx_N`..`mz_Nm`, optionally an accelerometer `ax`..`az`, `trigger` 0/1,
`override_percent` of the feed, `temperature_degC` of the sensor. The case's `[recording]` maps file formats, other
names, units and clocks. A run may come as several files with their own clocks.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.basis import KEPT, Artefact, recording_basis
from cases.errors import RecordingError
from cases.files import RUN, atomic_folder, check_folder, json_text, read_json
from cases.recording_format import (
    ACCELEROMETER,
    BAR_FORCES,
    CLOCK,
    DRIVES,
    JOINT_ANGLES,
    JOINT_WAYS,
    OVERRIDE,
    ROTATION,
    STRUTS,
    TEMPERATURE,
    TRIGGER,
    WRENCH,
)
from cases.schema import Case
from cases.units import MM
from identification.formats.reading import files_of, read_run
from identification.formats.stream import Recording
from identification.formats.text import unreadable

__all__ = ["Recording", "about_case", "files_of", "load_recording", "read", "save_recording", "write_recording"]

SCHEMA_VERSION = 1
# 1e-8 mm and 1e-6 N: below every encoder and converter, and short to read
_DECIMALS = (
    {CLOCK: 9}
    | dict.fromkeys((*STRUTS, *DRIVES, *JOINT_ANGLES, *JOINT_WAYS), 8)
    | dict.fromkeys((*BAR_FORCES, *WRENCH), 6)
)
FINE = 12  # decimals of all else


def read(paths: Path | str | Sequence[Path | str], case: Case) -> Recording:
    """The recording in a file, in several files of one run, or in a folder of `hexcite run`.

    Args:
        paths: paths in any order.
        case: says which columns to expect and how the files write them.

    Raises:
        RecordingError: anything that keeps the run from being used, with line, column, value and remedy.
    """
    places = [Path(paths)] if isinstance(paths, Path | str) else [Path(path) for path in paths]
    recording = read_run(places, case)
    return replace(recording, record=record_of(places[0])) if len(places) == 1 else recording


def record_of(path: Path) -> Mapping[str, Any]:
    """What recording.json in a folder says of its run; nothing where `path` is no such folder.

    Raises:
        RecordingError: there is nothing at `path`.
        FileProblem: recording.json is damaged.
    """
    try:
        path.stat()
    except (OSError, ValueError) as error:
        raise unreadable(path, error) from error
    file = path / "recording.json"
    return read_json(file, "hexcite run") if path.is_dir() and file.is_file() else {}


def load_recording(folder: Path) -> Recording:
    """The recording of a folder, with the case that it names.

    Raises:
        RecordingError: it does not say which machine it is from, or cannot be used.
        FileProblem: its case has changed since.
    """
    record = record_of(folder)
    if not record:
        raise RecordingError(folder, "does not say which machine it is from", "read it with its case")
    artefact = Artefact(folder / "recording.json", record, "run the program again")
    case = artefact.case()
    artefact.require_unchanged(recording_basis(case), case, stale=False)
    return read(folder, case)


def about_case(case: Case) -> dict[str, Any]:
    """What `recording.json` says of the case."""
    return {
        "schema_version": SCHEMA_VERSION,
        "case": case.name,
        "case_file": case.origin,
        "case_hash": case.hash,
        KEPT: recording_basis(case),
    }


def save_recording(recording: Recording, folder: Path, overwrite: bool = False) -> None:
    """Makes a folder with recording.csv and recording.json.

    Raises:
        RecordingError: the run has several clocks, or its case is not known.
        FileProblem: the folder is somebody's, or cannot be written.
    """
    if recording.case is None:
        raise RecordingError(recording.source, "does not say which case it is of", "read it with its case")
    if recording.others:
        raise RecordingError(recording.source, "has several clocks, and one table has one", "keep its files")
    check_folder(folder, RUN, recording.paths, overwrite)
    record = recording.record or about_case(recording.case) | {"source": recording.source}
    with atomic_folder(folder, RUN, overwrite) as part:
        write_recording(part / "recording.csv", recording, recording.case)
        (part / "recording.json").write_text(json_text(dict(record)), encoding="utf-8")


def write_recording(file: Path, recording: Recording, case: Case) -> None:
    """Writes one table in our column names: as Parquet where the file's name says so, else as CSV.

    Args:
        file: file to write; write into an atomic folder.
    """
    import pyarrow as pa
    import pyarrow.csv as pacsv

    table = {name: np.round(values, _DECIMALS.get(name, FINE)) for name, values in _columns(recording, case).items()}
    if recording.trigger is not None:
        table[TRIGGER] = recording.trigger.astype(np.int8)
    if file.suffix == ".parquet":
        import pyarrow.parquet as pq

        pq.write_table(pa.table(table), file)
    else:
        pacsv.write_csv(pa.table(table), file, pacsv.WriteOptions(quoting_style="none"))


def _columns(recording: Recording, case: Case) -> dict[str, NDArray[np.float64]]:
    """Numbers by the names of their columns, in the units that the names say."""
    table = {} if recording.t is None else {CLOCK: recording.t}
    groups = (
        (case.drive_columns, recording.struts, MM if case.chain is None else case.chain.units),
        (ROTATION, None if recording.rotations is None else recording.rotations.reshape(-1, 9), 1.0),
        (case.sensor_frame.channels, recording.forces, 1.0),
        (ACCELEROMETER, recording.specific_forces, 1.0),
        ((TEMPERATURE,), None if recording.temperature is None else recording.temperature[:, None], 1.0),
        ((OVERRIDE,), None if recording.override is None else recording.override[:, None], 0.01),
    )
    for names, values, unit in groups:
        if values is not None:
            table |= dict(zip(names, (values / unit).T, strict=True))
    return table
