"""A recording survives the way through its file, whatever the file calls its columns."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import RecordingError
from cases.recording_format import BAR_FORCES, STRUTS
from cases.schema import Case
from identification.looks.looking import look
from identification.machines.hexapod import Hexapod
from identification.recording.recording import Recording, read, write_recording
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, one_line
from tests.simulated_machine import PoseExecution


@pytest.fixture
def recording(hexapod_case: Case) -> Recording:
    execution = PoseExecution(Hexapod.of(hexapod_case), Harmonic(duration=1.0))
    return simulate_recording(hexapod_case, execution, np.array([[0.2, 0.8]]), seed=1)


def test_what_is_written_is_read_back(tmp_path: Path, recording: Recording, hexapod_case: Case) -> None:
    file = tmp_path / "recording.csv"
    write_recording(file, recording, hexapod_case)
    for place in (file, tmp_path):  # a file, or the folder that holds it
        back = read(place, hexapod_case)
        np.testing.assert_allclose(back.t, recording.t, atol=1e-9)
        np.testing.assert_allclose(back.drives, recording.drives, atol=1e-11)  # 1e-8 mm
        np.testing.assert_allclose(back.forces, recording.forces, atol=1e-6)
        np.testing.assert_array_equal(back.trigger, recording.trigger)
        assert back.rotations is None
        assert back.source == str(file)
        assert back.step == pytest.approx(1e-3)


def test_the_file_has_the_columns_of_the_conventions(tmp_path: Path, recording: Recording, hexapod_case: Case) -> None:
    file = tmp_path / "recording.csv"
    write_recording(file, recording, hexapod_case)
    header, *rows = file.read_text().splitlines()
    assert (
        header.replace('"', "")
        == "t_s,"
        + ",".join([f"l{k}_mm" for k in range(1, 7)])
        + ","
        + ",".join([f"f{k}_N" for k in range(1, 7)])
        + ",trigger"
    )
    assert len(rows) == len(recording.forces)
    assert rows[300].endswith(",1")
    assert rows[100].endswith(",0")


def test_columns_may_have_other_names_and_any_order(tmp_path: Path, recording: Recording, hexapod_case: Case) -> None:
    file = tmp_path / "recording.csv"
    write_recording(file, recording, hexapod_case)
    table = [line.replace('"', "").split(",") for line in file.read_text().splitlines()]
    table[0] = [{"l1_mm": "q[0]", "t_s": "Zeit"}.get(n, n) for n in table[0]]
    file.write_text("\n".join(",".join(reversed(row)) for row in table))
    columns = {"l1_mm": "q[0]", "t_s": "Zeit"}
    recorded = hexapod_case.recording.model_copy(update={"columns": columns})
    back = read(file, hexapod_case.model_copy(update={"recording": recorded}))
    np.testing.assert_allclose(back.drives, recording.drives, atol=1e-11)
    np.testing.assert_allclose(back.forces, recording.forces, atol=1e-6)
    with pytest.raises(RecordingError, match=r"l1_mm .*missing.*q\[0\]"):
        read(file, hexapod_case)


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_files_of_any_system_are_read(
    tmp_path: Path, recording: Recording, hexapod_case: Case, newline: str, mark: str
) -> None:
    file = tmp_path / "recording.csv"
    write_recording(file, recording, hexapod_case)
    file.write_bytes((mark + file.read_text().replace("\n", newline)).encode())
    np.testing.assert_allclose(read(file, hexapod_case).forces, recording.forces, atol=1e-6)


def test_a_column_of_words_that_nobody_asks_for_does_no_harm(
    tmp_path: Path, recording: Recording, hexapod_case: Case
) -> None:
    file = tmp_path / "recording.csv"
    write_recording(file, recording, hexapod_case)
    header, *rows = file.read_text().splitlines()
    file.write_text("\n".join([header + ",note", *(row + ",warm-up" for row in rows)]))
    np.testing.assert_allclose(read(file, hexapod_case).forces, recording.forces, atol=1e-6)


def test_counts_of_a_long_running_clock_are_numbers(tmp_path: Path, recording: Recording, hexapod_case: Case) -> None:
    """Integers beyond 2^53, such as nanoseconds since 1970, stand in columns that nobody asks for, too."""
    file = tmp_path / "recording.csv"
    write_recording(file, recording, hexapod_case)
    header, *rows = file.read_text().splitlines()
    stamps = [f"{row},{1_764_000_000_000_000_001 + k}" for k, row in enumerate(rows)]
    file.write_text("\n".join([header + ",stamp_ns", *stamps]))
    np.testing.assert_allclose(read(file, hexapod_case).forces, recording.forces, atol=1e-6)


@pytest.mark.parametrize(("value", "says"), [("1.5", None), ("x", r", line 30002, f1_N: 'x' is not a number")])
def test_what_comes_late_in_a_long_file_counts_as_what_comes_first(
    tmp_path: Path, hexapod_case: Case, value: str, says: str | None
) -> None:
    """A force of 0 N for 30 000 rows, 2 MB, must not make it a column of whole numbers."""
    file = tmp_path / "run.csv"
    header = ",".join([*STRUTS, *BAR_FORCES])
    row = ",".join(["980.123456"] * 6 + ["0"] * 6)
    file.write_text("\n".join([header, *[row] * 30_000, row.replace(",0,", f",{value},", 1)]))
    if says is None:
        assert read(file, hexapod_case).forces[-1, 0] == float(value)
        return
    with pytest.raises(RecordingError, match=says) as caught:
        read(file, hexapod_case)
    one_line(caught.value)


def test_a_gap_is_counted_and_does_not_change_the_step(recording: Recording) -> None:
    """A gap of a second in a run of a second doubles the mean step; the sampling goes on as before."""
    late = recording.t.copy()
    late[700:] += 1.0
    gap = replace(recording, t=late)
    assert gap.step == pytest.approx(1e-3)
    assert np.flatnonzero(gap.lost).tolist() == [699]
    assert gap.lost[699] == 1000


def test_uneven_sampling_is_named_where_it_happens(recording: Recording) -> None:
    """From one of a thousand samples on the recorder is 4 % slower."""
    late = recording.t.copy()
    late[700:] += 0.04 * (late[700:] - late[700])
    with pytest.raises(RecordingError, match=r"line 70\d, t_s: .*\b1\.04 ms .*\b1 ms") as caught:
        _ = replace(recording, t=late).step
    assert "at one rate" in one_line(caught.value)


def test_rounded_time_stamps_count_as_even(recording: Recording) -> None:
    assert replace(recording, t=np.round(recording.t, 5)).step == pytest.approx(1e-3)


@pytest.mark.parametrize("jitter", [0.02, 0.2, 0.95, 7.0])
def test_a_stamp_may_be_late(recording: Recording, jitter: float) -> None:
    trembling = recording.t.copy()
    trembling[400] += jitter * 1e-3
    if jitter > 1.0:  # a host that was busy stamps what waited at once
        trembling[401:410] = np.maximum(trembling[401:410], trembling[400] + 1e-6 * np.arange(1, 10))
    assert replace(recording, t=trembling).step == pytest.approx(1e-3, rel=2e-5)


def test_standstills_have_no_step(recording: Recording) -> None:
    with pytest.raises(RecordingError, match="no t_s column"):
        _ = replace(recording, t=None).step


def test_rows_that_stand_for_nothing_stay_so_in_a_saved_recording(
    tmp_path: Path, recording: Recording, hexapod_case: Case
) -> None:
    missing = np.zeros(recording.rows, dtype=bool)
    missing[500:520] = True
    forces = np.where(missing[:, None], 9e9, recording.forces)
    replace(recording, case=hexapod_case, forces=forces, missing=missing).save(tmp_path / "saved")
    np.testing.assert_array_equal(Recording.load(tmp_path / "saved").bad, missing)


def test_a_single_row_has_no_step(recording: Recording) -> None:
    with pytest.raises(RecordingError, match="one row"):
        _ = replace(recording, t=recording.t[:1]).step


def test_a_trigger_may_be_a_voltage_with_noise(tmp_path: Path, recording: Recording, hexapod_case: Case) -> None:
    file = tmp_path / "recording.csv"
    write_recording(file, recording, hexapod_case)
    header, *rows = file.read_text().splitlines()
    volts = 4.9 * recording.trigger + np.random.default_rng(0).normal(0.02, 0.01, len(rows))
    voltage = [f"{row.rpartition(',')[0]},{v:.3f}" for row, v in zip(rows, volts, strict=True)]
    file.write_text("\n".join([header, *voltage]) + "\n")
    np.testing.assert_array_equal(read(file, hexapod_case).trigger, recording.trigger)
    voltage[400] = f"{rows[400].rpartition(',')[0]},2.4"
    file.write_text("\n".join([header, *voltage]) + "\n")
    with pytest.raises(RecordingError, match=r"line \d+, trigger: 2\.4 .*switch") as caught:
        read(file, hexapod_case)
    one_line(caught.value)


def test_a_look_tells_that_a_voltage_is_off_at_the_end(
    tmp_path: Path, recording: Recording, hexapod_case: Case
) -> None:
    file = tmp_path / "recording.csv"
    write_recording(file, recording, hexapod_case)
    header, *rows = file.read_text().replace('"trigger"', '"TTL [V]"').splitlines()
    voltage = [
        f"{row.rpartition(',')[0]},{4.98 if on else 0.02}" for row, on in zip(rows, recording.trigger, strict=True)
    ]
    file.write_text("\n".join([header, *voltage]) + "\n")
    found = look(file, hexapod_case)
    assert found.settings["columns"]["trigger"] == "TTL [V]"
    assert not any("last row" in odd or "switch" in odd for odd in found.odd)
