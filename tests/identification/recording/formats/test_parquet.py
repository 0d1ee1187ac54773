"""Parquet holds the same run as CSV; what is not Parquet any more is named."""

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from identification.recording.recording import Recording, read, write_recording
from identification.samples.sample_checks import unmeasured
from tests.helpers import answer, examples, refused_at, tells
from tests.identification.recording.formats.runs import HEXAPOD, NAMES, Truth, case_with, written

RUN = Truth()


def columns(run: Truth = RUN) -> dict[str, Any]:
    return {n: run.numbers()[:, k] for k, n in enumerate(NAMES)}


def parquet(folder: Path, content: dict[str, object]) -> Path:
    pq.write_table(pa.table(content), folder / "run.parquet")
    return folder / "run.parquet"


def recorded(run: Truth) -> Recording:
    return Recording("here", run.t, run.struts, None, run.forces, np.arange(run.count) % 7 > 2)


def test_what_is_written_is_read_back_from_file_and_folder(tmp_path: Path) -> None:
    write_recording(tmp_path / "table.csv", recorded(RUN), HEXAPOD)
    pq.write_table(pacsv.read_csv(tmp_path / "table.csv"), tmp_path / "recording.parquet")
    (tmp_path / "table.csv").unlink()
    for place in (tmp_path, tmp_path / "recording.parquet"):
        back = read(place, HEXAPOD)
        np.testing.assert_array_equal(back.drives, read_back(tmp_path).drives)
        np.testing.assert_allclose(back.t, RUN.t, atol=1e-12)
        np.testing.assert_array_equal(back.trigger, np.arange(RUN.count) % 7 > 2)


def read_back(folder: Path) -> Recording:
    """The same run on its way through CSV."""
    write_recording(folder / "run.csv", recorded(RUN), HEXAPOD)
    return read(folder / "run.csv", HEXAPOD)


def test_the_name_of_the_file_does_not_matter(tmp_path: Path) -> None:
    file = parquet(tmp_path, columns()).rename(tmp_path / "run.csv")
    np.testing.assert_allclose(read(file, HEXAPOD).forces, RUN.forces)


def test_names_units_and_types_are_mapped_as_in_text(tmp_path: Path) -> None:
    micrometres = {f"l{k + 1}_mm": (RUN.struts[:, k] * 1e6).round().astype("int32") for k in range(6)}
    content = columns() | micrometres | {"note": ["x"] * RUN.count}
    content = {{"l1_mm": "axis.1", "t_s": "clock"}.get(n, n): v for n, v in content.items()}
    content["clock"] = np.arange(RUN.count, dtype="int64") + 10**15
    content["f3_N"] = RUN.forces[:, 2].astype("float32")
    case = case_with(columns={"l1_mm": "axis.1", "t_s": "clock"}, units={"struts": "um"}, clock={"unit": "ms"})
    recording = read(parquet(tmp_path, content), case)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-12)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-6)
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-12)


def test_row_groups_follow_each_other(tmp_path: Path) -> None:
    file = parquet(tmp_path, columns())
    pq.write_table(pq.read_table(file), file, row_group_size=3)
    recording = read(file, HEXAPOD)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-6)
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    assert recording.lines.place(RUN.count - 1) == f"row {RUN.count}"


def gap(name: str, value: object) -> dict[str, object]:
    values = list(columns()[name])
    values[7] = value
    return columns() | {name: values}


@pytest.mark.parametrize("value", [None, float("nan"), float("inf")])
def test_what_was_not_measured_is_marked(value: float | None, tmp_path: Path) -> None:
    recording = read(parquet(tmp_path, gap("f2_N", value)), HEXAPOD)
    assert np.flatnonzero(recording.missing).tolist() == [7]
    (warning,) = map(str, unmeasured(recording))
    assert tells(warning, "row 8: ", "f2_N", "left out")
    others = np.arange(RUN.count) != 7
    np.testing.assert_allclose(recording.forces[others], RUN.forces[others], rtol=1e-6)


WRONG = {
    "null in the clock": (gap("t_s", None), r"t_s: has no value in row 8"),
    "time backwards": (gap("t_s", 0.001), r"row 8, t_s: 0.001 is not later"),
    "text": (columns() | {"f2_N": ["1.5"] * RUN.count}, r"f2_N: holds string, not numbers; export it as double"),
    "no forces": ({n: v for n, v in columns().items() if n[0] != "f"}, r"no forces: none of the columns f1_N"),
    "a missing strut": ({n: v for n, v in columns().items() if n != "l4_mm"}, r"column l4_mm is missing; it has t_s, "),
    "nothing of ours": ({"a": [1.0, 2.0]}, r"none of the columns .*; it has a: name them so"),
    "no rows": ({n: np.zeros(0) for n in NAMES}, r"has columns but no rows"),
    "metres": ({n: v * 1e-3 if n[0] == "l" else v for n, v in columns().items()}, r"row 1: .*struts = 'm'"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_cannot_be_used_is_named_with_its_row(what: str, tmp_path: Path) -> None:
    content, message = WRONG[what]
    file = parquet(tmp_path, content)
    with refused_at(file, message):
        read(file, HEXAPOD)


@pytest.mark.parametrize("keep", [4, 5, 12, 100, 1000, -1, -8, -100])
def test_a_file_that_was_cut_off_is_named(keep: int, tmp_path: Path) -> None:
    whole = parquet(tmp_path, columns()).read_bytes()
    file = written(tmp_path, whole[:keep], "cut.parquet")
    with refused_at(file, r"damaged Parquet file \(.+\); .*export"):
        read(file, HEXAPOD)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=examples(100))
@given(place=st.floats(0.0, 1.0), noise=st.binary(min_size=1, max_size=8))
def test_a_file_with_a_stain_gives_a_run_or_one_line(place: float, noise: bytes, tmp_path: Path) -> None:
    whole = parquet(tmp_path, columns()).read_bytes()
    at = int(place * (len(whole) - len(noise)))
    file = written(tmp_path, whole[:at] + noise + whole[at + len(noise) :], "stain.parquet")
    recording = answer(lambda: read(file, HEXAPOD), str(file))
    assert recording is None or np.isfinite(recording.forces).all()
