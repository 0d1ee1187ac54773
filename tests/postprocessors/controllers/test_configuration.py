"""What is told to LinuxCNC: limits, struts, kinematics and channels of the case."""

import configparser
import re
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import CaseError
from cases.schema import Case, load_case
from postprocessors.controllers.linuxcnc import configuration
from tests.postprocessors.changed_case import changed
from tests.postprocessors.independent import strut_lengths


def settings(text: str) -> configparser.ConfigParser:
    parser = configparser.ConfigParser()
    parser.read_string(text)
    return parser


def test_axes_have_the_limits_of_the_case_in_millimetres_and_degrees(hexapod_case: Case) -> None:
    """In the narrower box of dense paths; without one the workspace and the struts limit them."""
    moved = changed(hexapod_case, machine__home__x_mm=7.0)
    wide = settings(configuration.ini_text(moved, 1.0, box=False))
    assert wide.getfloat("AXIS_X", "MAX_LIMIT") == pytest.approx(307.0, abs=2e-6)
    assert wide.getfloat("AXIS_C", "MIN_LIMIT") == pytest.approx(-90.0, abs=2e-6)
    ini = settings(configuration.ini_text(moved, 1.0))
    assert ini.getfloat("AXIS_X", "MIN_LIMIT") == pytest.approx(-243.0, abs=2e-6)
    assert ini.getfloat("AXIS_X", "MAX_LIMIT") == pytest.approx(257.0, abs=2e-6)
    assert ini.getfloat("AXIS_X", "MAX_LIMIT") >= 257.0
    assert ini.getfloat("AXIS_Z", "MIN_LIMIT") == pytest.approx(800.0, abs=2e-6)
    assert ini.getfloat("AXIS_C", "MIN_LIMIT") == pytest.approx(-20.0, abs=2e-6)
    assert ini.getfloat("AXIS_Y", "MAX_VELOCITY") == pytest.approx(600.0)
    assert ini.getfloat("AXIS_B", "MAX_VELOCITY") == pytest.approx(60.0)
    assert ini.get("EMCMOT", "SERVO_PERIOD") == "1000000"


@pytest.mark.parametrize("headroom", [1.0, 35.0])
def test_acceleration_limits_are_multiplied_by_the_headroom(headroom: float, hexapod_case: Case) -> None:
    ini = settings(configuration.ini_text(hexapod_case, headroom))
    assert ini.getfloat("AXIS_Z", "MAX_ACCELERATION") == pytest.approx(6000.0 * headroom)
    assert ini.getfloat("AXIS_A", "MAX_ACCELERATION") == pytest.approx(np.degrees(10.0) * headroom)


@pytest.mark.parametrize(("kind", "axes"), [("LINEAR", "XYZ"), ("ANGULAR", "ABC")])
@pytest.mark.parametrize("quantity", ["VELOCITY", "ACCELERATION"])
def test_limits_of_the_path_bind_after_those_of_all_axes_together(
    kind: str, axes: str, quantity: str, hexapod_case: Case
) -> None:
    ini = settings(configuration.ini_text(hexapod_case, 1.0))
    together = np.linalg.norm([ini.getfloat(f"AXIS_{axis}", f"MAX_{quantity}") for axis in axes])
    assert ini.getfloat("TRAJ", f"MAX_{kind}_{quantity}") >= together - 1e-9


def test_struts_have_the_range_of_the_workspace_and_start_at_home(hexapod_case: Case) -> None:
    ini = settings(configuration.ini_text(hexapod_case, 1.0))
    home = strut_lengths(hexapod_case.machine.home.vector[None], hexapod_case)[0]
    assert [ini.getfloat(f"JOINT_{k}", "HOME") for k in range(6)] == pytest.approx(home * 1e3)
    for k in range(6):
        assert ini.getfloat(f"JOINT_{k}", "MIN_LIMIT") == 650.0
        assert ini.getfloat(f"JOINT_{k}", "MAX_LIMIT") == 1550.0


def test_kinematics_has_the_joints_of_the_case(hexapod_case: Case) -> None:
    assert hexapod_case.machine is not None
    found = re.findall(
        r"^setp genhexkins\.(base|platform)\.(\d)\.([xyz]) (\S+)$", configuration.hal_text(hexapod_case), re.M
    )
    points = {ring: np.full((6, 3), np.nan) for ring in ("base", "platform")}
    for ring, k, coordinate, value in found:
        points[ring][int(k), "xyz".index(coordinate)] = float(value)
    np.testing.assert_allclose(points["base"], hexapod_case.machine.base.points * 1e3, atol=1e-9)
    np.testing.assert_allclose(points["platform"], hexapod_case.machine.platform.points * 1e3, atol=1e-9)


@pytest.mark.parametrize("name", ["hexapod", "five_axis_table"])
def test_every_channel_is_logged(name: str) -> None:
    case = load_case(name)
    layout, hal = configuration.AxisLayout.of(case), configuration.hal_text(case)
    pins = re.findall(r"^net log-(\d+) (\S+) => sampler\.0\.pin\.(\d+)$", hal, re.M)
    assert [(int(a), pin, int(b)) for a, pin, b in pins] == [(k, pin, k) for k, (_, pin) in enumerate(layout.channels)]
    assert len(pins) == 2 + 2 * len(layout.axes)
    assert f"cfg={layout.sampler}" in hal
    assert f"SAMPLER = {layout.sampler}\n" in configuration.ini_text(case, 1.0)


def test_the_axes_of_a_chain_are_its_joints() -> None:
    case = load_case("five_axis_table")
    _, limits = case.need_motion("a test")
    ini = settings(configuration.ini_text(case, 1.0, box=False))
    assert (ini["KINS"]["KINEMATICS"], ini["KINS"]["JOINTS"]) == ("trivkins coordinates=XYZAC", "5")
    assert [ini[f"JOINT_{k}"]["TYPE"] for k in range(5)] == ["LINEAR"] * 3 + ["ANGULAR"] * 2
    for k, joint in enumerate(case.chain.joints):
        for section in (f"JOINT_{k}", f"AXIS_{joint.name}"):
            assert float(ini[section]["MAX_VELOCITY"]) == pytest.approx(limits.rate[k] / joint.unit)
            assert float(ini[section]["MAX_ACCELERATION"]) == pytest.approx(limits.acceleration[k] / joint.unit)
            low, high = (float(ini[section][key]) * joint.unit for key in ("MIN_LIMIT", "MAX_LIMIT"))
            assert low <= joint.position[0] + 1e-6 or joint.kind == "continuous"
            assert high >= joint.position[1] - 1e-6 or joint.kind == "continuous"
    assert "genhexkins" not in configuration.hal_text(case)


def test_a_case_without_a_machine_cannot_be_configured(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="program on LinuxCNC"):
        configuration.write_configuration(tmp_path, load_case("ft_wrist"), 1.0)
