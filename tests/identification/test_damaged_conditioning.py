"""Damaged files of runs that are to be conditioned: an answer or one line, whatever is asked."""

import random
from functools import cache
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.recording import Recording, read, write_recording
from identification.runs.preparation import on_one_clock
from identification.samples import Conditioning
from tests.bench.reliability.recordings import stained
from tests.helpers import answer
from tests.identification.repeating import Repeating, recorded

CASE = load_case("hexapod")
RUN = Repeating(0.5, 2.0)
PERIODIC = [Conditioning(True), Conditioning(True, 0.5), Conditioning(True, 0.5, 6)]
ASKED = [*PERIODIC, Conditioning(flexible=True)]


@cache
def text(folder: Path) -> str:
    write_recording(folder / "run.csv", recorded(CASE, RUN), CASE)
    return (folder / "run.csv").read_text()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("runs")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=12)
@given(seed=st.integers(0, 2**32), asked=st.sampled_from(ASKED))
def test_a_damaged_run_ends_in_an_answer_or_in_one_line(seed: int, asked: Conditioning, folder: Path) -> None:
    file = folder / "damaged.csv"
    file.write_bytes(stained(text(folder), random.Random(seed)))

    def evaluated() -> Recording:
        recording = on_one_clock(read(file, CASE), CASE)
        estimate_parameters(recording, CASE, conditioning=asked)
        return recording

    answer(evaluated, "damaged.csv")
