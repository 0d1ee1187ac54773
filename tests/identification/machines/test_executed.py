"""What a machine did is the same whether it is told by its platform or by its struts."""

import numpy as np
import pytest

from cases.schema import Case, load_case
from identification.machines.executed import Execution
from identification.machines.hexapod import Hexapod
from identification.motion.motion import Standstill
from identification.simulate import simulate_recording
from tests.helpers import HOME, Harmonic, ideal, simulated
from tests.simulated_machine import PoseExecution, true_forces

CASE = load_case("hexapod")
HEXAPOD = Hexapod.of(CASE)
BY_POSE = PoseExecution(HEXAPOD, Harmonic(seed=2))
INNER = np.linspace(0.1, 2.9, 300)  # [s] away from the ends, where a spline knows only one side


def by_struts(period: float) -> Execution:
    t = np.arange(round(3.0 / period) + 1) * period
    return Execution.of_log(HEXAPOD, period, BY_POSE.drives(t))


def test_logged_struts_tell_the_motion_of_the_platform() -> None:
    log, expected = by_struts(1e-3), BY_POSE.kinematics(INNER)
    found = log.kinematics(INNER)
    assert log.duration == pytest.approx(BY_POSE.duration)
    np.testing.assert_allclose(log.drives(INNER), BY_POSE.drives(INNER), atol=1e-10)
    np.testing.assert_allclose(found.pose, expected.pose, atol=1e-9)
    np.testing.assert_allclose(found.twist, expected.twist, atol=1e-6)
    np.testing.assert_allclose(found.twist_rate, expected.twist_rate, atol=1e-3)


def test_cubic_splines_lose_accelerations_with_the_square_of_the_cycle() -> None:
    error = [
        np.abs(by_struts(period).kinematics(INNER).twist_rate - BY_POSE.kinematics(INNER).twist_rate).max()
        for period in (0.02, 0.01, 0.005)
    ]
    np.testing.assert_allclose(np.log2(np.divide(error[:-1], error[1:])), 2.0, atol=0.3)


def test_forces_of_both_executions_agree() -> None:
    by_pose, by_log = (true_forces(CASE, e, INNER) for e in (BY_POSE, by_struts(1e-3)))
    np.testing.assert_allclose(by_log, by_pose, atol=0.05)


def test_forces_are_recorded_late_by_delay_and_sampling_offset() -> None:
    case = simulated(ideal(CASE), force_delay_ms=7.0, force_sampling_offset_cycles=0.5)
    recording = simulate_recording(case, BY_POSE, np.zeros((0, 2)), 0)
    rows = np.arange(100, 2900)
    np.testing.assert_allclose(
        recording.forces[rows], true_forces(case, BY_POSE, recording.t[rows] - 7.5e-3), atol=1e-9
    )


def test_encoders_record_whole_steps_and_lose_no_more_than_half_of_one() -> None:
    step = CASE.simulation.encoder_resolution
    recording = simulate_recording(CASE, BY_POSE, np.zeros((0, 2)), 0)
    np.testing.assert_allclose(recording.drives / step, np.round(recording.drives / step), atol=1e-3)
    assert np.abs(recording.drives - BY_POSE.drives(recording.t)).max() <= 0.501 * step


def test_noise_is_white_of_the_stated_size_and_repeats_with_its_seed() -> None:
    quiet, one, again, other = (
        simulate_recording(simulated(CASE, force_noise_N=n), BY_POSE, np.zeros((0, 2)), s).forces
        for n, s in ((0.0, 1), (2.0, 1), (2.0, 1), (2.0, 2))
    )
    noise = one - quiet
    assert noise.std() == pytest.approx(2.0, rel=0.03)
    assert np.abs(np.corrcoef(noise, rowvar=False) - np.eye(6)).max() < 0.1
    assert abs(np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1]) < 0.1
    np.testing.assert_array_equal(one, again)
    assert not np.array_equal(one, other)


def test_the_trigger_is_on_from_each_start_until_each_end() -> None:
    recording = simulate_recording(CASE, BY_POSE, np.array([[0.2, 0.5], [1.0, 1.001]]), 0)
    on = recording.t[recording.trigger]
    np.testing.assert_allclose(on, np.r_[np.arange(200, 500), 1000] * 1e-3, atol=1e-12)


def test_a_machine_at_rest_feels_weight_and_offsets_only() -> None:
    """At home the sensors share m g and the offsets stay; k0..k3 act on position and inclination, which are 0 there."""
    execution = PoseExecution(HEXAPOD, Standstill(HOME, 1.0))
    forces = true_forces(CASE, execution, np.array([0.5]))[0] - CASE.simulation.parameters.offsets_N
    bars = CASE.sensor_frame.bars
    direction = bars.upper.points - bars.lower.points
    upward = forces @ (direction[:, 2] / np.linalg.norm(direction, axis=1))
    assert upward == pytest.approx(31.83 * 9.81)


def test_a_case_without_simulated_machine_is_refused(wrist_case: Case) -> None:
    with pytest.raises(ValueError, match=r"simulation: .*missing.*sensor forces"):
        simulate_recording(wrist_case, BY_POSE, np.zeros((0, 2)), 0)
