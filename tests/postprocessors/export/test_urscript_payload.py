"""`set_target_payload`: mass, centre of gravity and inertia about it, in the order that the robot expects."""

import re
from pathlib import Path

import numpy as np
import pytest

from cases.errors import IdentificationError
from cases.schema import load_case
from identification.model import identification_model
from postprocessors.export.targets import urscript_payload
from tests.helpers import one_line
from tests.postprocessors.export.calibrations import calibration, plausible

COMMAND = re.compile(r"set_target_payload\((\S+), \[(.*?)\], \[(.*?)\]\)")
INERTIA = np.array([[0.031, 0.002, -0.004], [0.002, 0.027, 0.001], [-0.004, 0.001, 0.019]])
CENTRE = np.array([0.012, -0.034, 0.105])


def body(mass: float, inertia: np.ndarray, number: int = 9) -> np.ndarray:
    case = load_case("hexapod")
    u = plausible(case, identification_model(case, number))
    about_origin = inertia + mass * (CENTRE @ CENTRE * np.eye(3) - np.outer(CENTRE, CENTRE))
    u[:10] = [mass, *(mass * CENTRE), *about_origin[np.triu_indices(3)]]
    return u


def test_the_command_means_the_body(tmp_path: Path) -> None:
    text = urscript_payload(calibration(tmp_path, "hexapod", 9, body(2.6, INERTIA)))
    (found,) = COMMAND.findall(text)
    mass, (centre, elements) = float(found[0]), ([float(v) for v in part.split(",")] for part in found[1:])
    xx, yy, zz, xy, xz, yz = elements
    assert mass == pytest.approx(2.6, abs=1e-4)
    np.testing.assert_allclose(centre, CENTRE, atol=1e-5)
    np.testing.assert_allclose([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], INERTIA, atol=1e-6)
    lines = text.splitlines()
    assert re.fullmatch(r"def \w+\(\):", lines[0])
    assert lines[-1] == "end"
    assert all(line.startswith("  ") for line in lines[1:-1])
    assert text.isascii()


@pytest.mark.parametrize("moments", [(1.0, 1.0, 2.5), (150.0, 150.0, 150.0)])
def test_what_is_no_load_of_a_robot_is_refused(moments: tuple[float, float, float], tmp_path: Path) -> None:
    with pytest.raises(IdentificationError, match="principal inertias") as caught:
        urscript_payload(calibration(tmp_path, "hexapod", 9, body(30.0, np.diag(moments))))
    one_line(caught.value)


@pytest.mark.parametrize(("case", "model"), [("hexapod", 5), ("strut_sensors", 6)])
def test_neither_a_static_model_nor_rods_of_struts_are_a_load(case: str, model: int, tmp_path: Path) -> None:
    with pytest.raises(IdentificationError, match="set_target_payload needs the inertia of a load alone"):
        urscript_payload(calibration(tmp_path, case, model))
