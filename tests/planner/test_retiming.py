"""Re-timed motions: whole controller cycles, the same poses, limits kept."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.base.errors import HexciteError, InfeasiblePlan
from cases.schema import load_case
from identification.limits.proof import prove
from identification.machines.path_timing import retime as timed_path
from identification.machines.path_timing import rounded
from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Joined, Standstill
from identification.motion.moves import CircularMove, Plane, StraightMove, fastest_profile
from planner.families.manual import fastest_within_limits
from planner.plans.plan import Plan
from planner.retiming import Way, as_fast_as_possible, by_controller, force_shares
from tests.helpers import few
from tests.hexcite.command_line import call, refused
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
        ends = [p.at([0.0, p.duration]).coordinates for p in (before, part)]
        assert np.allclose(ends[0], ends[1], atol=1e-12)


def test_what_a_controller_makes_of_a_hasty_plan_satisfies_the_limits_of_coordinates_and_struts():
    hasty = moves(1.4)
    passed = [str(c.of) for c in prove(hasty, CASE).violations]
    assert {"velocity", "acceleration", "jerk"} <= set(passed)
    after = by_controller(hasty, CASE, "moves")
    assert prove(after, CASE).kept
    assert after.duration > hasty.duration


@pytest.mark.repeats
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
    pose = after.at(np.linspace(0.0, after.duration, 50)).coordinates
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


@pytest.mark.repeats
def test_a_path_keeps_its_pace_where_it_satisfies_every_limit_and_else_its_way(series: Path):
    motion: Any = Plan.load(series).motion
    kept: Any = fastest_within_limits(CASE, motion.slowed, "series", "")
    assert np.array_equal(kept.a, motion.a)
    case = changed(CASE, limits__motion__velocity_mm_s=[200.0] * 3)
    slower = fastest_within_limits(case, motion.slowed, "series", "")
    report, pace = prove(slower, case), motion.duration / slower.duration
    assert report.kept
    assert report.worst_ratio > 0.99
    t = np.linspace(0.0, motion.duration, 100)
    assert np.allclose(slower.at(t / pace).coordinates, motion.at(t).coordinates, atol=1e-12)


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


def test_toppra_runs_moves_and_paths_as_fast_as_all_limits_but_jerk_allow_and_keeps_their_way(series: Path):
    """Moves that need time for jerk become faster; somewhere along them a limit is used up."""
    for motion in (moves(1.0), Plan.load(series).motion):
        after, steps = as_fast_as_possible(motion, CASE, "path", "jerk")
        assert after.duration < motion.duration
        assert steps > 0.0
        report = prove(after, CASE)
        assert {c.kind.family for c in report.violations} == {"jerk"}
        others = [c.ratio for c in report.checks if c.kind.family != "jerk"]
        assert 0.98 < max(others) <= 1.0
        ends = after.at([0.0, after.duration])
        assert np.abs(ends.rates).max() < 1e-9
        way = motion.at(np.linspace(0.0, motion.duration, 4000)).coordinates[:, :3]
        for place in after.at(np.linspace(0.0, after.duration, 300)).coordinates[:, :3]:
            assert np.linalg.norm(way - place, axis=1).min() < 1.5e-3  # half a step of `way`, and the rounding


@pytest.mark.repeats
def test_pauses_stay_as_long_as_they_are():
    after, _ = as_fast_as_possible(Joined((*moves(1.0).parts[:-1], Standstill(HOME, 2.0))), CASE, "moves", "jerk")
    tail = after.at(np.linspace(after.duration - 1.9, after.duration, 50))
    assert np.abs(tail.rates).max() < 1e-9


def test_a_force_that_follows_the_acceleration_slows_down_as_a_limit_of_it_does():
    """A force of a mass, and of its weight: m (a + g) within m A / 2 + m g is an acceleration within A / 2 one way."""
    own = CASE.without_jerk()
    path = StraightMove.fastest(HOME, HOME + np.array([0.2, 0.0, 0.0, 0.0, 0.0, 0.0]), BOX.rate, BOX.acceleration)
    half = 0.5 * BOX.acceleration[0]

    def forces(pose: np.ndarray, rates: np.ndarray, accelerations: np.ndarray) -> np.ndarray:
        return (accelerations[:, :1] + 9.81) / (half + 9.81)

    way = Way(path)
    free, held = (timed_path(way, own, 10.0, f) for f in (None, forces))
    assert free.duration == pytest.approx(path.duration, rel=0.01)
    largest = held.at(np.linspace(0.0, held.duration, 5000)).accelerations[:, 0]
    assert largest.max() == pytest.approx(half, rel=0.01)
    assert largest.min() == pytest.approx(-BOX.acceleration[0], rel=0.01)  # braking may be as hard as before
    assert held.duration > free.duration


def test_forces_that_come_close_are_those_of_the_machine():
    arm = load_case("ur10_wrist")
    home, box = arm.need_motion("this test")
    shares = force_shares(arm)
    assert shares is not None
    still = np.zeros((1, len(home)))
    now, faster = (shares(home[None], still, scale * box.acceleration[None])[0] for scale in (0.0, 1.0))
    assert np.abs(faster - now).max() > 0.01
    assert shares(home[None], still, 2 * box.acceleration[None])[0] - now == pytest.approx(2 * (faster - now), abs=1e-9)


def test_a_limit_of_jerk_is_left_out_by_name_only(by_hand: Path, tmp_path: Path):
    line = refused("retime", by_hand, "--with", "toppra", "-o", tmp_path / "after")
    for word in ("jerk", "--without jerk", "--with ruckig"):
        assert word in line
    assert "--with toppra" in refused("retime", by_hand, "--without", "jerk")
    assert "choose ruckig, toppra" in refused("retime", by_hand, "--with", "magic")


@pytest.mark.repeats
def test_what_toppra_timed_is_a_plan_that_says_so_and_can_be_posted(by_hand: Path, tmp_path: Path):
    out = tmp_path / "after"
    answer = call("retime", by_hand, "--with", "toppra", "--without", "jerk", "-o", out, "--json").json()
    assert answer["method"] == "toppra"
    assert answer["after"]["duration_s"] < answer["before"]["duration_s"]
    saved = Plan.load(out)
    assert saved.without == ("jerk",)
    assert {str(c.status) for c in saved.limits.checks if c.kind.family == "jerk"} == {"left out, as planned"}
    accept = ("--accept", "acceleration,strut-acceleration,sensor-force,strut-velocity,velocity")
    program = call("post", out, *accept, "--dialect", "linuxcnc", "-o", tmp_path / "run.ngc", "--json").json()
    assert program["excitation_s"] > 0.99 * saved.motion.duration  # its blocks may need more time
    assert "leaves out as planned: jerk" in (tmp_path / "run.ngc").read_text(encoding="utf-8")
    assert "jerk" in refused("post", out, "--dialect", "sinumerik", "-o", tmp_path / "run.mpf")  # which limits it


def test_a_rounded_motion_is_a_mean_that_exceeds_nothing():
    steps = StraightMove.fastest(HOME, HOME + WAYS[0], BOX.rate, BOX.acceleration)
    after = PolynomialMotion.of_pieces(rounded(steps, 0.02, 0.01))
    assert after.duration == pytest.approx(steps.duration + 0.02)
    t = np.linspace(0.0, after.duration, 5000)
    before, now = steps.at(np.linspace(0.0, steps.duration, 5000)), after.at(t)
    assert np.all(np.abs(now.rates) <= np.abs(before.rates).max(axis=0) * 1.001)
    assert np.all(np.abs(now.accelerations) <= np.abs(before.accelerations).max(axis=0) * 1.1)
    window = np.linspace(-0.01, 0.01, 201)
    for middle in (0.05, 0.3 * after.duration, after.duration / 2):
        times = np.clip(middle - 0.01 + window, 0.0, steps.duration)
        assert after.at([middle]).coordinates[0] == pytest.approx(steps.at(times).coordinates.mean(axis=0), abs=2e-5)
