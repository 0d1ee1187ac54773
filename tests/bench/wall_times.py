"""Wall times of identification: the whole command, and from Python with BLAS threads and other work beside it."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from cases.schema import load_case
from identification.machines.hexapod import Hexapod
from identification.recording.recording import write_recording
from identification.simulate import circumstances, simulate_recording
from tests.helpers import Harmonic
from tests.simulated_machine import PoseExecution

DURATION = 15.0  # [s] at 1 kHz
REPEATS = 5
FROM_PYTHON = f"""
import sys, time
from pathlib import Path
from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.recording.recording import read
case = load_case("hexapod")
recording = read(Path(sys.argv[1]), case)
times = []
for _ in range({REPEATS}):
    began = time.perf_counter()
    estimate_parameters(recording, case)
    times.append(time.perf_counter() - began)
print(max(times))
"""
BUSY = "while True: pass"


def wall_time_rows(folder: Path, command: Callable[..., tuple[float, str]]) -> list[list[str]]:
    """Rows of a run of 15 s whose errors come back with the pose, which takes the most factorisations.

    Args:
        folder: for the recording and the results.
        command: runs hexcite; returns wall time [s] and what it printed.
    """
    case = load_case("hexapod")
    execution = PoseExecution(Hexapod.of(case), Harmonic(seed=3, duration=DURATION))
    window = np.array([[0.3, DURATION - 0.3]])
    recording = simulate_recording(case, execution, window, 1, around=circumstances(case, 0, True))
    file = folder / "run.csv"
    write_recording(file, recording, case)
    words = ("identify", str(file), "--case", "hexapod", "--json", "-o")
    whole = [command(*words, str(folder / f"result-{k}"))[0] for k in range(REPEATS)]
    rows = [["hexcite identify, 15 s at 1 kHz, with its page", f"{min(whole):.1f} to {max(whole):.1f} s", "2.5 s"]]
    for threads in (1, 2):
        for load in (0, os.cpu_count() or 1):
            with _beside(load):
                slowest = _from_python(file, threads)
            where = f"beside {load} busy processes" if load else "alone"
            rows.append([f"  from Python, {threads} BLAS threads, {where}, slowest of {REPEATS}", f"{slowest:.2f} s",
                         "" if load else "1.2 s"])  # fmt: skip
    return rows


def _from_python(file: Path, threads: int) -> float:
    """Wall time of the slowest call [s]."""
    called = [sys.executable, "-c", FROM_PYTHON, str(file)]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": str(threads)}
    return float(subprocess.run(called, env=environment, capture_output=True, text=True, check=True).stdout)


@contextmanager
def _beside(load: int) -> Iterator[None]:
    """As many processes that only compute."""
    others = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(load)]
    try:
        yield
    finally:
        for other in others:
            other.kill()
            other.wait()
