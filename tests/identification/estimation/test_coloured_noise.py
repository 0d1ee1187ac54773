"""Noise with memory: intervals hold the truth also in short runs, where white formula and kernel estimates fail."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import lfilter

from cases.schema import load_case
from identification.estimation.fit import Fit, Regression, Robust, gauss_markov
from identification.estimation.force_noise import Turned, coloured_covariance, turned
from identification.machines.hexapod import Hexapod
from tests.bench.coverage import coloured_coverage
from tests.helpers import Harmonic, few
from tests.simulated_machine import PoseExecution

SAMPLES, UNKNOWNS = 300, 6
T = np.arange(SAMPLES) / SAMPLES
# Slow columns, as motions make them: the noise at their frequencies is what counts.
WAVES = np.stack(
    [np.sin(2 * np.pi * f * T + p) for f, p in ((1, 0.3), (2, 1.1), (3, 2.0), (4, 0.0), (5, 0.7), (0, 1.5))]
)
A = np.einsum("fku,ft->tku", np.random.default_rng(0).normal(size=(6, 6, UNKNOWNS)), WAVES)
U = np.arange(1.0, UNKNOWNS + 1.0)
NAMES = [f"u{k}" for k in range(UNKNOWNS)]
ONES = np.ones(6)


def memory(seed: int, phi: float) -> np.ndarray:
    """First-order autoregressive noise of variance 1."""
    drawn = np.random.default_rng(seed).normal(size=(SAMPLES + 200, 6))
    return np.sqrt(1 - phi**2) * lfilter([1.0], [1.0, -phi], drawn, axis=0)[200:]


def share_inside(noise: Callable[[int], np.ndarray], deviations: Callable[[Fit], np.ndarray], seeds: int = 25) -> float:
    inside = []
    for seed in range(seeds):
        fit = gauss_markov(Regression(A, A @ U + noise(seed), NAMES), ONES)
        inside.append(np.abs(fit.values - U) <= 1.96 * deviations(fit))
    return float(np.mean(inside))


def robust(found: Turned) -> Robust:
    of = coloured_covariance(found)
    assert of is not None
    return of


def coloured(fit: Fit) -> np.ndarray:
    return np.sqrt(np.diag(robust(turned(A, fit.residuals, ONES)).covariance))


@pytest.mark.slow
@pytest.mark.parametrize("phi", [0.0, 0.6, 0.9])
def test_95_percent_intervals_hold_the_truth_whatever_the_memory(phi: float) -> None:
    assert 0.9 <= share_inside(lambda s: memory(s, phi), coloured) <= 0.985


def test_the_white_formula_fails_where_noise_has_memory() -> None:
    assert share_inside(lambda s: memory(s, 0.9), lambda fit: np.sqrt(np.diag(fit.covariance))) < 0.75


@pytest.mark.slow
def test_noise_that_channels_share_counts_as_such() -> None:
    """One disturbance that shakes all channels: the parameters' errors are larger than independent noise makes them."""
    mixing = np.ones((6, 6)) + np.diag(np.full(6, 0.1))
    assert share_inside(lambda s: memory(s, 0.6) @ mixing.T, coloured) > 0.9


def test_white_noise_gives_the_covariance_of_28_and_a_little_for_what_300_samples_do_not_tell() -> None:
    ratio = []
    for seed in range(10):
        fit = gauss_markov(Regression(A, A @ U + memory(seed, 0.0), NAMES), ONES)
        ratio.append(coloured(fit) / np.sqrt(np.diag(fit.covariance)))
    assert 1.0 < np.mean(ratio) < 1.2


def test_noise_nearly_as_slow_as_the_run_is_no_surprise() -> None:
    """Memory of a sixth of the run: of the spectrum at the motion's frequencies the fit leaves next to nothing."""
    assert 0.9 <= share_inside(lambda s: memory(s, 0.98), coloured) <= 0.985


@pytest.mark.first(1)
@pytest.mark.parametrize("phi", few(0.9, 0.0))
def test_sections_with_gaps_between_are_no_neighbours(phi: float) -> None:
    """Of 300 samples 20 in 50: as one series, noise would seem to forget itself at every gap."""
    places = np.flatnonzero(np.arange(SAMPLES) % 50 < 20)
    some, inside = A[places], []
    for seed in range(50):
        fit = gauss_markov(Regression(some, some @ U + memory(seed, phi)[places], NAMES), ONES)
        covariance = robust(turned(some, fit.residuals, ONES, places)).covariance
        inside.append(np.abs(fit.values - U) <= 1.96 * np.sqrt(np.diag(covariance)))
    assert 0.9 <= np.mean(inside) <= 0.99


@pytest.mark.parametrize(("phi", "told"), [(0.0, 0.0), (0.9, 0.1), (0.992, 0.7)])
def test_a_run_that_is_short_for_what_its_noise_remembers_is_told_so(phi: float, told: float) -> None:
    """White noise and memories of a thirtieth of the run are not; of two fifths they mostly are."""
    seen = []
    for seed in range(20):
        fit = gauss_markov(Regression(A, A @ U + memory(seed, phi), NAMES), ONES)
        seen.append(any("slow_noise" in f.quantity for f in robust(turned(A, fit.residuals, ONES)).findings))
    share = float(np.mean(seen))
    assert share >= told if told > 0.5 else share <= told


def test_what_lies_between_samples_that_are_there_does_not_matter() -> None:
    fit = gauss_markov(Regression(A, A @ U + memory(1, 0.5), NAMES), ONES)
    one_by_one = robust(turned(A, fit.residuals, ONES, np.arange(7, SAMPLES + 7))).covariance
    np.testing.assert_array_equal(one_by_one, robust(turned(A, fit.residuals, ONES)).covariance)


def test_it_does_not_depend_on_units_and_is_positive_definite() -> None:
    fit = gauss_markov(Regression(A, A @ U + memory(1, 0.5), NAMES), ONES)
    unit = np.array([1.0, 1e3, 1e-3, 1.0, 10.0, 1e6])
    plain = robust(turned(A, fit.residuals, ONES)).covariance
    scaled = robust(turned(A * unit, fit.residuals, ONES)).covariance
    np.testing.assert_allclose(scaled * np.outer(unit, unit), plain, rtol=1e-6, atol=1e-9 * plain.max())
    assert np.linalg.eigvalsh(plain).min() > 0.0


@pytest.mark.first(1)
@pytest.mark.parametrize("stride", [5, 12])
def test_25_to_60_samples_tell_enough_of_their_memory(stride: int) -> None:
    few, held = A[::stride], []
    for seed in range(30):
        fit = gauss_markov(Regression(few, few @ U + memory(seed, 0.6)[: len(few)], NAMES), ONES)
        covariance = robust(turned(few, fit.residuals, ONES)).covariance
        assert covariance is not None
        held.append(np.abs(fit.values - U) <= 1.96 * np.sqrt(np.diag(covariance)))
    assert np.mean(held) > 0.87


def test_a_run_too_short_to_tell_a_spectrum_has_none() -> None:
    assert coloured_covariance(turned(A[:19], np.ones((19, 6)), ONES)) is None


@pytest.mark.slow
def test_over_200_runs_with_noise_of_a_20_Hz_filter_the_robust_intervals_hold_and_the_white_ones_do_not() -> None:
    case = load_case("hexapod")
    execution = PoseExecution(Hexapod.of(case), Harmonic(seed=1, duration=4.0))
    found = coloured_coverage(case, execution, np.array([[0.2, 3.8]]), seeds=200)
    assert 91.0 <= found.robust <= 98.0
    assert found.width <= 1.5
    assert found.white < 91.0
