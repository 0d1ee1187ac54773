"""Means of channels that stand are off by what is said, also where noise remembers a large part of the record."""

import numpy as np
import pytest
from scipy.signal import lfilter

from identification.estimation.standing_mean import StandingMean, standing_mean

RATE, SECONDS, RECORDS = 250.0, 2.0, 40
MIXING = np.random.default_rng(5).normal(size=(6, 6))  # gauges of a sensor, which its calibration mixes


def records(memory: float, share: float) -> list[np.ndarray]:
    """Standstills with mean zero: white noise, and a share of noise that remembers so many seconds."""
    count, keep = round(RATE * SECONDS), np.exp(-1.0 / (max(memory, 1e-3) * RATE))
    before = round(8.0 * memory * RATE)
    drawn = []
    for seed in range(RECORDS):
        draw = np.random.default_rng(seed)
        white, steps = draw.normal(size=(count, 6)), draw.normal(size=(count + before, 6))
        slow = np.sqrt(1.0 - keep**2) * lfilter([1.0], [1.0, -keep], steps, axis=0)[before:]
        drawn.append((np.sqrt(1.0 - share**2) * white + share * slow) @ MIXING.T)
    return drawn


def over_deviations(drawn: list[np.ndarray], found: list[StandingMean]) -> np.ndarray:
    return np.array([x.mean(axis=0) / np.sqrt(np.diag(of.covariance)) for x, of in zip(drawn, found, strict=True)])


@pytest.mark.parametrize(
    ("memory", "share", "least", "most"),
    [(0.0, 0.0, 0.8, 1.1), (0.05, 0.8, 0.7, 1.1), (0.3, 0.3, 0.6, 1.1), (0.3, 1.0, 0.6, 1.1), (1.0, 0.6, 0.8, 1.3)],
)
def test_means_are_off_by_their_deviations(memory: float, share: float, least: float, most: float) -> None:
    """Memories of up to half of the record; noise that lasts for half of it had 2.6 times the deviations once."""
    drawn = records(memory, share)
    off = over_deviations(drawn, [standing_mean(x) for x in drawn])
    assert least < np.sqrt(np.mean(off**2)) < most
    assert np.mean(np.abs(off) < 1.96) > 0.88


@pytest.mark.parametrize("count", [20, 100, 127, 500])
def test_all_samples_count(count: int) -> None:
    """Of white noise of any number of samples deviations are near the root of its variance over that number."""
    drawn = [np.random.default_rng(seed).normal(size=(count, 6)) for seed in range(RECORDS)]
    assert 0.7 < np.median([standing_mean(x).covariance.diagonal() for x in drawn]) ** -0.5 / count**0.5 < 1.1


def test_it_says_how_much_is_of_noise_that_the_record_hardly_shows() -> None:
    short, white = ([standing_mean(x).slow for x in records(*of)] for of in ((1.0, 0.6), (0.0, 0.0)))
    assert np.mean(np.array(short) > 0.4) > 0.9
    assert np.mean(np.array(white) > 0.4) < 0.1


def test_units_of_a_channel_do_not_count() -> None:
    x, units = records(0.3, 0.6)[0], np.array([1.0, 1e3, 1e-3, 1.0, 10.0, 1e6])
    plain, scaled = standing_mean(x), standing_mean(x * units)
    np.testing.assert_allclose(scaled.covariance, plain.covariance * np.outer(units, units), rtol=1e-6)
    assert scaled.slow == pytest.approx(plain.slow, rel=1e-6)


def test_a_channel_that_says_nothing_leaves_the_others_as_they_are() -> None:
    x = records(0.3, 0.6)[1]
    with_dead = np.c_[x[:, :5], np.full(len(x), 3.0)]
    found = standing_mean(with_dead)
    assert np.all(np.isfinite(found.covariance))
    assert found.covariance[5, 5] < 1e-20
    np.testing.assert_allclose(found.covariance[:5, :5], standing_mean(x[:, :5]).covariance, rtol=0.2)
