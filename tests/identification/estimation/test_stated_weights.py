"""W from the noise of forces and accelerations that a case states, through the model."""

import numpy as np
import pytest

from cases.base.errors import IdentificationError
from cases.schema import Case, load_case
from identification.estimation.estimators import Method
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters, physical_form
from identification.model.stated_noise import acceleration_to_force, noise_covariance, whitening_of
from identification.recording.recording import Recording
from identification.results.estimate import entries_of
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, ideal, simulated
from tests.identification.point_masses import PointMasses, wrench_of_bars
from tests.simulated_machine import PoseExecution

BARE = ideal(load_case("hexapod"))
MODEL = identification_model(BARE, 9)
TRUTH = linear_parameters(MODEL, BARE.simulation.parameters)
PHYSICAL = physical_form(MODEL).of(TRUTH, np.eye(20))[0]
MOTION = Harmonic(seed=1, duration=2.0)


def shaken(force: float, acceleration: float, angular: float) -> Case:
    """A machine whose structure vibrates, and a case that says so."""
    noise = {"acceleration_noise_m_s2": acceleration, "angular_acceleration_noise_rad_s2": angular}
    case = simulated(BARE, force_noise_N=force, **noise)
    stated = {"force_noise_N": force} | {name: value or None for name, value in noise.items()}
    return case.model_copy(update={"sensors": case.sensors.model_copy(update=stated)})


CASE = shaken(1.0, 0.05, 1.0)


def runs(case: Case, count: int) -> list[Recording]:
    execution = PoseExecution(Hexapod.of(case), MOTION)
    return [simulate_recording(case, execution, np.array([[0.1, 1.9]]), seed) for seed in range(count)]


def test_vibration_is_felt_as_newton_s_law_has_it() -> None:
    """Point masses that are accelerated without moving yet: each pulls with mass times acceleration."""
    masses = PointMasses.drawn(3)
    values = np.array([masses.parameters.get(n, 0.0) for n in MODEL.names])
    felt = acceleration_to_force(MODEL, values)
    rng = np.random.default_rng(0)
    for linear, angular in rng.normal(size=(4, 2, 3)):
        pulls = masses.masses[:, None] * (linear + np.cross(angular, masses.points))
        wrench = np.r_[pulls.sum(axis=0), np.cross(masses.points, pulls).sum(axis=0)]
        carried = wrench_of_bars(BARE.sensor_frame.bars, felt @ np.r_[linear, angular])
        np.testing.assert_allclose(carried, wrench, rtol=1e-9, atol=1e-9)


def test_the_stated_covariance_is_that_of_many_samples_and_whitening_makes_it_one() -> None:
    recording, quiet = runs(CASE, 1)[0], runs(shaken(1e-9, 0.0, 0.0), 1)[0]
    drawn = recording.forces - quiet.forces
    expected = noise_covariance(MODEL, CASE.sensors, TRUTH)
    found = np.cov(drawn.T)
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)) * 2 / len(drawn))
    assert np.abs((found - expected) / size).max() < 4.5
    whitening = whitening_of(expected)
    np.testing.assert_allclose(whitening @ expected @ whitening.T, np.eye(6), atol=1e-9)


def test_covariance_does_not_depend_on_the_pose() -> None:
    """Noise that is alike in all directions is so in every orientation."""
    turns = np.broadcast_to(np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0], (7, 3, 3))
    if np.linalg.det(turns[0]) < 0:
        turns = -turns
    still = np.zeros((7, 6))
    forces = MODEL.matrices(still[:, :3] + 0.1, turns, still, np.vstack([np.zeros(6), np.eye(6)])) @ TRUTH
    felt = (forces[1:] - forces[0]).T * CASE.sensors.acceleration_noise
    alone = np.diag(CASE.sensors.force_noise**2)
    np.testing.assert_allclose(felt @ felt.T + alone, noise_covariance(MODEL, CASE.sensors, TRUTH), rtol=1e-9)


@pytest.mark.slow
def test_scatter_shrinks_and_the_reported_deviations_stay_true() -> None:
    """20 runs: a scatter is known to 16 % for each parameter, to a few percent over all 20."""
    estimates = {
        w: [estimate_parameters(r, CASE, how=Method(weights=w)) for r in runs(CASE, 20)] for w in ("equal", "stated")
    }
    scatter, told, inside = {}, {}, {}
    for weights, found in estimates.items():
        values = np.array([[v.value for v in e.physical.values()] for e in found])
        reported = np.array([[v.reported for v in e.physical.values()] for e in found])
        scatter[weights], told[weights] = values.std(axis=0, ddof=1), reported.mean(axis=0)
        inside[weights] = np.mean(np.abs(values - PHYSICAL) < 1.96 * reported)
    gain = np.exp(np.mean(np.log(scatter["stated"] / scatter["equal"])))
    assert gain < 0.75
    assert np.exp(np.mean(np.log(told["stated"] / told["equal"]))) == pytest.approx(gain, rel=0.15)
    assert 0.92 <= inside["stated"] <= 0.99
    assert np.mean([e.fit.white_noise for e in estimates["stated"]]) == pytest.approx(
        1.0, abs=0.05
    )  # as stated, in its own units


@pytest.mark.repeats
def test_weights_without_noise_of_accelerations_are_equal_weights() -> None:
    case = shaken(2.0, 0.0, 0.0)
    recording = runs(case, 1)[0]
    equal, stated = (estimate_parameters(recording, case, how=Method(weights=w)) for w in ("equal", "stated"))
    np.testing.assert_allclose(stated.fit.values, equal.fit.values, rtol=1e-9)
    np.testing.assert_allclose(stated.fit.covariance, equal.fit.covariance, rtol=1e-9)
    assert stated.fit.white_noise == pytest.approx(equal.fit.white_noise / 2.0, rel=1e-9)
    assert [entries_of(e).weights for e in (equal, stated)] == ["equal", "stated"]


def test_a_known_mass_goes_with_stated_weights() -> None:
    recording = runs(CASE, 1)[0]
    known = estimate_parameters(recording, CASE, how=Method({"m": 31.83}, weights="stated"))
    assert known.physical["m"].value == pytest.approx(31.83, rel=1e-12)


def test_weights_that_cannot_be_are_refused() -> None:
    recording = runs(CASE, 1)[0]
    with pytest.raises(IdentificationError, match=r"no noise; .*sensors\.force_noise_N"):
        estimate_parameters(recording, BARE, how=Method(weights="stated"))
    with pytest.raises(IdentificationError, match=r"weights 'best'.*choose equal, per_channel"):
        Method(weights="best")
