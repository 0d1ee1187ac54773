"""Drives, poses and accelerometers become struts and specific forces of the platform, as the case says."""

from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import RecordingError
from cases.recording_format import BAR_FORCES, STRUTS
from identification.machines.hexapod import Hexapod
from identification.recording.recording import read
from tests.helpers import one_line
from tests.identification.recording.formats.runs import HEXAPOD, Truth, case_with, csv, written

RUN = Truth()
ORDER, SIGN = [2, 1, 3, 6, 5, 4], [1.0, -1.0, 1.0, 1.0, -1.0, -1.0]
OFFSET = [500.0, 510.0, 520.0, 530.0, 540.0, 550.0]
DRIVES = {"order": ORDER, "sign": SIGN, "offset_mm": OFFSET}
DRIVE_NAMES = [f"q{k}_mm" for k in range(1, 7)]
POSE = ["x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"]


def table(**columns: np.ndarray) -> tuple[np.ndarray, list[str]]:
    numbers = np.column_stack([RUN.t, *columns.values(), RUN.forces])
    return numbers, ["t_s", *columns, *BAR_FORCES]


def drives() -> np.ndarray:
    """Positions [mm] of the drives at which strut k = sign_k * drive order_k + offset_k holds."""
    positions = np.empty((RUN.count, 6))
    for k in range(6):
        positions[:, ORDER[k] - 1] = (RUN.struts[:, k] * 1e3 - OFFSET[k]) / SIGN[k]
    return positions


@pytest.mark.parametrize(("unit", "size"), [("mm", 1e-3), ("um", 1e-6), ("m", 1.0)])
def test_struts_follow_from_drives_by_sign_order_and_offset(unit: str, size: float, tmp_path: Path) -> None:
    numbers, names = table(**dict(zip(DRIVE_NAMES, drives().T * 1e-3 / size, strict=True)))
    case = case_with(drives=DRIVES, units={"drives": unit})
    recording = read(written(tmp_path, csv(numbers, names)), case)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-8)


@pytest.mark.parametrize("names_of_speeds", ["qd{}_mm_s", "ld{}_mm_s"])
def test_measured_velocities_are_left_out(names_of_speeds: str, tmp_path: Path) -> None:
    """Damage in columns of which nothing is evaluated costs no samples."""
    speeds = np.full((RUN.count, 6), np.nan)
    columns = dict(zip(DRIVE_NAMES, drives().T, strict=True))
    columns |= {names_of_speeds.format(k + 1): speeds[:, k] for k in range(6)}
    numbers, names = table(**columns)
    recording = read(written(tmp_path, csv(numbers, names)), case_with(drives=DRIVES))
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-8)
    assert recording.missing is None


def poses() -> np.ndarray:
    """Poses near home [mm, deg]."""
    spread = np.random.default_rng(2).uniform(-1.0, 1.0, (RUN.count, 6)) * [80.0, 80.0, 50.0, 9.0, 9.0, 9.0]
    return (spread + np.array([0.0, 0.0, 900.0, 0.0, 0.0, 0.0])).round(4)


def test_struts_follow_from_poses_by_inverse_kinematics(tmp_path: Path) -> None:
    numbers, names = table(**dict(zip(POSE, poses().T, strict=True)))
    recording = read(written(tmp_path, csv(numbers, names)), HEXAPOD)
    si = poses() * ([1e-3] * 3 + [np.pi / 180] * 3)
    np.testing.assert_allclose(recording.poses, si, rtol=1e-12)
    np.testing.assert_allclose(Hexapod.of(HEXAPOD).poses(recording.drives), si, atol=1e-9)


def test_without_a_machine_poses_turn_the_sensor(tmp_path: Path, wrist_case) -> None:
    numbers = np.column_stack([poses()[:, :3], [[0.0, 0.0, 90.0]] * RUN.count, RUN.forces])
    names = [*POSE, "fx", "fy", "fz", "tx", "ty", "tz"]
    recording = read(written(tmp_path, csv(numbers, names)), wrist_case)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(recording.rotations, [quarter] * RUN.count, atol=1e-12)


def test_readings_of_an_accelerometer_are_scaled_and_turned_into_the_platform(tmp_path: Path) -> None:
    readings = np.random.default_rng(3).normal([0.0, 0.0, 1.0], 0.1, (RUN.count, 3)).round(6)
    columns = dict(zip(STRUTS, RUN.struts.T * 1e3, strict=True)) | dict(
        zip(("ax", "ay", "az"), readings.T, strict=True)
    )
    file = written(tmp_path, csv(*table(**columns)))
    mounting = [[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]
    case = case_with(accelerometer={"scale_m_s2": 9.82085, "mounting": mounting})
    expected = 9.82085 * np.column_stack([-readings[:, 1], readings[:, 2], -readings[:, 0]])
    np.testing.assert_allclose(read(file, case).specific_forces, expected, rtol=1e-12)
    assert read(file, HEXAPOD).specific_forces is None
    with pytest.raises(RecordingError, match=r" 1\.\d+ m/s\^2 .*gravity.* 9\.81") as caught:
        read(file, case_with(accelerometer={"scale_m_s2": 1.0, "mounting": mounting}))
    assert "correct recording.accelerometer.scale_m_s2" in one_line(caught.value)


def test_drives_that_the_case_does_not_know_are_refused(tmp_path: Path) -> None:
    columns = dict(zip(DRIVE_NAMES, drives().T, strict=True))
    with pytest.raises(RecordingError, match=r"drive positions.*\[recording\.drives\]"):
        read(written(tmp_path, csv(*table(**columns))), HEXAPOD)
    columns |= dict(zip(STRUTS, RUN.struts.T * 1e3, strict=True))
    with pytest.raises(RecordingError, match=r"strut lengths and drive positions.*out"):
        read(written(tmp_path, csv(*table(**columns))), case_with(drives=DRIVES))


def test_a_drive_that_is_missing_is_named(tmp_path: Path) -> None:
    columns = dict(zip(DRIVE_NAMES[:5], drives().T[:5], strict=True))
    with pytest.raises(RecordingError, match=r"q6_mm .*missing.* t_s, q1_mm"):
        read(written(tmp_path, csv(*table(**columns))), case_with(drives=DRIVES))
