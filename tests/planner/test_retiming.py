"""Re-timed motions: whole controller cycles, the same poses, limits kept."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cases.errors import HexciteError, InfeasiblePlan
from cases.schema import load_case
from identification.limit_proof import prove
from identification.motion import Joined, Standstill
from identification.trajectories.moves import CircularMove, Plane, StraightMove, fastest_profile
from planner.families.manual import fastest_within_limits
from planner.plans import Plan
from planner.retiming import by_controller
from tests.helpers import few
from tests.planner.command_line import call, refused
from tests.postprocessors.changed_case import changed

CASE = load_case("hexapod")
HOME = CASE.machine.home.vector
BOX = CASE.limits.motion
WAYS = np.array(
    [
        [0.2, 0.1, -0.05, 0.3, -0.2, 0.1],
        [-0.2, 0.2, 0.08, -0.3, 0.3, -0.1],
        [0.1, -0.2, 0.0, 0.2, 0.1, 0.3],
        [-0.1, -0.1, -0.08, -0.1, -0.3, -0.3],
        [0.0, 0.2, 0.05, 0.0, 0.3, 0.0],
    ]
)


LIMITS = (BOX.rate, BOX.acceleration, BOX.jerk)
POSES = """x_mm,y_mm,z_mm,a_deg,b_deg,c_deg
100,50,920,10,-5,5
-100,80,870,-10,10,-5
50,-100,910,5,-10,10
0,60,880,0,12,-10
"""


def moves(hurry: float) -> Joined:
    """A closed sequence of moves, `hurry` times as fast as the coordinates may, and a pause."""
    poses = HOME + np.vstack([np.zeros(6), WAYS, np.zeros(6)])
    limits = (BOX.rate * hurry, BOX.acceleration * hurry**2, BOX.jerk * hurry**3)
    return Joined((*(StraightMove.fastest(a, b, *limits) for a, b in pairwise(poses)), Standstill(HOME, 0.1234)))


def slowed_moves() -> Joined:
    return moves(0.8)


def test_a_controller_takes_whole_cycles_and_is_faster_than_a_slow_plan():
    plan = slowed_moves()
    after = by_controller(plan, CASE, "moves")
    for part in after.parts:
        assert part.duration / 1e-3 == pytest.approx(round(part.duration / 1e-3), abs=1e-6)
    assert after.parts[-1].duration == pytest.approx(0.124)
    assert after.duration < plan.duration
    for before, part in zip(plan.parts, after.parts, strict=True):
        ends = [p.at([0.0, p.duration]).pose for p in (before, part)]
        assert np.allclose(*ends, atol=1e-12)


def test_what_a_controller_makes_of_a_hasty_plan_satisfies_the_limits_of_coordinates_and_struts():
    hasty = moves(1.4)
    passed = [str(c.of) for c in prove(hasty, CASE).violations]
    assert {"velocity", "acceleration", "jerk"} <= set(passed)
    after = by_controller(hasty, CASE, "moves")
    assert prove(after, CASE).kept
    assert after.duration > hasty.duration


def test_moves_are_as_slow_as_their_struts_need_and_no_slower():
    case = slow_struts()
    report = prove(by_controller(moves(1.0), case, "moves"), case)
    assert report.kept
    assert max(c.ratio for c in report.checks if c.kind == "strut velocity") > 0.99


def slow_struts():
    return changed(CASE, limits__motion__strut_velocity_m_s=0.5)


def test_arcs_keep_their_circle():
    law = fastest_profile(1.0, 0.5, 2.0, 10.0)
    arc = CircularMove(HOME, HOME[3:], Plane.XY, np.array([0.1, 0.0]), 2 * np.pi, law)
    (after,) = by_controller(Joined((arc,)), CASE, "arc").parts
    assert law.duration <= after.duration <= law.duration + 1.001e-3
    pose = after.at(np.linspace(0.0, after.duration, 50)).pose
    assert np.allclose(np.hypot(pose[:, 0] - 0.1, pose[:, 1]), 0.1)


def test_a_case_without_controller_settings_is_refused():
    with pytest.raises(HexciteError, match="controller"):
        by_controller(moves(1.0), replace_controller(), "moves")


def replace_controller():
    data = CASE.model_dump(exclude_none=True)
    del data["controller"]
    return type(CASE).model_validate(data)


@pytest.fixture(scope="module")
def by_hand(cache: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan of moves."""
    folder = tmp_path_factory.mktemp("by-hand")
    (folder / "poses.csv").write_text(POSES)
    words = ("--family", "manual", "--sequence", folder / "poses.csv", "--model", 0)
    assert call("plan", "hexapod", *words, "-o", folder / "plan").code == 0
    return folder / "plan"


@pytest.fixture(scope="module")
def series(cache: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan of a path that is not a sequence of moves, with room for another pace."""
    folder = tmp_path_factory.mktemp("series") / "plan"
    words = ("--family", "fourier", "--order", 2, "--duration", 3, "--starts", 1)
    assert call("plan", "hexapod", *words, "-o", folder).code == 0
    return folder


def test_the_command_prints_before_and_after(by_hand: Path):
    answer = call("retime", by_hand, "--json").json()
    assert answer["plan"] is None
    assert answer["after"]["duration_s"] >= answer["before"]["duration_s"] - 1e-3
    said = call("retime", by_hand)
    assert said.code == 0
    head, *rows = said.out.splitlines()[-5:]
    assert head.split() == ["before", "after"]
    assert [row.split()[0] for row in rows][:3] == ["duration_s", "criterion_value", "d_efficiency"]


def test_a_move_that_leaves_the_box_is_refused():
    far = StraightMove.fastest(HOME, HOME + np.array([0.0, 0.0, 0.15, 0.0, 0.0, 0.0]), *LIMITS)
    with pytest.raises(InfeasiblePlan, match=r"moves, move 8: .*position .*no pace helps"):
        by_controller(Joined((*slowed_moves().parts, far)), CASE, "moves")


def test_a_path_keeps_its_pace_where_it_satisfies_every_limit_and_else_its_way(series: Path):
    motion = Plan.load(series).motion
    assert np.array_equal(fastest_within_limits(CASE, motion.slowed, "series", "").a, motion.a)
    case = changed(CASE, limits__motion__velocity_mm_s=[200.0] * 3)
    slower = fastest_within_limits(case, motion.slowed, "series", "")
    report, pace = prove(slower, case), motion.duration / slower.duration
    assert report.kept
    assert report.worst_ratio > 0.99
    t = np.linspace(0.0, motion.duration, 100)
    assert np.allclose(slower.at(t / pace).pose, motion.at(t).pose, atol=1e-12)


@pytest.mark.parametrize("method", few("ruckig", "one slower pace"))
def test_a_retimed_motion_is_a_plan_that_can_be_posted(method: str, request: pytest.FixtureRequest, tmp_path: Path):
    out = tmp_path / "after"
    source = request.getfixturevalue("by_hand" if method == "ruckig" else "series")
    answer = call("retime", source, "-o", out, "--json").json()
    assert answer["method"] == method
    assert answer["plan"] == str(out)
    saved = Plan.load(out)  # its figures are those of its motion
    assert saved.motion.duration == pytest.approx(answer["after"]["duration_s"], abs=1e-6)
    assert saved.worth.d_efficiency == pytest.approx(answer["after"]["d_efficiency"], rel=1e-3)
    assert "retimed_with" in (out / "report.html").read_text(encoding="utf-8")
    accept = ("--accept", "acceleration,jerk,strut-acceleration,sensor-force,strut-velocity,velocity")
    program = call("post", out, *accept, "-o", tmp_path / "run.ngc", "--json").json()
    assert program["excitation_s"] == pytest.approx(saved.motion.duration, rel=1e-2)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--case", "ft_wrist"), ("machine",)),
    ],
)
def test_bad_requests_are_refused_in_one_line(arguments: tuple[object, ...], words: tuple[str, ...], planned: dict):
    line = refused("retime", planned["plan"], *arguments)
    for word in words:
        assert word in line


def test_what_is_not_there_is_refused(tmp_path: Path):
    assert "cannot be read" in refused("retime", tmp_path / "none")
    assert "plan.json" in refused("retime", tmp_path)
