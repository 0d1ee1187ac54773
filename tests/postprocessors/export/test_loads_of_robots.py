"""Loads in the words of robots: each text, read by rules of its receiver, is the same body."""

import itertools
import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cases.base.errors import CaseError, FileProblem, HexciteError, IdentificationError
from cases.basis import plan_basis, result_basis
from cases.schema import Case, load_case
from identification.finding import Kind, warning
from identification.model.model import identification_model
from identification.results.payload import payload
from identification.results.result import Result
from postprocessors.export import export, preview
from postprocessors.export.load import principal_axes
from postprocessors.export.targets import FRAMED, SINGLE_FILES
from tests.helpers import examples, one_line
from tests.postprocessors.export.calibrations import calibration, plausible

COMMAND = re.compile(r"set_target_payload\((\S+), \[(.*?)\], \[(.*?)\]\)")
INERTIA = np.array([[0.031, 0.002, -0.004], [0.002, 0.027, 0.001], [-0.004, 0.001, 0.019]])
CENTRE = np.array([0.012, -0.034, 0.105])


ADAPTER = {"origin_mm": (0.0, 0.0, 154.05), "rpy_deg": (0.0, 0.0, 90.0)}
"""A sensor 37.5 mm before the flange of the UR10e, turned by 90 degrees about it."""


def text_of(target: str, result: Result, **options: str) -> str:
    (text,) = preview(result, target, **options).values()
    return text


def body(mass: float, inertia: np.ndarray, number: int = 6) -> np.ndarray:
    case = load_case("ur10_wrist")
    u = plausible(case, identification_model(case, number))
    about_origin = inertia + mass * (CENTRE @ CENTRE * np.eye(3) - np.outer(CENTRE, CENTRE))
    u[:10] = [mass, *(mass * CENTRE), *about_origin[np.triu_indices(3)]]
    return u


def written(text: str) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre of gravity and inertia of the command."""
    (found,) = COMMAND.findall(text)
    centre, elements = (np.array([float(v) for v in part.split(",")]) for part in found[1:])
    xx, yy, zz, xy, xz, yz = elements
    return float(found[0]), centre, np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def with_chain(made: Result, **frames: object) -> Result:
    """The result of a robot whose sensor and flange are elsewhere."""
    data = made.case.model_dump()
    data["machine"]["chain"].update(frames)
    return replace(made, case=Case.model_validate(data))


def test_the_command_means_the_body(tmp_path: Path) -> None:
    text = text_of("urscript", calibration(tmp_path, "ur10_wrist", 6, body(2.6, INERTIA)))
    mass, centre, inertia = written(text)
    assert mass == pytest.approx(2.6, abs=1e-4)
    np.testing.assert_allclose(centre, CENTRE, atol=1e-5)  # the sensor's frame is the flange
    np.testing.assert_allclose(inertia, INERTIA, atol=1e-6)
    lines = text.splitlines()
    assert re.fullmatch(r"def \w+\(\):", lines[0])
    assert lines[-1] == "end"
    assert all(line.startswith("  ") for line in lines[1:-1])
    assert text.isascii()


def test_the_load_is_counted_from_the_flange_along_its_axes(tmp_path: Path) -> None:
    """An adapter turns and lifts the sensor: points of the body, seen from the flange, have the same moments."""
    made = with_chain(calibration(tmp_path, "ur10_wrist", 6, body(2.6, INERTIA)), sensor=ADAPTER)
    mass, centre, inertia = written(text_of("urscript", made))
    x, y, z = CENTRE
    np.testing.assert_allclose(centre, [-y, x, z + 0.0375], atol=1e-5)
    turn = Rotation.from_euler("z", 90.0, degrees=True).as_matrix()
    np.testing.assert_allclose(inertia, turn @ INERTIA @ turn.T, atol=1e-6)
    assert mass == pytest.approx(2.6, abs=1e-4)


def test_frames_of_sensor_and_flange_may_lie_anyhow(tmp_path: Path) -> None:
    """Gravity's moment about the flange is the same, whatever frame the load is stated in."""
    sensor = {"origin_mm": (30.0, -20.0, 140.0), "rpy_deg": (20.0, -35.0, 100.0)}
    flange = {"origin_mm": (5.0, 1.0, 110.0), "rpy_deg": (-10.0, 50.0, 7.0)}
    made = with_chain(calibration(tmp_path, "ur10_wrist", 6, body(2.6, INERTIA)), sensor=sensor, flange=flange)
    _, centre, inertia = written(text_of("urscript", made))
    turns = [Rotation.from_euler("xyz", f["rpy_deg"], degrees=True) for f in (sensor, flange)]
    origins = [np.array(f["origin_mm"]) / 1000 for f in (sensor, flange)]
    in_link = origins[0] + turns[0].apply(CENTRE)
    np.testing.assert_allclose(origins[1] + turns[1].apply(centre), in_link, atol=2e-5)
    np.testing.assert_allclose(np.linalg.eigvalsh(inertia), np.linalg.eigvalsh(INERTIA), atol=2e-6)
    axis = np.array([0.3, -0.5, 0.8])
    seen = [turn.inv().apply(axis) for turn in turns]
    assert seen[1] @ inertia @ seen[1] == pytest.approx(seen[0] @ INERTIA @ seen[0], abs=2e-6)


def test_a_flange_that_is_not_known_is_asked_for(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"machine\.chain\.flange: is missing; .*flange.*origin_mm") as caught:
        text_of("urscript", with_chain(calibration(tmp_path, "ur10_wrist", 6, body(2.6, INERTIA)), flange=None))
    one_line(caught.value)
    heavy = [0.9, 0.0003, 1e-4, 0.041, 0.004, 0.0, 0.0, 0.004, 0.0, 0.002, *[0.0] * 6]
    wrist = calibration(tmp_path / "wrist", "ft_wrist", 6, np.array(heavy))
    with pytest.raises(CaseError, match=r"sensor_frame\.transducer\.flange: is missing"):
        text_of("urscript", wrist)
    data = wrist.case.model_dump()
    data["sensor_frame"]["transducer"]["flange"] = {"origin_mm": (0.0, 0.0, -40.0)}
    stated = replace(wrist, case=Case.model_validate(data))
    sensor = [wrist.parameters[f"{c}C"].value for c in "xyz"]
    np.testing.assert_allclose(written(text_of("urscript", stated))[1], sensor + np.array([0, 0, 0.04]), atol=1e-5)
    with pytest.raises(CaseError, match="setup: is that of no robot"):
        text_of("urscript", calibration(tmp_path / "hexapod", "hexapod", 9))


def test_a_flange_that_is_stated_later_does_not_make_results_stale() -> None:
    case = load_case("ur10_wrist")
    without = case.chain.model_copy(update={"flange": None})
    before = case.model_copy(update={"machine": case.machine.model_copy(update={"chain": without})})
    assert result_basis(before) == result_basis(case)
    assert plan_basis(before) == plan_basis(case)


def test_what_is_no_load_of_a_robot_is_refused(tmp_path: Path) -> None:
    with pytest.raises(IdentificationError, match="at most 133") as caught:
        text_of("urscript", calibration(tmp_path, "ur10_wrist", 6, body(30.0, np.diag([150.0, 150.0, 150.0]))))
    one_line(caught.value)


def test_an_inertia_that_no_body_has_is_exported_as_that_of_the_nearest_one(tmp_path: Path) -> None:
    result = calibration(tmp_path, "ur10_wrist", 6, body(30.0, np.diag([1.0, 1.0, 2.5])))
    text = text_of("kuka", result)
    moments = np.sort([float(v) for v in re.findall(r"J \{X ([\d.]+),Y ([\d.]+),Z ([\d.]+)", text)[0]])
    assert moments[0] + moments[1] == pytest.approx(moments[2], rel=1e-4)
    assert "nearest body that can exist" in text


def turned(axis: str, degrees: float) -> np.ndarray:
    """A rotation about one axis, by its sine and cosine."""
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return {
        "x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


def kuka(text: str) -> tuple[float, np.ndarray, np.ndarray]:
    """KRL: CM turned about z by A, then about the new y by B, then about the new x by C; J about its axes."""
    (line,) = (line for line in text.splitlines() if not line.startswith(";"))
    number = r"(-?[\d.]+)"
    pattern = (
        rf"LOAD_DATA\[1\]=\{{M {number},CM \{{X {number},Y {number},Z {number},A {number},B {number},C {number}\}},"
        rf"J \{{X {number},Y {number},Z {number}\}}\}}"
    )
    found = re.fullmatch(pattern, line)
    assert found is not None
    m, x, y, z, a, b, c, *moments = (float(v) for v in found.groups())
    axes = turned("z", a) @ turned("y", b) @ turned("x", c)
    return m, np.array([x, y, z]) / 1000, axes @ np.diag(moments) @ axes.T


def rapid(text: str) -> tuple[float, np.ndarray, np.ndarray]:
    """RAPID: [mass, cog, aom, ix, iy, iz]; aom is a quaternion with its scalar first."""
    lines = text.splitlines()
    assert re.fullmatch(r"MODULE \w{1,32}", lines[0])
    assert lines[-1] == "ENDMODULE"
    (data,) = re.findall(r"^  PERS loaddata tool_load:=(.*);$", text, re.MULTILINE)
    mass, cog, (w, x, y, z), *moments = json.loads(data)
    assert np.isclose(w * w + x * x + y * y + z * z, 1.0, atol=1e-7)
    axes = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return mass, np.array(cog) / 1000, axes @ np.diag(moments) @ axes.T


def franka(text: str) -> tuple[float, np.ndarray, np.ndarray]:
    """SetLoad: the inertia column by column."""
    entries = yaml.safe_load(text)
    assert set(entries) == {"mass", "center_of_mass", "load_inertia"}
    return entries["mass"], np.array(entries["center_of_mass"]), np.array(entries["load_inertia"]).reshape(3, 3).T


READERS = {"urscript": written, "kuka": kuka, "rapid": rapid, "franka": franka}
ANYHOW = {"origin_mm": (30.0, -20.0, 140.0), "rpy_deg": (20.0, -35.0, 100.0)}


@pytest.fixture
def turned_sensor(tmp_path: Path) -> Result:
    """A sensor that lies anyhow before the flange."""
    return with_chain(calibration(tmp_path, "ur10_wrist", 6, body(2.6, INERTIA)), sensor=ANYHOW)


def expected_at_flange() -> tuple[np.ndarray, np.ndarray]:
    """Centre of gravity and inertia from the flange of that robot."""
    flange = load_case("ur10_wrist").chain.flange
    roll, pitch, yaw = ANYHOW["rpy_deg"]
    rotation = turned("z", yaw) @ turned("y", pitch) @ turned("x", roll)
    in_link = rotation @ CENTRE + np.array(ANYHOW["origin_mm"]) / 1000
    back = flange.parent_from_frame[:3, :3].T
    return back @ (in_link - flange.parent_from_frame[:3, 3]), back @ rotation @ INERTIA @ rotation.T @ back.T


@pytest.mark.parametrize("target", READERS)
def test_every_robot_reads_the_same_body_from_its_flange(target: str, turned_sensor: Result) -> None:
    mass, centre, inertia = READERS[target](text_of(target, turned_sensor))
    at_flange, about_it = expected_at_flange()
    assert mass == pytest.approx(2.6, abs=1e-4)
    np.testing.assert_allclose(centre, at_flange, atol=1e-5)
    np.testing.assert_allclose(inertia, about_it, atol=2e-6)
    assert text_of(target, turned_sensor).isascii()


def test_an_xarm_gets_kilograms_and_millimetres(turned_sensor: Result) -> None:
    class Arm:
        def set_tcp_load(self, weight: float, center_of_gravity: list[float]) -> tuple[float, list[float]]:
            return weight, center_of_gravity

    space: dict[str, Any] = {}
    exec(text_of("xarm", turned_sensor), space)
    weight, centre = space["set_payload"](Arm())
    assert weight == pytest.approx(2.6)
    np.testing.assert_allclose(np.array(centre) / 1000, expected_at_flange()[0], atol=1e-5)


class Kortex:
    """ControlConfigClient of the Kortex API: messages with fields, of which others stay as they are."""

    def __init__(self) -> None:
        self.tool = SimpleNamespace(
            tool_transform="kept", tool_mass=0.0, tool_mass_center=SimpleNamespace(x=9, y=9, z=9)
        )
        self.payload = SimpleNamespace(payload_mass=0.0, payload_mass_center=SimpleNamespace(x=9, y=9, z=9))
        self.sent: list[Any] = []
        self.GetToolConfiguration = lambda: self.tool
        self.GetPayloadInformation = lambda: self.payload
        self.SetToolConfiguration = self.SetPayloadInformation = self.sent.append


def test_a_kinova_gets_its_tool_from_the_flange(turned_sensor: Result) -> None:
    space: dict[str, Any] = {}
    exec(text_of("kinova", turned_sensor), space)
    space["set_tool"](arm := Kortex())
    assert arm.sent == [arm.tool]
    assert arm.tool.tool_transform == "kept"
    assert arm.tool.tool_mass == pytest.approx(2.6)
    centre = arm.tool.tool_mass_center
    np.testing.assert_allclose([centre.x, centre.y, centre.z], expected_at_flange()[0], atol=2e-6)


def test_a_kinova_gets_what_was_added_from_the_frame_of_its_tool(tmp_path: Path) -> None:
    """A tool 120 mm in front of the flange, where the sensor is: 1.5 kg at c are at c less 120 mm there."""
    empty, loaded = (tmp_path / name for name in ("empty", "loaded"))
    for folder in (empty, loaded):
        folder.mkdir()
    flange = {"origin_mm": (0.0, 0.0, 0.0)}
    tcp = {"origin_mm": (0.0, 0.0, 120.0)}
    with_tool = [
        with_chain(calibration(folder, "ur10_wrist", 6, body(mass, inertia)), sensor={}, flange=flange, tcp=tcp)
        for folder, mass, inertia in ((empty, 1.1, 0.4 * INERTIA), (loaded, 2.6, INERTIA))
    ]
    added = payload(*with_tool)
    space: dict[str, Any] = {}
    exec(text_of("kinova", added), space)
    space["set_payload"](arm := Kortex())
    assert arm.sent == [arm.payload]
    assert arm.payload.payload_mass == pytest.approx(1.5, abs=1e-4)
    centre = arm.payload.payload_mass_center
    np.testing.assert_allclose([centre.x, centre.y, centre.z], CENTRE - [0.0, 0.0, 0.12], atol=2e-5)


def test_fanuc_is_typed_in_as_its_screen_asks(turned_sensor: Result) -> None:
    """kg, cm, and kgf cm s^2: a kilogram-force is 9.80665 N, so that 1 kgf cm s^2 is 0.0980665 kg m^2."""
    text = text_of("fanuc", turned_sensor)
    rows = [
        (name, unit, float(v)) for name, unit, v in re.findall(r"^(PAYLOAD.*) \[(.+)\] +(\S+)$", text, re.MULTILINE)
    ]
    centre, inertia = expected_at_flange()
    assert [(name, unit) for name, unit, _ in rows] == [
        ("PAYLOAD", "kg"),
        *((f"PAYLOAD CENTER {axis}", "cm") for axis in "XYZ"),
        *((f"PAYLOAD INERTIA {axis}", "kgfcms^2") for axis in "XYZ"),
    ]
    values = [value for *_, value in rows]
    assert values[0] == pytest.approx(2.6, abs=1e-3)
    np.testing.assert_allclose(np.array(values[1:4]) / 100, centre, atol=1e-5)
    np.testing.assert_allclose(np.array(values[4:]) * 9.80665 * 0.01, np.diag(inertia), atol=1e-6)


def test_a_table_has_several_units(turned_sensor: Result) -> None:
    """1 kgf cm s^2 is 0.0980665 kg m^2."""
    rows = dict(re.findall(r"^(.*\])  +(\S.*)$", text_of("table", turned_sensor), re.MULTILINE))
    centre, inertia = expected_at_flange()
    for axis, k in zip("XYZ", range(3), strict=True):
        mm, cm, m = (float(v) for v in rows[f"centre of gravity {axis} [mm]  [cm]  [m]"].split())
        np.testing.assert_allclose([mm / 1000, cm / 100, m], centre[k], atol=1e-6)
        si, fanuc = (float(v) for v in rows[f"inertia I{axis}{axis} [kg m^2]  [kgf cm s^2]"].split())
        assert si == pytest.approx(inertia[k, k], rel=1e-5)
        assert fanuc * 0.0980665 == pytest.approx(si, rel=1e-5)


@pytest.mark.parametrize("frame", ["sensor", "flange"])
@pytest.mark.parametrize("target", ["urdf", "mjcf"])
def test_mujoco_reads_the_body(target: str, frame: str, turned_sensor: Result) -> None:
    """MuJoCo reads both formats: a body that hangs from a joint has the same weight, moment and resistance."""
    element = text_of(target, turned_sensor, frame=frame)
    if target == "mjcf":
        text = f"<mujoco><worldbody><body>{element}<freejoint/></body></worldbody></mujoco>"
    else:
        text = (
            f'<robot name="r"><link name="w"/><link name="l">{element}</link>'
            '<joint name="j" type="floating"><parent link="w"/><child link="l"/></joint></robot>'
        )
    model = mujoco.MjModel.from_xml_string(text)
    centre, inertia = (CENTRE, INERTIA) if frame == "sensor" else expected_at_flange()
    assert model.body_mass[1] == pytest.approx(2.6, abs=1e-6)
    np.testing.assert_allclose(model.body_ipos[1], centre, atol=1e-6)
    axes = Rotation.from_quat(model.body_iquat[1], scalar_first=True).as_matrix()
    np.testing.assert_allclose(axes @ np.diag(model.body_inertia[1]) @ axes.T, inertia, atol=1e-6)


def test_sdf_states_the_body(turned_sensor: Result) -> None:
    element = ElementTree.fromstring(text_of("sdf", turned_sensor))
    assert [child.tag for child in element] == ["pose", "mass", "inertia"]
    pose = np.array([float(v) for v in str(element.findtext("pose")).split()])
    np.testing.assert_allclose(pose, [*CENTRE, 0, 0, 0], atol=1e-6)
    values = {child.tag: float(str(child.text)) for child in element.iterfind("inertia/*")}
    for i, j in itertools.combinations_with_replacement(range(3), 2):
        assert values[f"i{'xyz'[i]}{'xyz'[j]}"] == pytest.approx(INERTIA[i, j], abs=1e-6)


def standing(mass: float, centre: np.ndarray, offsets: np.ndarray, orientation: Rotation, sign: float) -> np.ndarray:
    """What a force/torque sensor reads that carries a body and stands turned in a world with gravity along -z."""
    weight = orientation.inv().apply([0.0, 0.0, -9.81 * mass])
    return sign * np.array([*weight, *np.cross(centre, weight)]) + offsets


def with_sense(made: Result, sense: str) -> Result:
    data = made.case.model_dump()
    data["sensor_frame"]["transducer"]["sense"] = sense
    return replace(made, case=Case.model_validate(data))


@pytest.mark.parametrize("sense", ["load_on_sensor", "sensor_on_load"])
def test_ros_2_takes_offsets_and_weight_off_whichever_way_the_sensor_counts(sense: str, tmp_path: Path) -> None:
    """The chain of the documents: the broadcaster adds and multiplies, the filter takes m g off."""
    made = with_sense(calibration(tmp_path, "ur10_wrist", 6, body(2.6, INERTIA)), sense)
    made = replace(made, case=made.case.model_copy(update={"gravity_m_s2": (0.0, 0.0, -9.81)}))
    parameters = yaml.safe_load(text_of("ros2", made))["force_torque_sensor_broadcaster"]["ros__parameters"]
    tool = parameters["sensor_filter_chain"]["filter1"]["params"]["tool"]
    offsets = np.array([made[f"f_q0_{k}"].value for k in range(1, 7)])
    added, factor = (
        np.array([of[kind][axis] for kind in ("force", "torque") for axis in "xyz"])
        if (of := parameters.get(key)) is not None
        else np.ones(6)
        for key in ("offset", "multiplier")
    )
    for k, orientation in enumerate(Rotation.random(5, rng=np.random.default_rng(3))):
        sign = 1.0 if sense == "load_on_sensor" else -1.0
        reading = (standing(2.6, CENTRE, offsets, orientation, sign) + added) * factor
        weight = orientation.inv().apply(tool["gravity_field"]) * tool["mass"]
        left = reading - np.array([*weight, *np.cross(tool["pos"], weight)])
        np.testing.assert_allclose(left, 0.0, atol=1e-3, err_msg=f"orientation {k}")


def test_ft_tools_takes_readings_of_the_load_on_the_sensor(tmp_path: Path) -> None:
    made = with_sense(calibration(tmp_path, "ur10_wrist", 6, body(2.6, INERTIA)), "load_on_sensor")
    entries = yaml.safe_load(text_of("ft-tools", made))
    offsets = np.array([made[f"f_q0_{k}"].value for k in range(1, 7)])
    for orientation in Rotation.random(5, rng=np.random.default_rng(4)):
        reading = standing(2.6, CENTRE, offsets, orientation, 1.0)
        weight = orientation.inv().apply([0.0, 0.0, -9.81]) * entries["mass"]
        moment = np.cross(entries["sensor_frame_to_com"], weight)
        left = reading - [*weight, *moment] - np.array([*entries["force_offset"], *entries["torque_offset"]])
        np.testing.assert_allclose(left, 0.0, atol=1e-3)
    with pytest.raises(CaseError, match=r"transducer\.sense: is sensor_on_load") as caught:
        text_of("ft-tools", with_sense(made, "sensor_on_load"))
    one_line(caught.value)


@given(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6))
@settings(max_examples=examples(50), deadline=None)
def test_principal_axes_are_a_rotation_that_turns_little(values: list[float]) -> None:
    inertia = np.zeros((3, 3))
    inertia[np.triu_indices(3)] = values
    inertia = inertia + np.triu(inertia, 1).T
    moments, axes = principal_axes(inertia)
    np.testing.assert_allclose(axes @ np.diag(moments) @ axes.T, inertia, atol=1e-12)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)


@pytest.mark.parametrize(("case", "model"), [("ur10_wrist", 0), ("strut_sensors", 6)])
def test_neither_a_static_model_nor_rods_of_struts_have_an_inertia(case: str, model: int, tmp_path: Path) -> None:
    for target in ("urscript", "franka", "urdf"):
        with pytest.raises((IdentificationError, CaseError)) as caught:
            text_of(target, calibration(tmp_path, case, model))
        one_line(caught.value)


@pytest.mark.parametrize("target", ["kuka", "rapid", "table", "fanuc", "xarm", "kinova", "ros2"])
def test_a_standing_run_gives_mass_and_centre_and_says_that_it_is_a_point(target: str, tmp_path: Path) -> None:
    text = text_of(target, calibration(tmp_path, "ur10_wrist", 0))
    if target in READERS:
        assert not READERS[target](text)[2].any()
    assert ("point mass" in text) == (target != "ros2")  # gravity compensation asks for no inertia


@pytest.mark.first(6)
@pytest.mark.parametrize("target", [name for name in SINGLE_FILES if name not in FRAMED])
def test_a_frame_is_chosen_of_links_and_signal_chains_alone(target: str, turned_sensor: Result) -> None:
    with pytest.raises(HexciteError, match=target) as caught:
        text_of(target, turned_sensor, frame="flange")
    assert "urdf" in one_line(caught.value)
    with pytest.raises(HexciteError, match="'tcp' is unknown"):
        text_of("sdf", turned_sensor, frame="tcp")
    with pytest.raises(HexciteError, match=r"machine\.chain\.tcp"):
        text_of("sdf", turned_sensor, frame="tool")


def as_loaded(folder: Path, u: np.ndarray) -> Result:
    """A result of the turned sensor that was loaded from its own file."""
    return with_chain(calibration(folder, "ur10_wrist", 6, u), sensor=ANYHOW)


EMPTY_TOOL = np.array([1.4, 0.02, -0.01, 0.06, 0.012, 0.001, -0.002, 0.011, 0.0005, 0.006])
"""Mass, first moments and inertia about the origin of {P} of what the sensor carried before [SI]."""


@pytest.fixture
def both(tmp_path: Path) -> tuple[Result, Result]:
    """Results of the tool alone, and of the tool with the body added: rigid bodies about one point add."""
    added = body(2.6, INERTIA)
    alone, together = added.copy(), added.copy()
    alone[:10] = EMPTY_TOOL
    together[:10] += EMPTY_TOOL
    return as_loaded(tmp_path / "empty", alone), as_loaded(tmp_path / "loaded", together)


@pytest.mark.parametrize("target", READERS)
def test_a_robot_reads_of_a_payload_the_body_that_was_added(target: str, both: tuple[Result, Result]) -> None:
    (text,) = preview(payload(*both), target).values()
    mass, centre, inertia = READERS[target](text)
    at_flange, about_it = expected_at_flange()
    assert mass == pytest.approx(2.6, abs=1e-4)
    np.testing.assert_allclose(centre, at_flange, atol=1e-5)
    np.testing.assert_allclose(inertia, about_it, atol=2e-6)
    assert text.isascii()
    assert all(of.fingerprint[:16] in text for of in both)


def test_what_was_taken_off_is_no_load(both: tuple[Result, Result], tmp_path: Path) -> None:
    off = payload(*reversed(both))
    for write in (lambda: preview(off, "kuka"), lambda: export(off, "kuka", tmp_path / "load.dat", force=True)):
        with pytest.raises(FileProblem, match=r"mass -2\.6 kg is not positive") as caught:
            write()
        one_line(caught.value)
    assert not (tmp_path / "load.dat").exists()


@pytest.mark.parametrize("target", ["c", "linuxcnc", "json", "ros2", "ft-tools"])
def test_a_payload_is_no_model_of_the_forces(target: str, both: tuple[Result, Result]) -> None:
    with pytest.raises(HexciteError, match=rf"target {target} .*kuka") as caught:
        preview(payload(*both), target)
    one_line(caught.value)


def test_doubts_of_either_result_are_doubts_of_a_payload(both: tuple[Result, Result], tmp_path: Path) -> None:
    empty, loaded = both
    told = warning(Kind.MODEL, "the offsets drift")
    doubtful = replace(empty, record=empty.record.replaced(findings=(*empty.findings, told)))
    found = payload(doubtful, loaded)
    with pytest.raises(FileProblem, match="drift"):
        export(found, "kuka", tmp_path / "load.dat")
    (file,) = export(found, "kuka", tmp_path / "load.dat", force=True)
    assert "WARNING: the offsets drift" in file.read_text()
    with pytest.raises(FileProblem, match="stands there"):
        export(found, "kuka", file, force=True)


def test_a_payload_of_standing_runs_is_a_point(tmp_path: Path) -> None:
    """Mass and centre of gravity alone, and a target that needs an inertia refuses."""
    empty, loaded = (
        calibration(tmp_path / name, "ur10_wrist", 0, np.array([mass, *first, *[0.0] * 6]))
        for name, mass, first in (("empty", 1.4, EMPTY_TOOL[1:4]), ("loaded", 4.0, EMPTY_TOOL[1:4] + 2.6 * CENTRE))
    )
    (text,) = preview(payload(empty, loaded), "kuka").values()
    mass, centre, inertia = kuka(text)
    assert mass == pytest.approx(2.6, abs=1e-4)
    np.testing.assert_allclose(centre, CENTRE, atol=1e-5)  # the sensor's frame is the flange
    assert not inertia.any()
    assert "point mass" in text
    with pytest.raises(IdentificationError, match="needs an inertia"):
        preview(payload(empty, loaded), "urscript")


@pytest.mark.parametrize("target", ["python", "xarm", "kinova"])
def test_names_in_comments_do_not_say_how_a_module_is_encoded(target: str, tmp_path: Path) -> None:
    result = calibration(tmp_path / "coding=nothing", "ur10_wrist", 6, body(2.6, INERTIA))
    assert "coding=nothing" in text_of(target, result)
    compile(text_of(target, result).encode(), "model.py", "exec")
