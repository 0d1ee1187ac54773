"""Treatments that the paper tried: accelerated sections, a Fourier series of the motion, other low-passes or none."""

import math
from dataclasses import replace

import numpy as np
import pytest

import hexcite as hx
from cases.base.errors import HexciteError, IdentificationError
from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.samples.moving_window import moving_run
from identification.samples.treatment import WIDEST, Treatment
from identification.simulate import simulate_recording
from tests.bench.table_3 import standing_run
from tests.helpers import Harmonic, one_line
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
MOTION = Harmonic(seed=1, duration=2.0)
CLEAN = simulate_recording(CASE, PoseExecution(Hexapod.of(CASE), MOTION), np.array([[0.15, 1.85]]), 0, "run.csv")
NOISY = replace(CLEAN, drives=CLEAN.drives + 20e-6 * np.random.default_rng(4).normal(size=CLEAN.drives.shape))
TRUTH = CASE.need_simulation("the test").parameters.body


def accelerations_off(treatment: Treatment | None) -> float:
    """Rms error of the platform's accelerations in a run with noisy encoders [m/s^2]."""
    run = moving_run(NOISY, CASE, MODEL) if treatment is None else treatment.run(NOISY, CASE, MODEL)
    clean = moving_run(CLEAN, CASE, MODEL)
    away = run.kinematics(0.0).twist_rate - clean.kinematics(0.0).twist_rate
    return float(np.sqrt(np.mean(away[5:-5, :3] ** 2)))  # at the ends the filter reaches beyond the series


@pytest.mark.repeats
def test_a_fourier_series_of_the_motion_filters_noisy_encoders() -> None:
    """Encoders of 20 um: the series of the motion's own period has their noise in nine numbers alone."""
    plain, series = accelerations_off(None), accelerations_off(Treatment(period=2.0, harmonics=4))
    assert series < 0.2 * plain
    result = hx.identify(NOISY, CASE, treatment=Treatment(period=2.0, harmonics=4))
    assert abs(result["m"].value - TRUTH.mass_kg) < 5.0 * result["m"].reported
    assert result.record.treatment["fourier"] == {"period_s": 2.0, "harmonics": 4}


def test_a_motion_that_is_not_this_series_is_refused() -> None:
    for wrong in (Treatment(period=1.3, harmonics=4), Treatment(period=2.0, harmonics=2)):
        with pytest.raises(IdentificationError, match=r"run\.csv.*Fourier series.*harmonics.*%") as caught:
            hx.identify(CLEAN, CASE, treatment=wrong)
        one_line(caught.value)


def test_accelerated_sections_are_those_and_hold_the_truth() -> None:
    whole, part = moving_run(CLEAN, CASE, MODEL), Treatment(accelerated=0.5).run(CLEAN, CASE, MODEL)
    rates, left = whole.kinematics(0.0).twist_rate, part.kinematics(0.0).twist_rate
    most = [np.linalg.norm(rates[:, own], axis=1).max() for own in (slice(0, 3), slice(3, 6))]
    shares = [np.linalg.norm(left[:, own], axis=1) / m for own, m in zip((slice(0, 3), slice(3, 6)), most, strict=True)]
    assert 0 < len(left) < len(rates)
    assert np.maximum(*shares).min() >= 0.5
    found = hx.identify(CLEAN, CASE, treatment=Treatment(accelerated=0.5))
    assert abs(found["m"].value - TRUTH.mass_kg) < 5.0 * found["m"].reported
    effect = found.record.treatment
    assert effect["samples"]["treated"] < effect["samples"]["default"]


def test_without_a_low_pass_the_widest_is_used_and_the_effect_stands_beside_the_default() -> None:
    run = Treatment(cutoff=math.inf).run(CLEAN, CASE, MODEL)
    assert run.filter.cutoff == pytest.approx(WIDEST / CLEAN.step)
    usual = estimate_parameters(CLEAN, CASE)
    result = hx.identify(CLEAN, CASE, treatment=Treatment(cutoff=25.0))
    effect = result.record.treatment
    assert effect["parameters"]["m"]["default"]["value"] == pytest.approx(usual.physical["m"].value, rel=1e-9)
    assert effect["parameters"]["m"]["treated"]["value"] == result["m"].value
    off = (result["m"].value - usual.physical["m"].value) / effect["parameters"]["m"]["default"]["std_robust"]
    assert abs(effect["parameters"]["m"]["deviations"]) <= abs(off) + 1e-9
    assert "25 Hz" in effect["words"]
    assert result.case.recording.filter_cutoff_Hz == CASE.recording.filter_cutoff_Hz  # the case stays what it is
    assert "beside the default" in str(result)


@pytest.mark.parametrize(
    "wrong", [{"accelerated": 1.5}, {"accelerated": 0.0}, {"period": -1.0}, {"harmonics": 0}, {"cutoff": 0.0}]
)
def test_values_that_mean_nothing_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(HexciteError) as caught:
        Treatment(**wrong)
    one_line(caught.value)


def test_standstills_are_not_treated() -> None:
    with pytest.raises(IdentificationError, match="runs that move") as caught:
        hx.identify(standing_run(CASE, 1.0, 0), CASE, 5, treatment=Treatment(accelerated=0.3))
    one_line(caught.value)
