"""An hour at 1 kHz through `hexcite identify`, as CSV and as Parquet: processor and wall time, memory."""

import json
import os
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow.csv as pacsv
import pyarrow.parquet as pq

from cases.schema import load_case
from identification.machines.hexapod import Hexapod
from identification.recording.recording import Recording, write_recording
from identification.simulate import simulate_recording
from tests.helpers import Harmonic
from tests.simulated_machine import PoseExecution

HEXCITE = Path(sys.executable).parent / "hexcite"
ROWS, PERIOD, NOISY = 3_600_000, 3000, 60_000


class Use(NamedTuple):
    """What one command took: wall time, time of all processors [s], largest resident memory [byte]; its answer.

    `load` is the machine's mean load of that minute, this command's own included: beyond the number of cores others
    had their share of the wall time.
    """

    wall: float
    processors: float
    memory: float
    load: float
    answer: str


def used(folder: Path, *words: str) -> Use:
    """Runs hexcite and waits for this one process, so that its memory is not that of commands before it.

    Raises:
        RuntimeError: the command failed.
    """
    began = time.perf_counter()
    with (folder / "answer.json").open("wb") as out:
        process = subprocess.Popen([str(HEXCITE), *words], stdout=out)
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"hexcite {' '.join(words)}: exit code {process.returncode}")
    wall = time.perf_counter() - began
    return Use(
        wall,
        usage.ru_utime + usage.ru_stime,
        1024.0 * usage.ru_maxrss,
        os.getloadavg()[0],
        (folder / "answer.json").read_text(),
    )


def long_recording(rows: int) -> Recording:
    """Three seconds of motion again and again, with a minute of noise: a long run of the simulated machine."""
    case = load_case("hexapod")
    silent = case.need_simulation("a long run").model_copy(update={"force_noise_N": 0.0})
    case = case.model_copy(update={"simulation": silent})  # noise that came back each period would not average out
    execution = PoseExecution(Hexapod.of(case), Harmonic(seed=1, duration=PERIOD / 1000))
    period = simulate_recording(case, execution, np.array([[-1.0, 9.0]]), 0)
    assert period.drives is not None
    noise = np.random.default_rng(1).normal(size=(NOISY, 6))
    forces = np.tile(period.forces[:PERIOD], (NOISY // PERIOD, 1)) + noise
    return Recording(
        "hour", np.arange(rows) * 1e-3, np.tile(period.drives[:PERIOD], (rows // PERIOD, 1)), None,
        np.tile(forces, (rows // NOISY, 1)), np.ones(rows, dtype=bool),
    )  # fmt: skip


def write_long(file: Path, rows: int) -> None:
    """Writes such a recording as CSV or, by the file's ending, as Parquet."""
    table = file.with_suffix(".csv")
    write_recording(table, long_recording(rows), load_case("hexapod"))
    if file != table:
        pq.write_table(pacsv.read_csv(table), file)
        table.unlink()


def hour_figures(folder: Path) -> list[list[str]]:
    """Rows of the table of figures; the files are deleted as soon as they are measured."""
    rows = []
    for suffix, limit in (("csv", "25 s"), ("parquet", "10 s")):
        file = folder / f"hour.{suffix}"
        # By a process of its own: Linux counts what a process had in memory as used by those that it starts.
        with ProcessPoolExecutor(1, get_context("spawn")) as pool:
            pool.submit(write_long, file, ROWS).result()
        size = file.stat().st_size
        hour = used(folder, "identify", str(file), "--case", "hexapod", "-o", str(folder / suffix), "--json")
        file.unlink()
        mass = json.loads(hour.answer)["parameters"]["m"]
        rows += [
            [
                f"identification of {ROWS} rows, {size / 1e6:.0f} MB of {suffix} to result: wall time",
                f"{hour.wall:.0f} s on {os.cpu_count()} cores, load {hour.load:.1f}",
                limit,
            ],
            ["  the same: time of all processors", f"{hour.processors:.0f} s", ""],
            ["  its largest memory", f"{hour.memory / 1e9:.2f} GB", "2 GB"],
            ["  mass", f"{mass['value']:.4f} +- {max(mass['std'], mass['std_robust']):.4f} kg", ""],
        ]
    return rows
