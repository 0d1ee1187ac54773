"""Re-timed motions: whole controller cycles, the same poses, limits kept; and a table of poses is a motion."""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cases.errors import FileProblem, HexciteError, InfeasiblePlan
from cases.loading import load_case
from identification.limits import prove
from identification.model import identification_model
from identification.motion import Joined, Standstill, TimedPoints, sample
from identification.trajectories.circle import CircularMove, Plane
from identification.trajectories.profile import StraightMove, fastest_profile
from planner.families.settings import Manual
from planner.plan_folder import load_plan
from planner.plans import motion_csv
from planner.request import Request
from planner.retiming.retimed import RetimingMethod, by_controller, fitting_method, retimed
from planner.retiming.retimed_plan import read_motion, retimed_plan
from tests.planner.command_line import call, refused
from tests.postprocessors.changed_case import changed

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 0)
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
    after, slowed = by_controller(plan, CASE)
    assert slowed == 0  # the coordinates' limits are the narrower ones here
    for part in after.parts:
        assert part.duration / 1e-3 == pytest.approx(round(part.duration / 1e-3), abs=1e-6)
    assert after.parts[-1].duration == pytest.approx(0.124)
    assert after.duration < plan.duration
    for before, part in zip(plan.parts, after.parts, strict=True):
        ends = [p.at([0.0, p.duration]).pose for p in (before, part)]
        assert np.allclose(*ends, atol=1e-12)


def test_what_a_controller_makes_of_a_hasty_plan_keeps_the_limits_of_coordinates_and_struts():
    found = retimed(moves(1.4), CASE, MODEL, RetimingMethod.RUCKIG, False)
    passed = [c.name.split(" (")[0] for c in found.before.limits.violations]
    assert {"velocity", "acceleration", "jerk"} <= set(passed)
    assert found.after.limits.kept
    assert found.after.duration > found.before.duration
    assert found.after.criteria["D"] < found.before.criteria["D"]  # who slows down learns less


def test_moves_are_as_slow_as_their_struts_need_and_no_slower():
    case = slow_struts()
    after, slowed = by_controller(moves(1.0), case)
    assert 0 < slowed < len(after.parts)
    report = prove(after, case)
    assert report.kept
    assert max(c.ratio for c in report.checks if c.name.startswith("strut velocity")) > 0.99
    assert retimed(moves(1.0), case, MODEL, RetimingMethod.RUCKIG, False).remarks[0].startswith(f"{slowed} of 7 moves")


def slow_struts():
    drives = {f"controller__{name}__ptp": None for name in ("sinumerik", "twincat")}  # they would be too fast
    return changed(CASE, limits__motion__strut_velocity_m_s=0.5, **drives)


def test_toppra_is_named_where_it_is_missing(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "toppra.algorithm", None)
    with pytest.raises(HexciteError, match=r"toppra.* is not installed; install it"):
        retimed(moves(1.0), CASE, MODEL, RetimingMethod.TOPPRA, False)


def test_arcs_keep_their_circle():
    law = fastest_profile(1.0, 1.0, 5.0, 50.0)
    arc = CircularMove(HOME, HOME[3:], Plane.XY, np.array([0.1, 0.0]), 2 * np.pi, law)
    (after,) = by_controller(Joined((arc,)), CASE)[0].parts
    assert law.duration <= after.duration <= law.duration + 1.001e-3
    pose = after.at(np.linspace(0.0, after.duration, 50)).pose
    assert np.allclose(np.hypot(pose[:, 0] - 0.1, pose[:, 1]), 0.1)


def test_toppra_slows_a_hasty_motion_down_and_says_what_it_would_have_passed():
    case = slow_struts()
    found = retimed(moves(1.0), case, MODEL, RetimingMethod.TOPPRA, False)
    assert "strut velocity" in {c.name.split(" (")[0] for c in found.before.limits.violations}
    left = {c.name.split(" (")[0] for c in found.after.limits.violations}
    assert left <= {"jerk", "angular jerk"}  # toppra does not know jerk
    assert found.after.criteria.keys() == set("ADKN")
    assert 0.0 < found.after.d_efficiency < found.before.d_efficiency < 1.0


def test_each_kind_of_motion_has_its_method():
    assert fitting_method(moves(1.0)) is RetimingMethod.RUCKIG
    assert fitting_method(TimedPoints.through(np.arange(6.0), np.tile(HOME, (6, 1)))) is RetimingMethod.IPOPT


def test_a_continuous_path_is_nothing_for_ruckig():
    points = TimedPoints.through(np.arange(6.0), np.tile(HOME, (6, 1)))
    with pytest.raises(InfeasiblePlan, match="use --method ipopt"):
        retimed(points, CASE, MODEL, RetimingMethod.RUCKIG, False)
    with pytest.raises(InfeasiblePlan, match="use --method ipopt"):
        retimed(Joined((points,)), CASE, MODEL, RetimingMethod.RUCKIG, False)


def test_a_case_without_controller_settings_is_refused():
    with pytest.raises(HexciteError, match="controller"):
        by_controller(moves(1.0), replace_controller())


def replace_controller():
    data = CASE.model_dump(exclude_none=True)
    del data["controller"]
    return type(CASE).model_validate(data)


def written(folder: Path) -> Path:
    file = folder / "motion.csv"
    file.write_text(motion_csv(sample(slowed_moves(), 100.0), CASE))
    return file


def test_a_table_is_read_back_as_the_motion_it_is(tmp_path: Path):
    motion, back = slowed_moves(), read_motion(written(tmp_path))
    t = np.linspace(0.0, motion.duration, 300)
    assert back.duration == pytest.approx(motion.duration, abs=1e-6)
    assert np.abs(back.at(t).pose - motion.at(t).pose).max() < 1e-4


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda lines: [lines[0].replace("b_deg", "pitch"), *lines[1:]], ("line 1", "b_deg")),
        (lambda lines: [*lines[:5], lines[5].replace(",", ",x", 1), *lines[6:]], ("line 6", "x_mm", "not a number")),
        (lambda lines: [*lines[:5], "0.04,1,2", *lines[6:]], ("line 6", "not a number")),
        (lambda lines: [*lines[:5], lines[5].replace(",", ",nan,", 1), *lines[6:]], ("line 6", "not a number")),
        (lambda lines: [*lines[:7], lines[6], *lines[7:]], ("line 8", "does not increase")),
        (lambda lines: lines[:3], ("holds 2 poses",)),
        (lambda lines: [], ("line 1", "t_s")),
    ],
)
def test_a_damaged_table_is_refused_by_line(damage, words: tuple[str, ...], tmp_path: Path):
    file = written(tmp_path)
    file.write_text("\n".join(damage(file.read_text().splitlines())))
    with pytest.raises(FileProblem) as caught:
        read_motion(file)
    for word in words:
        assert word in str(caught.value)


def test_the_command_tells_before_and_after(cache: Path, tmp_path: Path):
    out = tmp_path / "after.csv"
    arguments = (written(tmp_path), "--case", "hexapod", "--model", 0)
    answer = call("retime", *arguments, "--method", "toppra", "--fastest", "--json", "-o", out).json()
    assert answer["method"] == "toppra"
    assert not answer["jerk_limited"]
    assert answer["after"]["duration_s"] < answer["before"]["duration_s"]
    assert answer["after"]["d_efficiency"] > answer["before"]["d_efficiency"]
    assert read_motion(out).duration == pytest.approx(answer["after"]["duration_s"], abs=1e-6)
    told = call("retime", *arguments, "--method", "toppra")
    assert told.code == 0
    assert "no jerk limit" in told.out
    assert "before" in told.out


@pytest.mark.parametrize("family", ["manual", "table"])
def test_a_retimed_motion_is_a_plan_that_can_be_posted(family: str, cache: Path, tmp_path: Path):
    """Moves as a controller times them, and a table of poses as a spline."""
    source = written(tmp_path)
    if family == "manual":
        poses = tmp_path / "poses.csv"
        poses.write_text(POSES)
        by_hand = ("--family", "manual", "--sequence", poses, "--model", 0)
        assert call("plan", "hexapod", *by_hand, "-o", tmp_path / "by hand").code == 0
        source = tmp_path / "by hand"
    out = tmp_path / "after"
    which = () if family == "manual" else ("--case", "hexapod", "--model", 0, "--fastest")
    answer = call("retime", source, *which, "-o", out, "--json").json()
    assert answer["method"] == ("ruckig" if family == "manual" else "ipopt")
    assert answer["plan"] == str(out)
    assert answer["jerk_limited"]
    assert answer["after"]["violations"] == []
    saved = load_plan(out)  # its figures are those of its motion
    assert saved.motion.duration == pytest.approx(answer["after"]["duration_s"], abs=1e-6)
    assert saved.worth.d_efficiency == pytest.approx(answer["after"]["d_efficiency"], rel=1e-3)
    assert any(note.startswith(f"re-timed with {answer['method']}") for note in saved.worth.notes)
    assert "re-timed with" in (out / "report.html").read_text(encoding="utf-8")
    accept = ("--accept", "acceleration,jerk,strut-acceleration,sensor-force,strut-velocity,velocity")
    program = call("post", out, *accept, "-o", tmp_path / "run.ngc", "--json").json()
    assert program["excitation_s"] == pytest.approx(saved.motion.duration, rel=1e-2)


def test_a_plan_that_passes_a_limit_is_not_written(tmp_path: Path):
    far = StraightMove.fastest(HOME, HOME + np.array([0.0, 0.0, 0.15, 0.0, 0.0, 0.0]), *LIMITS)
    found = retimed(Joined((*slowed_moves().parts, far)), CASE, MODEL, RetimingMethod.RUCKIG, False)
    request = Request(Manual(), model=0)
    with pytest.raises(InfeasiblePlan, match="is no plan: position"):
        retimed_plan(found, request, CASE, tmp_path, 0.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--case", "hexapod", "--method", "magic"), ("magic", "ruckig, ipopt, toppra")),
        (("--case", "hexapod", "--method", "ruckig"), ("use --method ipopt",)),
        (("--case", "hexapod", "--method", "ruckig", "--fastest"), ("--fastest",)),
        (("--case", "hexapod", "--model", 11), ("model 11",)),
        (("--case", "ft_wrist"), ("machine",)),
        ((), ("--case",)),
        (("--case", "hexapod", "--method", "toppra", "-o", "folder"), ("folder", "--method ipopt", "after.csv")),
        (("--case", "hexapod", "-o", "after.txt"), ("after.txt", ".csv")),
    ],
)
def test_bad_requests_are_refused_in_one_line(
    arguments: tuple[object, ...], words: tuple[str, ...], cache: Path, tmp_path: Path
):
    line = refused("retime", written(tmp_path), *arguments)
    for word in words:
        assert word in line


def test_what_is_not_there_is_refused(tmp_path: Path):
    assert "cannot be read" in refused("retime", tmp_path / "none.csv", "--case", "hexapod")
    assert "plan.json" in refused("retime", tmp_path)
