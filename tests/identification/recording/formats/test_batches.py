"""A long file is read whole, each row with its line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.base.errors import RecordingError
from identification.recording.formats import content, table
from identification.recording.recording import read
from tests.helpers import examples, refused_at
from tests.identification.recording.formats.runs import HEXAPOD, NAMES, Truth, csv, written

LONG = Truth(count=60_000)
TEXT = csv(LONG.numbers())


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("long"), TEXT)


def test_a_long_file_is_read_whole(file: Path) -> None:
    recording = read(file, HEXAPOD)
    np.testing.assert_allclose(recording.t, LONG.t, atol=1e-9)
    np.testing.assert_allclose(recording.drives, LONG.struts, rtol=1e-8)


@pytest.mark.parametrize("row", [0, 1, 44_000, 59_999])
def test_a_bad_value_is_marked_in_its_line(row: int, tmp_path: Path) -> None:
    lines = TEXT.splitlines()
    lines[row + 1] = lines[row + 1].rsplit(",", 1)[0] + ",nan"
    recording = read(written(tmp_path, "\n".join(lines)), HEXAPOD)
    assert np.flatnonzero(recording.missing).tolist() == [row]
    assert recording.missing_in == ("f6_N",)
    assert recording.lines.place(row) == f"line {row + 2}"


@pytest.mark.parametrize("row", [1, 44_000, 59_999])
def test_a_damage_is_named_with_its_line(row: int, tmp_path: Path) -> None:
    lines = TEXT.splitlines()
    lines[row + 1] = lines[row + 1].rsplit(",", 1)[0] + ",x"
    with pytest.raises(RecordingError, match=rf"line {row + 2}, f6_N: 'x' is not a number"):
        read(written(tmp_path, "\n".join(lines)), HEXAPOD)


def test_time_runs_forwards(tmp_path: Path) -> None:
    rows = 44_000
    lines = TEXT.splitlines()
    lines[rows + 1] = "0," + lines[rows + 1].split(",", 1)[1]
    with pytest.raises(RecordingError, match=rf"line {rows + 2}, t_s: 0\.0 is not later .*time must"):
        read(written(tmp_path, "\n".join(lines)), HEXAPOD)


def test_a_file_that_takes_more_than_half_of_the_free_memory_is_refused_with_its_size(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(table, "free_memory", lambda: 2 * table.BYTES * 100_000)
    with refused_at(file, r"780,000 numbers .*free memory.* 7,692 rows .*13 columns"):
        read(file, HEXAPOD)


def test_two_gigabytes_of_nothing_are_refused_at_once(tmp_path: Path) -> None:
    file = written(tmp_path, ",".join(NAMES) + "\n")
    with file.open("r+b") as stream:
        stream.truncate(2_000_000_000)  # sparse: takes no room
    with pytest.raises(RecordingError, match=r"line 2: .*longer than.*million"):
        read(file, HEXAPOD)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=examples(100))
@given(
    lengths=st.lists(st.integers(0, 40), max_size=60),
    above=st.integers(0, 5),
    below=st.integers(0, 3),
    newline=st.booleans(),
)
def test_lines_are_those_between_header_and_trailing_rows(
    lengths: list[int], above: int, below: int, newline: bool, tmp_path: Path
) -> None:
    lines = [str(k).encode() * n for k, n in enumerate(lengths)]
    file = written(tmp_path, b"\n".join(lines) + b"\n" * newline or b"\n")
    text = content.Content(file)
    section = content.section_of(text, above, below)
    data = content.lines_of(text, section)
    assert section.rows == len(data.splitlines())
    assert b"".join(part for _, part in content.blocks_of(text, section, size=7)) == data
    found = {k: line for k, line in enumerate(data.split(b"\n"), section.first) if line}
    filled = [k for k, line in enumerate(lines) if line and k >= above]
    assert found == {k + 1: lines[k] for k in filled[: max(len(filled) - below, 0)]}
