"""Recorded runs: read with every damage explained, written whole or not at all.

Columns (CONVENTIONS): `t_s` (absent: each row is an averaged standstill), struts `l1_mm`..`l6_mm` (or drive positions
`q1_mm`.., a pose `x_mm`..`c_deg`, a rotation matrix `r11`..`r33` sensor to world), forces `f1_N`..`f6_N` or
`fx_N`..`mz_Nm`, optionally strut velocities `ld1_mm_s`.., an accelerometer `ax`..`az`, `trigger` 0/1,
`override_percent` of the feed. The case's
`[recording]` maps file formats, other names, units and clocks. A run may come as several files with their own clocks.
"""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv

from cases.recording_columns import STRUTS
from cases.schema import Case
from cases.units import MM
from identification.formats.assembly import force_columns
from identification.formats.reading import files_of, read_recording, read_run
from identification.formats.stream import Recording

__all__ = ["Recording", "files_of", "force_columns", "read_recording", "read_run", "write_recording"]


def write_recording(file: Path, recording: Recording, case: Case) -> None:
    """Writes a recording of struts in our column names: as Parquet where the file's name says so, else as CSV.

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
    if file.suffix == ".parquet":
        import pyarrow.parquet as pq

        pq.write_table(pa.table(table), file)
    else:
        pacsv.write_csv(pa.table(table), file, pacsv.WriteOptions(quoting_style="none"))
