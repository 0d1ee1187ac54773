"""Restricted likelihood: shares of noises from what a fit leaves, as if it had taken nothing."""

import numpy as np
import pytest

from identification.estimation.pose_noise import independent, likeliest, likelihood, shares_by_channel
from tests.helpers import taylor_slope

COUNT, UNKNOWNS = 60, 20
DRAW = np.random.default_rng(3)
TAKEN = DRAW.normal(size=(COUNT, 6, UNKNOWNS))
WHITE = np.eye(COUNT)
SLOW = np.exp(-np.abs(np.subtract.outer(np.arange(COUNT), np.arange(COUNT))) / 8.0)
KERNELS = np.array([WHITE, SLOW])


def left_by_fit(noise: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residuals of ordinary least squares, channels together, and the columns that it took."""
    columns = TAKEN.reshape(-1, UNKNOWNS)
    values = np.linalg.lstsq(columns, noise.ravel(), rcond=None)[0]
    return noise - TAKEN @ values, independent(TAKEN)


def drawn(seed: int, white: np.ndarray, slow: np.ndarray) -> np.ndarray:
    """Noise with shares of both kinds in each channel."""
    draw = np.random.default_rng(seed)
    root = np.linalg.cholesky(SLOW)
    shape = (COUNT, 6)
    return np.sqrt(white) * draw.normal(size=shape) + np.sqrt(slow) * (root @ draw.normal(size=shape))


def test_of_white_noise_the_share_is_the_sum_of_squares_over_degrees_of_freedom() -> None:
    left = left_by_fit(DRAW.normal(size=(COUNT, 6)))
    shares, _ = likeliest(*left, WHITE[None])
    assert shares[0] == pytest.approx(np.sum(left[0] ** 2) / (6 * COUNT - UNKNOWNS), rel=1e-4)


def test_it_does_not_matter_what_the_fit_took() -> None:
    """Residuals of any other parameters have the same likelihood: it knows only what no parameters explain."""
    left = left_by_fit(drawn(0, np.ones(6), np.ones(6)))
    other = (left[0] + TAKEN @ DRAW.normal(size=UNKNOWNS), left[1])
    one, two = (likeliest(noise, taken, KERNELS) for noise, taken in (left, other))
    np.testing.assert_allclose(one[0], two[0], rtol=1e-3)
    assert one[1] == pytest.approx(two[1], abs=1e-3)


def test_columns_that_depend_on_one_another_count_once() -> None:
    assert independent(np.dstack([TAKEN, TAKEN[:, :, :5]])).shape == (COUNT, 6, UNKNOWNS)


@pytest.mark.parametrize("field", [False, True])
def test_the_likelihood_knows_its_slope(field: bool) -> None:
    distances = np.abs(np.subtract.outer(np.arange(COUNT), np.arange(COUNT))) / 20.0 if field else None
    at, along = np.array([0.3, -1.0, -0.5, 0.2]), np.array([0.7, 1.0, -0.4, 0.6])
    size = 4 if field else 2
    at, along, left = at[:size], along[:size], left_by_fit(drawn(1, np.ones(6), np.ones(6)))
    slope = likelihood(at, *left, KERNELS, distances)[1] @ along
    found = taylor_slope(
        lambda h: np.array(likelihood(at + h * along, *left, KERNELS, distances)[0]), 0.0, np.array(slope), 0.1
    )
    assert found == pytest.approx(2.0, abs=0.1)


def test_shares_by_channel_are_right_on_average_though_channels_differ() -> None:
    """Two channels without slow noise, one with much; the fit couples them all."""
    white, slow = np.array([1.0, 1.0, 0.5, 1.0, 2.0, 1.0]), np.array([0.0, 1.0, 4.0, 0.5, 0.0, 1.0])
    found = []
    for seed in range(60):
        left = left_by_fit(drawn(seed, white, slow))
        shares, _ = likeliest(*left, KERNELS)
        found.append(shares_by_channel(*left, KERNELS, shares))
    error = np.std(found, axis=0) / np.sqrt(len(found))
    mean = np.mean(found, axis=0)
    assert np.abs((mean - np.stack([white, slow], axis=1)) / error)[slow > 0.0].max() < 4.0
    assert np.all(mean[slow == 0.0, 1] < 0.3)  # none can be negative, so that none is none on average
