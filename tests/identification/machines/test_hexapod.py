"""Forward and inverse kinematics (7): each undoes the other everywhere that the machine works."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cases.base.errors import IdentificationError
from cases.schema import load_case
from identification.machines.hexapod import Hexapod
from tests.helpers import HOME, one_line, paper_poses

CASE = load_case("hexapod")
HEXAPOD = Hexapod.of(CASE)
BOX = CASE.limits.motion.coordinates
share = st.lists(st.floats(0.0, 1.0), min_size=6, max_size=6)


def rotations(poses: np.ndarray) -> np.ndarray:
    return Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()


def test_strut_length_is_the_distance_between_its_joints() -> None:
    poses = HOME + np.random.default_rng(0).uniform(BOX[0], BOX[1], (50, 6))
    joints = poses[:, None, :3] + np.einsum("nij,kj->nki", rotations(poses), CASE.machine.platform.points)
    expected = np.linalg.norm(joints - CASE.machine.base.points, axis=2)
    np.testing.assert_allclose(HEXAPOD.strut_lengths(poses), expected, rtol=1e-14)


@given(share=share)
def test_forward_undoes_inverse_kinematics_in_the_whole_box(share: list[float]) -> None:
    pose = (HOME + BOX[0] + np.array(share) * (BOX[1] - BOX[0]))[None]
    np.testing.assert_allclose(HEXAPOD.poses(HEXAPOD.strut_lengths(pose)), pose, atol=1e-10)


def test_forward_undoes_inverse_kinematics_in_all_corners_of_the_box() -> None:
    corners = HOME + np.array(np.meshgrid(*BOX.T)).reshape(6, 64).T
    np.testing.assert_allclose(HEXAPOD.poses(HEXAPOD.strut_lengths(corners)), corners, atol=1e-10)


def test_forward_undoes_inverse_kinematics_at_the_480_poses_of_the_paper() -> None:
    positions, turns = paper_poses()
    poses = np.hstack([positions, Rotation.from_matrix(turns).as_euler("xyz")])
    assert len(poses) == 480
    np.testing.assert_allclose(HEXAPOD.poses(HEXAPOD.strut_lengths(poses)), poses, atol=1e-10)


def test_order_of_the_samples_does_not_matter() -> None:
    """Samples start from the interpolation between their neighbours: scattered ones must find the same poses."""
    poses = HOME + np.random.default_rng(1).uniform(BOX[0], BOX[1], (500, 6))
    np.testing.assert_allclose(HEXAPOD.poses(HEXAPOD.strut_lengths(poses)), poses, atol=1e-10)


def test_a_third_of_a_turn_of_pose_and_machine_only_renames_the_struts() -> None:
    """The joints come in three equal pairs: (o, R) -> (Q o, Q R Q^T) moves the load of struts k to struts k + 2."""
    poses = HOME + np.random.default_rng(2).uniform(BOX[0], BOX[1], (40, 6))
    third = Rotation.from_euler("z", 120, degrees=True).as_matrix()
    turned = np.hstack(
        [poses[:, :3] @ third.T, Rotation.from_matrix(third @ rotations(poses) @ third.T).as_euler("xyz")]
    )
    expected = np.roll(HEXAPOD.strut_lengths(poses), 2, axis=1)
    np.testing.assert_allclose(HEXAPOD.strut_lengths(turned), expected, rtol=1e-13)


def test_equal_struts_mean_a_level_platform_on_the_axis() -> None:
    length = HEXAPOD.strut_lengths(HOME[None])
    for factor in (0.95, 1.1):
        pose = HEXAPOD.poses(factor * length)[0]
        np.testing.assert_allclose(np.delete(pose, 2), 0.0, atol=1e-12)
        assert pose[2] > 0.0  # the platform stays above the base


@pytest.mark.parametrize("sample", [0, 4, 31, 32, 99])
def test_struts_that_cannot_close_are_named_by_their_sample(sample: int) -> None:
    lengths = np.tile(HEXAPOD.strut_lengths(HOME[None]), (100, 1))
    lengths[sample] = [0.3, 1.5, 0.3, 1.5, 0.3, 1.5]
    with pytest.raises(IdentificationError, match=rf"sample {sample + 1}: .*300\.000, 1500\.000") as caught:
        HEXAPOD.poses(lengths)
    assert "order and offset" in one_line(caught.value)


def test_the_first_of_several_impossible_samples_is_named() -> None:
    lengths = np.tile(HEXAPOD.strut_lengths(HOME[None]), (100, 1))
    lengths[[5, 64, 70]] *= 0.2
    with pytest.raises(IdentificationError, match="sample 6:"):
        HEXAPOD.poses(lengths)


def test_a_strut_that_is_not_a_number_is_impossible() -> None:
    lengths = np.tile(HEXAPOD.strut_lengths(HOME[None]), (3, 1))
    lengths[1, 2] = np.nan
    with pytest.raises(IdentificationError, match="sample 2"):
        HEXAPOD.poses(lengths)


def test_samples_that_close_are_told_from_those_that_do_not_and_move_alike() -> None:
    """Also where so many samples run to infinity at once that NumPy would warn."""
    draw = np.random.default_rng(3)
    velocities, accelerations = draw.normal(size=(2, 2000, 6))
    lengths = HEXAPOD.strut_lengths(HOME + draw.uniform(-0.02, 0.02, (2000, 6)))
    lengths[1::2, 5] *= -draw.uniform(0.5, 1e6, 1000)
    motion, closed = HEXAPOD.kinematics_where_closed(lengths, velocities, accelerations)
    assert closed.tolist() == 1000 * [True, False]
    one_by_one = HEXAPOD.kinematics(lengths[closed], velocities[closed], accelerations[closed])
    for name in ("pose", "twist", "twist_rate"):
        np.testing.assert_allclose(getattr(motion, name)[closed], getattr(one_by_one, name), rtol=1e-7, atol=1e-8)
