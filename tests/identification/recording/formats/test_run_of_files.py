"""One run in several files: told apart by their columns, in any order, each with its own clock on one time axis."""

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import RecordingError
from cases.recording_format import BAR_FORCES, STRUTS
from cases.schema import load_case
from identification.recording.recording import Recording, read
from tests.helpers import one_line
from tests.identification.recording.formats.runs import HEXAPOD, Truth, case_with, csv, written

RUN = Truth()
NTNU = Path(__file__).parents[5] / "shared/data/ft_wrist_ntnu"
WRIST = load_case("ft_wrist")
EPOCH = 1_708_857_503_931_759
real = pytest.mark.skipif(not NTNU.is_dir(), reason=f"the recordings are not there: {NTNU}")


def files(folder: Path, late: float = 0.0, unit: float = 1.0) -> list[Path]:
    """Forces at 1 kHz and struts at 250 Hz, which start 0.5 ms and `late` [s] later."""
    forces = np.column_stack([RUN.t / unit, RUN.forces])
    struts = np.column_stack([(RUN.t[::4] + 0.0005 + late) / unit, RUN.struts[::4] * 1e3])
    return [
        written(folder, csv(forces, ["t_s", *BAR_FORCES]), "forces.csv"),
        written(folder, csv(struts, ["t_s", *STRUTS]), "struts.csv"),
    ]


def require_streams(recording: Recording) -> None:
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    assert recording.drives is None
    (struts,) = recording.others
    np.testing.assert_allclose(struts.drives, RUN.struts[::4], rtol=1e-8)
    np.testing.assert_allclose(struts.t, RUN.t[::4] + 0.0005, atol=1e-9)
    assert struts.step == pytest.approx(4e-3)
    assert [list(s.channels) for s in (recording, *recording.others)] == [["forces"], ["drives"]]


@pytest.mark.parametrize("reverse", [False, True])
def test_files_make_one_run_in_any_order(reverse: bool, tmp_path: Path) -> None:
    paths = files(tmp_path)
    require_streams(read(paths[::-1] if reverse else paths, HEXAPOD))


def test_a_clock_that_is_late_is_set_right_by_the_case(tmp_path: Path) -> None:
    require_streams(read(files(tmp_path, late=0.0084), case_with(clock={"offset_s": {"struts": -0.0084}})))


def test_clocks_of_another_epoch_are_brought_together(tmp_path: Path) -> None:
    case = case_with(clock={"offset_s": {"struts": -3600.0}})
    require_streams(read(files(tmp_path, late=3600.0), case))


@pytest.mark.parametrize("late", [0.0084, -0.02, 0.012])
def test_columns_of_one_file_are_shifted_apart(late: float, tmp_path: Path) -> None:
    numbers = np.column_stack([RUN.t, RUN.struts * 1e3, RUN.forces, RUN.t > 0.01])
    file = written(tmp_path, csv(numbers, ["t_s", *STRUTS, *BAR_FORCES, "trigger"]))
    recording = read(file, case_with(clock={"offset_s": {"forces": -late}}))
    motion = recording.stream_with("drives")
    assert motion is not None
    assert motion.t is not None
    assert recording.t is not None
    np.testing.assert_allclose(motion.t - recording.t, late, atol=1e-9)
    np.testing.assert_allclose(motion.drives, RUN.struts, rtol=1e-8)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)
    assert recording.stream_with("trigger") is motion  # a controller has both


def test_files_whose_samples_coincide_are_joined(tmp_path: Path) -> None:
    paths = [
        written(tmp_path, csv(np.column_stack([RUN.t, RUN.struts * 1e3]), ["t_s", *STRUTS]), "a.csv"),
        written(tmp_path, csv(np.column_stack([RUN.t, RUN.forces]), ["t_s", *BAR_FORCES]), "b.csv"),
    ]
    recording = read(paths, HEXAPOD)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-8)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)
    assert recording.others == ()


def test_standstills_in_several_files_are_joined_row_by_row(tmp_path: Path) -> None:
    paths = [
        written(tmp_path, csv(RUN.struts * 1e3, STRUTS), "a.csv"),
        written(tmp_path, csv(RUN.forces, BAR_FORCES), "b.csv"),
    ]
    recording = read(paths, HEXAPOD)
    assert recording.t is None
    assert recording.drives.shape == recording.forces.shape


def test_a_run_of_one_file_has_one_stream(tmp_path: Path) -> None:
    numbers = np.column_stack([RUN.t, RUN.struts * 1e3, RUN.forces])
    stream = read(written(tmp_path, csv(numbers, ["t_s", *STRUTS, *BAR_FORCES])), HEXAPOD)
    assert stream.others == ()
    assert list(stream.channels) == ["drives", "forces"]
    assert stream.rows == RUN.count


DAMAGES = [
    "one file twice", "two runs", "a clock and nothing more", "no forces", "no pose", "not together",
    "one without a clock", "no file", "standstills of two sets", "a file of something else",
    "forces of another sensor", "an unknown accelerometer",
]  # fmt: skip


def damaged(folder: Path) -> dict[str, tuple[list[Path], str]]:
    forces, struts = files(folder)
    (folder / "later").mkdir()
    later = files(folder / "later", late=100.0)[1]
    alone = written(folder, csv(RUN.struts * 1e3, STRUTS), "alone.csv")
    few = written(folder, csv(RUN.forces[:9], BAR_FORCES), "few.csv")
    notes = written(folder, "a,b\n1,2\n", "notes.csv")
    timed = written(folder, "t_s,u1\n0,1\n1,1\n", "timed.csv")
    wrench = written(folder, "t_s,fx_N\n0,1\n1,1\n", "wrench.csv")
    felt = written(folder, "t_s,ax,ay,az\n0,0,0,1\n1,0,0,1\n", "felt.csv")
    return {
        "one file twice": ([forces, struts, forces], r"forces.csv: has forces, as .*forces.csv does; .*each once"),
        "two runs": ([forces, struts, later], r"later.*: has drives, as .*struts.csv does; give the files of one run"),
        "no forces": ([struts], r"struts.csv: no forces: none of the columns f1_N, .*; it has t_s, l1_mm"),
        "no pose": ([forces], r"forces.csv: no pose: none of the columns l1_mm"),
        "not together": ([forces, later], r"struts.csv: starts 99.96\d* s after .*forces.csv ends; .*offset_s"),
        "one without a clock": (
            [forces, alone],
            r"forces.csv, .*alone.csv: .*not all of them have time stamps; give files of one run",
        ),
        "standstills of two sets": (
            [few, alone],
            r"alone.csv: have no common rows.*; give files of one run",
        ),
        "a file of something else": ([forces, struts, notes], r"notes.csv: none of the columns .*; it has a, b"),
        "a clock and nothing more": ([forces, timed], r"timed.csv: none of the columns l1_mm, .*; it has t_s, u1"),
        "forces of another sensor": ([forces, struts, wrench], r"wrench.csv: none of .* f1_N; it has t_s, fx_N: name"),
        "an unknown accelerometer": ([forces, struts, felt], r"felt.csv: has readings .*\[recording.accelerometer\]"),
        "no file": ([], r"no recording is named; give the files of one run"),
    }


@pytest.mark.parametrize("what", DAMAGES)
def test_what_is_no_run_is_named_with_its_file(what: str, tmp_path: Path) -> None:
    paths, message = damaged(tmp_path)[what]
    with pytest.raises(RecordingError, match=message) as caught:
        read(paths, HEXAPOD)
    one_line(caught.value)


@real
def test_the_three_files_of_a_real_run_are_three_streams_in_any_order() -> None:
    """Wrench, orientations and accelerometer came at 698, 100 and 254 Hz, on the clock of one host."""
    paths = [NTNU / f"1-baseline_{kind}.csv" for kind in ("wrench", "orientations", "accel")]
    for order in permutations(paths):
        recording = read(order, WRIST)
        streams = [recording.stream_with(c) for c in ("forces", "rotations", "specific_forces")]
        assert [s.rows for s in streams] == [4376, 627, 1593]
        rates = [(s.rows - 1) / (s.t[-1] - s.t[0]) for s in streams]
        np.testing.assert_allclose(rates, [698, 100, 254], rtol=1e-3)
        # on the lines through the stamps, which stray by part of a step
        assert [s.t[0] for s in streams] == pytest.approx([0.000423, 0.0, 0.002637], abs=2e-3)
        assert recording.rotations is None


@real
def test_the_real_accelerometer_feels_gravity_in_the_axes_of_the_sensor() -> None:
    """At rest it reads minus gravity: within what its bias (0.08 g) and misalignment leave."""
    recording = read(NTNU / "0-calibration_fts-accel.csv", WRIST)
    assert recording.t is None
    gravity = recording.rotations.transpose(0, 2, 1) @ WRIST.gravity
    error = recording.specific_forces + gravity
    assert np.abs(error.mean(axis=0)).max() < 0.08 * 9.82
    assert error.std(axis=0).max() < 0.1
