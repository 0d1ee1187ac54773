"""A run beside its plan: what was different is said with numbers, and of sound runs nothing is said.

Recordings are made from motions of known difference, on a hexapod, a robot, and a five-axis table; forces are noise.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

import hexcite as hx
from cases.base.units import DEG, MM
from cases.schema import Case, load_case
from identification.finding import Finding
from identification.findings.as_planned import as_planned
from identification.findings.plan_comparison import closest
from identification.identify import identify
from identification.machines.executed import Execution
from identification.machines.of_case import machine_of
from identification.motion.motion import Joined, Motion, Slowed, Standstill, Trajectory
from identification.motion.moves import StraightMove, limits_along, ruckig_profile
from identification.recording.recording import Recording
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, few, seeds, tells

Array = NDArray[np.float64]
STEP = 0.002  # [s] of the recordings
MACHINES = "hexapod", "ur10_wrist", "five_axis_table"


@dataclass(frozen=True)
class Planned:
    """A plan as the comparison asks for it."""

    motion: Trajectory
    name: str = "plan"
    poses: Array = field(default_factory=lambda: np.zeros((0, 6)))


@dataclass(frozen=True)
class Changed:
    """A motion in another time, or at another place."""

    motion: Trajectory
    duration: float
    time: Callable[[Array], Array] = lambda t: t
    by: float | Array = 0.0

    def at(self, t: ArrayLike) -> Motion:
        motion = self.motion.at(np.clip(self.time(np.asarray(t, dtype=float)), 0.0, self.motion.duration))
        return replace(motion, coordinates=motion.coordinates + self.by)


def corners(case: Case, count: int = 8, seed: int = 0) -> Array:
    """Poses about home, inside the limits of a machine."""
    home, limits = case.need_motion("a test")
    size = np.where(limits.turns, 12.0 * DEG, 60.0 * MM)
    return home + np.random.default_rng(seed).uniform(-1.0, 1.0, (count, len(home))) * size


def moves(case: Case, poses: Array, jerk: float = 40.0, stay: float = 0.0) -> Joined:
    """Straight moves from pose to pose, with a stay at each but the ends."""
    speed = np.where(case.need_motion("a test")[1].turns, 30.0 * DEG, 150.0 * MM)
    parts: list[Trajectory] = []
    for start, end in pairwise(poses):
        law = ruckig_profile(*limits_along(np.abs(end - start), speed, 4.0 * speed, jerk * speed))
        parts += [StraightMove(start, end, law), *([Standstill(end, 0.2 * stay, 0.8 * stay)] if stay else [])]
    return Joined(tuple(parts))


def recorded(case: Case, motion: Trajectory, start: float = -0.5, end: float = 0.5, seed: int = 0) -> Recording:
    """A run of a motion with encoder noise, from `start` of it to `end` behind it [s]; it stands before and after."""
    draw, t = np.random.default_rng(seed), np.arange(start, motion.duration + end, STEP)
    drives = machine_of(case).drives(motion.at(np.clip(t, 0.0, motion.duration)).coordinates)
    noise = draw.normal(0.0, 1e-6, drives.shape)
    return Recording("run", t - t[0], drives + noise, None, draw.normal(size=(len(t), 6)), None)


def said(case: Case, plan: Planned, run: Recording) -> list[str]:
    """Sentences on what was different."""
    return [finding.sentence for finding in as_planned(closest(run, case, plan), plan) if finding.sentence]


def one(case: Case, plan: Planned, run: Recording) -> tuple[str, Finding]:
    """The only sentence, and its finding."""
    findings = as_planned(closest(run, case, plan), plan)
    (found,) = (finding for finding in findings if finding.sentence)
    return found.sentence, found


@pytest.mark.parametrize("name", MACHINES)
@seeds(20)
def test_nothing_is_said_of_sound_runs(name: str, seed: int) -> None:
    """Whatever a recorder cuts off, a controller stretches by some percent, or a time law makes of the same moves."""
    case = load_case(name)
    draw = np.random.default_rng(seed)
    poses = corners(case, 9, seed)
    motion = moves(case, poses)
    plan = Planned(motion)
    home = case.need_motion("a test")[0]
    whole = moves(case, np.vstack([home, poses, home]))
    stretched = Slowed(motion, 1.0 - draw.uniform(0.0, 0.03))
    law = moves(case, poses, jerk=draw.uniform(36.0, 44.0))
    runs = {
        "as planned": recorded(case, motion, seed=seed),
        "cut": recorded(case, motion, 0.1 * draw.uniform(), -0.1 * draw.uniform(), seed),
        "stretched": recorded(case, stretched, seed=seed),
        "from home and back": recorded(case, whole, seed=seed),
        "another law": recorded(case, law, seed=seed),
    }
    jitter = np.sort(runs["as planned"].t + draw.normal(0.0, 0.002, runs["as planned"].rows))
    runs["stamps of a host"] = replace(runs["as planned"], t=jitter)
    for what, run in runs.items():
        assert said(case, plan, run) == [], what


@pytest.mark.repeats
def test_a_circle_is_a_move_and_no_stay_where_it_begins_and_ends() -> None:
    """The motion by hand has circles; a controller takes another time than planned for its corners."""
    case = load_case("hexapod")
    plan = hx.plan(case, hx.Manual())
    run = hx.run(hx.write(plan, "sinumerik"), case, on="virtual", seed=0)
    assert said(case, Planned(plan.motion), run) == []


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("override", few(0.5, 0.8, 1.2, 0.1))
def test_an_override_is_read_off_path_and_time(name: str, override: float) -> None:
    case = load_case(name)
    motion = moves(case, corners(case))
    sentence, found = one(case, Planned(motion), recorded(case, Slowed(motion, override)))
    number, how = re.findall(r"([\d.]+) times (slower|faster)", sentence)[0]
    assert how == ("slower" if override < 1.0 else "faster")
    assert float(number) == pytest.approx(max(override, 1.0 / override), rel=0.01)
    assert tells(sentence, "plan", f"override {100 * override:.0f} %")
    assert found.severity == "warning"
    assert found.quantity["as_planned"]["override_percent"] == pytest.approx([100 * override] * 2, rel=0.02)


def test_a_smooth_motion_is_known_too() -> None:
    case = load_case("hexapod")
    motion = Harmonic(3, duration=3.0, size=0.5)
    assert said(case, Planned(motion), recorded(case, motion)) == []
    sentence, _ = one(case, Planned(motion), recorded(case, Slowed(motion, 0.5)))
    assert tells(sentence, "2.00 times slower", "override 50 %")


def test_an_override_that_was_changed_meanwhile_is_said_with_its_place() -> None:
    case = load_case("hexapod")
    motion = moves(case, corners(case))
    middle = float(motion.starts[4])
    late = Changed(motion, 2 * motion.duration - middle, lambda t: np.where(t < middle, t, (t + middle) / 2))
    sentence, found = one(case, Planned(motion), recorded(case, late))
    assert found.quantity["as_planned"]["times_longer_of_a_part"] == pytest.approx(2.0, rel=0.02)
    assert tells(sentence, "times slower", f"from {middle:.3g} to", "as fast as planned elsewhere")


@pytest.mark.parametrize("name", few(*MACHINES))
def test_another_motion_is_another_program(name: str) -> None:
    case = load_case(name)
    plan = Planned(moves(case, corners(case, seed=1)))
    run = recorded(case, moves(case, corners(case, seed=2)))
    sentence, found = one(case, plan, run)
    assert tells(sentence, "not the motion of the plan plan", "another program ran")
    assert found.severity == "warning"
    (beside,) = as_planned(closest(run, case, [plan]), [plan])  # of which nobody said that it ran
    assert (beside.severity, tells(beside.sentence, "beside it", "its own plan")) == ("note", True)
    own = Planned(moves(case, corners(case, seed=2)), "own")
    (found,) = as_planned(closest(run, case, [plan, own]), [plan, own])
    assert (found.sentence, found.quantity["as_planned"]["plan"]) == ("", "own")


@pytest.mark.repeats
@pytest.mark.parametrize("name", few(*MACHINES))
def test_a_move_that_was_edited_is_named(name: str) -> None:
    case = load_case(name)
    poses = corners(case)
    edited = poses.copy()
    turns = bool(case.need_motion("a test")[1].turns[0])
    edited[4, 0] += 8.0 * DEG if turns else 40.0 * MM
    sentence, _ = one(case, Planned(moves(case, poses)), recorded(case, moves(case, edited)))
    assert tells(sentence, "elsewhere from", "moves 4 to 5 of 7", "changed after planning")


@pytest.mark.parametrize("name", few(*MACHINES))
def test_a_run_that_was_broken_off_or_begun_late_is_said_with_times(name: str) -> None:
    case = load_case(name)
    motion = moves(case, corners(case))
    total = motion.duration
    sentence, _ = one(case, Planned(motion), recorded(case, motion, end=-0.4 * total))
    assert tells(sentence, "the run ends at", f"of its {total:.3g} s", "path is missing")
    assert float(sentence.split("ends at ")[1].split()[0]) == pytest.approx(0.6 * total, abs=0.05 * total)
    sentence, _ = one(case, Planned(motion), recorded(case, motion, start=0.4 * total))
    assert tells(sentence, "the recording begins", f"into its {total:.3g} s", "missing at its start")


@pytest.mark.parametrize("name", MACHINES)
def test_a_shifted_home_is_said_with_its_amount(name: str) -> None:
    case = load_case(name)
    motion = moves(case, corners(case))
    home, limits = case.need_motion("a test")
    by = np.zeros(len(home))
    by[2] = 2.0 * DEG if limits.turns[2] else 5.0 * MM
    sentence, found = one(case, Planned(motion), recorded(case, Changed(motion, motion.duration, by=by)))
    assert tells(sentence, "shifted by", limits.columns[2].rpartition("_")[0])
    shift = found.quantity["as_planned"]["shift"]
    assert shift == {limits.columns[2]: pytest.approx(2.0 if limits.turns[2] else 5.0, rel=0.05)}


@pytest.mark.parametrize("name", few(*MACHINES))
def test_a_pose_that_was_left_out_is_named(name: str) -> None:
    case = load_case(name)
    poses = corners(case, 8)
    plan = Planned(moves(case, poses, stay=0.6), poses=poses[1:])
    assert said(case, plan, recorded(case, plan.motion)) == []
    run = recorded(case, moves(case, np.delete(poses, 4, axis=0), stay=0.6))
    assert tells(one(case, plan, run)[0], "pose 4 was not visited")
    slow = recorded(case, moves(case, poses, jerk=10.0, stay=0.6))
    assert all("visited" not in sentence for sentence in said(case, plan, slow))


def test_what_has_no_clock_or_no_drives_is_not_compared() -> None:
    case = load_case("hexapod")
    plan = Planned(moves(case, corners(case)))
    run = recorded(case, plan.motion)
    for other in (replace(run, t=None), replace(run, drives=None)):
        assert as_planned(closest(other, case, plan), plan) == ()


def test_damage_of_a_recording_is_not_another_program() -> None:
    case = load_case("hexapod")
    plan = Planned(moves(case, corners(case)))
    run = recorded(case, plan.motion)
    leaping, missing = run.drives.copy(), np.zeros(run.rows, dtype=bool)
    leaping[[300, 700, 1100], 2] += 30.0 * MM
    missing[500:520] = True
    assert said(case, plan, replace(run, drives=leaping, missing=missing)) == []
    kept = np.r_[0:600, 640 : run.rows]
    assert said(case, plan, replace(run, t=run.t[kept], drives=run.drives[kept], forces=run.forces[kept])) == []


def test_findings_stand_in_the_result() -> None:
    """Nothing is refused: a slower run is still a run."""
    case = load_case("hexapod")
    plan = Planned(moves(case, corners(case)))
    slow, machine = Slowed(plan.motion, 0.5), machine_of(case)
    drives = machine.drives(slow.at(np.arange(0.0, slow.duration, STEP)).coordinates)
    followed = Execution.of_set_points(machine, STEP, drives)
    run = simulate_recording(case, followed, np.array([[0.0, followed.duration]]), seed=0)
    result = identify(run, case, plan=plan)
    assert any(tells(warning, "2.00 times slower") for warning in result.warnings)
    assert result.record.to_json()["as_planned"]["times_longer"] == pytest.approx(2.0, abs=0.01)
