"""Damage and contacts of runs that are evaluated in blocks: named with their rows, left out or refused."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cases.errors import HexciteError
from identification.findings import contact_free
from identification.formats import parquet
from identification.frame import structure_matrix
from identification.identify import identify
from identification.long.streaming import identify_long
from identification.recording import Recording, read_recording
from identification.result import Estimate
from tests.helpers import one_line
from tests.identification.long.long_runs import CASE, RUN, assert_same, written


def test_damage_is_named_with_its_rows_and_left_out(tmp_path: Path) -> None:
    forces = RUN.forces.copy()
    forces[1500, 2] = 3000.0
    estimate = identify_long(written(tmp_path, replace(RUN, forces=forces)), CASE).estimate
    assert any("row 1501: channel 3 jumps" in w for w in estimate.warnings)
    clean = identify_long(written(tmp_path), CASE).estimate
    assert np.abs((estimate.values - clean.values) / np.sqrt(np.diag(clean.covariance))).max() < 1.0


def strays(recording: Recording) -> Recording:
    t = recording.t.copy()
    t[2100] += 0.0003
    return replace(recording, t=t)


def jammed(recording: Recording) -> Recording:
    struts = recording.struts.copy()
    struts[2500:] = [0.3, 1.5, 0.3, 1.5, 0.3, 1.5]
    return replace(recording, struts=struts)


@pytest.mark.parametrize(
    ("recording", "says"),
    [
        (strays(RUN), r"row 2101, t_s: step of 1.3 ms"),
        (jammed(RUN), r"row 2[45]\d\d: no pose has the strut lengths"),
        (replace(RUN, trigger=np.zeros(len(RUN.t), dtype=bool)), "trigger: is never 1|independent|record"),
    ],
    ids=["stamp", "struts", "trigger"],
)
def test_what_stops_a_run_is_named_with_its_row(recording: Recording, says: str, tmp_path: Path) -> None:
    with pytest.raises(HexciteError, match=says) as caught:
        identify_long(written(tmp_path, recording), CASE)
    assert "run.parquet" in one_line(caught.value)


def test_a_long_silence_of_a_sensor_is_left_out_with_the_length_of_the_filter(tmp_path: Path) -> None:
    forces = RUN.forces.copy()
    forces[1200:1230, 4] = 5000.0  # at the end of its range
    file = written(tmp_path, replace(RUN, forces=forces))
    assert_same(identify_long(file, CASE).estimate, identify(read_recording(file, CASE), CASE))


def pushed(starts: Sequence[float], duration: float = 0.2) -> Recording:
    """The run with 20 N on the platform, which sensors read by J^T (1)."""
    extra = np.linalg.solve(structure_matrix(CASE.sensor_frame), [12.0, 0.0, 16.0, 0.0, 0.0, 0.0])
    on = np.any([(RUN.t >= s) & (RUN.t < s + duration) for s in starts], axis=0)
    return replace(RUN, forces=RUN.forces - on[:, None] * extra)


def told(estimate: Estimate) -> list[tuple[float, ...]]:
    """First line, last line, begin, end and force of each contact that is told."""
    pattern = r"(\d+) to (\d+): external contact from ([\d.]+) to ([\d.]+) s, up to ([\d.]+) N"
    return [tuple(map(float, m.groups())) for w in estimate.warnings if (m := re.search(pattern, w))]


@pytest.mark.parametrize("batch", [1100, 1500])
def test_contacts_are_found_as_in_a_whole_run_also_across_blocks(
    batch: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parquet, "_BATCH", batch)
    starts = (1.0, 2.9)  # blocks of 1100 rows end in the first, of 1500 in the second
    file = written(tmp_path, pushed(starts))
    long, whole = identify_long(file, CASE).estimate, identify(read_recording(file, CASE), CASE)
    found = told(long)
    assert len(found) == len(starts)
    for start, (first, last, begin, end, newtons) in zip(starts, found, strict=True):
        assert abs(begin - start) < 0.05
        assert abs(end - start - 0.2) < 0.05
        assert abs(first - 1 - 1e3 * begin) < 2
        assert abs(last - 1 - 1e3 * end) < 2
        assert 17.0 < newtons < 25.0
    assert np.abs((long.values - whole.values) / np.sqrt(np.diag(whole.covariance))).max() < 0.5


def test_nothing_is_found_where_nothing_touches(tmp_path: Path) -> None:
    for seed in range(4):
        run = replace(RUN, forces=RUN.forces + np.random.default_rng(seed).normal(size=RUN.forces.shape))
        assert identify_long(written(tmp_path, run), CASE).estimate.warnings == ()


def test_a_run_in_contact_for_too_long_is_refused_with_the_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(contact_free, "MOST_TOUCHED", 0.05)
    with pytest.raises(HexciteError, match=r"in contact \(rows \d+ to \d+: external contact from [01]\.") as caught:
        identify_long(written(tmp_path, pushed((1.0,))), CASE)
    one_line(caught.value)
