"""Cases with a chain of joints: arrays in SI, and one line for each mistake."""

import re
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import CaseError
from cases.schema import load_case
from tests.helpers import one_line

GANTRY = """
schema_version = 1
name = "gantry"
title = "A slide that carries a wrist"
setup = "R"
gravity_m_s2 = [0.0, 0.0, -9.81]
[machine.chain]
joints = [
    { name = "slide", kind = "prismatic", axis = [2.0, 0.0, 0.0], position_mm = [0.0, 800.0], home_mm = 300.0 },
    { name = "lift", kind = "revolute", origin_mm = [0.0, 0.0, 500.0], axis = [0.0, 1.0, 0.0], position_deg = [-90.0, 90.0], home_deg = 30.0 },
    { name = "wrist", kind = "continuous", origin_mm = [250.0, 0.0, 0.0], rpy_deg = [0.0, 90.0, 0.0], axis = [0.0, 0.0, 1.0], home_deg = 0.0 },
]
sensor = { origin_mm = [0.0, 0.0, 40.0] }
[limits.motion]
joints = [
    { name = "slide", position_mm = [-200.0, 200.0], velocity_mm_s = 500.0, acceleration_m_s2 = 4.0, jerk_m_s3 = 60.0 },
    { name = "lift", position_deg = [-50.0, 40.0], velocity_deg_s = 90.0, acceleration_rad_s2 = 5.0, jerk_rad_s3 = 80.0 },
    { name = "wrist", position_deg = [-170.0, 170.0], velocity_deg_s = 180.0, acceleration_rad_s2 = 8.0, jerk_rad_s3 = 99.0 },
]
[sensor_frame.transducer]
sense = "load_on_sensor"
[sensors]
weights = "per_unit"
[recording]
"""  # noqa: E501

MISTAKES = {
    "no unit": ("home_mm = 300.0", "home = 300.0", "machine.chain.joints[1].home: has no unit.*home_mm"),
    "unknown key": ("velocity_mm_s = 500.0", "speed = 1.0", "limits.motion.joints[1].speed: .*unknown key"),
    "unknown kind": ('"continuous"', '"floating"', "joints[3].kind: 'floating'"),
    "no axis": ("axis = [2.0, 0.0, 0.0]", "axis = [0.0, 0.0, 0.0]", "joints[1].axis: has no direction"),
    "nan": ("[2.0, 0.0, 0.0]", "[nan, 0.0, 0.0]", "joints[1].axis[1]: nan.*finite"),
    "no range": ("position_deg = [-90.0, 90.0], ", "", "lift: position_deg missing; limits of motion"),
    "ends of a continuous one": ('"revolute"', '"continuous"', "lift: is continuous and has no position_deg"),
    "the other unit": ("home_deg = 30.0", "home_mm = 30.0", "lift: is revolute and has no home_mm"),
    "no home": (", home_deg = 30.0", "", "machine.chain.joints: lift: home_deg missing; limits of motion"),
    "home outside": ("home_deg = 30.0", "home_deg = 130.0", "home_deg = 130 is outside position_deg"),
    "swapped": ("[-90.0, 90.0]", "[90.0, -90.0]", "joints[2].position_deg: lower limit 90"),
    "one name twice": ('"wrist", kind', '"lift", kind', "machine.chain.joints: has two joints lift"),
    "a name with a blank": ('"wrist", kind', '"my wrist", kind', "joints[3].name: 'my wrist'"),
    "no joints": ("sensor = {", "joinst = {", "machine.chain.joinst: is an unknown key.*joints"),
    "another joint": ('"lift", position', '"left", position', "limits.motion.joints are slide, left, wrist; list"),
    "an angle for a length": (
        "position_mm = [-200.0, 200.0], velocity_mm_s = 500.0, acceleration_m_s2 = 4.0, jerk_m_s3 = 60.0",
        "position_deg = [-2.0, 2.0], velocity_deg_s = 5.0, acceleration_rad_s2 = 4.0, jerk_rad_s3 = 60.0",
        "slide is prismatic; give the keys",
    ),
    "both units": ("velocity_mm_s = 500.0", "velocity_deg_s = 500.0", "slide: velocity_deg_s stand beside .*; give"),
    "no jerk": (", jerk_rad_s3 = 80.0", "", "lift: jerk_rad_s3 or jerk_deg_s3 not stated; add"),
    "box beyond the joint": ("[-50.0, 40.0]", "[-50.0, 70.0]", "lift moves from -20 to 100, beyond -90 to 90"),
    "jerk in both units": ("jerk_rad_s3 = 80.0", "jerk_rad_s3 = 80.0, jerk_deg_s3 = 1.0", "_s3 and .*; remove one"),
    "box without home": ("[-50.0, 40.0]", "[10.0, 40.0]", "lift: position_deg does not contain 0"),
    "negative speed": ("velocity_mm_s = 500.0", "velocity_mm_s = -5.0", "joints[1].velocity_mm_s: -5.0.*greater"),
    "another setup": ('setup = "R"', 'setup = "1b"', "machine.chain, go with a force/torque sensor"),
    "limits of a pose": ("[limits.motion]\njoints", "[limits.motion]\nbox", "limits.motion.box: is an unknown key"),
}  # fmt: skip


def written(folder: Path, text: str) -> str:
    file = folder / "case.toml"
    file.write_text(text, encoding="utf-8")
    return str(file)


def test_coordinates_and_limits_come_in_si(tmp_path: Path) -> None:
    case = load_case(written(tmp_path, GANTRY))
    home, limits = case.need_motion("a test")
    np.testing.assert_allclose(home, [0.3, np.pi / 6, 0.0])
    np.testing.assert_allclose(limits.coordinates, [[-0.2, *np.radians([-50, -170])], [0.2, *np.radians([40, 170])]])
    np.testing.assert_allclose(limits.rate, [0.5, np.pi / 2, np.pi])
    np.testing.assert_allclose(limits.acceleration, [4.0, 5.0, 8.0])
    np.testing.assert_allclose(limits.jerk, [60.0, 80.0, 99.0])
    chain, _ = case.need_chain("a test")
    assert chain.names == ("slide", "lift", "wrist")
    np.testing.assert_allclose(chain.position, [[0.0, -np.pi / 2, -np.inf], [0.8, np.pi / 2, np.inf]])


def test_degrees_of_accelerations_and_jerks_are_the_same_limits(tmp_path: Path) -> None:
    before = load_case(written(tmp_path, GANTRY)).need_motion("a test")[1]
    text = re.sub(
        r"(acceleration|jerk)_rad_(s\d) = ([\d.]+)",
        lambda m: f"{m[1]}_deg_{m[2]} = {float(np.degrees(float(m[3])))!r}",
        GANTRY,
    )
    limits = load_case(written(tmp_path, text)).need_motion("a test")[1]
    np.testing.assert_allclose(limits.acceleration, before.acceleration, rtol=1e-14)
    np.testing.assert_allclose(limits.jerk, before.jerk, rtol=1e-14)
    assert np.isinf(limits.with_jerk(np.full(len(limits.jerk), np.inf)).jerk).all()


def test_home_may_lie_on_a_limit(tmp_path: Path) -> None:
    limits = load_case(written(tmp_path, GANTRY.replace("[-50.0, 40.0]", "[0.0, 40.0]"))).need_motion("a test")[1]
    assert limits.coordinates[0, 1] == 0.0


def test_without_jerk_all_else_stays(tmp_path: Path) -> None:
    limits = load_case(written(tmp_path, GANTRY)).need_motion("a test")[1]
    free = limits.with_jerk(np.full(len(limits.jerk), np.inf))
    assert limits.limits_jerk
    assert not free.limits_jerk
    assert np.isinf(free.jerk).all()
    for name in ("coordinates", "rate", "acceleration"):
        np.testing.assert_array_equal(getattr(free, name), getattr(limits, name))


def test_a_hexapod_has_the_same_words(tmp_path: Path) -> None:
    case = load_case("hexapod")
    home, limits = case.need_motion("a test")
    np.testing.assert_array_equal(home, case.machine.home.vector)
    assert limits is case.limits.motion
    with pytest.raises(CaseError, match="machine: is a hexapod, and a test is for a chain"):
        case.need_chain("a test")


def test_what_only_a_hexapod_can_do_is_refused_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"machine\.chain: .*validation.*hexapods") as caught:
        load_case(written(tmp_path, GANTRY)).need_machine("a validation")
    one_line(caught.value)


def test_a_case_of_a_hexapod_with_the_limits_of_joints(tmp_path: Path) -> None:
    start, end = GANTRY.index("[machine.chain]"), GANTRY.index("[limits.motion]")
    with pytest.raises(CaseError, match=r"add \[machine\.chain\]") as caught:
        load_case(written(tmp_path, GANTRY[:start] + GANTRY[end:]))
    one_line(caught.value)


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_in_one_line(mistake: str, tmp_path: Path) -> None:
    old, new, words = MISTAKES[mistake]
    assert old in GANTRY
    with pytest.raises(CaseError, match=re.sub(r"\[(\d)\]", r"\\[\1\\]", words)) as caught:
        load_case(written(tmp_path, GANTRY.replace(old, new, 1)))
    message = one_line(caught.value)
    assert "<" not in message.removeprefix(str(tmp_path))
