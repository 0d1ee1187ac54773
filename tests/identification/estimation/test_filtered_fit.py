"""Fits behind the low-pass are as honest as fits of the recorded forces: gain and stride are accounted for."""

import numpy as np
import pytest
from scipy import stats

from cases.base.errors import IdentificationError
from identification.estimation.fit import Filtered, Fit, Regression, gauss_markov
from identification.signals import Filter
from tests.helpers import one_line

LOW_PASS = Filter(40.0, 1e-3)
T = np.arange(1500) * 1e-3
NAMES = ["m", "mxC", "k0"]
U = np.array([30.0, -2.0, 7.0])
# Regressors that the filter leaves as they are: nothing above half of its cut-off.
COLUMNS = np.random.default_rng(0).normal(size=(3, 6, 4))
WAVES = np.stack([np.sin(2 * np.pi * f * T + f) for f in (1.0, 3.0, 7.0, 12.0)])
A = np.einsum("usf,ft->tsu", COLUMNS, WAVES)


def fit(seed: int, std: float) -> Fit:
    forces = A @ U + std * np.random.default_rng(seed).normal(size=(len(T), 6))
    rows = slice(None, None, LOW_PASS.stride)
    smooth, inner = LOW_PASS.apply(forces)[rows], A[LOW_PASS.margin : -LOW_PASS.margin][rows]
    return gauss_markov(
        Regression(inner, smooth, NAMES, filtered=Filtered(LOW_PASS.noise_gain, LOW_PASS.stride)), np.ones(6)
    )


def test_gain_is_the_variance_that_the_filter_leaves_of_white_noise() -> None:
    noise = np.random.default_rng(1).normal(size=(200_000, 1))
    assert LOW_PASS.apply(noise).var() == pytest.approx(LOW_PASS.noise_gain, rel=0.03)
    assert LOW_PASS.noise_gain == pytest.approx(2 * 40.0 * 1e-3, rel=0.1)  # the pass band's share of all frequencies


@pytest.mark.parametrize(("cutoff", "step"), [(40.0, 1e-3), (5.0, 1e-3), (100.0, 1e-3), (40.0, 4e-3)])
def test_what_is_kept_is_sampled_more_often_than_twice_the_highest_frequency(cutoff: float, step: float) -> None:
    low_pass = Filter(cutoff, step)
    assert low_pass.stride >= 1
    assert low_pass.stride == 1 or 1 / (low_pass.stride * step) >= 2 * 1.5 * cutoff


def test_errors_are_as_large_as_predicted_and_s0_is_that_of_the_recorded_noise() -> None:
    distance, s0 = [], []
    for seed in range(150):
        found = fit(seed, std=0.5)
        error = found.values - U
        distance.append(error @ np.linalg.solve(found.covariance, error) / 3)
        s0.append(found.white_noise)
    assert np.mean(s0) == pytest.approx(0.5, rel=0.02)
    assert stats.kstest(distance, stats.f(3, found.freedom).cdf).pvalue > 0.01


def test_without_noise_the_parameters_are_exact_to_the_ripple_of_the_filter() -> None:
    np.testing.assert_allclose(fit(0, std=0.0).values, U, rtol=1e-4)


def test_more_unknowns_than_the_filter_leaves_independent_forces_are_refused() -> None:
    """Ten samples through a 40 Hz low-pass at 1 kHz hold about 10 * 6 * 0.08 = 5 independent forces."""
    matrices = np.random.default_rng(2).normal(size=(10, 6, 6))
    regression = Regression(matrices, np.ones((10, 6)), list("abcdef"), filtered=Filtered(0.08, 1))
    with pytest.raises(IdentificationError, match=r"60 forces, 5 .*independent.* 6 unknowns") as caught:
        gauss_markov(regression, np.ones(6))
    one_line(caught.value)
