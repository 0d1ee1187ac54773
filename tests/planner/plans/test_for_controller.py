"""Plans made for the controller that runs them: what it makes of their moves, and what is said of jerks."""

import json
import math
import shutil
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.base.errors import CaseError, Code
from cases.schema import Case, load_case
from hexcite._write import usual_dialect
from identification.limits.limit import Status
from identification.limits.proof import prove
from identification.motion.motion import Joined
from identification.motion.moves import StraightMove, has_steps
from planner.controller_limits import controlled, with_steps
from planner.families.settings import PointToPoint, Spline
from planner.plans.folder import motion_entries, motion_of_entries
from planner.plans.plan import Plan
from tests.helpers import polynomials_of
from tests.hexcite.command_line import call, refused
from tests.postprocessors.changed_case import changed

SECONDS, MOVES = 3.0, 14
PLAN: tuple[Any, ...] = (
    "plan",
    "hexapod",
    "--family",
    "ptp",
    "--for",
    "linuxcnc",
    "--without",
    "jerk",
    "--duration",
    SECONDS,
)
PLAN = (*PLAN, "--starts", 1)
ACCEPT = ("--accept", "jerk,strut-velocity,strut-acceleration,sensor-force")  # of other plans than such
PLACES = np.array([[0.0, 0.0, 0.9, 0, 0, 0], [0.1, -0.1, 0.95, 0.1, 0, 0.2], [-0.1, 0.1, 0.9, 0, 0.2, 0]])


@pytest.fixture(scope="module")
def plan(shared: Path, once: Callable[[str, Callable[[], Any]], Any]) -> dict[str, Any]:
    """The answer of a plan of trapezoids; its folder is `shared/steps`."""
    return once("steps", lambda: call(*PLAN, "-o", shared / "steps", "--json").json())


@pytest.fixture(scope="module")
def folder(plan: dict[str, Any]) -> Path:
    return Path(plan["plan"])


def trapezoids(case: Case) -> Joined:
    """Two moves as fast as the limits of rates and accelerations allow, less a hundredth."""
    box = case.limits.motion
    pairs = pairwise(PLACES)
    return Joined(tuple(StraightMove.fastest(a, b, 0.98 * box.rate, 0.98 * box.acceleration) for a, b in pairs))


@pytest.mark.parametrize(("controller", "steps"), [("linuxcnc", 1e-3), *((name, 0.0) for name in
                         ("virtual", "sinumerik", "twincat", "setpoints"))])  # fmt: skip
def test_jerks_count_unless_the_controller_does_not_limit_them(controller: str, steps: float, hexapod_case: Case):
    own, step_time = controlled(hexapod_case, controller)
    assert step_time == steps
    assert own.limits.motion.limits_jerk == (steps == 0.0)
    assert hexapod_case.limits.motion.limits_jerk
    assert own.hash == hexapod_case.hash or steps


def test_twincat_without_a_slope_has_steps(hexapod_case: Case):
    case = changed(hexapod_case, controller__twincat__slope="STEP")
    assert controlled(case, "twincat")[1] == 2e-3


def test_the_case_says_for_whom_to_plan(hexapod_case: Case):
    wishes = hexapod_case.controller.model_copy(update={"plan_for": "linuxcnc"})
    case = hexapod_case.model_copy(update={"controller": wishes})
    assert PointToPoint().made_for(case) == "linuxcnc"
    assert PointToPoint(controller="sinumerik").made_for(case) == "sinumerik"
    assert Spline().made_for(case) is None
    assert PointToPoint().made_for(hexapod_case) is None


@pytest.mark.parametrize(
    ("name", "controller"), [("hexapod", "ros2"), ("hexapod", "urscript"), ("ur10_wrist", "sinumerik")]
)
def test_a_controller_of_other_machines_is_refused_before_anything_is_searched(name: str, controller: str) -> None:
    family = PointToPoint(controller=controller, without="jerk" if controller == "urscript" else None)
    with pytest.raises(CaseError, match=controller) as raised:
        family.require_plannable(load_case(name), 12.0)
    assert (raised.value.key, raised.value.code) == ("machine", Code.NOT_SUPPORTED)


@pytest.mark.parametrize(
    ("name", "keeps", "steps"),
    [
        ("hexapod", "sinumerik", "linuxcnc"),
        ("five_axis_table", "setpoints", "linuxcnc"),
        ("ur10_wrist", "setpoints", "urscript"),
        ("strut_sensors", "setpoints", "linuxcnc"),
    ],
)
def test_a_plan_is_written_for_a_controller_that_keeps_what_it_keeps(name: str, keeps: str, steps: str) -> None:
    case = load_case(name)
    assert usual_dialect(case) == keeps
    assert usual_dialect(case, steps=True) == steps


def test_shorter_moves_are_more_moves(hexapod_case: Case):
    """At 6 m/s^2 it takes 0.1 s to 0.6 m/s, at 10 rad/s^2 0.105 s to 60 deg/s, and as long to rest again."""
    own, _ = controlled(hexapod_case, "linuxcnc")
    assert PointToPoint().count(own, 12.0) == round(12.0 / (2 * math.radians(60) / 10.0))
    assert PointToPoint().count(hexapod_case, 12.0) == 40
    assert PointToPoint(moves=20).count(own, 12.0) == 20
    assert PointToPoint().count(own, 60.0) == 64


def test_the_proof_sees_steps_of_acceleration(hexapod_case: Case):
    """The derivative is 0 before and after a step; what the case limits is exceeded in between."""
    motion = trapezoids(hexapod_case)
    report = prove(motion, hexapod_case)
    assert sorted(str(v.of) for v in report.violations) == ["angular jerk", "jerk"]
    own, step_time = controlled(hexapod_case, "linuxcnc")
    told = with_steps(report, step_time)
    assert told.kept
    jerk = next(c for c in told.checks if c.kind == "jerk")
    assert jerk.status is Status.LEFT_OUT
    parts: Any = motion.parts
    largest = max(part.profile.acceleration * np.abs(part.end - part.start)[:3].max() for part in parts)
    assert largest / 1e-3 <= abs(jerk.worst) <= 2 * largest / 1e-3 * (1 + 1e-9)  # from one side to the other in a cycle
    assert jerk.ratio == pytest.approx(abs(jerk.worst) / jerk.limit if jerk.worst > 0 else jerk.worst / jerk.limit)
    assert "jerk" not in "".join(c.name for c in prove(motion, own).checks)
    assert told.worst_ratio == pytest.approx(prove(motion, own).worst_ratio)


def test_trapezoids_are_read_back_as_they_were_saved(hexapod_case: Case):
    motion = trapezoids(hexapod_case)
    entries = json.loads(json.dumps(motion_entries(motion)))
    again = motion_of_entries(entries)
    t = np.linspace(0.0, motion.duration, 501)
    assert has_steps(again)
    for one, other in zip(motion.at(t).coordinates.T, again.at(t).coordinates.T, strict=True):
        assert one == pytest.approx(other, abs=1e-15)
    entries["moves"][0]["hold_time_s"] = 0.0  # nothing would accelerate
    with pytest.raises(ValueError, match=r"moves\[0\]"):
        motion_of_entries(entries)


def test_trapezoids_are_polynomials_of_the_second_degree(hexapod_case: Case):
    motion = trapezoids(hexapod_case)
    pieces = polynomials_of([part for part in motion.parts if isinstance(part, StraightMove)])
    assert not pieces.table[3:].any()
    t = np.linspace(0.0, motion.duration, 997)
    assert pieces.at(t).coordinates == pytest.approx(motion.at(t).coordinates, abs=1e-12)
    assert pieces.at(t).rates == pytest.approx(motion.at(t).rates, abs=1e-10)


def test_a_plan_says_what_is_not_limited_and_for_whom_it_is(plan: dict[str, Any], folder: Path):
    assert plan["settings"]["made_for"] == "linuxcnc"
    assert plan["settings"]["moves"] == MOVES
    for name in ("jerk", "angular jerk"):
        assert plan["limits"][name]["status"] == "left out, as planned"
        assert plan["limits"][name]["ratio"] > 10.0
        assert not any(name in entry for entry in plan["bound_by"])
    assert all(v["ratio"] <= 1.0 for name, v in plan["limits"].items() if "jerk" not in name)
    assert any("made for linuxcnc" in note and "100 m/s^3" in note for note in plan["notes"])
    saved = Plan.load(folder)
    assert saved.motion.duration == pytest.approx(SECONDS)
    assert has_steps(saved.motion)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_plan(plan: dict[str, Any], tmp_path: Path):
    again = call(*PLAN, "-o", tmp_path / "again", "--json").json()
    own, other = ({k: v for k, v in answer.items() if k in ("moves", "logdet", "limits")} for answer in (plan, again))
    assert own == other


@pytest.mark.slow
def test_it_carries_more_information_than_limited_jerk_does(plan: dict[str, Any], tmp_path: Path):
    words = [*PLAN[:4], "--for", "virtual", *PLAN[8:], "--moves", 10, "-o", tmp_path / "smooth", "--json"]
    smooth = call(*words).json()
    assert plan["d_efficiency"] > 1.2 * smooth["d_efficiency"]
    assert smooth["limits"]["jerk"]["status"] == "proven"
    assert not any("made for" in note for note in smooth["notes"])


@pytest.mark.repeats
def test_a_program_is_written_for_the_controller_that_the_plan_is_made_for(folder: Path, tmp_path: Path):
    answer = call("post", folder, "-o", tmp_path / "run.ngc", "--json").json()
    assert answer["dialect"] == "linuxcnc"
    assert answer["excitation_s"] == pytest.approx(SECONDS, rel=1e-5)
    assert answer["remarks"] == []
    ran = call("run", tmp_path / "run.ngc", "--case", "hexapod", "--on", "virtual", "-o", tmp_path / "rec", "--json")
    planned = json.loads((folder / "plan.json").read_text())["d_efficiency"]
    assert ran.json()["d_efficiency"] > 0.95 * planned


def test_a_program_says_what_its_plan_leaves_out_and_needs_no_leave_for_it(folder: Path, tmp_path: Path):
    """What its header says is read by whoever checks it; a program of no such plan relies on nobody for its jerk."""
    program = tmp_path / "run.ngc"
    assert call("post", folder, "-o", program).code == 0
    answer = call("check", program, "--case", "hexapod", "--json").json()
    assert answer["without"] == ["jerk"]
    assert "jerk" not in answer["relies_on"]
    assert answer["verdict"].startswith("proven, without jerk as planned")
    foreign = tmp_path / "foreign.ngc"
    lines = program.read_text().splitlines(keepends=True)
    foreign.write_text("".join(line for line in lines if "leaves out" not in line))
    told = call("check", foreign, "--case", "hexapod", "--json").json()
    assert told["without"] == []
    assert "jerk" in told["relies_on"]


def test_strut_limits_follow_from_what_linuxcnc_enforces(folder: Path, tmp_path: Path):
    answer = call("post", folder, "-o", tmp_path / "run.ngc", "--json").json()
    check = answer["limits"]["strut acceleration, untimed moves"]
    assert check["status"] == "follows from what the controller enforces"
    assert check["ratio"] <= 1.0
    assert answer["relies_on"] == []


@pytest.mark.repeats
def test_a_plan_without_jerk_says_what_the_same_moves_take_with_it(plan: dict[str, Any], folder: Path):
    note = next(note for note in plan["notes"] if "limited jerk" in note)
    seconds, efficiency = (
        float(word.rstrip(",")) for word in note.split() if word.rstrip(",").replace(".", "").isdigit()
    )
    assert seconds > 1.1 * SECONDS
    assert efficiency < plan["d_efficiency"]
    retimed = call("retime", folder, "-o", folder.parent / "within-jerk", "--json").json()["after"]
    assert retimed["duration_s"] == pytest.approx(seconds, rel=0.03)  # in whole cycles


@pytest.mark.parametrize(("dialect", "file"), [("sinumerik", "p.mpf"), ("twincat", "p.nc"), ("setpoints", "p.csv")])
def test_moves_with_steps_are_no_program_of_a_controller_that_limits_jerk(
    dialect: str, file: str, folder: Path, tmp_path: Path
):
    line = refused("post", folder, "--dialect", dialect, "-o", tmp_path / file)
    for words in ("made for linuxcnc", f"--for {dialect}", "hexcite retime"):
        assert words in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.repeats
def test_retimed_they_have_limited_jerk_and_go_anywhere(folder: Path, tmp_path: Path):
    done = call("retime", folder, "-o", tmp_path / "smooth", "--json").json()
    assert done["after"]["duration_s"] > SECONDS
    saved = Plan.load(tmp_path / "smooth")
    assert not has_steps(saved.motion)
    assert call("post", tmp_path / "smooth", "--dialect", "sinumerik", "-o", tmp_path / "p.mpf").code == 0
    assert call("post", tmp_path / "smooth", *ACCEPT, "-o", tmp_path / "p.ngc").code == 0


def test_a_motion_with_an_edited_law_is_not_believed(folder: Path, tmp_path: Path):
    edited = tmp_path / "edited"
    shutil.copytree(folder, edited)
    data = json.loads((edited / "plan.json").read_text())
    for move in data["moves"]:
        move["jerk_time_s"], move["hold_time_s"] = move["hold_time_s"] / 2, 0.0
    (edited / "plan.json").write_text(json.dumps(data))
    assert "plan again" in refused("post", edited, "-o", tmp_path / "run.ngc")


@pytest.mark.slow
@pytest.mark.linuxcnc
def test_linuxcnc_runs_it_as_planned(folder: Path, plan: dict[str, Any], tmp_path: Path):
    assert call("post", folder, *ACCEPT, "-o", tmp_path / "run.ngc").code == 0
    words = ("run", tmp_path / "run.ngc", "--case", "hexapod", "--on", "linuxcnc", "-o", tmp_path / "rec", "--json")
    ran = call(*words).json()
    assert ran["duration_s"] == pytest.approx(SECONDS, rel=5e-3)
    assert ran["d_efficiency"] > 0.95 * plan["d_efficiency"]
    about = json.loads((tmp_path / "rec" / "recording.json").read_text())
    assert max(about["peaks_of_limit"].values()) <= 1.001


@pytest.mark.slow
@pytest.mark.linuxcnc
def test_forty_moves_are_executed_with_most_of_what_was_planned(tmp_path: Path):
    plan = (
        "plan",
        "hexapod",
        "--for",
        "linuxcnc",
        "--without",
        "jerk",
        "--moves",
        40,
        "--starts",
        1,
        "-o",
        tmp_path / "plan",
    )
    assert call(*plan).code == 0
    assert call("post", tmp_path / "plan", *ACCEPT, "-o", tmp_path / "run.ngc").code == 0
    words = ("run", tmp_path / "run.ngc", "--case", "hexapod", "--on", "linuxcnc", "-o", tmp_path / "rec", "--json")
    ran = call(*words).json()
    assert ran["d_efficiency"] >= 0.60
    assert ran["duration_s"] == pytest.approx(12.0, rel=5e-3)
    about = json.loads((tmp_path / "rec" / "recording.json").read_text())
    assert max(about["peaks_of_limit"].values()) <= 1.001
