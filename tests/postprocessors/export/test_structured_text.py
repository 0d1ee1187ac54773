"""The exported Structured Text parses as a third party's parser reads it, and computes what (1)-(15) say."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.schema import load_case
from identification.machines.hexapod import Hexapod
from identification.motion.motion import Standstill
from identification.results.result import Result
from identification.results.taring import tare
from identification.simulate import simulate_recording
from postprocessors.export.calibration import MOST_STEPS, result_hash
from postprocessors.export.code import structured_text
from tests.helpers import HOME
from tests.postprocessors.export.calibrations import calibration, with_drives
from tests.postprocessors.export.physics import external, states
from tests.postprocessors.export.plc import Cell, Plc, Scope
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
ROUNDING = 1e-12


class Block:
    """An instance of the exported function block."""

    def __init__(self, plc: Plc, name: str) -> None:
        self.plc, self.name = plc, name
        self.scope: Scope = plc.block(name)

    def __call__(self, **inputs: Any) -> np.ndarray:
        """One cycle; force and moment."""
        self.plc.cycle(self.name, self.scope, **inputs)
        return np.array(self.scope["wrench"].value)

    def __getitem__(self, name: str) -> Any:
        return self.scope[name.lower()].value


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Result:
    return calibration(tmp_path_factory.mktemp("nine"), "hexapod", 9)


@pytest.fixture(scope="module")
def loaded(made: Result) -> Plc:
    return Plc().load(structured_text(made, "hexapod_force"))


@pytest.fixture
def block(loaded: Plc) -> Callable[[], Block]:
    return lambda: Block(loaded, "FB_HexapodForce")


def test_the_function_block_computes_the_papers_model(made: Result, block: Callable[[], Block]) -> None:
    u = dict(zip(made.model.names, made.values, strict=True))
    s = states(CASE, 6, 0)
    for k in range(len(s.pose)):
        expected = external(CASE, u, s.pose[k], s.twist[k], s.twist_rate[k], s.forces[k])
        scale = max(np.abs(expected).max(), np.abs(s.forces[k]).max())
        at_home = block()
        posed = at_home(
            FromPose=True, Position=s.pose[k], Velocity=s.rates[k], Acceleration=s.accelerations[k], Forces=s.forces[k]
        )
        assert at_home["Valid"]
        assert np.abs(posed - expected).max() <= ROUNDING * scale
        at_home = block()
        strutted = at_home(
            Position=s.lengths[k], Velocity=s.velocities[k], Acceleration=s.strut_accelerations[k], Forces=s.forces[k]
        )
        assert at_home["Valid"]
        assert at_home["Steps"] <= 6
        assert np.abs(strutted - expected).max() <= ROUNDING * scale


def test_struts_follow_from_drives_as_the_case_states(tmp_path: Path) -> None:
    text = structured_text(with_drives(calibration(tmp_path, "hexapod", 0)), "hexapod_force")
    begin = text.index("FUNCTION F_HexapodForceStrutsOfDrives")
    plc = Plc().load(text[begin : text.index("END_FUNCTION", begin)] + "END_FUNCTION\n")
    expected = [2.0 + 0.5, -1.0 + 0.51, 3.0 + 0.52, 6.0 + 0.53, -5.0 + 0.54, -4.0 + 0.55]
    for order, values in ((0, expected), (1, [2.0, -1.0, 3.0, 6.0, -5.0, -4.0])):
        drives, struts = Cell("LREAL[]", [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), Cell("LREAL[]", [0.0] * 6)
        plc.function("F_HexapodForceStrutsOfDrives", {"drives": drives, "struts": struts}, order=order)
        np.testing.assert_allclose(struts.value, values, rtol=1e-15)


@pytest.mark.repeats
def test_a_force_torque_sensors_block_needs_no_struts(tmp_path: Path) -> None:
    case, number = load_case("ft_wrist"), 4
    made = calibration(tmp_path, "ft_wrist", number)
    block = Block(Plc().load(structured_text(made, "ft_wrist_force")), "FB_FtWristForce")
    u = dict(zip(made.model.names, made.values, strict=True))
    s = states(case, 5, number)
    for k in range(len(s.pose)):
        expected = external(case, u, s.pose[k], s.twist[k], s.twist_rate[k], s.forces[k])
        found = block(Position=s.pose[k], Velocity=s.rates[k], Acceleration=s.accelerations[k], Forces=s.forces[k])
        assert block["Valid"]
        assert np.abs(found - expected).max() <= ROUNDING * max(np.abs(expected).max(), np.abs(s.forces[k]).max())


def test_bad_inputs_and_open_struts_keep_the_outputs(block: Callable[[], Block]) -> None:
    one = block()
    home = Hexapod.of(CASE).strut_lengths(HOME[None])[0]
    before = one(Position=home, Forces=np.full(6, 100.0))
    assert one["ErrorId"] == 0
    for inputs, code in (
        ({"Position": home * [0.2, 1, 1, 1, 1, 3]}, 2),
        ({"Position": home, "Forces": np.r_[np.nan, np.zeros(5)]}, 1),
        ({"Position": home, "Forces": np.zeros(6), "Velocity": np.r_[np.zeros(5), 1e300]}, 1),
    ):
        np.testing.assert_array_equal(one(**inputs), before)
        assert not one["Valid"]
        assert one["ErrorId"] == code
        assert one["Steps"] <= 2 * MOST_STEPS
    again = one(Position=home, Velocity=np.zeros(6), Forces=np.full(6, 100.0))
    np.testing.assert_allclose(again, before, rtol=1e-12)
    assert one["Valid"]


@pytest.mark.repeats
def test_a_tare_does_what_hexcite_tare_does(made: Result, block: Callable[[], Block]) -> None:
    execution = PoseExecution(Hexapod.of(CASE), Standstill(np.add(HOME, [0.05, 0.1, 0.0, 0.1, -0.1, 0.05]), 0.05))
    recording = simulate_recording(CASE, execution, np.zeros((0, 2)), 3, "still.csv")
    expected = tare(recording, made)
    one = block()
    assert recording.drives is not None
    for struts, forces in zip(recording.drives, recording.forces, strict=True):
        one(Position=struts, Forces=forces, Tare=True)
    one(Tare=False)
    found = [cell.value for cell in one["parameters"].values()]
    np.testing.assert_allclose(found, expected.values, rtol=1e-9, atol=1e-9)
    one()
    np.testing.assert_array_equal([cell.value for cell in one["parameters"].values()], found)


def test_the_text_says_where_the_numbers_are_from(tmp_path: Path) -> None:
    made = calibration(tmp_path, "hexapod", 9, warnings=["poses cover *) little \N{DEGREE SIGN}"])
    text = structured_text(made, "hexapod_force")
    assert text.isascii()
    head = text[: text.index("(* The linear")]
    assert head.count("*)") == 1
    for word in (str(tmp_path), result_hash(made), CASE.hash, "model 9", "hexcite 0", "WARNING: poses cover"):
        assert word in head


@pytest.mark.slow
def test_every_line_parses(made: Result) -> None:
    from blark.parse import parse_source_code

    assert parse_source_code(structured_text(made, "hexapod_force")).exception is None
