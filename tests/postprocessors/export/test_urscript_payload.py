"""`set_target_payload`: mass, centre of gravity and inertia about it, in the order that the robot expects."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.basis import plan_basis, result_basis
from cases.errors import CaseError, IdentificationError
from cases.schema import Case, load_case
from identification.model import identification_model
from identification.outcome import Result
from postprocessors.export.targets import urscript_payload
from tests.helpers import one_line
from tests.postprocessors.export.calibrations import calibration, plausible

COMMAND = re.compile(r"set_target_payload\((\S+), \[(.*?)\], \[(.*?)\]\)")
INERTIA = np.array([[0.031, 0.002, -0.004], [0.002, 0.027, 0.001], [-0.004, 0.001, 0.019]])
CENTRE = np.array([0.012, -0.034, 0.105])


ADAPTER = {"origin_mm": (0.0, 0.0, 154.05), "rpy_deg": (0.0, 0.0, 90.0)}
"""A sensor 37.5 mm before the flange of the UR10e, turned by 90 degrees about it."""


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
    text = urscript_payload(calibration(tmp_path, "ur10_wrist", 6, body(2.6, INERTIA)))
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
    mass, centre, inertia = written(urscript_payload(made))
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
    _, centre, inertia = written(urscript_payload(made))
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
        urscript_payload(with_chain(calibration(tmp_path, "ur10_wrist", 6, body(2.6, INERTIA)), flange=None))
    one_line(caught.value)
    heavy = [0.9, 0.0003, 1e-4, 0.041, 0.004, 0.0, 0.0, 0.004, 0.0, 0.002, *[0.0] * 6]
    wrist = calibration(tmp_path / "wrist", "ft_wrist", 6, np.array(heavy))
    with pytest.raises(CaseError, match=r"sensor_frame\.transducer\.flange: is missing"):
        urscript_payload(wrist)
    data = wrist.case.model_dump()
    data["sensor_frame"]["transducer"]["flange"] = {"origin_mm": (0.0, 0.0, -40.0)}
    stated = replace(wrist, case=Case.model_validate(data))
    sensor = [wrist.parameters[f"{c}C"].value for c in "xyz"]
    np.testing.assert_allclose(written(urscript_payload(stated))[1], sensor + np.array([0, 0, 0.04]), atol=1e-5)
    with pytest.raises(CaseError, match="setup: is that of no robot"):
        urscript_payload(calibration(tmp_path / "hexapod", "hexapod", 9))


def test_a_flange_that_is_stated_later_does_not_make_results_stale() -> None:
    case = load_case("ur10_wrist")
    without = case.chain.model_copy(update={"flange": None})
    before = case.model_copy(update={"machine": case.machine.model_copy(update={"chain": without})})
    assert result_basis(before) == result_basis(case)
    assert plan_basis(before) == plan_basis(case)


@pytest.mark.parametrize("moments", [(1.0, 1.0, 2.5), (150.0, 150.0, 150.0)])
def test_what_is_no_load_of_a_robot_is_refused(moments: tuple[float, float, float], tmp_path: Path) -> None:
    with pytest.raises(IdentificationError, match="principal inertias") as caught:
        urscript_payload(calibration(tmp_path, "ur10_wrist", 6, body(30.0, np.diag(moments))))
    one_line(caught.value)


@pytest.mark.parametrize(("case", "model"), [("ur10_wrist", 0), ("strut_sensors", 6)])
def test_neither_a_static_model_nor_rods_of_struts_are_a_load(case: str, model: int, tmp_path: Path) -> None:
    with pytest.raises(IdentificationError, match="set_target_payload needs the inertia of a load alone"):
        urscript_payload(calibration(tmp_path, case, model))
