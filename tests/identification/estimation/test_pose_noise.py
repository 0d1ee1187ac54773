"""Errors that come back with the pose: intervals hold the truth where those for noise in time alone do not."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import lfilter

from cases.schema import load_case
from identification.estimation.fit import Regression, gauss_markov
from identification.estimation.force_noise import Turned, turned
from identification.estimation.noise_mixtures import coloured_covariance
from identification.estimation.pose_field import matern
from identification.estimation.pose_noise import FREEDOM, covariance_by_pose, spectrum_of
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.results.estimate import Estimate
from identification.simulate import UNDISTURBED, Circumstances, simulate_recording
from tests.helpers import Harmonic, taylor_slope
from tests.simulated_machine import PoseExecution

SAMPLES, UNKNOWNS, STOPS = 300, 8, 15
CASE = load_case("hexapod")


def _travel() -> np.ndarray:
    """Struts of a motion that stops at few places, and comes back to them, shape (n, 6) [m]."""
    draw = np.random.default_rng(1)
    places = draw.uniform(-0.1, 0.1, (STOPS, 6))
    order = draw.integers(0, STOPS, 40)
    t = np.linspace(0.0, len(order) - 1.001, SAMPLES)
    k = t.astype(int)
    share = np.clip(2.0 * (t - k) - 0.5, 0.0, 1.0)[:, None]
    smooth = share**2 * (3.0 - 2.0 * share)
    return places[order[k]] * (1.0 - smooth) + places[order[k + 1]] * smooth


STRUTS = _travel()
FEATURES = np.c_[np.ones(SAMPLES), STRUTS / 0.1, np.gradient(STRUTS[:, 0]) * 50.0]
A = np.einsum("fku,nf->nku", np.random.default_rng(0).normal(size=(8, 6, UNKNOWNS)), FEATURES)
NAMES = [f"u{k}" for k in range(UNKNOWNS)]


def memory(seed: int, phi: float) -> np.ndarray:
    """First-order autoregressive noise of variance 1."""
    drawn = np.random.default_rng(seed).normal(size=(SAMPLES + 200, 6))
    return np.sqrt(1 - phi**2) * lfilter([1.0], [1.0, -phi], drawn, axis=0)[200:]


def field(seed: int, length: float = 0.07) -> np.ndarray:
    """Errors of the pose of variance 1, smoother than those that the estimate expects."""
    draw = np.random.default_rng(seed)
    waves, phases = draw.normal(size=(6, 6, 60)) / length, draw.uniform(0.0, 2 * np.pi, (6, 60))
    return np.stack(
        [np.sqrt(2 / 60) * np.cos(STRUTS @ w + p).sum(axis=1) for w, p in zip(waves, phases, strict=True)]
    ).T


def left(noise: np.ndarray) -> tuple[np.ndarray, Turned]:
    """Errors of the parameters by a noise, and the residuals of the fit."""
    fit = gauss_markov(Regression(A, noise, NAMES), np.ones(6))
    return fit.values, turned(A, fit.residuals, np.ones(6))


def shares_inside(noise: Callable[[int], np.ndarray], seeds: int) -> tuple[float, float]:
    """Of the true parameters in 95 % intervals with errors of the pose, and in those without."""
    with_pose, without = [], []
    for seed in range(seeds):
        errors, found = left(noise(seed))
        coloured, placed = coloured_covariance(found), covariance_by_pose(found, STRUTS)
        assert coloured is not None
        used = coloured.covariance if placed is None else placed.covariance
        with_pose.append(np.abs(errors) <= 1.96 * np.sqrt(np.diag(used)))
        without.append(np.abs(errors) <= 1.96 * np.sqrt(np.diag(coloured.covariance)))
    return float(np.mean(with_pose)), float(np.mean(without))


@pytest.mark.slow
def test_intervals_hold_the_truth_where_errors_repeat() -> None:
    with_pose, without = shares_inside(lambda s: field(s) + 0.3 * memory(s, 0.3), 12)
    assert with_pose > 0.88
    assert without < with_pose - 0.08


@pytest.mark.slow
def test_an_error_in_one_sensor_widens_the_intervals_that_feel_it() -> None:
    only = np.eye(6)[2]
    with_pose, without = shares_inside(lambda s: 2.0 * field(s) * only + 0.3 * memory(s, 0.3), 12)
    assert with_pose > 0.88
    assert without < with_pose - 0.02


@pytest.mark.slow
@pytest.mark.parametrize("phi", [0.0, 0.9])
def test_noise_that_does_not_know_the_pose_is_seldom_taken_for_its_errors(phi: float) -> None:
    assert sum(covariance_by_pose(left(memory(seed, phi))[1], STRUTS) is not None for seed in range(8)) <= 2


@pytest.mark.slow
def test_its_size_and_length_are_told() -> None:
    """Variance 1 [N^2]; a field of waves of length 0.05 m is half alike at 0.06 m, and smoother than Matern's."""
    sizes, lengths = [], []
    for seed in range(6):
        noise = field(seed, 0.05) + 0.1 * memory(seed, 0.0)
        fit = gauss_markov(Regression(A, noise, NAMES), np.ones(6))
        found = covariance_by_pose(turned(A, fit.residuals, np.ones(6)), STRUTS, fit.residuals)
        assert found is not None
        sizes.append(found.field.size**2)
        lengths.append(found.field.length)
    assert 0.5 < np.median(sizes) < 2.0
    assert 0.03 < np.median(lengths) < 0.12


@pytest.mark.slow
def test_it_does_not_depend_on_the_units_of_parameters_or_forces() -> None:
    noise = field(1) + 0.3 * memory(1, 0.3)
    fit = gauss_markov(Regression(A, noise, NAMES), np.ones(6))
    unit, newton = np.logspace(-3, 4, UNKNOWNS), 1e3
    plain = covariance_by_pose(turned(A, fit.residuals, np.ones(6)), STRUTS)
    scaled = covariance_by_pose(turned(newton * A * unit, newton * fit.residuals, np.ones(6)), STRUTS)
    assert plain is not None
    assert scaled is not None
    back = scaled.covariance * np.outer(unit, unit)
    np.testing.assert_allclose(np.diag(back), np.diag(plain.covariance), rtol=0.01)
    assert np.linalg.eigvalsh(plain.covariance).min() > 0.0


def test_samples_that_are_missing_do_not_bring_their_neighbours_together() -> None:
    """Half of the samples with a gap between: the covariance is that of the places that they have in time."""
    noise, kept = field(2) + 0.3 * memory(2, 0.3), np.r_[0:100, 200:300]
    fit = gauss_markov(Regression(A[kept], noise[kept], NAMES), np.ones(6))
    found = covariance_by_pose(turned(A[kept], fit.residuals, np.ones(6), kept), STRUTS[kept])
    later = covariance_by_pose(turned(A[kept], fit.residuals, np.ones(6), kept + 7), STRUTS[kept])
    assert found is not None
    assert later is not None
    np.testing.assert_array_equal(found.covariance, later.covariance)


def test_a_platform_that_stands_still_has_no_errors_that_come_back() -> None:
    assert covariance_by_pose(left(field(1))[1], np.tile(STRUTS[:1], (SAMPLES, 1))) is None


def test_too_few_samples_tell_nothing() -> None:
    assert covariance_by_pose(turned(A[:19], memory(1, 0.0)[:19], np.ones(6)), STRUTS[:19]) is None


def test_the_correlation_knows_its_slope() -> None:
    apart = np.array([0.1, 1.0, 3.0])
    found = taylor_slope(lambda h: matern(apart * np.exp(-h))[0], 0.0, matern(apart)[1], 0.1)
    assert found == pytest.approx(2.0, abs=0.1)


def test_waves_add_up_to_the_correlation() -> None:
    """The mean of cos(w x) over the spectrum is the correlation at x, in every direction."""
    waves = spectrum_of(6)
    for direction in np.linalg.qr(np.random.default_rng(5).normal(size=(6, 6)))[0]:
        for apart in (0.3, 1.0, 2.0, 6.0):
            mean = np.cos(waves @ (apart * direction)).mean()
            assert mean == pytest.approx(float(matern(np.array(apart))[0]), abs=0.12)
    assert FREEDOM == 3  # 2 nu, nu = 3/2


def identified(around: Circumstances) -> Estimate:
    motion = PoseExecution(Hexapod.of(CASE), Harmonic(seed=1, duration=6.0))
    recording = simulate_recording(CASE, motion, np.array([[0.2, 5.8]]), 3, "run.csv", around)
    return estimate_parameters(recording, CASE)


@pytest.mark.repeats
def test_identify_says_that_errors_come_back_and_allows_for_them() -> None:
    quiet = identified(UNDISTURBED)
    disturbed = identified(Circumstances((), CASE.simulation.disturbances))
    assert not any("errors depend on the pose" in note for note in quiet.notes)
    assert sum("errors depend on the pose" in note for note in disturbed.notes) == 1
    wider = [v.reported / v.std for v in disturbed.physical.values()]
    assert min(wider) > 1.5
