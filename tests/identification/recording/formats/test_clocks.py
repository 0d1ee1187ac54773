"""Time stamps of any unit and epoch give the same time axis, to the last digit that the file holds."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.interpolate import BarycentricInterpolator

from cases.base.errors import RecordingError
from identification.recording.formats.table import Lines
from identification.recording.recording import read
from identification.samples.sample_checks import unmeasured
from tests.helpers import refused_at, tells
from tests.identification.recording.formats.runs import NAMES, Truth, case_with, csv, rows, written

RUN = Truth()
TICKS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "filetime": 1e-7}
EPOCHS = {"us": 1_708_857_503_931_759, "ns": 1_764_000_000_000_000_001, "filetime": 132_959_733_843_760_000}


def stamped(stamps: list[str]) -> str:
    lines = rows(RUN.numbers()[:, 1:])
    return "\n".join([",".join(NAMES), *(f"{t},{line}" for t, line in zip(stamps, lines, strict=True))]) + "\n"


@pytest.mark.parametrize("unit", TICKS)
def test_stamps_may_have_any_unit(unit: str, tmp_path: Path) -> None:
    file = written(tmp_path, csv(RUN.numbers(tick=TICKS[unit])))
    recording = read(file, case_with(clock={"unit": unit}))
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    assert recording.step == pytest.approx(1e-3)


@pytest.mark.parametrize("unit", EPOCHS)
def test_stamps_that_count_from_an_epoch_lose_no_digit(unit: str, tmp_path: Path) -> None:
    """A double holds stamps of 1e17 in steps of 16 only; the differences must be those of the integers."""
    odd = [k * k % 7 + round(k * 1e-3 / TICKS[unit]) for k in range(RUN.count)]
    file = written(tmp_path, stamped([str(EPOCHS[unit] + k) for k in odd]))
    recording = read(file, case_with(clock={"unit": unit}))
    np.testing.assert_allclose(recording.t, np.array(odd) * TICKS[unit], rtol=1e-14)


def test_time_starts_with_the_run(tmp_path: Path) -> None:
    file = written(tmp_path, stamped([f"{1000.0 + t:.3f}" for t in RUN.t]))
    np.testing.assert_allclose(read(file, case_with()).t, RUN.t, atol=1e-9)


def test_rows_without_stamps_follow_each_other_in_the_period_that_the_case_states(tmp_path: Path) -> None:
    file = written(tmp_path, csv(RUN.numbers()[:, 1:], NAMES[1:]))
    assert read(file, case_with()).t is None
    np.testing.assert_allclose(read(file, case_with(clock={"period_ms": 2.0})).t, 2.0 * RUN.t)


@pytest.mark.parametrize("unit", ["ms", "us", "ns"])
def test_time_stamps_of_parquet_know_their_unit(unit: str, tmp_path: Path) -> None:
    times = np.datetime64("2026-11-01T08:00:00") + np.round(RUN.t * 1e9).astype("timedelta64[ns]")
    columns = {n: RUN.numbers()[:, k] for k, n in enumerate(NAMES)} | {"t_s": times.astype(f"M8[{unit}]")}
    pq.write_table(pa.table(columns), tmp_path / "run.parquet")
    np.testing.assert_allclose(read(tmp_path / "run.parquet", case_with()).t, RUN.t, atol=1e-9)


WRONG = {
    "backwards": (["0.000", "0.002", "0.001"], "s", r"line 4, t_s: 0.001 is not later .*sort the rows"),
    "repeated": (["0", "1", "1"], "ms", r"line 4, t_s: 1 is not later"),
    "backwards by one of many": (["1708857503931759", "1708857503931758"], "us", r"1708857503931758 is not later"),
    "a date": (["2026-11-01", "2026-11-02"], "s", r"line 2, t_s: '2026-11-01' is not a number"),
    "a time of day that goes back": (["08:00:00.002", "08:00:00.001"], "s", r"line 3, t_s: 08:00:00.001 is not later"),
    "not a time of day": (["08:00:00.001", "noon", "08:00:00.003"], "s", r"line 3, t_s: 'noon' is not a time stamp"),
    "nothing": (["0", "", "2"], "s", r"line 3, t_s: is empty where a time stamp is needed; remove the row"),
    "NaN": (["0", "nan", "2"], "s", r"line 3, t_s: nan is not a time stamp"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_clock_that_cannot_be_is_named_with_its_line(what: str, tmp_path: Path) -> None:
    stamps, unit, message = WRONG[what]
    lines = stamped([*stamps, *(str(10 + k) for k in range(len(stamps), RUN.count))])
    file = written(tmp_path, "\n".join(lines.splitlines()[: len(stamps) + 1]))
    with refused_at(file, message):
        read(file, case_with(clock={"unit": unit}))


def test_a_sampling_rate_that_changes_is_named_where_it_does(tmp_path: Path) -> None:
    times = [*RUN.t[:30], *(RUN.t[29] + 2e-3 * np.arange(1, 11))]
    recording = read(written(tmp_path, stamped([f"{t:.3f}" for t in times])), case_with())
    with pytest.raises(RecordingError, match=r"run\.csv, line 32, t_s: .*\b2 ms .*\b1 ms; .*one rate"):
        _ = recording.step


def test_a_line_is_counted_in_the_file_whatever_stands_above_it(tmp_path: Path) -> None:
    """Header rows, blank lines and the row itself: a gap behind row 20 of the numbers."""
    times = [*RUN.t[:20], *(RUN.t[20:] + 1.0)]
    lines = stamped([f"{t:.3f}" for t in times]).splitlines()
    text = "\n".join(["title", "", *lines[:11], "", "", *lines[11:]])
    recording = read(written(tmp_path, text), case_with(header_rows=3))
    (told,) = map(str, unmeasured(recording))
    assert tells(told, f"line {text.splitlines().index(lines[20]) + 1}: 1000 samples", "no filter")


def test_a_few_missing_samples_are_put_back_and_marked(tmp_path: Path) -> None:
    times = [f"{t:.3f}" for t in (*RUN.t[:10], *(RUN.t[10:] + 3e-3))]
    recording = read(written(tmp_path, stamped(times)), case_with())
    assert recording.step == pytest.approx(1e-3)
    assert np.flatnonzero(recording.missing).tolist() == [10, 11, 12]
    np.testing.assert_allclose(np.diff(recording.t), 1e-3, rtol=1e-6)
    cubic = BarycentricInterpolator([8, 9, 13, 14], RUN.struts[8:12])  # through two samples on either side
    np.testing.assert_allclose(recording.drives[10:13], cubic([10, 11, 12]), rtol=1e-9)
    np.testing.assert_allclose(recording.drives[13:], RUN.struts[10:], rtol=1e-9)
    assert recording.lines.place(12) == "line 11"
    assert recording.lines.place(13) == "line 12"
    (told,) = map(str, unmeasured(recording))
    assert tells(told, "line 11: 3 samples", "bridged")


def test_lines_are_counted_behind_rows_that_stand_in_none() -> None:
    lines = Lines(first=2, inserted=(3, 4, 9))
    places = [int(lines.place(row).split()[1]) for row in range(12)]
    assert places == [2, 3, 4, 4, 4, 5, 6, 7, 8, 8, 9, 10]
    for row in range(12):
        assert [int(lines.later(row).place(k).split()[1]) for k in range(12 - row)] == places[row:]
    assert [int(lines.later(2, 3).place(k).split()[1]) for k in range(4)] == places[2::3]
