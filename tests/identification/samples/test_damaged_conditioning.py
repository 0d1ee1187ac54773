"""Damaged files of runs that are to be conditioned: an answer or one line, whatever is asked."""

import random
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.recording.recording import Recording, read, write_recording
from identification.samples.clocks import on_one_clock
from identification.simulate import simulate_recording
from tests.bench.reliability.recordings import stained
from tests.helpers import Harmonic, answer, examples
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")


@cache
def text(folder: Path) -> str:
    execution = PoseExecution(Hexapod.of(CASE), Harmonic(duration=1.8))
    run = simulate_recording(CASE, execution, np.array([[0.4, 1.4]]), 0)
    write_recording(folder / "run.csv", run, CASE)
    return (folder / "run.csv").read_text()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("runs")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=examples(3))
@given(seed=st.integers(0, 2**32))
def test_a_damaged_run_ends_in_an_answer_or_in_one_line(seed: int, folder: Path) -> None:
    file = folder / "damaged.csv"
    file.write_bytes(stained(text(folder), random.Random(seed)))

    def evaluated() -> Recording:
        recording = on_one_clock(read(file, CASE), CASE)
        estimate_parameters(recording, CASE)
        return recording

    answer(evaluated, "damaged.csv")
