"""`#LIMIT LOAD`: the same body, told by principal moments and a rotation; refused where no body is behind it."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cases.errors import IdentificationError
from cases.schema import load_case
from identification.model import identification_model
from postprocessors.export.targets import isg_load, principal_axes
from tests.helpers import one_line
from tests.postprocessors.export.calibrations import calibration, plausible

# The form that Beckhoff's diagnosis 22209 gives as right.
COMMAND = re.compile(
    r"#LIMIT LOAD DEF \[X=(\S+) Y=(\S+) Z=(\S+) RX=(\S+) RY=(\S+) RZ=(\S+) IX=(\S+) IY=(\S+) IZ=(\S+) MASS=(\S+) ID=1\]"
)
CASE = load_case("hexapod")


def body(mass: float, centre: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """U of model 9 with a given body: inertia about the centre of gravity."""
    u = plausible(CASE, identification_model(CASE, 9))
    about_origin = inertia + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    u[:10] = [mass, *(mass * centre), *about_origin[np.triu_indices(3)]]
    return u


def commanded(text: str) -> list[float]:
    (line,) = [line for line in text.splitlines() if line.startswith("#LIMIT LOAD DEF")]
    match = COMMAND.fullmatch(line)
    assert match is not None, line
    return [float(v) for v in match.groups()]


@given(angles=st.tuples(*[st.floats(-180.0, 180.0)] * 3), stretch=st.floats(0.05, 0.95))
def test_the_command_means_the_body(angles: tuple[float, float, float], stretch: float, tmp_path_factory) -> None:
    turn = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
    inertia = turn @ np.diag([1.2, 0.8, 0.45 + stretch]) @ turn.T
    centre = np.array([0.012, -0.034, 0.105])
    made = calibration(tmp_path_factory.mktemp("load"), "hexapod", 9, body(31.8, centre, inertia))
    x, y, z, rx, ry, rz, ix, iy, iz, mass = commanded(isg_load(made))
    again = Rotation.from_euler("ZYX", [rz, ry, rx], degrees=True).as_matrix()  # intrinsic: C, then B, then A
    np.testing.assert_allclose(again @ np.diag([ix, iy, iz]) @ again.T, inertia, atol=5e-6)
    np.testing.assert_allclose([x, y, z, mass], [*(centre * 1e3), 31.8], atol=1e-4)


def test_axes_that_nearly_fit_stay_where_they_are() -> None:
    """No exchange of axes where a small turn does: the operator recognises the body."""
    turn = Rotation.from_euler("xyz", [2.0, -1.0, 3.0], degrees=True).as_matrix()
    moments, found = principal_axes(turn @ np.diag([1.3, 0.7, 0.9]) @ turn.T)
    np.testing.assert_allclose(moments, [1.3, 0.7, 0.9])
    np.testing.assert_allclose(found, turn, atol=1e-12)


def test_a_static_model_has_no_inertia_to_tell(tmp_path: Path) -> None:
    with pytest.raises(IdentificationError, match=r"model 5 .*no inertia.*model 6, 7, 8 or 9") as caught:
        isg_load(calibration(tmp_path, "hexapod", 5))
    one_line(caught.value)


@pytest.mark.parametrize("moments", [(1.0, 1.0, 2.5), (1.0, 1.0, -0.1)])
def test_an_inertia_of_no_body_is_refused(moments: tuple[float, float, float], tmp_path: Path) -> None:
    made = calibration(tmp_path, "hexapod", 9, body(30.0, np.array([0.0, 0.0, 0.1]), np.diag(moments)))
    with pytest.raises(IdentificationError, match="principal inertias") as caught:
        isg_load(made)
    one_line(caught.value)


def test_the_file_is_ascii_and_says_units_and_frame(tmp_path: Path) -> None:
    text = isg_load(calibration(tmp_path, "hexapod", 9, warnings=["rank 19 of 20 \N{EM DASH} see"]))
    assert text.isascii()
    for word in ("[mm]", "[kg m^2]", "platform frame {P}", "WARNING: rank 19", "case hexapod", "model 9", "hexcite"):
        assert word in text
    assert all(len(line) <= 4096 for line in text.splitlines())  # the longest block of the kernel


def test_the_rods_of_struts_are_no_load(tmp_path: Path) -> None:
    """Sensors at the drives carry platform and rods in one; no command for a load is made of that."""
    with pytest.raises(IdentificationError, match="rods"):
        isg_load(calibration(tmp_path, "strut_sensors", 6))
