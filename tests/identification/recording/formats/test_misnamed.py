"""Names in another order than the columns: their values tell, before anything is made of them."""

from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import RecordingError
from cases.schema import Case
from identification.machines.hexapod import Hexapod
from identification.recording.formats.reading import read_run
from tests.identification.recording.formats.runs import case_with

STRUTS = [f"l{k}_mm" for k in range(1, 7)]
FORCES = [f"f{k}_N" for k in range(1, 7)]
RIGHT = ["t_s", *STRUTS, *FORCES, "trigger"]


@pytest.fixture(scope="module")
def headless(tmp_path_factory: pytest.TempPathFactory, hexapod_case: Case) -> Path:
    """A motion of 2 s at 250 Hz in a file without names: time, struts, forces with noise, switch."""
    t = np.arange(500) / 250.0
    poses = np.tile(hexapod_case.hexapod.home.vector, (len(t), 1))
    poses[:, 0] += 0.02 * np.sin(3.0 * t)
    poses[:, 2] += 0.02 * np.sin(4.0 * t)
    lengths = 1e3 * Hexapod.of(hexapod_case).strut_lengths(poses)
    forces = 60.0 + 20.0 * np.sin(3.0 * t)[:, None] + np.random.default_rng(1).normal(size=(len(t), 6))
    file = tmp_path_factory.mktemp("headless") / "run.csv"
    np.savetxt(file, np.column_stack([t, lengths, forces, t > 0.5]), delimiter=",", fmt="%.6f")
    return file


def read(file: Path, case: Case, names: list[str]) -> None:
    read_run([file], case_with(case, column_names=names))


def test_the_right_order_is_read(headless: Path, hexapod_case: Case) -> None:
    read(headless, hexapod_case, RIGHT)


@pytest.mark.parametrize(
    ("names", "column", "said"),
    [
        (["t_s", *FORCES, *STRUTS, "trigger"], "l1_mm", "f1_N"),
        (["t_s", *STRUTS[:5], "f1_N", "l6_mm", *FORCES[1:], "trigger"], "l6_mm", "f1_N"),
        ([*RIGHT[1:], "t_s"], "t_s", "l1_mm"),
        (["trigger", *RIGHT[1:-1], "t_s"], "t_s", "trigger"),
        (["row", *RIGHT[:-1]], "t_s", "clock"),
    ],
    ids=["forces first", "two exchanged", "shifted by one", "clock and switch", "one too many"],
)
def test_another_order_is_named_with_the_column_that_fits(
    headless: Path, hexapod_case: Case, names: list[str], column: str, said: str
) -> None:
    with pytest.raises(RecordingError) as refused:
        read(headless, hexapod_case, names)
    assert refused.value.place.endswith(f"line 1, {column}")
    assert said in refused.value.problem
    assert "recording.column_names" in refused.value.remedy
