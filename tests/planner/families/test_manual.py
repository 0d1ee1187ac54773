"""Hand-made motions: what the file says, as fast as the limits allow, or one line that says why not."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hexcite as hx
from cases.base.errors import HexciteError
from cases.schema import Case
from identification.limits.proof import prove
from identification.motion.motion import Standstill
from identification.motion.moves import CircularMove, StraightMove
from planner.families.manual import in_turn, manual_motion, sequence_file
from planner.families.settings import IN_TURN
from tests.helpers import one_line, tells
from tests.hexcite.command_line import call, refused

HOME = np.array([0.0, 0.0, 0.9, 0.0, 0.0, 0.0])


def written(folder: Path, text: str, name: str = "steps.toml") -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.slow
def test_the_sequence_of_section_7_keeps_every_limit_and_touches_one(hexapod_case: Case):
    """Each axis alone, inclinations, all six axes, and one circle in each Cartesian plane."""
    motion = manual_motion(hexapod_case, sequence_file(hexapod_case))
    report = prove(motion, hexapod_case)
    assert report.kept
    assert report.worst_ratio > 0.99
    ways = np.array([np.abs(p.end - p.start) > 0 for p in motion.parts if isinstance(p, StraightMove)])
    for axis in range(6):
        assert (ways[ways.sum(axis=1) == 1][:, axis]).sum() >= 3
    assert ways.all(axis=1).sum() >= 3
    assert {p.plane.value for p in motion.parts if isinstance(p, CircularMove)} == {"XY", "ZX", "YZ"}
    ends = motion.at([0.0, motion.duration])
    assert np.allclose(ends.coordinates, HOME, atol=1e-12)
    assert np.abs(ends.rates).max() < 1e-12


def test_steps_do_what_they_say(hexapod_case: Case, tmp_path: Path):
    file = written(
        tmp_path, 'title = "t"\nsteps = [{x_mm = 100.0}, {pause_s = 0.5}, {circle = "XY", radius_mm = 50.0}]'
    )
    move, pause, circle, back = manual_motion(hexapod_case, file).parts
    assert move.at([move.duration]).coordinates[0] == pytest.approx([0.1, 0, 0.9, 0, 0, 0])
    assert isinstance(pause, Standstill)
    assert pause.duration == 0.5
    places = circle.at(np.linspace(0, circle.duration, 50)).coordinates
    assert np.hypot(places[:, 0] - 0.05, places[:, 1]) == pytest.approx(0.05)
    assert back.at([back.duration]).coordinates[0] == pytest.approx(HOME)


def test_half_the_speed_takes_twice_the_time(hexapod_case: Case, tmp_path: Path):
    times = []
    for speed in (1.0, 0.5):
        file = written(tmp_path, f'title = "t"\nsteps = [{{x_mm = 100.0, speed = {speed}}}]')
        times.append(manual_motion(hexapod_case, file).parts[0].duration)
    assert times[1] == pytest.approx(2 * times[0], rel=1e-3)


def test_a_list_of_poses_is_visited_in_order_and_left_for_home(hexapod_case: Case, tmp_path: Path):
    table = "x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\n100,0,900,0,0,0\n0,50,950,5,0,-5\n"
    motion = manual_motion(hexapod_case, written(tmp_path, table, "poses.csv"))
    corners = motion.at(motion.starts).coordinates
    assert corners[1, :3] == pytest.approx([0.1, 0.0, 0.9])
    assert corners[2] == pytest.approx([0.0, 0.05, 0.95, *np.radians([5, 0, -5])])
    assert corners[3] == pytest.approx(HOME)
    assert prove(motion, hexapod_case).kept


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("steps = [", "is not TOML"),
        ('title = "t"', "steps"),
        ('title = "t"\nsteps = []', "steps"),
        ('title = "t"\nsteps = [{}, {}]', "nothing moves"),
        ('title = "t"\nsteps = [{x_mm = 10.0}, {x = 1.0}]', "steps[2].x: has no unit"),
        ('title = "t"\nsteps = [{circle = "XY"}]', "a circle needs circle and radius_mm"),
        ('title = "t"\nsteps = [{circle = "AB", radius_mm = 3.0}]', "steps[1].circle"),
        ('title = "t"\nsteps = [{x_mm = 3.0, pause_s = 1.0}]', "not several"),
        ('title = "t"\nsteps = [{x_mm = nan}]', "steps[1].x_mm"),
        ('title = "t"\nsteps = [{x_mm = 3.0, speed = 1.5}]', "steps[1].speed"),
        ('title = "t"\nsteps = [{x_mm = 10.0}, {x_mm = 400.0}]', "step 2: position (x) reaches 400 mm"),
        ('title = "t"\nsteps = [{x_mm = 1e12}]', "step 1: position (x) reaches 1e+12 mm, limit 250"),
        ('title = "t"\nsteps = [{circle = "ZX", radius_mm = 150.0}]', "step 1: position (z)"),
        ('title = "t"\nsteps = [{circle = "YZ", radius_mm = 1e9}]', "step 1: position (z) reaches 1e+09 mm, limit 100"),
    ],
)
def test_a_file_that_cannot_be_moved_names_the_step(text: str, words: str, hexapod_case: Case, tmp_path: Path):
    file = written(tmp_path, text)
    with pytest.raises(HexciteError) as caught:
        manual_motion(hexapod_case, file)
    assert words in one_line(caught.value)
    assert str(file) in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "column x_mm is missing"),
        ("x_mm,y_mm\n1,2\n", "column z_mm is missing"),
        ("x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\n", "0 poses"),
        ("x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\n0,0,900,0,0,0\n0,0,900,0,0\n", "pose 2"),
        ("x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\n0,0,nan,0,0,0\n", "pose 1"),
        ("x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\n0,0,0,0,0,0\n", "step 1: position (z)"),
        ("x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\n0,0,900,0,0,1e30\n", "step 1: angle (c) reaches 1e+30 deg, limit 20"),
    ],
)
def test_a_list_that_holds_no_poses_says_where(text: str, words: str, hexapod_case: Case, tmp_path: Path):
    with pytest.raises(HexciteError) as caught:
        manual_motion(hexapod_case, written(tmp_path, text, "poses.csv"))
    assert words in one_line(caught.value)


def test_a_motion_of_hours_is_refused_before_it_is_proven(tmp_path: Path):
    file = written(tmp_path, 'title = "t"\nsteps = [{x_mm = 50.0}, {pause_s = 1e9}]')
    line = refused("plan", "hexapod", "--family", "manual", "--sequence", file, "-o", tmp_path / "plan", "--json")
    assert tells(line, "steps.toml: ", "1000000001 s", "600 s", "take steps out")


def test_the_command_writes_a_proven_plan_that_loads_again(tmp_path: Path):
    file = written(tmp_path, 'title = "t"\nsteps = [{x_mm = 50.0}, {circle = "YZ", radius_mm = 40.0}, {a_deg = 10.0}]')
    plan = call(
        "plan", "hexapod", "--family", "manual", "--sequence", file, "--model", 0, "-o", tmp_path / "plan", "--json"
    ).json()
    assert (plan["family"], plan["status"], plan["starts"]) == ("manual", "proven", [])
    assert [m["kind"] for m in plan["moves"]] == ["straight", "circle", "straight", "straight"]
    assert plan["predicted_std"]["m"] > 0.0


def test_a_motion_that_does_not_excite_the_model_is_refused_and_nothing_is_written(tmp_path: Path):
    """Inertia cannot come from translations."""
    file = written(tmp_path, 'title = "t"\nsteps = [{x_mm = 50.0}, {y_mm = 50.0}]')
    plan = ("plan", "hexapod", "--family", "manual", "--sequence", file, "-o", tmp_path / "plan", "--json")
    line = refused(*plan)
    assert f"{file}: rank " in line
    assert "I11" in line
    assert not (tmp_path / "plan").exists()


def moves_of(motion: Any) -> Any:
    """Its moves, one after the other."""
    return motion.parts


def test_a_machine_without_a_sequence_moves_each_coordinate_to_both_ends(hexapod_case: Case):
    """Each alone, up, down and back, then all at once, inside every limit; from home to home."""
    motion = in_turn(hexapod_case)
    ways = np.array([np.abs(part.end - part.start) > 0 for part in moves_of(motion)])
    alone = ways[ways.sum(axis=1) == 1]
    assert (alone.sum(axis=0) == 3).all()
    assert (ways.sum(axis=1) == 6).sum() == 3
    assert prove(motion, hexapod_case).kept
    assert motion.at([0.0, motion.duration]).coordinates == pytest.approx(np.tile(HOME, (2, 1)))


@pytest.mark.parametrize("name", [pytest.param("ur10_wrist", marks=pytest.mark.slow), "five_axis_table"])
def test_every_kind_of_machine_has_a_hand_made_motion_that_determines_its_parameters(name: str):
    """So that an optimal excitation has something to be compared with, without a file."""
    plan = hx.plan(hx.load_case(name), hx.Manual())
    assert plan.limits.kept
    assert plan.settings.source == IN_TURN
    assert 0.0 < plan.worth.d_efficiency < 0.5


def test_a_box_that_cannot_be_reached_is_moved_in_as_far_as_it_can(hexapod_case: Case):
    """A way that ends outside the struts' strokes is shortened, the others stay as they are."""
    motion = hexapod_case.limits.model_copy(
        update={"motion": hexapod_case.limits.motion.model_copy(update={"z_mm": (-900.0, 900.0)})}
    )
    wide = hexapod_case.model_copy(update={"limits": motion})
    heights = np.vstack([part.end for part in moves_of(in_turn(wide))])[:, 2] - HOME[2]
    assert 0.08 < heights.max() < 0.89
    assert prove(in_turn(wide), wide).kept
