"""Noise with memory: intervals hold the truth also in short runs, where white formula and kernel estimates fail."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import lfilter

from cases.schema import load_case
from identification.estimation.fit import Fit, Regression, Robust, gauss_markov
from identification.estimation.force_noise import Turned, turned
from identification.estimation.noise_mixtures import coloured_covariance
from identification.machines.hexapod import Hexapod
from identification.signals import Filter
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


@pytest.mark.parametrize("phi", [0.0, 0.6, 0.9])
def test_deviations_are_as_wide_as_errors_are(phi: float) -> None:
    """Root mean square of true over reported deviations: the mixture finds its maximum, and channels tell together."""
    true = np.var([gauss_markov(Regression(A, memory(1000 + s, phi), NAMES), ONES).values for s in range(200)], axis=0)
    ratios = []
    for seed in range(8):
        fit = gauss_markov(Regression(A, A @ U + memory(seed, phi), NAMES), ONES)
        ratios.append(np.sqrt(true) / coloured(fit))
    assert 0.88 < np.sqrt(np.mean(np.square(ratios))) < 1.1


def test_a_channel_that_remembers_alone_is_judged_by_itself() -> None:
    """Offsets of six channels, of which the third drifts: its deviation is as large as its errors, and no other's."""
    offsets = np.tile(np.eye(6), (SAMPLES, 1, 1))

    def fitted(seed: int) -> Fit:
        noise = memory(seed, 0.0)
        noise[:, 2] += 2.0 * memory(seed + 5000, 0.95)[:, 2]
        return gauss_markov(Regression(offsets, noise, NAMES), ONES)

    true = np.std([fitted(100 + seed).values for seed in range(200)], axis=0)
    found = []
    for seed in range(8):
        fit = fitted(seed)
        found.append(np.sqrt(np.diag(robust(turned(offsets, fit.residuals, ONES)).covariance)))
    ratio = true / np.median(found, axis=0)
    assert 0.6 < ratio[2] < 1.4
    assert np.all(ratio[[0, 1, 3, 4, 5]] > 0.5)
    assert np.all(np.delete(np.array(found), 2, axis=1).mean(axis=0) < 0.4 * np.array(found)[:, 2].mean())


def test_noise_of_accelerations_is_not_taken_for_white() -> None:
    """White noise of encoders, differentiated twice behind a filter: parameters of a slow motion hardly have it."""
    low_pass, size = Filter(20.0, 0.002), np.r_[5.0, 2.0, 8.0, 1.0, 1.0, 3.0]
    rows = np.arange(SAMPLES) * low_pass.stride
    sources = np.array([low_pass.autocovariance(order) for order in (0, 2)])
    bent = float(np.linalg.norm(low_pass.kernel(2, 0.0)))

    def fitted(seed: int) -> Fit:
        draw = np.random.default_rng(seed)
        raw = draw.normal(size=(2, rows[-1] + 1 + 2 * low_pass.margin, 6))
        noise = 0.5 * low_pass.apply(raw[0])[rows] + size * low_pass.apply(raw[1], 2)[rows] / bent
        return gauss_markov(Regression(A, noise, NAMES), ONES)

    true, ratios, white = np.std([fitted(50 + seed).values for seed in range(100)], axis=0), [], []
    for seed in range(6):
        fit = fitted(seed)
        found = robust(turned(A, fit.residuals, ONES)._replace(sources=sources))
        assert found.sources is not None
        ratios.append(true / np.sqrt(np.diag(found.sources)))
        white.append(true / np.sqrt(np.diag(fit.covariance)))
    assert 0.8 < np.sqrt(np.mean(np.square(ratios))) < 1.15
    assert np.sqrt(np.mean(np.square(white))) < 0.5


def test_white_noise_of_forces_alone_leaves_28_as_it_is() -> None:
    low_pass, told = Filter(20.0, 0.002), []
    rows = np.arange(SAMPLES) * low_pass.stride
    sources = np.array([low_pass.autocovariance(order) for order in (0, 2)])
    for seed in range(10):
        raw = np.random.default_rng(seed).normal(size=(rows[-1] + 1 + 2 * low_pass.margin, 6))
        fit = gauss_markov(Regression(A, low_pass.apply(raw)[rows], NAMES), ONES)
        kept = robust(turned(A, fit.residuals, ONES)._replace(sources=sources)).sources
        told.append(1.0 if kept is None else float(np.mean(np.sqrt(np.diag(kept) / np.diag(fit.covariance)))))
    assert min(told) > 0.8


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


@pytest.mark.parametrize("phi", [0.0, 0.9, 0.97])
def test_errors_are_on_average_as_large_as_reported_where_noise_remembers_up_to_a_tenth_of_the_run(phi: float) -> None:
    """Of noise that is known, the covariance is exact: squares of true over reported deviations have a mean near 1."""
    basis = A.reshape(-1, UNKNOWNS)
    gain = np.linalg.inv(basis.T @ basis) @ basis.T
    memories = np.kron(phi ** np.abs(np.subtract.outer(np.arange(SAMPLES), np.arange(SAMPLES))), np.eye(6))
    true = np.diag(gain @ memories @ gain.T)
    squares = []
    for seed in range(12):
        fit = gauss_markov(Regression(A, A @ U + memory(seed, phi), NAMES), ONES)
        squares.append(true / coloured(fit) ** 2)
    assert 0.9 < np.sqrt(np.mean(squares)) < 1.15
