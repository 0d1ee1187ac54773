"""Periodic runs: truth without noise, agreement with the low-pass where there is little, far less error beyond."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from cases.errors import RecordingError
from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.model import identification_model
from identification.parameters import linear_parameters, physical_form
from identification.result import Estimate
from identification.runs.averaging import periodic_run
from identification.runs.fourier_series import FourierSeries
from identification.runs.periods import each_period, rows_of_periods
from identification.samples import Conditioning
from tests.helpers import few, ideal, one_line, simulated, tells
from tests.identification.repeating import LEAD, Repeating, recorded

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
PHYSICAL = physical_form(MODEL).of(linear_parameters(MODEL, CASE.simulation.parameters), np.eye(20))[0]
AUTO = Conditioning(True)


def values(estimate: Estimate) -> np.ndarray:
    return np.array([v.value for v in estimate.physical.values()])


def reported(estimate: Estimate) -> np.ndarray:
    return np.array([v.reported for v in estimate.physical.values()])


def far(estimate: Estimate) -> float:
    """Geometric mean of the errors of all parameters over their expected size for 1 N of noise."""
    return float(np.exp(np.mean(np.log(np.abs(values(estimate) - PHYSICAL)))))


@pytest.fixture(scope="module")
def clean() -> Estimate:
    return estimate_parameters(recorded(CASE, Repeating()), CASE, conditioning=AUTO)


@pytest.mark.parametrize("period", few(1.3, 2.0, 2.0 / 3.0 * np.sqrt(3.0)))
def test_an_ideal_machine_gives_its_parameters_back(period: float) -> None:
    """Whether or not the period is a whole number of samples: derivatives are analytic, nothing is differenced."""
    estimate = estimate_parameters(recorded(ideal(CASE), Repeating(period, 3)), CASE, conditioning=AUTO)
    np.testing.assert_allclose(values(estimate), PHYSICAL, rtol=1e-6, atol=1e-6)
    assert estimate.quantities["periodic"]["period_s"] == pytest.approx(period, rel=1e-8)
    assert estimate.quantities["periodic"]["periods"] == 3


@pytest.mark.slow
def test_with_little_noise_of_the_struts_it_agrees_with_the_low_pass() -> None:
    run = recorded(CASE, Repeating(), seed=1)
    clean, usual = estimate_parameters(run, CASE, conditioning=AUTO), estimate_parameters(run, CASE)
    assert np.abs((values(clean) - values(usual)) / reported(usual)).max() < 0.3
    np.testing.assert_allclose(reported(clean), reported(usual), rtol=0.35)
    assert clean.delay.value == pytest.approx(usual.delay.value, abs=2 * usual.delay.std)
    assert clean.fit.s0 == pytest.approx(CASE.simulation.force_noise_N, rel=0.15)
    assert clean.warnings == ()


def test_errors_are_as_large_as_reported(clean: Estimate) -> None:
    assert np.abs((values(clean) - PHYSICAL) / reported(clean)).max() < 4.0
    found = clean.quantities["periodic"]["noise_between_periods"]
    np.testing.assert_allclose(found, CASE.simulation.force_noise_N, rtol=0.35)


@pytest.mark.slow
@pytest.mark.parametrize("step_um", few(200.0, 50.0))
def test_coarse_encoders_bias_the_low_pass_and_spare_the_series(step_um: float) -> None:
    case = simulated(CASE, encoder_resolution_um=step_um)
    run = recorded(case, Repeating(period=2.0003))
    usual, periodic = estimate_parameters(run, case), estimate_parameters(run, case, conditioning=AUTO)
    assert far(periodic) < far(usual) / 8.0
    assert np.abs((values(periodic) - PHYSICAL) / reported(periodic)).max() < 5.0
    white = np.array([v.std for v in usual.physical.values()])
    assert np.abs((values(usual) - PHYSICAL) / white).max() > 5.0
    assert periodic.quantities["periodic"]["harmonics"] < 30


@pytest.mark.slow
def test_more_noise_of_the_struts_leaves_fewer_harmonics() -> None:
    counts = []
    for step_um in (0.1, 10.0, 200.0):
        case = simulated(CASE, encoder_resolution_um=step_um)
        counts.append(
            estimate_parameters(recorded(case, Repeating()), case, conditioning=AUTO).quantities["periodic"][
                "harmonics"
            ]
        )
    assert counts[0] > counts[1] > counts[2] >= 4  # of the motion itself


@pytest.mark.parametrize("delay_ms", few(2.5, 0.0, 15.0))
def test_the_delay_is_found(delay_ms: float) -> None:
    case = simulated(ideal(CASE), force_delay_ms=delay_ms)
    estimate = estimate_parameters(recorded(case, Repeating(periods=2)), case, conditioning=AUTO)
    assert estimate.delay.value == pytest.approx(delay_ms * 1e-3, abs=1e-7)


def test_forces_and_regressor_pass_the_same_filter() -> None:
    """What is above the harmonics leaves the estimate alone on either side, however few they are."""
    run = recorded(ideal(CASE), Repeating(periods=2))
    few = estimate_parameters(run, CASE, conditioning=Conditioning(True, harmonics=4))
    np.testing.assert_allclose(values(few), PHYSICAL, rtol=1e-5, atol=1e-5)
    ripple = 50.0 * np.sin(2 * np.pi * 30.0 * run.t)[:, None]
    disturbed = estimate_parameters(
        replace(run, forces=run.forces + ripple), CASE, conditioning=Conditioning(True, None, 4)
    )
    np.testing.assert_allclose(values(disturbed), values(few), rtol=1e-6, atol=1e-6)


def test_a_contact_in_one_period_costs_that_period_and_nothing_else() -> None:
    run = recorded(CASE, Repeating())
    touched = run.forces.copy()
    here = (run.t > LEAD + 4.5) & (run.t < LEAD + 4.7)
    touched[here] += np.linalg.solve(MODEL.structure, [20.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    estimate = estimate_parameters(replace(run, forces=touched), CASE, conditioning=AUTO)
    assert estimate.quantities["periodic"]["periods"] == 3
    assert any("period 3 of 4" in w and "left out" in w for w in estimate.warnings)
    assert np.abs((values(estimate) - PHYSICAL) / reported(estimate)).max() < 4.0


@pytest.mark.slow
def test_clean_runs_lose_no_period() -> None:
    model, run = MODEL, recorded(ideal(CASE), Repeating())
    for seed in range(4):
        noisy = replace(run, forces=run.forces + np.random.default_rng(seed).normal(size=run.forces.shape))
        assert periodic_run(noisy, CASE, model, AUTO).window == ()


def test_a_sensor_that_is_stuck_for_a_while_costs_its_period() -> None:
    run = recorded(CASE, Repeating())
    stuck = run.forces.copy()
    rows = np.flatnonzero((run.t > LEAD + 2.5) & (run.t < LEAD + 2.9))
    stuck[rows, 2] = stuck[rows[0], 2]
    estimate = estimate_parameters(replace(run, forces=stuck), CASE, conditioning=AUTO)
    assert estimate.quantities["periodic"]["periods"] == 3
    assert any(tells(w, "period 2 of 4", "bad samples") for w in estimate.warnings)
    assert np.abs((values(estimate) - PHYSICAL) / reported(estimate)).max() < 4.0


@pytest.mark.slow
def test_the_scatter_between_periods_gives_the_covariance_of_coloured_noise() -> None:
    """Noise behind a 20 Hz first-order filter: the robust covariance is that of the estimates, (28) is too small."""
    run = periodic_run(recorded(ideal(CASE), Repeating(periods=6)), CASE, MODEL, AUTO)
    matrices, t = run.regressors(0.0), run.recording.t
    flat = matrices.reshape(-1, 20)
    inverse = np.linalg.pinv(flat)
    pole, draw = np.exp(-2 * np.pi * 20.0 * 1e-3), np.random.default_rng(0)
    estimates, predicted = [], []
    for _ in range(40):
        noise = lfilter([1 - pole], [1, -pole], draw.normal(size=(len(t) + 300, 6)), axis=0)[300:]
        scatter = each_period(t, noise, rows_of_periods(t, run.part), run.part, 60)
        mean = FourierSeries(scatter.mean(axis=0), run.part.period, t[run.part.first])
        mean = mean.truncated(run.harmonics).at(run.t)
        estimates.append(inverse @ mean.ravel())
        noisy = replace(run, scatter=scatter)
        predicted.append(np.diag(noisy.robust_covariance(matrices, mean, np.ones(6), None).covariance))
    ratio = np.mean(predicted, axis=0) / np.mean(np.square(estimates), axis=0)
    assert np.exp(np.mean(np.log(ratio))) == pytest.approx(1.0, rel=0.12)
    assert ratio.min() > 0.5
    assert ratio.max() < 2.0


def test_residuals_are_told_at_every_sample_of_the_periods(clean: Estimate) -> None:
    left = clean.evaluated.series(clean.at, clean.fit.values)
    assert len(left.t) == clean.evaluated.samples == 8000
    assert left.values.std() == pytest.approx(CASE.simulation.force_noise_N, rel=0.05)
    assert clean.s0_N == pytest.approx(left.values.std(), rel=1e-3)


@pytest.mark.parametrize(
    ("change", "wish", "message"),
    [
        ({}, Conditioning(True, harmonics=500), "harmonics 500: a period of 2 s holds 80 of them up to"),
        ({}, Conditioning(True, period=3.0), "period 3: a period later the struts are"),
        ({"t": None}, Conditioning(True), "is not a moving run"),
        ({"struts": None}, Conditioning(True), "needs"),
        ({"trigger": np.zeros(8801, dtype=bool)}, Conditioning(True), "trigger: is never 1"),
    ],
)
def test_what_cannot_be_done_is_refused_in_a_line(change: dict, wish: Conditioning, message: str) -> None:
    run = recorded(CASE, Repeating())
    run = replace(run, **{k: v[: len(run.t)] if isinstance(v, np.ndarray) else v for k, v in change.items()})
    with pytest.raises((RecordingError, ValueError), match=message) as caught:
        estimate_parameters(run, CASE, 0 if run.struts is None else 9, conditioning=wish)
    assert "run.csv" in one_line(caught.value)
