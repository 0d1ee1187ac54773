"""The loaded and disturbed machine: bodies add, the mode is an oscillator, errors of the pose belong to the machine."""

from functools import reduce

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.base.errors import CaseError
from cases.schema import load_case
from cases.sensors import together
from identification.identify import estimate_parameters
from identification.machines.executed import Execution, mode_frequency, rippled, vibrating
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.model.parameters import body_parameters, linear_parameters
from identification.motion.motion import Standstill
from identification.simulate import (
    Circumstances,
    circumstances,
    loaded_truth,
    pose_fields,
)
from tests.helpers import Harmonic, paper_poses, pose_covariance
from tests.simulated_machine import PoseExecution, simulate_standstills, true_forces

CASE = load_case("hexapod")
WEIGHTS = CASE.payloads.weights
TRUTH = CASE.simulation.parameters
FOUND = CASE.simulation.disturbances
HOME = CASE.machine.home.vector
EXECUTION = PoseExecution(Hexapod.of(CASE), Harmonic(seed=2, duration=3.0))
Q5M = (1.28, 1.37, 1.48, 1.65, 1.94, 2.30)  # Table 7: s0 from 0 to 100 kg


def random_poses(count: int) -> np.ndarray:
    return HOME + np.random.default_rng(5).uniform(-1, 1, (count, 6)) * ([0.25] * 3 + [0.3] * 3)


def test_the_parameters_of_a_joined_body_are_the_sums_of_those_of_its_parts():
    joined = body_parameters(reduce(together, WEIGHTS[:3], TRUTH.body))
    parts = [body_parameters(b) for b in (TRUTH.body, *WEIGHTS[:3])]
    for name, value in joined.items():
        assert value == pytest.approx(sum(p[name] for p in parts), abs=1e-12)


@pytest.mark.parametrize(("weights", "mass", "z"), [(1, 51.76, 95.87), (2, 71.69, 109.12), (3, 91.62, 130.15)])
def test_weights_give_the_theoretical_values_behind_table_7(weights: int, mass: float, z: float):
    """Printed values and relative deviations of column D9M, solved for the theoretical ones."""
    body = loaded_truth(TRUTH, WEIGHTS[:weights]).body
    assert body.mass_kg == pytest.approx(mass, abs=0.005)
    assert body.centre_of_gravity_mm[2] == pytest.approx(z, rel=0.005)


def test_forces_of_weights_are_those_of_a_heavier_platform():
    t = np.linspace(0.0, 3.0, 50)
    loaded: np.ndarray = true_forces(CASE, EXECUTION, t, Circumstances(WEIGHTS[:2]))
    model = identification_model(CASE, 9)
    difference = linear_parameters(model, loaded_truth(TRUTH, WEIGHTS[:2])) - linear_parameters(model, TRUTH)
    assert difference[model.names.index("m")] == pytest.approx(2 * 19.93)
    assert np.all(difference[model.names.index("f_q0_1") :] == 0.0)
    assert np.abs(loaded - true_forces(CASE, EXECUTION, t)).max() > 50.0


@pytest.mark.parametrize("frequency", [5.0, 20.0, 40.0])
def test_the_mode_answers_a_sine_as_the_oscillator_does(frequency: float):
    step, mode, damping = 1e-4, 25.0, 0.1
    t = np.arange(0.0, 6.0, step)
    answer = vibrating(np.sin(2 * np.pi * frequency * t)[:, None], step, mode, damping)[len(t) // 2 :, 0]
    s, w = 2j * np.pi * frequency, 2 * np.pi * mode
    gain = abs((2 * damping * w * s + w**2) / (s**2 + 2 * damping * w * s + w**2))
    assert np.sqrt(2 * np.mean(answer**2)) == pytest.approx(gain, rel=1e-3)


def test_a_steady_acceleration_passes_the_mode_unchanged():
    assert vibrating(np.ones((20_000, 1)), 1e-3, 30.0, 0.1)[-1, 0] == pytest.approx(1.0, abs=1e-9)


def test_the_mode_falls_with_the_root_of_the_mass():
    bare, full = (mode_frequency(FOUND, TRUTH.body.mass_kg, Circumstances(WEIGHTS[:k], FOUND).load) for k in (0, 5))
    assert full / bare == pytest.approx(np.sqrt(31.83 / (31.83 + 5 * 19.93)))


def test_the_pose_error_has_its_size_and_grows_with_the_payload_alone():
    poses = random_poses(20_000)
    fields = pose_fields(FOUND, HOME, poses)
    bare, of_load = fields[0], 1000.0 * fields[1]
    assert np.sqrt(np.mean(bare**2)) == pytest.approx(FOUND.pose_error_N, rel=0.05)
    assert np.sqrt(np.mean(of_load**2)) == pytest.approx(1000.0 * FOUND.pose_error_of_load, rel=0.05)


def test_averaging_does_not_remove_the_pose_error():
    poses = random_poses(40)
    around = Circumstances((), FOUND)
    runs = [simulate_standstills(CASE, poses, 10_000, seed, around).forces for seed in range(20)]
    ideal = [simulate_standstills(CASE, poses, 10_000, seed).forces for seed in range(20)]
    left = np.mean(runs, axis=0) - np.mean(ideal, axis=0)
    assert np.sqrt(np.mean(left**2)) > 0.7 * FOUND.pose_error_N


def test_the_ripple_moves_struts_at_its_share_of_their_speed_and_differs_from_run_to_run():
    one, other = (rippled(EXECUTION, FOUND, seed) for seed in (0, 1))
    assert isinstance(one, Execution)
    t = np.arange(0.0, 3.0, 1e-3)
    spread = one.drives(t) - EXECUTION.drives(t)
    velocity = np.gradient(spread, 1e-3, axis=0)
    speed = np.abs(EXECUTION.drives(t, 1))
    share = np.sqrt(np.mean(velocity**2) / np.mean(speed**2))
    assert share == pytest.approx(FOUND.strut_velocity_noise_percent / 100.0, rel=0.15)
    slow = speed < np.quantile(speed, 0.2, axis=0)
    assert np.sqrt(np.mean(velocity[slow] ** 2)) < 0.5 * np.sqrt(np.mean(velocity**2))
    assert np.abs(one.drives(t) - other.drives(t)).max() > 1e-7


def test_what_stands_does_not_ripple():
    still = rippled(PoseExecution(Hexapod.of(CASE), Standstill(HOME, 1.0)), FOUND, 0)
    assert np.ptp(still.drives(np.linspace(0.0, 1.0, 200)), axis=0).max() < 1e-9


def test_the_error_of_the_pose_has_the_covariance_that_it_is_drawn_from():
    """Between 12 poses 10 mm and 1 degree apart, over 400 machines."""
    poses = HOME + np.arange(12)[:, None] * np.r_[np.full(3, 0.01), np.full(3, np.deg2rad(1.0))]
    weight = 500.0
    machines = (FOUND.model_copy(update={"pose_error_seed": 1000 + k}) for k in range(400))
    drawn = np.array([fields[0] + weight * fields[1] for fields in (pose_fields(m, HOME, poses) for m in machines)])
    covariance = np.einsum("mis,mjs->ij", drawn, drawn) / (400 * 6)
    told = pose_covariance(FOUND, HOME, poses, weight)
    np.testing.assert_allclose(covariance, told, atol=0.1 * told[0, 0])


def test_s0_of_the_480_poses_grows_with_the_load_as_table_7_prints_it():
    """Column Q5M, within a factor 1.5 at each step, with one set of values."""
    places, turns = paper_poses()
    poses = np.column_stack([places, Rotation.from_matrix(turns).as_euler("xyz")])
    for k, printed in enumerate(Q5M):
        recording = simulate_standstills(CASE, poses, 1000, k, circumstances(CASE, k, disturbed=True))
        assert printed / 1.5 < estimate_parameters(recording, CASE, 5).s0_N < printed * 1.5


def test_more_weights_than_the_case_has_are_refused():
    with pytest.raises(CaseError, match=r"payloads\.weights: .*\b5; 6\b"):
        circumstances(CASE, 6, disturbed=False)


def test_a_case_without_disturbances_says_so():
    bare = CASE.model_copy(update={"simulation": CASE.simulation.model_copy(update={"disturbances": None})})
    with pytest.raises(CaseError, match=r"simulation\.disturbances"):
        circumstances(bare, 0, disturbed=True)
