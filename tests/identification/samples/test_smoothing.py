"""Forces that are smoothed more, or less, than the motion: by their sampling, or by a low-pass of their channels."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters, physical_form
from identification.recording.recording import Recording
from identification.results.estimate import Estimate
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, ideal, simulated
from tests.identification.leaping import CASE, moves_without_jerk_limit
from tests.simulated_machine import PoseExecution, true_forces

MODEL = identification_model(CASE, 9)
TRUTH = physical_form(MODEL).of(linear_parameters(MODEL, CASE.simulation.parameters), np.eye(20))[0]
EXECUTION = moves_without_jerk_limit(0)
WINDOW = np.array([[0.25, EXECUTION.duration - 0.25]])
STEP = 1e-3  # [s] between samples


def run(offset: float, noise: float, seed: int = 0) -> Recording:
    """Sampled so much of a step after the encoders."""
    case = simulated(ideal(CASE), force_noise_N=noise, force_sampling_offset_cycles=offset)
    return simulate_recording(case, EXECUTION, WINDOW, seed, "run.csv")


def errors(estimate: Estimate) -> np.ndarray:
    """Of the physical parameters, in reported standard deviations."""
    return np.array([(v.value - t) / v.reported for v, t in zip(estimate.physical.values(), TRUTH, strict=True)])


@pytest.mark.first(1)
@pytest.mark.parametrize(("offset", "share"), [(0.0, -1 / 12), (0.25, 1 / 96), (0.5, 1 / 24)])
def test_pointwise_samples_of_leaping_forces_smooth_by_a_share_of_the_step_squared(offset: float, share: float) -> None:
    """Of straight lines between the ends of steps: trapezoids, midpoints, and B2(offset) / 2 between them."""
    found = estimate_parameters(run(offset, 0.05), CASE).quantities["smoothing_s2"]
    assert found["value"] == pytest.approx(share * STEP**2, abs=4.0 * found["std"] + 0.1 * abs(share) * STEP**2)
    assert found["std"] < 0.006 * STEP**2  # the test sees it


@pytest.mark.slow
def test_parameters_are_not_drawn_by_the_sampling() -> None:
    """Over noise of 6 seeds the errors centre on nothing; left out, the smoothing alone is several deviations."""
    estimates = [estimate_parameters(run(0.0, 0.2, seed), CASE) for seed in range(6)]
    centre = np.mean([errors(e) for e in estimates], axis=0)
    assert np.abs(centre).max() < 4.5 / np.sqrt(6)
    values = [e.quantities["smoothing_s2"]["value"] for e in estimates]
    std = np.mean([e.quantities["smoothing_s2"]["std"] for e in estimates])
    assert np.abs(np.mean(values) + STEP**2 / 12) < 4.0 * std / np.sqrt(6) + 0.1 * STEP**2 / 12


def test_a_low_pass_of_the_channels_is_found_as_delay_and_smoothing() -> None:
    """First order with time constant tau: 1 / (1 + tau s) = exp(-tau s) (1 + (tau s)^2 / 2 ..)."""
    tau, clean = 1e-3, run(0.5, 0.05)
    keep = np.exp(-0.1 * STEP / tau)
    fine = np.repeat(clean.forces, 10, axis=0)  # held over the step: half a step late, and a step wide
    slow = lfilter([1 - keep], [1, -keep], fine, axis=0, zi=keep * fine[:1])[0][9::10]
    found = estimate_parameters(replace(clean, forces=slow), CASE)
    assert found.quantities["smoothing_s2"]["value"] == pytest.approx(tau**2 / 2, rel=0.15)
    (note,) = [n for n in found.notes if "a second moment" in n]
    assert "smoothed against the motion" in note


@pytest.mark.repeats
def test_a_low_pass_of_the_forces_is_found_in_a_smooth_motion_too() -> None:
    """Left out, it would bias the mass by many deviations, which nothing would show."""
    tau, fine = 1 / (2.0 * np.pi * 20.0), 10
    execution = PoseExecution(Hexapod.of(CASE), Harmonic(seed=1, duration=2.0))
    record = simulate_recording(CASE, execution, np.array([[0.2, 1.8]]), 0)
    t = np.arange(-2.0, record.t[-1] + STEP, STEP / fine)
    keep = np.exp(-STEP / fine / tau)
    slow = lfilter([1 - keep], [1, -keep], true_forces(CASE, execution, t), axis=0)
    noise = np.random.default_rng(0).normal(0.0, 0.2, record.forces.shape)
    forces = np.array([np.interp(record.t, t, channel) for channel in slow.T]).T + noise
    found = estimate_parameters(replace(record, forces=forces), CASE)
    assert found.quantities["smoothing_s2"]["value"] == pytest.approx(tau**2 / 2, rel=0.15)
    assert np.abs(errors(found)).max() < 4.5


@pytest.mark.repeats
def test_noise_of_the_struts_is_not_taken_for_smoothing() -> None:
    """It disturbs forces by its second derivative and their bend by its fourth, which are opposite to each other."""
    noise = np.random.default_rng(0).normal(0.0, 2e-6, (len(run(0.5, 1.0).forces), 6))
    record = run(0.5, 1.0)
    assert record.drives is not None
    found = estimate_parameters(replace(record, drives=record.drives + noise), CASE)
    assert "smoothing_s2" not in found.quantities
    assert np.abs(errors(found)).max() < 4.5


@pytest.mark.repeats
def test_a_smooth_motion_cannot_tell_and_is_not_asked() -> None:
    execution = PoseExecution(Hexapod.of(CASE), Harmonic(seed=1, duration=3.0))
    found = estimate_parameters(simulate_recording(CASE, execution, np.array([[0.2, 2.8]]), 0), CASE)
    assert "smoothing_s2" not in found.quantities
    assert np.abs(errors(found)).max() < 4.5
