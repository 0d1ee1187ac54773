"""What `hexcite case check` notices beside errors: what commands miss, values of other machines, mistaken units."""

import json
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cases.base.errors import CaseError
from cases.readiness import NEEDS, readiness
from cases.scaffold import new_case
from cases.schema import Case, load_case
from cases.tables import built_in_cases
from hexcite.reports.case_figures import leftovers
from planner.families.settings import Fourier
from planner.plans.making import require_plannable
from planner.request import Request
from tests.helpers import tells
from tests.hexcite.command_line import call, refused


def own(change: Callable[[Any], object] = lambda data: None) -> Case:
    """A machine begun from the hexapod."""
    data = tomllib.loads(built_in_cases()["hexapod"].read_text(encoding="utf-8")) | {"name": "mine"}
    change(data)
    return Case.model_validate(data)


def mine(tmp_path: Path, *changes: tuple[str, str]) -> Path:
    file = tmp_path / "case.toml"
    text = built_in_cases()["hexapod"].read_text(encoding="utf-8").replace('name = "hexapod"', 'name = "mine"')
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    file.write_text(text, encoding="utf-8")
    return file


def test_built_in_cases_are_as_they_are_meant() -> None:
    assert [leftovers(load_case(name)) for name in built_in_cases()] == [()] * len(built_in_cases())


@pytest.mark.first(2)
@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda _: None, "machine, workspace, limits, .*: still the values of the built-in case hexapod"),
        (lambda d: d.update(gravity_m_s2=[0.0, 0.0, 9.81]), r"gravity points down: change its sign"),
        (
            lambda d: d["workspace"].update(base_joint_angle_deg=0.96),
            "base_joint_angle_deg = 0.96: .* looks like radians",
        ),
        (
            lambda d: d["limits"]["motion"].update({f"{k}_deg": [-0.3, 0.3] for k in "abc"}),
            "motion.a_deg, b_deg, c_deg .* radians",
        ),
        (lambda d: d["machine"]["home"].update(z_mm=0.9), "machine.home.z_mm = 0.9: .* looks like metres"),
        (
            lambda d: d["machine"]["base"]["ring"].update(half_angle_deg=0.21),
            "base.ring.half_angle_deg = 0.21: .* radians",
        ),
    ],
)
def test_what_is_hardly_meant_is_noticed(change: Callable[[Any], object], says: str) -> None:
    assert any(re.search(says, sentence) for sentence in leftovers(own(change)))


def test_what_each_command_misses_is_said_before_it_is_tried() -> None:
    case = own(lambda d: d.pop("nominal"))
    missing = readiness(case)
    assert set(missing) == set(NEEDS)
    assert missing["plan"] == ("nominal",)
    assert missing["bound"] == ()
    with pytest.raises(CaseError, match="nominal: is missing"):
        require_plannable(Request(Fourier()), case)


def test_a_dialects_table_is_needed_for_that_dialect_only() -> None:
    case = own(lambda d: d["controller"].pop("linuxcnc"))
    missing = readiness(case)
    assert missing["post --dialect linuxcnc"] == ("controller.linuxcnc",)
    assert missing["post --dialect sinumerik"] == missing["plan"] == ()


def test_movej_needs_six_joints_that_turn_between_ends() -> None:
    assert readiness(load_case("five_axis_table"))["post --dialect urscript"] == ("six joints that turn between ends",)
    assert readiness(load_case("ur10_wrist"))["post --dialect urscript"] == ()


def test_a_validation_needs_the_language_of_its_programs() -> None:
    """Any that limits jerk: a user of TwinCAT is not asked for the settings of SINUMERIK."""
    assert readiness(own(lambda d: d["controller"].pop("sinumerik")))["validate"] == ()
    neither = own(lambda d: [d["controller"].pop(name) for name in ("sinumerik", "twincat")])
    assert readiness(neither)["validate"] == ("controller.sinumerik or controller.twincat",)
    assert readiness(own(lambda d: d.pop("controller")))["validate"] == ("controller",)


def test_case_check_prints_both(tmp_path: Path) -> None:
    file = mine(tmp_path)
    answer = call("case", "check", file, "--json").json()
    assert answer["missing"]["plan"] == []
    remark = next(remark for remark in answer["remarks"] if "built-in case" in remark)
    for table in ("machine", "sensor_frame", "simulation", "payloads"):
        assert table in remark.split(":")[0].split(", ")
    assert "look at machine" in call("case", "check", file).out


def test_values_of_the_template_are_named_key_by_key(tmp_path: Path) -> None:
    folder = new_case("mill", "hexapod", tmp_path / "mill").parent
    file = folder / "case.toml"
    text = file.read_text(encoding="utf-8")
    for old, new in (
        ("radius_mm = 700.0", "radius_mm = 500.0"),
        ("strut_velocity_m_s = 1.0", "strut_velocity_m_s = 0.9"),
    ):
        assert old in text
        text = text.replace(old, new, 1)
    file.write_text(text, encoding="utf-8")
    whole, keys = (r for r in call("case", "check", folder, "--json").json()["remarks"] if "built-in case" in r)
    assert "workspace" in whole.split(":")[0].split(", ")
    assert "machine" not in whole.split(":")[0].split(", ")
    named = keys.split(":")[0].split(", ")
    assert {"machine.base.ring.half_angle_deg", "limits.motion.strut_acceleration_m_s2"} <= set(named)
    assert not {"machine.base.ring.radius_mm", "limits.motion.strut_velocity_m_s", "machine.base.ring.z_mm"} & set(
        named
    )
    before = load_case(str(file))
    file.write_text(text.replace('template = "hexapod"\n', ""), encoding="utf-8")
    assert load_case(str(file)).hash == before.hash
    assert "delete the line" in keys
    assert "delete the line" not in call("case", "check", folder).out


def test_what_contradicts_something_is_a_line_of_every_command(tmp_path: Path) -> None:
    """Once, on standard error; built-in cases say nothing, `case check` says it among its remarks."""
    file = mine(tmp_path, ("acceleration_m_s2 = [6.0, 6.0, 6.0]", "acceleration_m_s2 = [6000.0, 6000.0, 6000.0]"))
    doubt, refusal = call("check", tmp_path / "none.ngc", "--case", file).err.splitlines()
    assert tells(doubt, f"hexcite: {file}: look at", "acceleration_m_s2 = [6000, ", "velocity_mm_s", "[6, 6, 6]")
    assert "none.ngc" in refusal
    assert "none.ngc" in refused("check", tmp_path / "none.ngc", "--case", "hexapod")
    checked = call("case", "check", file)
    assert "acceleration_m_s2 = [6000" in checked.out
    assert checked.err == ""


def test_a_frame_in_metres_is_noticed_though_its_forces_keep_the_machine_from_home(tmp_path: Path) -> None:
    frame = (("146.0", "0.146"), ("171.0", "0.171"), ("z_mm = 9.0", "z_mm = 0.009"), ("z_mm = 121.0", "z_mm = 0.121"))
    answer = call("case", "check", mine(tmp_path, *frame))
    assert answer.code == 1
    assert "sensor force" in answer.refusal()
    assert re.search(r"sensor_frame\.bars\.lower\.ring\.radius_mm = 0\.14.* metres", answer.refusal())


def test_case_check_says_once_what_several_commands_miss() -> None:
    told = [line for line in call("case", "check", "ft_wrist").out.splitlines() if line.startswith("not ready for")]
    lacks = [line.split("misses ")[1] for line in told]
    assert len(lacks) == len(set(lacks)) < 10
    (dialects,) = [line for line in told if "sinumerik" in line]
    assert "twincat" in dialects


@pytest.mark.parametrize("command", [("case", "check"), ("plan",), ("case", "check", "--json")])
def test_every_command_lists_all_problems_each_in_a_line(command: tuple[str, ...], tmp_path: Path) -> None:
    file = mine(
        tmp_path, ("mass_kg = ", "mass = "), ("settle_s = ", "settle = "), ("range_N = 5000.0", "range_N = -1.0")
    )
    answer = call(*command, file)
    assert answer.code == 1
    lines = answer.err.splitlines()
    assert len(lines) == 3
    if "--json" in command:
        error = json.loads(answer.out)["error"]
        assert (error["code"], error["place"]) == ("wrong_kind", f"{file}: nominal.mass")
        assert [f"hexcite: {file}: {problem}" for problem in error["problems"]] == lines
    else:
        assert answer.out == ""
    assert all(line.startswith(f"hexcite: {file}: ") for line in lines)
    assert tells(answer.err, "nominal.mass", "mass_kg")
    assert tells(answer.err, "sensors.range_N", "-1.0", "greater than 0")


def test_rules_of_the_whole_case_are_all_told(tmp_path: Path) -> None:
    file = mine(tmp_path, ("safe_feed_mm_min = ", "safe_feed_mm_min = 999"))
    text = file.read_text(encoding="utf-8")
    motion = text.index("[limits.motion]")
    start = text.index("x_mm = [", motion)
    file.write_text(text[:start] + "x_mm = [-5000.0, 5000.0]" + text[text.index("\n", start) :], encoding="utf-8")
    problems = call("case", "check", file).err.splitlines()
    assert len(problems) == 2
    assert any("safe_feed_mm_min" in problem for problem in problems)
    assert any("limits.motion.x_mm" in problem for problem in problems)


@pytest.mark.parametrize(
    ("new", "says"),
    [
        ("range_N = 5000,0", "is not TOML: .*decimal points"),
        ('range_N = "5000,0"', "'5000,0': is not a number, without quotes and with a point"),
    ],
)
def test_decimal_commas_are_told_as_such(new: str, says: str, tmp_path: Path) -> None:
    assert re.search(says, refused("case", "check", mine(tmp_path, ("range_N = 5000.0", new))))


def test_a_decimal_comma_in_a_list_is_told_as_such(tmp_path: Path) -> None:
    line = refused("case", "check", mine(tmp_path, ("gravity_m_s2 = [0.0, 0.0, -9.8", "gravity_m_s2 = [0, 0, -9,8")))
    assert "decimal comma" in line
