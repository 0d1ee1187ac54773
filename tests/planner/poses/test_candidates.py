"""Candidates are the poses of the paper, valid ones only, and refusals say what stands in the way."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.base.errors import CaseError, HexciteError, InfeasiblePlan
from cases.schema import Case, load_case
from identification.limits.proof import prove_at
from identification.machines.hexapod import Hexapod
from identification.motion.motion import Standstill
from planner.poses.planned_poses import grid_candidates, sampled_candidates
from planner.poses.space import PoseSpace, valid_poses
from tests.helpers import one_line, paper_poses
from tests.planner.poses.conftest import Setting

CASE = load_case("hexapod")


def with_poses(case: Case = CASE, **changes: object) -> Case:
    assert case.poses is not None
    return case.model_copy(update={"poses": type(case.poses).model_validate(case.poses.model_dump() | changes)})


def with_workspace(**changes: object) -> Case:
    assert CASE.workspace is not None
    workspace = type(CASE.workspace).model_validate(CASE.workspace.model_dump() | changes)
    return CASE.model_copy(update={"workspace": workspace})


def test_the_grid_is_the_480_poses_of_section_6() -> None:
    poses = grid_candidates(CASE)
    positions, turns = paper_poses()
    np.testing.assert_allclose(poses[:, :3], positions, atol=1e-12)
    np.testing.assert_allclose(Rotation.from_euler("xyz", poses[:, 3:]).as_matrix(), turns, atol=1e-12)


def test_quasi_random_poses_fill_the_space_evenly_and_repeat_with_their_seed() -> None:
    one, same, other = (sampled_candidates(CASE, 1024, seed) for seed in (5, 5, 6))
    np.testing.assert_array_equal(one, same)
    assert not np.allclose(one, other)
    radius = np.hypot(one[:, 0], one[:, 1])
    tilt = np.arccos(Rotation.from_euler("xyz", one[:, 3:]).as_matrix()[:, 2, 2])
    assert radius.max() <= 0.3
    assert np.rad2deg(tilt.max()) <= 20.0 + 1e-6
    # even in area: half the points inside 1/sqrt(2) of the radius
    assert np.mean(radius < 0.3 / np.sqrt(2)) == pytest.approx(0.5, abs=0.01)


def test_a_pose_is_valid_exactly_where_the_model_of_the_search_says_so() -> None:
    case = with_workspace(strut_length_mm=[880.0, 1250.0], base_joint_angle_deg=37.0, platform_joint_angle_deg=60.0)
    poses = sampled_candidates(CASE, 256, 1)
    valid, hexapod = valid_poses(case, poses), Hexapod.of(case)
    for pose, ours in zip(poses, valid, strict=True):
        lengths = hexapod.strut_lengths(pose[None])[0]
        at_base, at_platform = (np.rad2deg(np.arccos(c.full())).max() for c in hexapod.joint_cosines(pose))
        inside = lengths.min() >= 0.88 and lengths.max() <= 1.25
        assert ours == (inside and at_base <= 37.0 and at_platform <= 60.0)
    assert 0.1 < valid.mean() < 0.9


def test_poses_stay_away_from_singularities_as_far_as_the_case_says() -> None:
    poses, hexapod = sampled_candidates(CASE, 64, 2), Hexapod.of(CASE)
    home = np.linalg.det(hexapod.inverse_jacobian(hexapod.home)[1].full())
    shares = [np.linalg.det(hexapod.inverse_jacobian(pose)[1].full()) / home for pose in poses]
    middle = float(np.median(shares))
    far = valid_poses(with_poses(singularity_distance=middle), poses)
    np.testing.assert_array_equal(far, np.array(shares) >= middle)


def test_smooth_coordinates_and_poses_are_each_others_inverse(sample: Setting) -> None:
    space = PoseSpace.of(CASE)
    shares = space.shares(sample.poses)
    np.testing.assert_allclose(space.poses(shares, sample.poses), sample.poses, atol=1e-12)
    np.testing.assert_allclose(space.project(shares), shares, atol=1e-12)
    assert np.abs(shares).max() <= 1.0 + 1e-12


def test_an_upright_pose_has_coordinates_too() -> None:
    space = PoseSpace.of(CASE)
    upright = np.array([[0.0, 0.0, 0.9, 0.0, 0.0, 0.1]])
    np.testing.assert_allclose(space.poses(space.shares(upright), upright), upright, atol=1e-12)


@pytest.mark.parametrize("longest", [[650.0, 730.0], [650.0, 700.0]])  # the latter below the shortest of the motions
def test_no_valid_pose_says_which_limit_and_what_to_do(longest: list[float]) -> None:
    with pytest.raises(
        InfeasiblePlan,
        match=r"480 poses.*strut length .* limit 7\d\d, .*100 %.*workspace\.strut_length_mm",
    ):
        grid_candidates(with_workspace(strut_length_mm=longest))


@pytest.mark.repeats
def test_poses_in_a_keep_out_box_are_left_out() -> None:
    box = {"name": "rack", "x_mm": [100.0, 900.0], "y_mm": [-900.0, 900.0], "z_mm": [870.0, 2000.0]}
    poses = grid_candidates(with_workspace(keep_out=[box]))
    assert 0 < len(poses) < 240
    for pose in poses:
        report = prove_at(Standstill(pose, 0.0), with_workspace(keep_out=[box]), np.zeros(1), in_box=False)
        assert report.kept
    with pytest.raises(InfeasiblePlan, match=r"distance from rack .*workspace\.keep_out"):
        grid_candidates(with_workspace(keep_out=[box | {"x_mm": [-900.0, 900.0]}]))


def test_a_ring_without_grid_points_is_named() -> None:
    with pytest.raises(InfeasiblePlan, match=r"poses\.radius_mm"):
        grid_candidates(with_poses(radius_mm=[110.0, 120.0]))


def test_a_grid_of_ten_million_poses_says_what_it_would_need_and_offers_sampling() -> None:
    fine = with_poses(x_mm=[-300.0, 300.0, 6.0], y_mm=[-300.0, 300.0, 6.0], azimuth_deg=[0.0, 359.0, 2.0])
    assert fine.poses is not None
    assert fine.poses.grid_size > 10_000_000
    with pytest.raises(HexciteError, match=r"1 to 200000: .*candidates 20000") as error:
        grid_candidates(fine)
    one_line(error.value)


@pytest.mark.parametrize(("count", "seed", "said"), [(0, 0, "0 candidates"), (10**7, 0, "1 to 200000")])
def test_impossible_samples_are_refused(count: int, seed: int, said: str) -> None:
    with pytest.raises(HexciteError, match=re.escape(said)):
        sampled_candidates(CASE, count, seed)


def test_a_case_without_poses_says_which_table_is_missing() -> None:
    with pytest.raises(CaseError, match="poses: is missing"):
        grid_candidates(CASE.model_copy(update={"poses": None}))


@pytest.mark.parametrize("steps", [[300.0, -300.0, 100.0], [-300.0, 300.0, 0.0], [-300.0, 300.0, -10.0]])
def test_ranges_that_never_arrive_are_refused(steps: list[float]) -> None:
    with pytest.raises(ValueError, match=r"\[first, last, step\]"):
        with_poses(x_mm=steps)
