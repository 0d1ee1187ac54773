"""Struts that are held over several rows of a run that is evaluated in blocks."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from cases.errors import HexciteError
from identification.formats import parquet
from identification.identify import identify
from identification.long.streaming import identify_long
from identification.recording import Recording, read_recording
from identification.runs.rates import on_one_clock
from tests.helpers import one_line
from tests.identification.long.long_runs import CASE, RUN, written


def held(ratio: int, dropped: int = 2) -> Recording:
    """The run with struts that come every `ratio` rows and are held until then; the file begins within a sample."""
    rows = np.arange(len(RUN.forces)) // ratio * ratio
    assert RUN.struts is not None
    assert RUN.t is not None
    assert RUN.trigger is not None
    later = slice(dropped, None)
    return replace(
        RUN, t=RUN.t[later] - RUN.t[dropped], struts=RUN.struts[rows][later], forces=RUN.forces[later],
        trigger=RUN.trigger[later],
    )  # fmt: skip


@pytest.mark.parametrize(("batch", "trigger"), [(97, True), (700, True), (700, False), (100_000, True)])
def test_struts_that_are_held_are_taken_when_they_are_new_as_in_a_whole_run(
    batch: int, trigger: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parquet, "_BATCH", batch)
    file = written(tmp_path, held(4))
    if not trigger:
        pq.write_table(pq.read_table(file).drop_columns(["trigger"]), file)
    whole = identify(on_one_clock(read_recording(file, CASE), CASE), CASE)
    long = identify_long(file, CASE).estimate
    assert np.linalg.norm(long.values - whole.values) < 1e-9 * np.linalg.norm(whole.values)
    assert long.samples == whole.samples
    assert long.told["averaged"]["ratio"] == pytest.approx(4.0)
    assert long.told["averaged"].keys() == whole.told["averaged"].keys()
    assert any("4 samples averaged" in note for note in long.notes)


def test_rows_of_held_struts_are_named_as_they_stand_in_the_file(tmp_path: Path) -> None:
    recording = held(4)
    forces = recording.forces.copy()
    forces[1500:1560, 4] = 5000.0  # at the end of its range
    estimate = identify_long(written(tmp_path, replace(recording, forces=forces)), CASE).estimate
    (warning,) = [w for w in estimate.warnings if "end of its range" in w]
    first, last = map(int, re.findall(r"rows (\d+) to (\d+):", warning)[0])
    assert abs(first - 1501) <= 4
    assert abs(last - 1560) <= 4


def test_struts_that_lose_their_rhythm_are_refused_with_the_row(tmp_path: Path) -> None:
    recording = held(4)
    rows = np.arange(len(recording.forces))
    rows[2500:] = 2500 + (rows[2500:] - 2500) // 4 * 4 + 2
    assert recording.struts is not None
    struts = recording.struts[np.minimum(rows, len(rows) - 1)]
    with pytest.raises(HexciteError, match=r"row 2\d\d\d: the struts were held for 4 rows each, from here") as caught:
        identify_long(written(tmp_path, replace(recording, struts=struts)), CASE)
    one_line(caught.value)
