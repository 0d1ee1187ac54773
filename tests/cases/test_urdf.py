"""Robots from URDF files: the same geometry as MuJoCo reads, and one line for each file that is not sound."""

import re
import time
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.base.errors import MOST_PROBLEMS, CaseError, FileProblem
from cases.readiness import readiness
from cases.schema import load_case
from cases.sensors import RigidBody
from cases.urdf import Arm, read_urdf
from hexcite._new_arm import new_arm
from identification.machines.casadi_batch import over_samples
from identification.machines.serial_chain import SerialChain
from identification.model.model import identification_model
from tests.helpers import examples, one_line
from tests.robots import MIMIC, panda, ur10, urdf

ROBOTS = {"ur10": (ur10(), "tool0"), "panda": (panda(), "tool")}
HOMES = {"ur10": [0.0, -90.0, 90.0, -90.0, -90.0, 0.0], "panda": [0.0, -40.0, 0.0, -120.0, 0.0, 90.0, 45.0]}


def file_with(folder: Path, text: str) -> Path:
    file = folder / "robot.urdf"
    file.write_text(text, encoding="utf-8")
    return file


def filled_in(text: str, homes: list[float]) -> str:
    """The text of a new case with what a URDF does not say."""
    values = iter(homes)
    block = text[text.index("# [[limits") : text.index("# What plans leave free")]
    text = text.replace(block, re.sub(r"^# ", "", block, flags=re.MULTILINE))
    text = re.sub(r"# home_deg = .*", lambda _: f"home_deg = {next(values)}", text)
    for key, value in {"position_deg": "[-5.0, 5.0]", "acceleration_rad_s2": "5.0", "jerk_rad_s3": "50.0"}.items():
        text = re.sub(rf"(# )?\b{key} = .*TO BE.*", f"{key} = {value}", text)
    text = re.sub(r"# (force_noise_N|moment_noise_Nm) = .*", r"\1 = 0.5", text)
    return text.replace('# sense = "load_on_sensor"', 'sense = "load_on_sensor"')


@pytest.mark.parametrize("robot", ROBOTS)
def test_mujoco_reads_the_same_robot(robot: str, tmp_path: Path) -> None:
    text, flange = ROBOTS[robot]
    case_file = new_arm("arm", file_with(tmp_path, text), flange, tmp_path / "arm")
    case_file.write_text(filled_in(case_file.read_text(), HOMES[robot]))
    case = load_case(str(tmp_path / "arm"))
    chain, limits = case.need_chain("a test")
    kept = text.replace("<link ", '<mujoco><compiler fusestatic="false"/></mujoco><link ', 1)
    model = mujoco.MjModel.from_xml_string(kept)
    data = mujoco.MjData(model)
    n = len(chain.joints)
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, k) for k in range(n)]
    assert list(chain.names) == names
    np.testing.assert_allclose(chain.position.T, model.jnt_range[:n], atol=5e-5)  # half of the last digit
    np.testing.assert_allclose(np.degrees(chain.home), HOMES[robot], atol=1e-12)
    assert limits.rate.min() > 2.0
    q = np.random.default_rng(0).uniform(-3.0, 3.0, (20, n))
    position, columns, _, _ = over_samples(SerialChain(chain).motion, q, 0 * q, 0 * q)
    for k in range(len(q)):
        data.qpos[:n] = q[k]
        mujoco.mj_kinematics(model, data)
        np.testing.assert_allclose(position[k], data.body(flange).xpos, atol=1e-12)
        np.testing.assert_allclose(columns[k].reshape(3, 3).T.ravel(), data.body(flange).xmat, atol=1e-12)


def test_evaluation_asks_for_the_sense_alone_and_plans_for_home_and_limits_joint_by_joint(tmp_path: Path) -> None:
    case_file = new_arm("arm", file_with(tmp_path, ur10()), "tool0", tmp_path / "arm")
    bare = load_case(str(tmp_path / "arm"))
    assert readiness(bare)["identify a motion"] == ("sensor_frame.transducer.sense",)
    with pytest.raises(
        CaseError, match=r"sensor_frame\.transducer\.sense: is missing; state .load_on_sensor. if"
    ) as caught:
        identification_model(bare, 6)
    one_line(caught.value)
    text = case_file.read_text().replace('# sense = "load', 'sense = "load')
    case_file.write_text(text)
    lacks = readiness(load_case(str(tmp_path / "arm")))
    assert lacks["identify a motion"] == lacks["identify standstills, force, tare"] == ()
    assert lacks["bound"] == ("machine.chain.joints.home_deg", "limits.motion")
    names = ", ".join(re.findall(r"(\w+_joint)\" type=\"revolute", ur10()))
    homeless = filled_in(text, HOMES["ur10"]).replace("\nhome_deg", "\n# home_deg")
    case_file.write_text(homeless.replace("acceleration_rad_s2 = 5.0", ""))
    with pytest.raises(CaseError) as caught:
        load_case(str(tmp_path / "arm"))
    assert f"{names}: acceleration_rad_s2 or acceleration_deg_s2 not stated" in str(caught.value)
    case_file.write_text(homeless)
    with pytest.raises(CaseError, match=f"machine.chain.joints: {names}: home_deg missing; limits of motion"):
        load_case(str(tmp_path / "arm"))


def test_a_case_that_is_there_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text("mine")
    with pytest.raises(FileProblem, match="exists"):
        new_arm("arm", file_with(tmp_path, ur10()), "tool0", tmp_path)
    assert (tmp_path / "case.toml").read_text() == "mine"


def test_a_flange_that_does_not_exist_lists_those_that_do(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"no link tool1; .*base_link, .*wrist_3, flange, tool0") as caught:
        read_urdf(file_with(tmp_path, ur10()), "tool1")
    one_line(caught.value)


def test_a_fixed_link_behind_a_joint_weighs_with_it_but_the_load_does_not(tmp_path: Path) -> None:
    """The hand hangs on the flange, so it is the load's; the camera is part of the forearm."""
    camera = ("camera_joint", "fixed", "link3", "camera", "0.1 0 0", "0 0 0", "")
    text = panda()
    more = text.replace("</robot>", urdf([camera]).split("<robot")[1].split("\n", 1)[1].replace(LINK3, ""))
    before, after = (read_urdf(file_with(tmp_path, t), "tool").joints for t in (text, more))
    masses = [(b.link.mass_kg, a.link.mass_kg) for (b, _), (a, _) in zip(before, after, strict=True)]
    assert [a - b for b, a in masses] == [0, 0, 1.25, 0, 0, 0, 0]
    assert after[6][0].link.mass_kg == pytest.approx(2.75)


LINK3 = urdf([("camera_joint", "fixed", "link3", "camera", "0.1 0 0", "0 0 0", "")]).splitlines()[2] + "\n"
ELBOW = '<joint name="elbow_joint" type="revolute">'
ELBOW_LIMIT = re.search(r'<limit lower="-3\.14[^>]*>', ur10())[0]
AXIS = '<axis xyz="0 0 1"/>'
WRIST = '<child link="wrist_1"/>'
BROKEN = {
    "reversed": (ELBOW_LIMIT, '<limit lower="3" upper="-3" effort="3" velocity="3"/>', "lower 3, upper -3; "),
    "nan": (ELBOW_LIMIT, '<limit lower="nan" upper="3" effort="3" velocity="3"/>', "lower of .* 'nan'; .* a number"),
    "a name of two words": ("wrist_3_joint", "wrist 3", "joint 'wrist 3' moves, but names have letters"),
    "a name of digits": ("wrist_3_joint", "3", "joint '3' moves, but names have .* a letter among them"),
    "a name of two lines": ('"base_link"', '"base&#10;nominal = 3"', "control characters"),
    "a name without end": ('"tool0"', f'"{"x" * 999}"', "at most 200 characters"),
    "a decimal comma": ('xyz="-0.612 0 0"', 'xyz="-0,612 0 0"', "'-0,612 0 0'; it takes 3 of numbers"),
    "beyond any machine": ('xyz="-0.612 0 0"', 'xyz="-6e99 0 0"', "it takes 3 of numbers up to 1e.06"),
    "two numbers": ('xyz="-0.612 0 0"', 'xyz="-0.612 0"', "origin of joint elbow_joint is '-0.612 0'; it takes 3"),
    "axis 0": (AXIS, '<axis xyz="0 0 0"/>', "axis of joint shoulder_pan_joint has no direction"),
    "two parents": (WRIST, '<child link="forearm"/>', "forearm has two parents, joints elbow_joint and wrist_1_joint"),
    "a loop": (WRIST, '<child link="base_link"/>', "are not joined to one root"),
    "unknown child": (WRIST, '<child link="wrist"/>', "has the child 'wrist', but there is no such link"),
    "no child": (WRIST, "", "joint wrist_1_joint has the child ''"),
    "mimic": (ELBOW, ELBOW + MIMIC, "elbow_joint is mimic"),
    "floating": (ELBOW, ELBOW.replace("revolute", "floating"), "elbow_joint is floating"),
    "planar": (ELBOW, ELBOW.replace("revolute", "planar"), "elbow_joint is planar"),
    "unknown type": (ELBOW, ELBOW.replace("revolute", "hinge"), "elbow_joint is hinge, which .*revolute"),
    "joint twice": (ELBOW, ELBOW.replace("elbow", "wrist_3"), "a joint has the name 'wrist_3_joint'; give each"),
    "link twice": ('<link name="tool0"/>', '<link name="flange"/>', "a link has the name 'flange'; give each"),
    "no name": ('<link name="tool0"/>', "<link/>", "a link has the name ''"),
    "two roots": ('<link name="tool0"/>', '<link name="tool0"/><link name="stand"/>', "links stand are not joined"),
    "DOCTYPE": ("<robot", '<!DOCTYPE robot [<!ENTITY a "b">]><robot', "has a DOCTYPE"),
    "xacro": ("<robot", "<robot><xacro:include filename='x'/></robot><robot", "is xacro, not URDF; expand it"),
    "a property of xacro": ('xyz="-0.612 0 0"', 'xyz="${a} 0 0"', "is xacro, not URDF; expand it"),
    "not closed": ("</robot>", "", "is not XML"),
}  # fmt: skip


@pytest.mark.parametrize("what", BROKEN)
def test_a_broken_file_is_one_line_with_its_line(what: str, tmp_path: Path) -> None:
    old, new, words = BROKEN[what]
    text = ur10()
    assert old in text
    file = file_with(tmp_path, text.replace(old, new, -1 if what == "a name of two lines" else 1))
    with pytest.raises(CaseError, match=words) as caught:
        read_urdf(file, "tool0")
    assert one_line(caught.value).startswith(f"{file}: ")


def arm(folder: Path, *changes: tuple[str, str], flange: str = "tool0", sensor: str | None = None) -> Arm:
    """What a UR10 whose file is a little different says."""
    text = ur10()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return read_urdf(file_with(folder, text), flange, sensor)


def test_all_that_is_wrong_is_told_at_once(tmp_path: Path) -> None:
    broken = (ELBOW_LIMIT, '<limit lower="3" upper="-3"/>'), ('xyz="-0.612 0 0"', 'xyz="-0,612 0 0"')
    with pytest.raises(CaseError) as caught:
        arm(tmp_path, *broken, (AXIS, '<axis xyz="0 0 0"/>'))
    assert len(caught.value.problems) == 3
    assert all(problem in one_line(caught.value) for problem in caught.value.problems)


@pytest.mark.parametrize("tag", ["axis", "origin", "limit"])
def test_what_a_joint_states_twice_is_refused_where_the_two_differ(tag: str, tmp_path: Path) -> None:
    """Readers of URDF do not agree on which one counts."""
    own = re.search(rf'name="elbow_joint".*?(<{tag} .*?/>)', ur10(), re.DOTALL)[1]
    elbow = '<joint name="elbow_joint" type="revolute">'
    assert arm(tmp_path, (elbow, elbow + own)).joints == arm(tmp_path).joints
    other = re.sub(r'="[^ "]+', '="0.5', own, count=1)
    with pytest.raises(CaseError, match=f"joint elbow_joint states {tag} more than once"):
        arm(tmp_path, (elbow, elbow + other))


def test_what_is_no_tree_hides_no_other_problem(tmp_path: Path) -> None:
    extra = '<joint name="extra" type="fixed"><parent link="nowhere"/><child link="base_link"/></joint></robot>'
    with pytest.raises(CaseError) as caught:
        arm(
            tmp_path, (ELBOW_LIMIT, '<limit lower="3" upper="-3"/>'), (AXIS, '<axis xyz="0 0 0"/>'), ("</robot>", extra)
        )
    line = one_line(caught.value)
    for words in ("no such link", "nowhere", "no direction", "lower"):
        assert words in line
    assert len(caught.value.problems) >= 3


@pytest.mark.parametrize(
    ("limit", "kind", "ends", "velocity", "effort", "says"),
    [
        ('lower="-3" upper="3" effort="0" velocity="0"', "revolute", (-3, 3), None, None, "no velocity above 0"),
        ('lower="-3" upper="3" effort="-3" velocity="nan"', "revolute", (-3, 3), None, None, "no effort above 0"),
        ('lower="-3" upper="3"', "revolute", (-3, 3), None, None, "no velocity above 0"),
        ('lower="-3" upper="3" effort="inf" velocity="1e9"', "revolute", (-3, 3), None, None, "no velocity above 0"),
        ('upper="3" effort="7" velocity="2"', "revolute", (0, 3), 2, 7, ""),
        ('effort="7" velocity="2"', "revolute", None, 2, 7, "no ends are stated"),
        ('lower="-Inf" upper="inf" effort="7" velocity="2"', "continuous", None, 2, 7, "taken as continuous"),
        ('lower="-170" upper="170" effort="7" velocity="2"', "revolute", (-170, 170), 2, 7, "look like degrees"),
        ('lower="-3" upper="3" effort="7" velocity="120"', "revolute", (-3, 3), 120, 7, "counts in radians"),
    ],
)
def test_what_only_says_how_far_and_fast_a_joint_goes_never_stops_a_case(
    limit: str, kind: str, ends: tuple[float, float] | None, velocity: float, effort: float, says: str, tmp_path: Path
) -> None:
    found = arm(tmp_path, (ELBOW_LIMIT, f"<limit {limit}/>"))
    joint, limits = found.joints[2]
    assert (joint.kind, joint.torque_Nm) == (kind, effort)
    assert joint.position_deg == (None if ends is None else pytest.approx(np.degrees(ends)))
    assert limits.velocity_deg_s == (None if velocity is None else pytest.approx(np.degrees(velocity)))
    assert all("elbow_joint" in note for note in found.notes)
    assert says in " ".join(found.notes)
    assert bool(found.notes) == bool(says)


def test_ends_of_a_continuous_joint_do_not_count(tmp_path: Path) -> None:
    limit = '<limit lower="-Inf" upper="Inf" effort="9" velocity="3"/>'
    found = arm(tmp_path, (ELBOW, ELBOW.replace("revolute", "continuous")), (ELBOW_LIMIT, limit))
    assert found.joints[2][0].position == (-np.inf, np.inf)
    assert found.notes == ()


def test_what_is_missing_is_left_to_be_filled_in(tmp_path: Path) -> None:
    text = ur10().replace(ELBOW_LIMIT, '<limit effort="0" velocity="0"/>')
    case_file = new_arm("arm", file_with(tmp_path, text), "tool0", tmp_path / "arm")
    lines = case_file.read_text().splitlines()
    assert sum(line.startswith("# velocity_deg_s = 0.0 # TO BE FILLED IN") for line in lines) == 1
    assert sum("TO BE FILLED IN: the ends of the joint" in line for line in lines) == 1
    assert any(line.startswith("# Look at joint elbow_joint: no ends are stated") for line in lines)


IMPOSSIBLE = {
    "negative mass": ("value='1.5'", "value='-1.5'"),
    "a disc thinner than nothing": ("ixx='0.04'", "ixx='0.4'"),
    "not a number": ("ixx='0.04'", "ixx='nan'"),
    "no mass": ("<mass value='1.5'/>", ""),
    "no place": ("xyz='0.01 -0.02 0.1'", "xyz='0.01'"),
}


@pytest.mark.parametrize("what", IMPOSSIBLE)
def test_inertias_of_no_body_are_left_out_and_all_named(what: str, tmp_path: Path) -> None:
    old, new = IMPOSSIBLE[what]
    text = ur10().replace("ixx='0.04'", "ixx='0.04' ", 1)  # the base's, which no joint moves, stays
    found = read_urdf(file_with(tmp_path, text.replace(old, new, 1)), "tool0")
    assert [joint.link is None for joint, _ in found.joints] == [True, *[False] * 5]
    assert found.notes == (
        "link shoulder: no rigid body has its mass and inertia: they are left out, state them yourself",
    )
    everywhere = read_urdf(file_with(tmp_path, text.replace("ixx='0.04'", "ixx='-1'")), "tool0")
    assert all(joint.link is None for joint, _ in everywhere.joints)
    assert everywhere.notes[0].startswith("links shoulder, upper_arm, forearm, wrist_1, wrist_2, wrist_3: ")


def test_points_that_are_fixed_to_a_body_weigh_with_it(tmp_path: Path) -> None:
    """Parallel axes: a point of 0.1 kg at (0, 0, 0.05) in the last link's frame."""
    point = '<link name="flange"><inertial><mass value="0.1"/><inertia ixx="0" iyy="0" izz="0"/></inertial></link>'
    moved = ('xyz="0 0 0" rpy="0 -1.5', 'xyz="0 0 0.05" rpy="0 -1.5')
    before, after = arm(tmp_path), arm(tmp_path, ('<link name="flange"/>', point), moved)
    assert after.notes == ()
    old, new = before.joints[5][0].link, after.joints[5][0].link
    assert new.mass_kg == pytest.approx(old.mass_kg + 0.1)
    at = np.array([0.0, 0.0, 0.05])
    np.testing.assert_allclose(
        new.mass_kg * new.centre_of_gravity, old.mass_kg * old.centre_of_gravity + 0.1 * at, atol=1e-12
    )

    def about_origin(body: RigidBody) -> np.ndarray:
        c = body.centre_of_gravity
        return body.inertia + body.mass_kg * (c @ c * np.eye(3) - np.outer(c, c))

    added = about_origin(new) - about_origin(old)
    np.testing.assert_allclose(added, 0.1 * (at @ at * np.eye(3) - np.outer(at, at)), atol=1e-12)


def test_what_other_programs_read_may_hold_anything(tmp_path: Path) -> None:
    """Controllers and simulators keep words of xacro and prefixes of their own."""
    other = '<ros2_control><param name="a">${b}</param><xacro:arm prefix="${c}"/></ros2_control><sim:world x="$(d)"/>'
    assert arm(tmp_path, ("</robot>", f"{other}</robot>")) == arm(tmp_path)
    with pytest.raises(CaseError, match="is xacro"):
        arm(tmp_path, ("</robot>", '<xacro:arm prefix="a"/></robot>'))


def test_a_flange_and_a_sensor_behind_it_are_both_written(tmp_path: Path) -> None:
    sensor = '<link name="ft"/><joint name="m" type="fixed"><origin xyz="0 0 0.04" rpy="0 0 1.5"/>'
    mount = ("</robot>", f'{sensor}<parent link="tool0"/><child link="ft"/></joint></robot>')
    found = arm(tmp_path, mount, sensor="ft")
    relative = np.linalg.solve(found.flange.parent_from_frame, found.sensor.parent_from_frame)
    np.testing.assert_allclose(relative[:3, 3], [0.0, 0.0, 0.04], atol=1e-12)
    assert np.arctan2(relative[1, 0], relative[0, 0]) == pytest.approx(1.5)
    open_ended = arm(tmp_path, mount, flange="ft")
    assert (open_ended.flange, open_ended.sensor) == (None, found.sensor)
    assert re.search("ft: .*tool0 as the flange and ft as the sensor", open_ended.notes[0])
    with pytest.raises(CaseError, match=r"link forearm is not fixed to link tool0; name .*tool0"):
        arm(tmp_path, sensor="forearm")


def fixed_link(name: str, parent: str, z: float, mass: float = 0.0) -> str:
    """A link that is fixed to another one at a height [m]; with a mass, it is a cube of 20 mm there."""
    inside = f'<inertial><mass value="{mass}"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3"/></inertial>'
    inside += '<collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision>'
    return (
        f'<link name="{name}">{inside if mass else ""}</link><joint name="to_{name}" type="fixed">'
        f'<origin xyz="0 0 {z}"/><parent link="{parent}"/><child link="{name}"/></joint>'
    )


def with_links(tmp_path: Path, *links: str, flange: str = "tool0", sensor: str | None = "ft") -> Arm:
    return arm(tmp_path, ("</robot>", "".join([*links, "</robot>"])), flange=flange, sensor=sensor)


def test_an_adapter_and_the_sensors_housing_move_with_the_last_link(tmp_path: Path) -> None:
    """They weigh on the joints, and are kept apart, but do not load the sensor."""
    bare = with_links(tmp_path, sensor=None)
    housing, camera = fixed_link("housing", "tool0", 0.01, 0.3), fixed_link("camera", "tool0", 0.05, 0.2)
    found = with_links(
        tmp_path, housing, camera, fixed_link("ft", "housing", 0.02, 0.1), fixed_link("hand", "ft", 0.03, 0.9)
    )
    assert found.load_links == ("hand",)
    assert found.load is not None
    np.testing.assert_allclose(found.load.centre_of_gravity_mm, [0.0, 0.0, 30.0], atol=1e-9)
    last, last_bare = found.joints[-1][0].link, bare.joints[-1][0].link
    assert last is not None
    assert last_bare is not None
    assert last.mass_kg == pytest.approx(last_bare.mass_kg + 0.3 + 0.2 + 0.1)
    assert {body.name for body in found.bodies[-1]} == {"housing", "camera", "ft"}
    assert [body.name for body in found.tool] == ["hand"]


def test_a_tool_on_the_flange_loads_a_sensor_in_the_wrist(tmp_path: Path) -> None:
    """The sensor's link is beside the flange in the file, as that of Universal Robots, or before it."""
    beside = fixed_link("ft", "wrist_3", 0.0), fixed_link("hand", "tool0", 0.03, 0.9)
    before = fixed_link("ft", "tool0", 0.0), fixed_link("end", "ft", 0.01), fixed_link("hand", "end", 0.03, 0.9)
    for links, flange in ((beside, "tool0"), (before, "end")):
        found = with_links(tmp_path, *links, flange=flange)
        assert found.load_links == ("hand",)
        assert found.load is not None
        assert found.load.mass_kg == pytest.approx(0.9)
        last = found.joints[-1][0].link
        assert last is not None
        assert last.mass_kg == pytest.approx(1.0 + 7 / 4)  # of wrist_3 alone


@pytest.mark.parametrize(("name", "noted"), [("ft_frame", True), ("axia_ft80", True), ("left_hand", False)])
def test_a_link_behind_the_flange_that_may_be_the_sensors_is_named(name: str, noted: bool, tmp_path: Path) -> None:
    found = with_links(tmp_path, fixed_link(name, "tool0", 0.04), sensor=None)
    assert any(name in note and "name it as the sensor" in note for note in found.notes) == noted
    assert not with_links(tmp_path, fixed_link(name, "tool0", 0.04), sensor=name).notes


def test_ends_have_no_more_digits_than_the_file_states(tmp_path: Path) -> None:
    """So that a joint of 120 deg can be used from -120 to 120 deg; a number of many digits is taken as it is."""
    found = arm(tmp_path, (ELBOW_LIMIT, '<limit lower="-2.094395" upper="1.23456789012" velocity="2.9671"/>'))
    joint, limit = next(entry for entry in found.joints if entry[0].name == "elbow_joint")
    low, high = joint.position_deg
    assert (low, limit.velocity_deg_s) == (-120.0, 170.0)
    assert high == pytest.approx(np.degrees(1.23456789012), abs=1e-9)


def test_angles_of_origins_have_no_more_digits_than_the_file_states(tmp_path: Path) -> None:
    """Right angles are written as 1.5708; of many digits, or few, an angle is taken as it is."""
    for text, degrees, within in (
        ("1.5708", 90.0, 1e-9),
        ("-0.785398", -45.0, 1e-9),
        ("1.57", np.degrees(1.57), 1e-9),
        ("0.12345678901", np.degrees(0.12345678901), 1e-9),
        ("1.57079", np.degrees(1.57079), 3e-4),
    ):
        found = arm(tmp_path, ('xyz="-0.612 0 0" rpy="0 0 0"', f'xyz="-0.612 0 0" rpy="0 0 {text}"'))
        place = next(joint for joint, _ in found.joints if joint.name == "elbow_joint")
        assert place.rpy_deg[2] == pytest.approx(degrees, abs=within)
    assert place.rpy_deg[2] != pytest.approx(90.0, abs=1e-4)


def test_digits_may_come_first_in_a_name(tmp_path: Path) -> None:
    text = ur10().replace("elbow_joint", "3_elbow")
    case_file = new_arm("arm", file_with(tmp_path, text), "tool0", tmp_path / "arm")
    case_file.write_text(filled_in(case_file.read_text(), HOMES["ur10"]))
    assert load_case(str(tmp_path / "arm")).chain.names[2] == "3_elbow"


@pytest.mark.parametrize(
    "text",
    [
        ur10().replace("</robot>", "<!--" * 100_000 + "</robot>"),
        ur10().replace("0.1273", "1" * 200_000 + "x"),
        "<robot>" + '<link name="l">' * 100_000 + "</link>" * 100_000 + "</robot>",
        urdf([(f"j{k}", "fixed", f"l{k}", f"l{k + 1}", "0 0 0", "0 0 0", "") for k in range(3000)]),
        urdf([(f"j{k}", "continuous", f"l{k}", f"l{k + 1}", "0 0 0", "0 0 0", "") for k in range(3000)]),
    ],
    ids=["comments", "digits", "deep", "fixed", "long"],
)
def test_no_file_takes_long(text: str, tmp_path: Path) -> None:
    start = time.process_time()
    with pytest.raises(CaseError) as caught:
        read_urdf(file_with(tmp_path, text), "tool0" if "tool0" in text else "l3000")
    assert time.process_time() - start < 2.0
    assert len(one_line(caught.value)) < 2000


def test_of_very_many_problems_the_first_are_listed_and_the_others_counted(tmp_path: Path) -> None:
    joints = "".join(
        f"<joint name='x{k}' type='fixed'><parent link='none{k}'/><child link='tool0'/></joint>" for k in range(2000)
    )
    with pytest.raises(CaseError) as caught:
        read_urdf(file_with(tmp_path, ur10().replace("</robot>", f"{joints}</robot>")), "tool0")
    assert len(caught.value.problems) == MOST_PROBLEMS
    assert f"has {4000 - MOST_PROBLEMS + 1} more problems" in one_line(caught.value)


def test_what_stands_beside_the_way_may_be_broken(tmp_path: Path) -> None:
    """A mimicking finger is nothing to the arm; that the arm ends at it is refused."""
    file = file_with(tmp_path, panda())
    assert len(read_urdf(file, "hand").joints) == 7
    assert read_urdf(file, "finger1").joints[-1][0].kind == "prismatic"
    with pytest.raises(CaseError, match="finger_joint2 is mimic"):
        read_urdf(file, "finger2")


def test_comments_that_xacro_keeps_do_no_harm_and_a_doctype_is_refused_in_any_encoding(tmp_path: Path) -> None:
    kept = ur10().replace('<link name="tool0"/>', '<!-- <xacro:tool prefix="${a}"/> --><link name="tool0"/>')
    assert new_arm("arm", file_with(tmp_path, kept), "tool0", tmp_path / "arm").is_file()
    file = tmp_path / "wide.urdf"
    file.write_bytes('<!DOCTYPE robot [<!ENTITY a "b">]><robot/>'.encode("utf-16"))
    with pytest.raises(CaseError, match="has a DOCTYPE"):
        new_arm("wide", file, "tool0", tmp_path / "wide")


def test_an_axis_of_any_length_is_a_direction(tmp_path: Path) -> None:
    text = ur10().replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 -2.5"/>', 1)
    np.testing.assert_array_equal(read_urdf(file_with(tmp_path, text), "tool0").joints[0][0].axis, [0.0, 0.0, -1.0])


def test_a_continuous_joint_needs_no_limit_and_has_no_ends(tmp_path: Path) -> None:
    text = ur10().replace(ELBOW, ELBOW.replace("revolute", "continuous")).replace(ELBOW_LIMIT, "")
    elbow, limit = read_urdf(file_with(tmp_path, text), "tool0").joints[2]
    assert (elbow.kind, elbow.position_deg, limit.velocity_deg_s, elbow.torque_Nm) == ("continuous", None, None, None)


@pytest.mark.parametrize("content", [b"", b"\x00\xff\xfe", b"<robot/>", b"<robot name='a'><link name='b'/></robot>"])
def test_files_with_next_to_nothing(content: bytes, tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_bytes(content)
    for flange in ("b", None):
        with pytest.raises(CaseError) as caught:
            read_urdf(file, flange)
        one_line(caught.value)
    with pytest.raises(CaseError, match="cannot be read"):
        read_urdf(tmp_path, "b")


PIECES = re.findall(r'<[^>]+>|"[^"]*"', panda())


@settings(
    max_examples=examples(150),
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
    deadline=None,
)
@given(
    edits=st.lists(st.tuples(st.sampled_from(PIECES), st.sampled_from([*PIECES, "", '"nan"', '"0 0 0"'])), max_size=3)
)
def test_a_file_with_pieces_put_elsewhere_is_read_or_refused_in_one_line(
    edits: list[tuple[str, str]], tmp_path: Path
) -> None:
    text = panda()
    for old, new in edits:
        text = text.replace(old, new, 1)
    try:
        joints = read_urdf(file_with(tmp_path, text), "tool").joints
    except CaseError as error:
        one_line(error)
    else:
        for joint, _ in joints:
            assert np.isclose(np.linalg.norm(joint.axis), 1.0)
            assert np.isfinite([*joint.origin, *joint.rpy]).all()


def test_what_is_fixed_behind_the_sensor_is_its_load(tmp_path: Path) -> None:
    """A plate of 1 kg, 20 mm before the sensor's link and turned by 90 degrees about z, and the link's own 5 kg."""
    plate = '<link name="plate"><inertial><origin xyz="0.01 0 0.03"/><mass value="1"/>'
    plate += '<inertia ixx="0.002" iyy="0.001" izz="0.002"/>'
    plate += '</inertial><collision><geometry><box size="0.1 0.02 0.04"/></geometry></collision></link>'
    plate += '<joint name="m" type="fixed"><origin xyz="0 0 0.02" rpy="0 0 1.5707963267948966"/>'
    plate += '<parent link="tool0"/><child link="plate"/></joint></robot>'
    tool0 = '<link name="tool0"><inertial><mass value="5"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
    found = arm(tmp_path, ("</robot>", plate), ('<link name="tool0"/>', tool0))
    assert found.load_links == ("plate",)
    assert found.load.mass_kg == pytest.approx(1.0)
    np.testing.assert_allclose(found.load.centre_of_gravity_mm, [0.0, 10.0, 50.0], atol=1e-9)
    np.testing.assert_allclose(np.diag(found.load.inertia), [0.001, 0.002, 0.002], atol=1e-12)
    np.testing.assert_allclose(np.ptp(found.tool[0].corners_mm, axis=0), [20.0, 100.0, 40.0], atol=0.02)
    text = ur10().replace("</robot>", plate).replace('<link name="tool0"/>', tool0)
    file = new_arm("arm", file_with(tmp_path, text), "tool0", tmp_path / "arm", bodies=True)
    file.write_text(filled_in(file.read_text(), HOMES["ur10"]))
    case = load_case(str(file))
    assert case.nominal.mass_kg == pytest.approx(1.0)
    assert [body.name for body in case.chain.tool] == ["plate"]


def test_each_tolerance_that_the_arm_has_is_offered(tmp_path: Path) -> None:
    """The comments, taken as they stand, leave no kind of tolerance that deviations would not count."""
    case_file = new_arm("arm", file_with(tmp_path, ur10()), "tool0", tmp_path / "arm")
    text = case_file.read_text()
    begin = text.index("# [tolerances]")
    end = text.index("\n\n", begin)
    assert "gains" in load_case(str(tmp_path / "arm")).not_counted
    case_file.write_text(text[:begin] + re.sub(r"^# ", "", text[begin:end], flags=re.MULTILINE) + text[end:])
    case = load_case(str(tmp_path / "arm"))
    assert tuple(key for key, _ in case.tolerances.stated()) == tuple(
        key for key in type(case.tolerances).model_fields if key in case.tolerable
    )
    assert "links_mm" in case.tolerable
    assert not case.not_counted
