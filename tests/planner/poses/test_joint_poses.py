"""Poses of chains: inside joints and clearances, as good as any, in programs, and identified."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cases.schema import Case, load_case
from hexcite._run import execute
from hexcite._write import write
from identification.identify import identify
from identification.limits.proof import prove
from identification.model.model import static_model
from identification.motion.motion import StandingPoses
from identification.simulate import truth_rows
from planner._plan import plan_poses
from planner.plans.plan import Plan
from planner.poses.travel import fastest_move
from tests.chains import chain_case
from tests.helpers import few
from tests.hexcite.command_line import call, refused

COUNT = 8


@cache
def plan_of(joints: int) -> Plan:
    return plan_poses(chain_case(joints), count=COUNT, candidates=512)


@pytest.mark.parametrize("joints", few(6, 5, 7))
def test_poses_of_joints_lie_in_the_box_clear_of_everything_and_no_design_is_better(joints: int, tmp_path: Path):
    plan = plan_of(joints)
    case = plan.case
    home, box = case.need_motion("a test")
    assert plan.poses.shape == (COUNT, joints)
    assert np.all((plan.poses >= home + box.coordinates[0] - 1e-9) & (plan.poses <= home + box.coordinates[1] + 1e-9))
    assert prove(StandingPoses(plan.poses), case, 1.0).kept
    assert 0.98 < plan.worth.efficiency < 1.1
    plan.save(tmp_path / "plan")
    again = Plan.load(tmp_path / "plan", case)
    np.testing.assert_allclose(again.poses, plan.poses, rtol=0, atol=1e-12)
    table = np.genfromtxt(tmp_path / "plan" / "poses.csv", delimiter=",", names=True)
    assert table.dtype.names == ("pose", *box.columns)
    assert [table[name][3] for name in box.columns] == pytest.approx(plan.poses[3] / case.chain.units, abs=1e-6)


@pytest.mark.repeats
@pytest.mark.parametrize("dialect", few("ros2", "urscript", "setpoints"))
def test_standstills_of_a_robot_are_executed_found_and_identified(dialect: str):
    """A joint trajectory switches no output: there standstills are found where the joints stand."""
    plan = plan_of(6)
    program = write(plan, dialect, accept=("jerk",) if dialect == "urscript" else ())
    recording = execute(program, plan.case, "virtual", seed=1)[1]
    result = identify(recording, plan.case, poses=plan.poses)
    assert result.estimate is not None
    assert result.estimate.model.number == static_model(plan.case) == 0
    assert len(result.estimate.fit.residuals) == COUNT
    for row in truth_rows(plan.case, result.estimate):
        assert abs(row["error"]) < 4.5 * row["std"], row["name"]


@pytest.mark.repeats
def test_a_wall_beside_the_robot_is_kept_clear_of_by_poses_and_on_the_way():
    data = chain_case(6).model_dump(mode="json", exclude_unset=True)
    wall = {"name": "wall", "x_mm": [-1500.0, 1500.0], "y_mm": [-900.0, -400.0], "z_mm": [0.0, 2000.0]}
    data["machine"]["chain"]["keep_out"].append(wall)
    case = Case.model_validate(data).found_at("ur10_wrist")
    free, beside = plan_poses(chain_case(6), count=4, candidates=256), plan_poses(case, count=4, candidates=256)
    assert not prove(StandingPoses(free.poses), case, 1.0).kept
    assert prove(StandingPoses(beside.poses), case, 1.0).kept
    assert beside.limits.kept
    assert any(check.name.startswith("distance from wall") for check in beside.limits.checks)


def test_moves_between_poses_are_slowed_where_torques_need_it():
    data = load_case("ur10_wrist").model_dump(mode="json", exclude_unset=True)
    for joint in data["machine"]["chain"]["joints"]:
        along = -200.0 if joint["name"] in ("shoulder", "elbow") else 0.0
        joint["link"] = {
            "mass_kg": 4.0, "centre_of_gravity_mm": [along, 0.0, 0.0],
            "inertia_kg_m2": [0.1, 0.0, 0.0, 0.1, 0.0, 0.1],
        }  # fmt: skip
    data["machine"]["chain"]["joints"][2]["torque_Nm"] = 330.0
    strong = Case.model_validate(data).found_at("ur10_wrist")
    data["machine"]["chain"]["joints"][2]["torque_Nm"] = 165.0
    weak = Case.model_validate(data).found_at("ur10_wrist")
    home = strong.need_motion("a test")[0]
    start, end = home + np.deg2rad([0, 14, 14, 0, 0, 0]), home + np.deg2rad([0, -14, -14, 40, 0, 0])
    quick, slow = (fastest_move(case, start, end) for case in (strong, weak))
    quick_torque, torque = ({str(c.of): c for c in prove(m, weak).checks}["joint torque"] for m in (quick, slow))
    assert quick_torque.ratio > 1.0 >= torque.ratio > 0.95
    assert slow.duration > quick.duration


def test_a_case_that_does_not_say_how_long_to_stand_is_asked_for_it(tmp_path: Path):
    text = (Path("cases") / "ur10_wrist" / "case.toml").read_text(encoding="utf-8")
    begin = text.index("[poses]")
    file = tmp_path / "case.toml"
    file.write_text(text[:begin] + text[text.index("[sensor_frame") :], encoding="utf-8")
    assert "poses" in refused("poses", file)


@pytest.mark.slow
def test_poses_chosen_by_hand_are_worth_less_than_chosen_ones_and_are_compared_with_them(tmp_path: Path):
    case = load_case("ur10_wrist")
    offsets = [(0, 0), (45, 0), (-45, 0), (0, 45), (0, -45), (45, 45), (45, -45), (-45, 45), (-45, -45), (20, 20)]
    rows = np.rad2deg(case.chain.home) + [[0, 0, 0, a, b, 0] for a, b in offsets]
    file = tmp_path / "hand.csv"
    file.write_text("\n".join([",".join(case.limits.motion.columns), *(",".join(map(str, row)) for row in rows)]))
    by_hand = call("poses", "ur10_wrist", "--at", file, "-o", tmp_path / "hand", "--json").json()
    chosen = call(
        "poses", "ur10_wrist", "--count", len(rows), "--candidates", 512, "-o", tmp_path / "chosen", "--json"
    ).json()
    assert by_hand["count"] == len(rows)
    assert by_hand["efficiency"] < 0.85 < chosen["efficiency"]
    both = call("compare", tmp_path / "hand", tmp_path / "chosen", "-o", tmp_path / "both", "--json").json()
    assert len(both["rows"]) == 2
    rows[3, 1] += 90.0
    file.write_text("\n".join([",".join(case.limits.motion.columns), *(",".join(map(str, row)) for row in rows)]))
    assert "pose 4" in refused("poses", "ur10_wrist", "--at", file, "-o", tmp_path / "no")
