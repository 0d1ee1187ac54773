"""A file of any length is read in batches that together are the whole, each row with its line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.errors import RecordingError
from identification.formats import reading
from identification.formats.blocks import read_blocks
from identification.recording import read_batches, read_recording
from tests.helpers import one_line
from tests.identification.formats.runs import HEXAPOD, NAMES, Truth, csv, written

LONG = Truth(count=60_000)
TEXT = csv(LONG.numbers())


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("long"), TEXT)


def test_batches_are_the_run_on_one_time_axis(file: Path) -> None:
    batches = list(read_batches(file, HEXAPOD))
    assert len(batches) > 1
    np.testing.assert_allclose(np.concatenate([b.t for b in batches]), LONG.t, atol=1e-9)
    np.testing.assert_allclose(np.vstack([b.struts for b in batches]), LONG.struts, rtol=1e-8)
    whole = read_recording(file, HEXAPOD)
    np.testing.assert_array_equal(np.vstack([b.forces for b in batches]), whole.forces)


def test_batches_do_not_grow_with_the_file(file: Path, tmp_path: Path) -> None:
    longer = written(tmp_path, csv(Truth(count=120_000).numbers()))
    largest = [max(b.rows for b in read_batches(f, HEXAPOD)) for f in (file, longer)]
    assert largest[1] <= 1.1 * largest[0]


@pytest.mark.parametrize("row", [0, 1, 44_000, 59_999])
def test_a_bad_value_is_marked_in_its_line_in_any_batch(row: int, tmp_path: Path) -> None:
    lines = TEXT.splitlines()
    lines[row + 1] = lines[row + 1].rsplit(",", 1)[0] + ",nan"
    bad = written(tmp_path, "\n".join(lines))
    batches = list(read_batches(bad, HEXAPOD))
    marked = np.concatenate([np.zeros(b.rows, dtype=bool) if b.missing is None else b.missing for b in batches])
    assert np.flatnonzero(marked).tolist() == [row]
    (batch,) = [b for b in batches if b.missing is not None]
    assert batch.missing_in == ("f6_N",)
    assert batch.lines.place(int(np.argmax(batch.missing))) == f"line {row + 2}"


def test_time_runs_forwards_across_batches(file: Path, tmp_path: Path) -> None:
    first = next(iter(read_batches(file, HEXAPOD))).rows
    lines = TEXT.splitlines()
    lines[first + 1] = "0," + lines[first + 1].split(",", 1)[1]
    with pytest.raises(RecordingError, match=rf"line {first + 2}, t_s: 0.000000 s comes after .* s; time must"):
        list(read_batches(written(tmp_path, "\n".join(lines)), HEXAPOD))


def test_a_file_too_long_to_be_read_at_once_is_refused_before_memory_ends(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reading, "MOST_NUMBERS", 100_000)
    with pytest.raises(
        RecordingError,
        match=r"holds too much to be read at once \(this one .* GB; at most 8,333 rows of 12 columns\); cut",
    ) as caught:
        read_recording(file, HEXAPOD)
    one_line(caught.value)
    assert sum(b.rows for b in read_batches(file, HEXAPOD)) == LONG.count


def test_two_gigabytes_of_nothing_are_refused_at_once(tmp_path: Path) -> None:
    file = written(tmp_path, ",".join(NAMES) + "\n")
    with file.open("r+b") as stream:
        stream.truncate(2_000_000_000)  # sparse: takes no room
    with pytest.raises(RecordingError, match=r"line 2: is longer than a million characters"):
        read_recording(file, HEXAPOD)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=100)
@given(
    lengths=st.lists(st.integers(0, 40), max_size=60),
    size=st.integers(4, 300),
    above=st.integers(0, 5),
    below=st.integers(0, 3),
    newline=st.booleans(),
)
def test_blocks_hold_each_line_once_with_its_number(
    lengths: list[int], size: int, above: int, below: int, newline: bool, tmp_path: Path
) -> None:
    lines = [str(k).encode() * n for k, n in enumerate(lengths)]
    text = b"\n".join(lines) + b"\n" * newline
    file = written(tmp_path, text or b"\n")
    found = {}
    for block in read_blocks(file, above, below, size, kept=400):
        for k, line in enumerate(block.data.split(b"\n")):
            if line:
                assert block.first_line + k not in found
                found[block.first_line + k] = line
    filled = [k for k, line in enumerate(lines) if line]
    kept = filled[: len(filled) - below] if below else filled
    assert found == {k + 1: lines[k] for k in kept if k >= above}
