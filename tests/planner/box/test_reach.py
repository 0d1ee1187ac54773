"""The reachable part of the motion box, and the largest reachable box: facts, by means other than their own."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.machine import POSE
from cases.schema import Case, load_case
from identification.limits.proof import prove
from identification.motion.motion import StandingPoses
from planner.box.proposal import proposed_box
from planner.box.reach import reach
from tests.cases.editing import written
from tests.helpers import few, tells
from tests.hexcite.command_line import call
from tests.postprocessors.changed_case import changed

STRUTS = [235.0, 325.0]
VICE = {"name": "vice", "x_mm": [100.0, 300.0], "y_mm": [-50.0, 50.0], "z_mm": [650.0, 750.0]}


def small_platform(case: Case, struts: list[float] = STRUTS, **keys: Any) -> Case:
    """A table-top platform with the strokes of its single axes as the motion box."""
    around = {"pair_centres_deg": [90.0, 210.0, 330.0], "z_mm": 0.0}
    sides = {"x_mm": 60.0, "y_mm": 60.0, "z_mm": 60.0, "a_deg": 20.0, "b_deg": 20.0, "c_deg": 30.0}
    return changed(
        case,
        machine__base={"ring": {"radius_mm": 150.0, "half_angle_deg": 12.0, **around}},
        machine__platform={"ring": {"radius_mm": 110.0, "half_angle_deg": 48.0, **around}},
        machine__home=dict.fromkeys(POSE, 0.0) | {"z_mm": 260.0},
        workspace__x_mm=[-100.0, 100.0],
        workspace__y_mm=[-100.0, 100.0],
        workspace__strut_length_mm=struts,
        workspace__platform_joint_angle_deg=60.0,
        limits__motion__strut_length_mm=struts,
        **{f"limits__motion__{key}": [-side, side] for key, side in sides.items()},
        **keys,
    )


def narrowed(case: Case, share: float) -> Case:
    box = {f"limits__motion__{key}": [share * v for v in getattr(case.limits.motion, key)] for key in POSE}
    return changed(case, **box)


def struts_kept(case: Case, poses: np.ndarray) -> np.ndarray:
    """Whether each pose keeps the strut lengths: a computation with nothing in common with hexcite's."""
    arms = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix() @ case.machine.platform.points.T
    ends = poses[:, None, :3] + arms.transpose(0, 2, 1)
    lengths = np.linalg.norm(ends - case.machine.base.points, axis=2)
    low, high = np.array(case.limits.motion.strut_length_mm) / 1e3
    return np.all((lengths >= low - 1e-7) & (lengths <= high + 1e-7), axis=1)


def kept_poses(case: Case, poses: np.ndarray) -> np.ndarray:
    """Whether the proof finds each pose within all limits, one by one."""
    return np.array([prove(StandingPoses(pose[None].repeat(2, axis=0)), case, 1.0).kept for pose in poses])


@pytest.fixture(scope="module")
def small(hexapod_case: Case) -> Case:
    return small_platform(hexapod_case)


@pytest.fixture(scope="module")
def with_vice(hexapod_case: Case) -> Case:
    """Home off the centre of the machine, a box to keep out of, and a tool that comes near it."""
    home = dict.fromkeys(POSE, 0.0) | {"x_mm": 30.0, "y_mm": -20.0, "z_mm": 900.0, "c_deg": 5.0}
    case = changed(hexapod_case, workspace__keep_out=[VICE], machine__home=home)
    return changed(case, workspace__tool=[{"name": "probe", "to_mm": [0.0, 0.0, -80.0], "radius_mm": 5.0}])


def test_a_box_may_be_reachable_as_a_whole(hexapod_case: Case) -> None:
    case = narrowed(hexapod_case, 0.8)
    found = reach(case)
    assert (found.share, found.whole, found.exceeded) == (1.0, True, {})
    assert found.share_std < 1e-4


def test_corners_that_random_poses_miss_count(hexapod_case: Case) -> None:
    found = reach(hexapod_case)
    assert found.share == 1.0
    assert not found.whole
    assert found.worst.name == "strut length (strut 6)"


@pytest.mark.parametrize("name", few("small", "with_vice"))
@pytest.mark.repeats
def test_the_share_is_that_of_the_proof(name: str, request: pytest.FixtureRequest) -> None:
    case = request.getfixturevalue(name)
    found = reach(case)
    poses = case.machine.home.vector + np.random.default_rng(5).uniform(*case.limits.motion.coordinates, (1500, 6))
    share = kept_poses(case, poses).mean()
    assert 0.05 < found.share < 0.95
    assert abs(found.share - share) < 4 * np.hypot(found.share_std, np.sqrt(share * (1 - share) / len(poses)))


def test_a_wider_range_of_the_struts_never_shrinks_the_reach(hexapod_case: Case) -> None:
    found = [reach(small_platform(hexapod_case, [235.0 - d, 325.0 + d]), 4000) for d in (-25.0, -10.0, 0.0, 10.0, 40.0)]
    for narrow, wide in pairwise(found):
        assert narrow.share < wide.share


def test_the_command_prints_and_draws_the_reach(small: Case, tmp_path: Path) -> None:
    file = written(tmp_path, small.model_dump(mode="json", exclude_none=True))
    found = call("case", "check", file, "--json").json()["reach"]
    assert found["share"] == pytest.approx(reach(small).share)
    assert found["exceeded"]["strut length"] == pytest.approx(1.0 - found["share"], abs=0.02)
    text = call("case", "check", file).out
    assert tells(text, f"{100 * found['share']:.3g} %", "reachable")


@pytest.mark.parametrize("name", ["ft_wrist", "clamping_table"])
def test_cases_without_a_motion_box(name: str) -> None:
    assert set(call("case", "check", name, "--json").json()) == {"ok", "figures", "missing", "remarks", "phrases"}
    assert "reach" not in call("case", "check", name).out


@pytest.mark.repeats
def test_the_reach_of_a_chain_ends_where_its_bodies_touch():
    data = load_case("ur10_wrist").model_dump(mode="json", exclude_unset=True)
    pillar = {"name": "pillar", "x_mm": [300.0, 900.0], "y_mm": [250.0, 400.0], "z_mm": [0.0, 2000.0]}
    data["machine"]["chain"]["keep_out"].append(pillar)
    case = Case.model_validate(data).found_at("ur10_wrist")
    found = reach(case, 500)
    poses = case.chain.home + np.random.default_rng(0).uniform(
        *case.limits.motion.coordinates, (300, case.chain.home.size)
    )
    assert not found.whole
    assert found.exceeded["distance from pillar"] > 0.0
    assert found.share == pytest.approx(kept_poses(case, poses).mean(), abs=0.15)


@pytest.mark.parametrize("tried", [2, pytest.param(6, marks=pytest.mark.repeats)])  # sides
@pytest.mark.parametrize("struts", few(STRUTS, [240.0, 310.0]))
def test_a_proposed_box_is_within_reach_and_none_of_its_sides_could_be_much_wider(
    hexapod_case: Case, struts: list[float], tried: int
):
    case = small_platform(hexapod_case, struts)
    assert not reach(case).whole
    box = proposed_box(case)
    sides = np.array(list(box.sides.values()))
    stated = {key: getattr(case.limits.motion, key) for key in POSE}
    for (low, high), limits in zip(sides, stated.values(), strict=True):
        assert limits[0] <= low <= 0.0 <= high <= limits[1]
    proposed = changed(case, **{f"limits__motion__{key}": list(side) for key, side in box.sides.items()})
    own = reach(proposed)
    assert own.share == 1.0
    assert own.worst.ratio <= 1.001
    assert box.share == pytest.approx(np.prod(np.ptp(sides, axis=1) / [np.ptp(v) for v in stated.values()]), rel=1e-6)
    for key, side in list(box.sides.items())[:tried]:
        for k in (0, 1):
            if abs(side[k]) > 0.95 * abs(stated[key][k]):
                continue
            wider = list(side)
            wider[k] += 0.1 * stated[key][k]
            assert not reach(changed(proposed, **{f"limits__motion__{key}": wider}), 2000).whole, (key, k)


@pytest.mark.slow
def test_the_command_proposes_lines_of_the_case_file(hexapod_case: Case, tmp_path: Path):
    file = written(tmp_path, small_platform(hexapod_case).model_dump(mode="json", exclude_none=True))
    answer = call("case", "check", file, "--propose", "--json").json()["proposal"]
    said = call("case", "check", file, "--propose").out
    for key, side in answer["limits_motion"].items():
        assert f"{key} = [{side[0]}, {side[1]}]" in said
    assert "proposal" not in call("case", "check", file, "--json").json()
    assert "no other box is needed" in call("case", "check", "ur10_wrist", "--propose").out
