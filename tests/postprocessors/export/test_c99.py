"""The exported C says what (1)-(15) say, to rounding, for every model, in bounded time, whatever its inputs are."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.schema import Case, load_case
from identification.machines.hexapod import Hexapod
from identification.machines.machine import Kinematics
from identification.model.model import expected_forces
from identification.motion.motion import Standstill
from identification.results.taring import tare
from identification.simulate import simulate_recording
from postprocessors.export.calibration import MOST_STEPS, result_hash
from postprocessors.export.code import RING, c_sources, half_window
from tests.helpers import HOME, Harmonic, few, simulated
from tests.postprocessors.export.calibrations import calibration, with_drives
from tests.postprocessors.export.compiled import BAD_INPUT, FILLING, NOT_CLOSED, OK, Chain, Compiled
from tests.postprocessors.export.physics import external, states
from tests.simulated_machine import PoseExecution

pytestmark = pytest.mark.usefixtures("gcc")
CASE = load_case("hexapod")
ROUNDING = 1e-12
"""Agreement, relative to the largest component of the forces that are added up."""


@pytest.fixture(scope="module")
def nine(tmp_path_factory: pytest.TempPathFactory, gcc: None) -> Compiled:
    folder = tmp_path_factory.mktemp("nine")
    return Compiled(calibration(folder, "hexapod", 9), folder)


def values(folder: Path, case: str, number: int) -> dict[str, float]:
    made = calibration(folder, case, number)
    return dict(zip(made.model.names, made.values, strict=True))


@pytest.mark.first(1)
@pytest.mark.parametrize("number", few(9, 4, 0, 1, 2, 3, 5, 6, 7, 8, kept=3))
def test_the_model_is_the_papers_from_struts_and_from_poses(number: int, tmp_path: Path) -> None:
    compiled = Compiled(calibration(tmp_path, "hexapod", number), tmp_path)
    u = values(tmp_path, "hexapod", number)
    s = states(CASE, 200, number)
    for k in range(len(s.pose)):
        expected = external(CASE, u, s.pose[k], s.twist[k], s.twist_rate[k], s.forces[k])
        scale = max(np.abs(expected).max(), np.abs(s.forces[k]).max())
        posed = compiled.wrench("from_pose", s.pose[k], s.rates[k], s.accelerations[k], s.forces[k])
        assert np.abs(posed - expected).max() <= ROUNDING * scale
        compiled("init")  # from home: random states do not follow each other
        strutted = compiled.wrench("from_struts", s.lengths[k], s.velocities[k], s.strut_accelerations[k], s.forces[k])
        assert np.abs(strutted - expected).max() <= ROUNDING * scale
        assert compiled.steps <= 6


def test_struts_follow_from_drives_as_the_case_states(tmp_path: Path) -> None:
    compiled = Compiled(with_drives(calibration(tmp_path, "hexapod", 9)), tmp_path)
    q = np.arange(1.0, 7.0)
    expected = [2.0 + 0.5, -1.0 + 0.51, 3.0 + 0.52, 6.0 + 0.53, -5.0 + 0.54, -4.0 + 0.55]
    np.testing.assert_allclose(compiled.struts_of_drives(q, 0), expected, rtol=1e-15)
    for order in (1, 2):
        np.testing.assert_array_equal(compiled.struts_of_drives(q, order), [2.0, -1.0, 3.0, 6.0, -5.0, -4.0])


@pytest.mark.parametrize("number", [0, 3, 4, 6, 8])
def test_a_force_torque_sensor_has_no_struts_but_the_same_model(number: int, tmp_path: Path) -> None:
    case = load_case("ft_wrist")
    made = calibration(tmp_path, "ft_wrist", number)
    compiled = Compiled(made, tmp_path)
    u = dict(zip(made.model.names, made.values, strict=True))
    s = states(case, 50, number)
    for k in range(len(s.pose)):
        expected = external(case, u, s.pose[k], s.twist[k], s.twist_rate[k], s.forces[k])
        found = compiled.wrench("from_pose", s.pose[k], s.rates[k], s.accelerations[k], s.forces[k])
        assert np.abs(found - expected).max() <= ROUNDING * max(np.abs(expected).max(), np.abs(s.forces[k]).max())
    assert "from_struts" not in c_sources(made, "wrist_force")[0]


def test_at_a_kilohertz_three_steps_close_the_struts(nine: Compiled) -> None:
    """The pose of the cycle before is at most 1.1 mm away at full speed."""
    nine("init")
    motion = Harmonic(seed=3, duration=3.0, size=0.8).at(np.arange(0, 3.0, 1e-3))
    lengths = Hexapod.of(CASE).strut_lengths(motion.coordinates)
    zero = np.zeros(6)
    steps = []
    for row in lengths:
        nine.wrench("from_struts", row, zero, zero, zero)
        steps.append(nine.steps)
    assert max(steps[1:]) <= 3
    np.testing.assert_allclose(np.array(nine.model.pose), motion.coordinates[-1], atol=1e-13)


def test_struts_that_do_not_close_end_after_bounded_steps_and_change_nothing(nine: Compiled) -> None:
    nine("init")
    zero = np.zeros(6)
    good = Hexapod.of(CASE).strut_lengths(HOME[None])[0]
    before = nine.wrench("from_struts", good, zero, zero, np.full(6, 100.0))
    pose = np.array(nine.model.pose)
    assert nine("from_struts", good * [0.2, 1, 1, 1, 1, 3], zero, zero, zero, nine.external) == NOT_CLOSED
    assert nine.steps <= 2 * MOST_STEPS
    np.testing.assert_array_equal(np.array(nine.external), before)
    np.testing.assert_array_equal(np.array(nine.model.pose), pose)
    np.testing.assert_array_equal(nine.wrench("from_struts", good, zero, zero, np.full(6, 100.0)), before)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
@pytest.mark.parametrize("place", range(4))
def test_an_input_that_is_no_number_is_refused(bad: float, place: int, nine: Compiled) -> None:
    good = [Hexapod.of(CASE).strut_lengths(HOME[None])[0], np.zeros(6), np.zeros(6), np.full(6, 50.0)]
    before = nine.wrench("from_struts", *good)
    broken = [g.copy() for g in good]
    broken[place][2] = bad
    assert nine("from_struts", *broken, nine.external) == BAD_INPUT
    np.testing.assert_array_equal(np.array(nine.external), before)
    broken[0] = HOME.copy() if place else np.full(6, bad)
    assert nine("from_pose", *broken, nine.external) == BAD_INPUT
    np.testing.assert_array_equal(nine.wrench("from_struts", *good), before)


def test_a_tare_does_what_hexcite_tare_does(tmp_path: Path) -> None:
    made = calibration(tmp_path, "hexapod", 9)
    compiled = Compiled(made, tmp_path)
    execution = PoseExecution(Hexapod.of(CASE), Standstill(np.add(HOME, [0.05, 0.1, 0.0, 0.1, -0.1, 0.05]), 0.4))
    recording = simulate_recording(CASE, execution, np.zeros((0, 2)), 3, "still.csv")
    expected = tare(recording, made)
    zero = np.zeros(6)
    compiled("tare_begin")
    assert recording.drives is not None
    for struts, forces in zip(recording.drives, recording.forces, strict=True):
        compiled.wrench("from_struts", struts, zero, zero, forces)
        compiled("tare_add")
    assert compiled("tare_end") == len(recording.forces)
    np.testing.assert_allclose(np.array(compiled.model.parameters), expected.values, rtol=1e-9, atol=1e-9)
    assert compiled("tare_end") == 0  # nothing was added since
    np.testing.assert_allclose(np.array(compiled.model.parameters), expected.values, rtol=1e-9, atol=1e-9)


def test_the_signal_chain_is_exact_for_constant_acceleration(nine: Compiled) -> None:
    """Position, velocity and acceleration half a window ago, forces by their mean there; a whole cycle of delay too."""
    step, half, late = 1e-3, 10, 3
    chain = Chain(nine, step, half * step, late * step)
    q0, v0, a0 = np.arange(1.0, 7.0), np.linspace(-1, 1, 6), np.linspace(5, -5, 6)
    for n in range(60):
        t = n * step
        status = chain.push(q0 + v0 * t + a0 * t * t / 2, np.full(6, 2.0 * (n - late)))  # a ramp, measured late
        assert status == (FILLING if n < 2 * half + 1 + late else OK)
    then = (59 - half - late) * step
    np.testing.assert_allclose(np.array(chain.sample.velocity), v0 + a0 * then, rtol=1e-9)
    np.testing.assert_allclose(np.array(chain.sample.acceleration), a0, rtol=1e-7)
    np.testing.assert_allclose(np.array(chain.sample.force), 2.0 * (59 - half - late), rtol=1e-12)
    smoothing = a0 * (half**2 - 1) / 12 * step**2  # variance of the triangle times half the curvature
    np.testing.assert_allclose(
        np.array(chain.sample.position), q0 + v0 * then + a0 * then**2 / 2 + smoothing, rtol=1e-9
    )


@pytest.mark.first(1)
@pytest.mark.parametrize("delay_ms", [2.5, -1.7, 0.0])
def test_the_chain_reads_no_force_from_a_fast_motion_with_late_noisy_forces(delay_ms: float, tmp_path: Path) -> None:
    """Raw encoder positions and late, noisy forces of a moving machine without contact leave noise alone."""
    case: Case = simulated(CASE, force_delay_ms=delay_ms, force_sampling_offset_cycles=0.0)
    from identification.model.model import identification_model
    from identification.model.parameters import linear_parameters

    assert case.simulation is not None
    truth = linear_parameters(identification_model(case, 9), case.simulation.parameters)
    compiled = Compiled(calibration(tmp_path, "hexapod", 9, truth), tmp_path)
    run = simulate_recording(case, PoseExecution(Hexapod.of(case), Harmonic(seed=4, duration=3.0)), np.zeros((0, 2)), 0)
    half = half_window(CASE)
    chain = Chain(compiled, 1e-3, half, delay_ms * 1e-3)
    assert chain.status == OK
    found, plain = [], []
    assert run.drives is not None
    for struts, forces in zip(run.drives, run.forces, strict=True):
        if chain.push(struts, forces) == OK:
            s = chain.sample
            compiled.wrench("from_struts", *(np.array(v) for v in (s.position, s.velocity, s.acceleration, s.force)))
            found.append(np.array(compiled.external))
            plain.append(np.array(s.force))
    triangle = np.r_[1 : round(half * 1e3) + 1, round(half * 1e3) - 1 : 0 : -1] / round(half * 1e3) ** 2

    noise = np.linalg.norm(triangle) * np.linalg.norm(CASE.sensor_frame.structure, axis=1)  # of 1 N a sensor
    rms = np.sqrt(np.mean(np.square(found), axis=0))
    assert np.std(plain, axis=0).max() > 20.0  # N: the motion itself
    assert np.all(rms < 1.5 * noise)
    assert np.all(rms > 0.7 * noise)


@pytest.mark.parametrize(
    ("step", "half", "delay"),
    [
        (0.0, 0.01, 0.0),
        (1e-3, 0.0, 0.0),
        (1e-3, 0.2, 0.0),
        (1e-3, 0.01, 0.3),
        (np.nan, 0.01, 0.0),
        (1e-3, 0.01, np.nan),
    ],
)
def test_a_signal_chain_that_does_not_fit_is_refused(step: float, half: float, delay: float, nine: Compiled) -> None:
    chain = Chain(nine, step, half, delay)
    assert chain.status == BAD_INPUT
    assert chain.push(np.ones(6), np.ones(6)) == BAD_INPUT


def test_the_longest_signal_chain_that_fits_works(nine: Compiled) -> None:
    chain = Chain(nine, 1e-3, (RING - 2) // 2 * 1e-3, 0.0)
    assert chain.status == OK
    for n in range(3 * RING):
        status = chain.push(np.full(6, 2.0 * n), np.full(6, 1.0))
    assert status == OK
    np.testing.assert_allclose(np.array(chain.sample.velocity), 2000.0)


def test_the_header_says_where_the_numbers_are_from(tmp_path: Path) -> None:
    made = calibration(tmp_path, "hexapod", 9, warnings=["poses cover */ little \N{DEGREE SIGN}\nat all"])
    for text in (*c_sources(made, "x"),):
        assert text.isascii()
        for word in (str(tmp_path), result_hash(made), CASE.hash, "model 9", "hexcite 0", "WARNING: poses cover"):
            assert word in text
    Compiled(made, tmp_path)


@pytest.mark.repeats
def test_forces_in_struts_become_one_on_the_platform_by_the_matrix_of_its_pose(tmp_path: Path) -> None:
    case = load_case("strut_sensors")
    made = calibration(tmp_path, "strut_sensors", 6)
    compiled, model = Compiled(made, tmp_path), made.model
    s = states(case, 20, 6)
    left = s.forces - expected_forces(model, Kinematics(s.pose, s.twist, s.twist_rate), made.values)
    expected = -model.wrenches(left, s.pose)
    for k in range(len(s.pose)):
        found = compiled.wrench("from_pose", s.pose[k], s.rates[k], s.accelerations[k], s.forces[k])
        np.testing.assert_allclose(found, expected[k], atol=1e-9 * np.abs(expected[k]).max())
        turned = Rotation.from_euler("xyz", s.pose[k, 3:]).as_matrix()
        joints = case.hexapod.platform.points
        struts = (s.pose[k, :3] + joints @ turned.T - case.hexapod.base.points) @ turned
        along = struts / np.linalg.norm(struts, axis=1)[:, None]
        pushed = -np.hstack([along, np.cross(joints, along)]).T @ left[k]
        np.testing.assert_allclose(expected[k], pushed, atol=1e-9 * np.abs(pushed).max())
