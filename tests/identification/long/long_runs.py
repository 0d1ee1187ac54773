"""A run as a file that is evaluated in blocks, and what it must agree with."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from cases.loading import load_case
from identification.hexapod import Hexapod
from identification.model import identification_model
from identification.recording import Recording, write_recording
from identification.result import Estimate
from identification.simulate import simulate_recording
from tests.helpers import Harmonic
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
RUN = simulate_recording(
    CASE, PoseExecution(Hexapod.of(CASE), Harmonic(seed=1, duration=4.0)), np.array([[0.2, 1.7], [2.0, 3.8]]), 0
)


def written(folder: Path, recording: Recording = RUN) -> Path:
    file = folder / "run.parquet"
    write_recording(file, recording, CASE)
    return file


def with_columns(file: Path, columns: dict[str, np.ndarray], without: str) -> None:
    """Writes a file anew with other columns in the place of some."""
    table = pq.read_table(file)
    table = table.drop_columns([n for n in table.column_names if n.startswith(without)])
    for name, values in columns.items():
        table = table.append_column(name, pa.array(values))
    pq.write_table(table, file)


def assert_same(blocks: Estimate, whole: Estimate, share: float = 1e-4) -> None:
    """Within a small share of the standard deviations."""
    std = np.sqrt(np.diag(whole.covariance))
    assert np.abs((blocks.values - whole.values) / std).max() < share
    np.testing.assert_allclose(np.diag(blocks.covariance), np.diag(whole.covariance), rtol=1e-3)
    assert blocks.samples == whole.samples
