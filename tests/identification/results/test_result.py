"""A result can be saved, and its intervals are Student's."""

import json
from dataclasses import replace

import numpy as np
import pytest

from cases.base.text_formats import json_text
from cases.schema import load_case
from identification.estimation.estimators import Method
from identification.estimation.fit import Value
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.results.estimate import Estimate, entries_of, of_version_0_2
from identification.simulate import simulate_recording
from tests.helpers import Harmonic
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
EXECUTION = PoseExecution(Hexapod.of(CASE), Harmonic(duration=2.0))


@pytest.fixture(scope="module")
def estimate() -> Estimate:
    return estimate_parameters(simulate_recording(CASE, EXECUTION, np.array([[0.15, 1.85]]), 0, "run.csv"), CASE)


def test_an_interval_of_95_percent_is_student_s() -> None:
    """Quantiles of Student's distribution as printed in tables: 2.228 for 10 degrees of freedom, 1.960 for many."""
    value = Value(5.0, 2.0, 3.0, "kg")
    np.testing.assert_allclose(value.interval(10), (5.0 - 2.228 * 3.0, 5.0 + 2.228 * 3.0), atol=1e-3)
    np.testing.assert_allclose(value.interval(10**6), (5.0 - 1.96 * 3.0, 5.0 + 1.96 * 3.0), atol=1e-3)
    np.testing.assert_allclose(value.interval(10, 0.99), (5.0 - 3.169 * 3.0, 5.0 + 3.169 * 3.0), atol=1e-3)
    assert Value(5.0, 3.0, 2.0, "kg").interval(10) == value.interval(10)  # the larger of the two, as beside the value


def test_everything_that_a_result_says_is_json(estimate: Estimate) -> None:
    back = json.loads(json_text(entries_of(estimate).to_json()))
    assert back["case"] == "hexapod"
    assert back["case_hash"] == CASE.hash
    assert back["recording"] == "run.csv"
    assert (back["model"], back["rank"], back["samples"]) == (9, 20, 1700)
    assert back["parameters"]["m"] == estimate.physical["m"]._asdict()
    assert back["intervals_95"]["m"] == list(estimate.physical["m"].interval(estimate.fit.freedom))
    assert back["linear"]["values"] == estimate.fit.values.tolist()
    assert np.array(back["covariance"]).shape == (20, 20)
    assert back["delay_s"]["value"] == estimate.delay.value


def test_physical_standard_deviations_follow_from_the_covariance_of_the_linear_ones(estimate: Estimate) -> None:
    """Those of mass, offsets and factors are diagonal elements; that of xC is a ratio's, by hand."""
    std = dict(zip(estimate.model.names, np.sqrt(np.diag(estimate.fit.covariance)), strict=True))
    for name in ("m", "f_q0_1", "f_q0_6", "k0", "k3"):
        assert estimate.physical[name].std == pytest.approx(std[name])
    mass, first = estimate.fit.values[:2]
    gradient = np.array([-first / mass**2, 1 / mass])
    by_hand = np.sqrt(gradient @ estimate.fit.covariance[:2, :2] @ gradient)
    assert estimate.physical["xC"].std == pytest.approx(by_hand)


def test_rms_residuals_are_those_of_the_recorded_forces(estimate: Estimate) -> None:
    """The simulated noise is white with 1 N, so this is what is left of each channel."""
    np.testing.assert_allclose(estimate.residual_rms, CASE.simulation.force_noise_N, rtol=0.1)
    assert estimate.s0_N == pytest.approx(np.sqrt(np.mean(estimate.residual_rms**2)))


def test_s0_is_27_of_the_recorded_forces(estimate: Estimate) -> None:
    """By hand, with the residuals of the samples that are evaluated standing for all 1700 of them."""
    chi2 = 1700 * np.sum(estimate.residuals**2) / len(estimate.residuals)
    assert estimate.s0 == pytest.approx(np.sqrt(chi2 / (6 * 1700 - 20)), rel=1e-12)


def test_what_the_filter_removes_is_in_s0_and_not_in_the_white_noise() -> None:
    """A hum at 101 Hz of 3 N, far above the cut-off, leaves the deviations as they are."""
    run = simulate_recording(CASE, EXECUTION, np.array([[0.15, 1.85]]), 0, "run.csv")
    assert run.t is not None
    hum = 3.0 * np.sqrt(2.0) * np.sin(2.0 * np.pi * 101.3 * run.t)[:, None]
    found = estimate_parameters(replace(run, forces=run.forces + hum), CASE)
    assert found.s0 == pytest.approx(np.hypot(3.0, 1.0), rel=0.1)
    assert found.fit.white_noise == pytest.approx(1.0, rel=0.15)


@pytest.mark.repeats
def test_weights_enter_s0(estimate: Estimate) -> None:
    """White noise alike in all channels: with W from the residuals s0 is 1, as is the white noise."""
    run = simulate_recording(CASE, EXECUTION, np.array([[0.15, 1.85]]), 0, "run.csv")
    found = estimate_parameters(run, CASE, 9, Method(weights="per_channel"))
    assert found.s0 == pytest.approx(1.0, rel=0.1)
    assert found.s0 / found.fit.white_noise == pytest.approx(estimate.s0 / estimate.fit.white_noise, rel=0.05)


def test_a_file_of_version_0_2_states_the_white_noise_as_s0(estimate: Estimate) -> None:
    new = json.loads(json_text(entries_of(estimate).to_json()))
    old = {key: value for key, value in new.items() if key != "white_noise"} | {"s0": new["white_noise"]}
    read = of_version_0_2(old)
    assert read["white_noise"] == new["white_noise"]
    assert read["s0"] == pytest.approx(new["s0"], rel=1e-12)
    assert of_version_0_2(new) == new


def test_a_result_without_delay_says_so(estimate: Estimate) -> None:
    assert entries_of(replace(estimate, delay=None)).delay_s is None
