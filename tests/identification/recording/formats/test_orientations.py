"""Poses in the conventions of controllers: angles in any order, rotation vectors, quaternions, matrices."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.base.errors import HexciteError, RecordingError, Write
from cases.orientation import OF_ANGLES, QUATERNION, ROTATION
from cases.recording_format import BAR_FORCES, STRUTS, WRENCH
from cases.schema import Case, load_case
from identification.identify import identify
from identification.recording.recording import read
from tests.helpers import one_line
from tests.identification.recording.formats.loaded_hexapod import CASE, CENTRE, MASS, run
from tests.identification.recording.formats.runs import case_with, csv, written

WRIST = case_with(load_case("ft_wrist"), columns={})
HELD, AT = 2.61, np.array([0.004, -0.007, 0.086])  # mass and centre of gravity of a load on a wrist
RUN = run(np.arange(1001) * 0.004)
SHORT = run(np.arange(60) * 0.004)
POSITIONS = ("x_mm", "y_mm", "z_mm")
ANGLES = ("a_deg", "b_deg", "c_deg")


def standstills(seed: int = 3) -> tuple[Rotation, np.ndarray]:
    """Orientations of a wrist all around, and the wrench of a load that it holds, with offsets and noise."""
    draw = np.random.default_rng(seed)
    turns = Rotation.from_quat(draw.normal(size=(20, 4)))
    pull = HELD * turns.inv().apply(np.array(WRIST.gravity))
    wrench = np.hstack([pull, np.cross(AT, pull)]) + np.array([3.2, -5.1, 8.4, 0.31, -0.22, 0.12])
    return turns, wrench + draw.normal(size=wrench.shape) * ([0.02] * 3 + [0.002] * 3)


TURNS, WRENCHES = standstills()


def wrist(folder: Path, names: list[str], numbers: np.ndarray, **recording: object) -> tuple[Path, Case]:
    text = csv(np.column_stack([numbers, WRENCHES]), [*names, *WRENCH])
    return written(folder, text), case_with(WRIST, **recording)


def hexapod(folder: Path, names: list[str], numbers: np.ndarray, motion: Any = RUN) -> Path:
    rows = np.column_stack([motion.t, motion.position * 1e3, numbers, motion.forces])
    return written(folder, csv(rows, ["t_s", "X", "Y", "Z", *names, *BAR_FORCES]))


def of_pose(names: list[str], ours: tuple[str, ...] = ANGLES, **recording: object) -> Case:
    return case_with(columns=dict(zip((*POSITIONS, *ours), ("X", "Y", "Z", *names), strict=True)), **recording)


def require_load(result: Any, mass: float, centre: np.ndarray) -> None:
    for name, truth in zip(("m", "xC", "yC", "zC"), (mass, *centre), strict=True):
        assert abs(result[name].value - truth) < 4.0 * result[name].reported


@pytest.mark.parametrize("convention", OF_ANGLES, ids=lambda c: c.name)
def test_orientations_of_every_convention_are_read(convention: Any, tmp_path: Path) -> None:
    vector = convention.form == "rotation vector"
    turns = TURNS.inv() if convention.inverse else TURNS
    angles = np.degrees(turns.as_rotvec()) if vector else turns.as_euler(convention.axes, degrees=True)
    file, case = wrist(tmp_path, [*ANGLES], angles, orientation=convention.name)
    np.testing.assert_allclose(read(file, case).rotations, TURNS.as_matrix(), atol=1e-7)


def test_angles_mean_roll_pitch_and_yaw_where_nothing_is_stated(tmp_path: Path) -> None:
    file, case = wrist(tmp_path, [*ANGLES], TURNS.as_euler("xyz", degrees=True))
    np.testing.assert_allclose(read(file, case).rotations, TURNS.as_matrix(), atol=1e-7)


@pytest.mark.parametrize(
    ("names", "unit", "orientation", "angles"),
    [
        (["RX [deg]", "RY [deg]", "RZ [deg]"], {}, "rotation vector", np.degrees(TURNS.as_rotvec())),
        (["rx", "ry", "rz"], {"angles": "rad"}, "rotation vector", TURNS.as_rotvec()),
        (["A", "B", "C"], {}, "zyx intrinsic", TURNS.as_euler("ZYX", degrees=True)),
        (["O", "A", "T"], {}, "zyz intrinsic", TURNS.as_euler("ZYZ", degrees=True)),
    ],
)
def test_a_load_on_a_wrist_is_weighed_in_the_orientations_of_its_controller(
    names: list[str], unit: dict[str, str], orientation: str, angles: np.ndarray, tmp_path: Path
) -> None:
    columns = dict(zip(ANGLES, names, strict=True))
    file, case = wrist(tmp_path, names, angles, columns=columns, units=unit, orientation=orientation)
    require_load(identify(read(file, case), case), HELD, AT)


@pytest.mark.parametrize(
    ("names", "numbers", "orientation"),
    [
        ([*ANGLES], TURNS.as_euler("ZYX", degrees=True), "zyx intrinsic"),
        ([*ANGLES], TURNS.inv().as_euler("xyz", degrees=True), "xyz extrinsic inverse"),
        ([*QUATERNION], TURNS.inv().as_quat(scalar_first=True), "quaternion inverse"),
        ([*ROTATION], TURNS.inv().as_matrix().reshape(-1, 9), "matrix inverse"),
    ],
)
def test_the_convention_that_explains_a_run_is_a_key_that_reads_the_file(
    names: list[str], numbers: np.ndarray, orientation: str, tmp_path: Path
) -> None:
    """Under our own names of columns too, of which the case says nothing."""
    file, case = wrist(tmp_path, names, numbers)
    with pytest.raises(HexciteError) as caught:
        identify(read(file, case), case)
    (remedy,) = caught.value.remedies
    assert remedy.keys == (Write(("recording", "orientation"), orientation),)
    mended = case_with(case, orientation=orientation)
    require_load(identify(read(file, mended), mended), HELD, AT)


@pytest.mark.parametrize("order", ["wxyz", "xyzw"])
@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_quaternions_are_read_in_both_orders_and_signs(order: str, turned: float, tmp_path: Path) -> None:
    names = [f"q{axis}" for axis in order]
    numbers = turned * TURNS.as_quat(scalar_first=order == "wxyz")
    file, case = wrist(tmp_path, names, numbers)
    np.testing.assert_allclose(read(file, case).rotations, TURNS.as_matrix(), atol=1e-7)


def test_a_matrix_that_turns_the_other_way_is_read_where_the_case_says_so(tmp_path: Path) -> None:
    matrices = TURNS.as_matrix().transpose(0, 2, 1).reshape(-1, 9)
    file, case = wrist(tmp_path, [*ROTATION], matrices, orientation="matrix inverse")
    np.testing.assert_allclose(read(file, case).rotations, TURNS.as_matrix(), atol=1e-7)


@pytest.mark.first(1)
@pytest.mark.parametrize("orientation", ["xyz intrinsic", "zyx intrinsic", "rotation vector", "yxz extrinsic"])
def test_a_body_on_a_hexapod_is_weighed_in_poses_of_any_convention(orientation: str, tmp_path: Path) -> None:
    order, _, kind = orientation.partition(" ")
    vector = orientation == "rotation vector"
    angles = np.degrees(RUN.turn.as_rotvec()) if vector else RUN.angles(order.upper() if kind == "intrinsic" else order)
    case = of_pose(["U", "V", "W"], orientation=orientation)
    recording = read(hexapod(tmp_path, ["U", "V", "W"], angles), case)
    np.testing.assert_allclose(recording.drives, RUN.struts, atol=1e-8)
    require_load(identify(recording, case), MASS, CENTRE)


def test_poses_of_a_hexapod_may_be_quaternions_or_matrices(tmp_path: Path) -> None:
    names = ["q1", "q2", "q3", "q4"]
    file = hexapod(tmp_path, names, SHORT.turn.as_quat(scalar_first=True), SHORT)
    np.testing.assert_allclose(read(file, of_pose(names, QUATERNION)).drives, SHORT.struts, atol=1e-8)
    # a 4 x 4 matrix, column by column, position in m
    whole = np.zeros((len(SHORT.t), 4, 4))
    whole[:, :3, :3], whole[:, :3, 3], whole[:, 3, 3] = SHORT.turn.as_matrix(), SHORT.position, 1.0
    labels = [f"O_T_EE[{k}]" for k in range(16)]
    rows = np.column_stack([SHORT.t, whole.transpose(0, 2, 1).reshape(-1, 16), SHORT.forces])
    file = written(tmp_path, csv(rows, ["t_s", *labels, *BAR_FORCES]), "matrix.csv")
    places = {f"r{i + 1}{j + 1}": f"O_T_EE[{4 * j + i}]" for i in range(3) for j in range(3)}
    columns = places | {name: f"O_T_EE[{12 + k}]" for k, name in enumerate(POSITIONS)}
    recording = read(file, case_with(columns=columns, units={"positions": "m"}))
    np.testing.assert_allclose(recording.drives, SHORT.struts, atol=1e-8)


def test_angles_that_leap_by_a_turn_are_one_way(tmp_path: Path) -> None:
    turned = run(np.arange(1.0, 3.0, 0.004))
    half = Rotation.from_euler("z", 180.0 - turned.angles("xyz")[:, 2].mean(), degrees=True)
    angles = (half * turned.turn).as_euler("xyz", degrees=True)
    assert np.ptp(angles[:, 2]) > 350.0
    file = hexapod(tmp_path, [*ANGLES], angles, turned)
    poses = read(file, of_pose([*ANGLES])).poses
    assert np.abs(np.diff(poses[:, 5])).max() < 0.1


def test_a_quaternion_of_another_norm_is_refused_with_its_line(tmp_path: Path) -> None:
    numbers = TURNS.as_quat(scalar_first=True)
    numbers[7] *= 1.2
    file, case = wrist(tmp_path, [*QUATERNION], numbers)
    with pytest.raises(RecordingError, match=r"line 9, qw: .*quaternion whose norm is not 1") as caught:
        read(file, case)
    one_line(caught.value)


def test_a_rotation_vector_of_more_than_a_turn_is_refused_with_its_unit(tmp_path: Path) -> None:
    file, case = wrist(
        tmp_path, [*ANGLES], np.degrees(TURNS.as_rotvec()), orientation="rotation vector", units={"angles": "rad"}
    )
    with pytest.raises(RecordingError, match=r"more than a turn.*recording\.units\.angles"):
        read(file, case)


def test_two_ways_of_writing_that_differ_are_refused_with_the_order_that_would_agree(tmp_path: Path) -> None:
    numbers = np.column_stack([TURNS.as_euler("ZYX", degrees=True), TURNS.as_quat(scalar_first=True)])
    file, case = wrist(tmp_path, [*ANGLES, *QUATERNION], numbers)
    with pytest.raises(RecordingError, match=r"differ.*recording\.orientation = 'zyx intrinsic' or 'quaternion'"):
        read(file, case)
    for orientation in ("zyx intrinsic", "quaternion"):
        stated = case_with(WRIST, orientation=orientation)
        np.testing.assert_allclose(read(file, stated).rotations, TURNS.as_matrix(), atol=1e-7)


def test_what_a_stated_orientation_needs_and_lacks_is_named(tmp_path: Path) -> None:
    file, case = wrist(tmp_path, [*ANGLES], TURNS.as_euler("xyz", degrees=True), orientation="quaternion")
    with pytest.raises(RecordingError, match="column qw is missing"):
        read(file, case)


def test_struts_alone_need_no_orientation(tmp_path: Path) -> None:
    rows = np.column_stack([SHORT.t, SHORT.struts * 1e3, SHORT.forces])
    file = written(tmp_path, csv(rows, ["t_s", *STRUTS, *BAR_FORCES]))
    recording = read(file, case_with(CASE, orientation="rotation vector"))
    np.testing.assert_allclose(recording.drives, SHORT.struts, atol=1e-8)


@pytest.mark.parametrize(("unit", "value"), [("m", 1.0), ("in", 0.0254), ("cm", 0.01)])
def test_positions_that_are_about_home_in_another_unit_alone_are_refused_with_it(
    unit: str, value: float, tmp_path: Path
) -> None:
    rows = np.column_stack([SHORT.t, SHORT.position / value, SHORT.angles("xyz"), SHORT.forces])
    file = written(tmp_path, csv(rows, ["t_s", *POSITIONS, *ANGLES, *BAR_FORCES]))
    with pytest.raises(
        RecordingError, match=rf"x_mm: positions about .*recording\.units\.positions = '{unit}'"
    ) as caught:
        read(file, CASE)
    one_line(caught.value)
    np.testing.assert_allclose(read(file, case_with(units={"positions": unit})).drives, SHORT.struts, atol=1e-8)


def test_struts_beside_half_a_pose_are_enough(tmp_path: Path) -> None:
    rows = np.column_stack([SHORT.t, SHORT.struts * 1e3, SHORT.position * 1e3, SHORT.forces])
    file = written(tmp_path, csv(rows, ["t_s", *STRUTS, *POSITIONS, *BAR_FORCES]))
    np.testing.assert_allclose(read(file, CASE).drives, SHORT.struts, atol=1e-8)


@pytest.mark.parametrize(
    ("names", "stated", "said"),
    [
        (["RX", "RY", "RZ"], {}, True),
        (["RX", "RY", "RZ"], {"orientation": "xyz extrinsic"}, False),
        (["roll", "pitch", "yaw"], {}, False),
        ([*ANGLES], {}, False),
    ],
)
def test_a_convention_that_nobody_states_is_said(
    names: list[str], stated: dict[str, str], said: bool, tmp_path: Path
) -> None:
    columns = {ours: name for ours, name in zip(ANGLES, names, strict=True) if ours != name}
    file, case = wrist(tmp_path, names, TURNS.as_euler("xyz", degrees=True), columns=columns, **stated)
    notes = [f.sentence for f in read(file, case).findings]
    assert [("recording.orientation" in note and "RX, RY, RZ" in note) for note in notes] == [True] * said
