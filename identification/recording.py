"""Recorded runs: read from CSV with every damage explained, written whole or not at all.

Columns (CONVENTIONS): `t_s` (absent: each row is an averaged standstill), struts `l1_mm`..`l6_mm` or a rotation matrix
`r11`..`r33` (sensor to world), forces `f1_N`..`f6_N` or `fx_N`..`mz_Nm`, optionally `trigger` 0/1. The case maps other
names.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv as pacsv
from numpy.typing import NDArray

from cases.errors import RecordingError
from cases.schema import Case
from cases.units import MM

Array = NDArray[np.float64]

STRUTS = tuple(f"l{k}_mm" for k in range(1, 7))
ROTATION = tuple(f"r{i}{j}" for i in range(1, 4) for j in range(1, 4))
BAR_FORCES = tuple(f"f{k}_N" for k in range(1, 7))
WRENCH = ("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm")

# Rotation matrices are printed with a few digits; beyond this they are no rotations (transposed columns, wrong order).
ORTHOGONALITY = 1e-3
# Time stamps of equal steps are printed with rounding; beyond this share of a step the sampling is not uniform.
UNIFORMITY = 0.05


@dataclass(frozen=True, slots=True)
class Recording:
    """A run, one row a sample; arrays are None where the file has no such columns.

    Args:
        source: the file, for messages.
        t: time, shape (n,) [s]; None: every row is an averaged standstill.
        struts: strut lengths, shape (n, 6) [m].
        rotations: R, shape (n, 3, 3).
        forces: of the sensors, shape (n, 6) [N, or N and N m].
        trigger: shape (n,).
    """

    source: str
    t: Array | None
    struts: Array | None
    rotations: Array | None
    forces: Array
    trigger: NDArray[np.bool_] | None

    @property
    def step(self) -> float:
        """Time between samples [s]; raises RecordingError where there is no clock or it is not uniform."""
        if self.t is None:
            raise RecordingError(f"{self.source}: has no t_s column; its rows are standstills")
        steps = np.diff(self.t)
        step = float((self.t[-1] - self.t[0]) / (len(self.t) - 1))
        off = np.abs(steps - step) > UNIFORMITY * step
        if off.any():
            row = int(np.argmax(off))
            raise RecordingError(
                f"{self.source}, line {row + 3}, t_s: step of {steps[row] * 1e3:.4g} ms where the run has "
                f"{step * 1e3:.4g} ms; export the run without gaps at one rate"
            )
        return step


def force_columns(case: Case) -> tuple[str, ...]:
    """Names of the force columns of a case's sensor frame."""
    return BAR_FORCES if case.sensor_frame.bars is not None else WRENCH


def read_recording(path: Path, case: Case) -> Recording:
    """Reads a recording: a CSV file, or the folder that `hexcite run` wrote.

    Args:
        path: file or folder.
        case: says which columns to expect and what the file calls them.

    Raises:
        RecordingError: anything that keeps the run from being used, with line, column, value and remedy.
    """
    file = path / "recording.csv" if path.is_dir() else path
    names = case.recording.columns
    columns = _read_columns(file)

    def group(wanted: tuple[str, ...]) -> Array | None:
        found = [names.get(c, c) in columns for c in wanted]
        if not any(found):
            return None
        if not all(found):
            missing = names.get(wanted[found.index(False)], wanted[found.index(False)])
            raise RecordingError(
                f"{file}: column {missing} is missing; it has {', '.join(columns)}: add it or map its name in "
                "[recording.columns] of the case"
            )
        return np.column_stack([columns[names.get(c, c)] for c in wanted])

    forces = group(force_columns(case))
    if forces is None:
        raise _no_columns(file, "forces", force_columns(case), columns)
    struts, rotation = group(STRUTS), group(ROTATION)
    if struts is None and rotation is None:
        raise _no_columns(file, "pose", STRUTS if case.machine is not None else ROTATION, columns)
    time, trigger = group(("t_s",)), group(("trigger",))
    if time is not None:
        _require_increasing(file, time[:, 0], names.get("t_s", "t_s"))
    turn = None if rotation is None else rotation.reshape(-1, 3, 3)
    if turn is not None:
        _require_rotations(file, turn)
    return Recording(
        source=str(file),
        t=None if time is None else time[:, 0],
        struts=None if struts is None else struts * MM,
        rotations=turn,
        forces=forces,
        trigger=None if trigger is None else trigger[:, 0] > 0.5,
    )


def _no_columns(file: Path, what: str, wanted: tuple[str, ...], columns: dict[str, Array]) -> RecordingError:
    return RecordingError(
        f"{file}: no {what}: none of the columns {', '.join(wanted)}; it has {', '.join(columns)}: name them so or map "
        "them in [recording.columns] of the case"
    )


def _read_columns(file: Path) -> dict[str, Array]:
    """All numeric columns; columns of text are errors only where they are used, so they are left out here."""
    try:
        size = file.stat().st_size
    except OSError as error:
        raise RecordingError(f"{file}: cannot be read ({error.strerror}); give a recording's CSV or folder") from error
    if size == 0:
        raise RecordingError(f"{file}: is empty; record again")
    try:
        # As text first: only so can a bad value be named with its line.
        options = pacsv.ConvertOptions(null_values=[], strings_can_be_null=False)
        table = pacsv.read_csv(file, convert_options=options)
    except (pa.ArrowInvalid, OSError, UnicodeDecodeError) as error:
        raise RecordingError(f"{file}: is not a CSV table: {str(error).splitlines()[0]}; correct that line") from error
    if table.num_rows == 0:
        raise RecordingError(f"{file}: has a header but no rows; record again")
    repeated = {n for n in table.column_names if table.column_names.count(n) > 1}
    if repeated:
        raise RecordingError(f"{file}: column {min(repeated)} is there twice; rename or remove one")
    return {name: _numbers(file, name, table.column(name)) for name in table.column_names}


def _numbers(file: Path, name: str, column: pa.ChunkedArray) -> Array:
    if not (pa.types.is_floating(column.type) or pa.types.is_integer(column.type)):
        column = _from_text(file, name, column)
    values = np.asarray(column.cast(pa.float64()).to_numpy(), dtype=float)
    bad = ~np.isfinite(values)
    if bad.any():
        row = int(np.argmax(bad))
        raise RecordingError(f"{file}, line {row + 2}, {name}: {values[row]} is not a measured value; remove the row")
    return values


def _from_text(file: Path, name: str, column: pa.ChunkedArray) -> pa.ChunkedArray:
    text = pc.utf8_trim_whitespace(column.cast(pa.string()))
    for row, value in enumerate(text.to_pylist()):
        try:
            float(value)
        except (TypeError, ValueError):
            shown = "nothing" if not value else repr(value)
            raise RecordingError(
                f"{file}, line {row + 2}, {name}: {shown} is not a number; correct or remove the row"
            ) from None
    return text.cast(pa.float64())


def _require_increasing(file: Path, t: Array, name: str) -> None:
    back = np.diff(t) <= 0.0
    if back.any():
        row = int(np.argmax(back)) + 1
        raise RecordingError(
            f"{file}, line {row + 2}, {name}: {t[row]:.6f} s comes after {t[row - 1]:.6f} s; time must increase: "
            "sort the rows or remove the repeated part"
        )


def _require_rotations(file: Path, rotations: Array) -> None:
    error = np.abs(rotations @ rotations.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    error = np.maximum(error, np.abs(np.linalg.det(rotations) - 1.0))
    if error.max() > ORTHOGONALITY:
        row = int(np.argmax(error > ORTHOGONALITY))
        raise RecordingError(
            f"{file}, line {row + 2}, r11..r33: not a rotation matrix (off by {error[row]:.3g}, at most "
            f"{ORTHOGONALITY:g}); check order and sign of the columns"
        )


def write_recording(file: Path, recording: Recording, case: Case) -> None:
    """Writes a recording of struts as CSV, in our column names.

    Args:
        file: where; write into an atomic folder.
        recording: with time, struts and trigger.
        case: for the names of the forces.
    """
    assert recording.t is not None
    assert recording.struts is not None
    assert recording.trigger is not None
    table = {"t_s": np.round(recording.t, 9)}
    # 1e-8 mm and 1e-6 N: below every encoder and converter, and short to read
    table |= {n: np.round(recording.struts[:, k] / MM, 8) for k, n in enumerate(STRUTS)}
    table |= {n: np.round(recording.forces[:, k], 6) for k, n in enumerate(force_columns(case))}
    table["trigger"] = recording.trigger.astype(np.int8)
    pacsv.write_csv(pa.table(table), file, pacsv.WriteOptions(quoting_style="none"))
