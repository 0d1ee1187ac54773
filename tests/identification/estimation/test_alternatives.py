"""Alternatives to a model: chance is what it says, sizes and biases are those of the fit that knows them."""

import numpy as np
import pytest
from scipy.signal import lfilter

from identification.estimation.alternatives import Alternative, Remainder, effects_of
from tests.helpers import few

SAMPLES = 600
T = np.arange(SAMPLES) / 100.0


def columns(seed: int, count: int) -> np.ndarray:
    """Slow columns, shape (n, 6, k)."""
    draw = np.random.default_rng(seed)
    frequency, phase = draw.uniform(0.2, 2.0, (6, count)), draw.uniform(0.0, 2 * np.pi, (6, count))
    return np.sin(2 * np.pi * frequency * T[:, None, None] + phase)


A, D = columns(0, 8), columns(1, 1)


def left(forces: np.ndarray) -> Remainder:
    fit = np.linalg.lstsq(A.reshape(-1, 8), forces.ravel(), rcond=None)[0]
    places = np.arange(SAMPLES)
    return Remainder.of(A, A, forces - A @ fit, np.eye(6), places, coloured=True, freedom=6.0 * SAMPLES - 8)


def noise(seed: int, memory: float) -> np.ndarray:
    white = np.random.default_rng(seed).normal(size=(SAMPLES + 400, 6))
    return lfilter([1.0], [1.0, -memory], white, axis=0)[400:]


@pytest.mark.repeats
@pytest.mark.parametrize("memory", few(0.9, 0.0))
def test_chance_is_that_of_noise_with_or_without_memory(memory: float) -> None:
    one = [Alternative("one", "it", "it", D)]
    chances = []
    for seed in range(100):
        effects = effects_of(one, left(noise(seed, memory))._replace(floor=0.0), 1.0)
        chances.append(effects[0].chance)
    assert 0.01 < np.mean(np.array(chances) < 0.1) < 0.19
    assert np.mean(np.array(chances) < 0.01) < 0.03
    assert min(chances) > 1e-5


def test_size_and_bias_are_those_of_the_fit_with_the_column() -> None:
    forces = A @ np.arange(1.0, 9.0) + 0.8 * D[:, :, 0] + 0.1 * noise(0, 0.5)
    (effect,) = effects_of([Alternative("one", "it", "it", D)], left(forces), 1e-6)
    both = np.concatenate([A, D], axis=2).reshape(-1, 9)
    known = np.linalg.lstsq(both, forces.ravel(), rcond=None)[0]
    without = np.linalg.lstsq(A.reshape(-1, 8), forces.ravel(), rcond=None)[0]
    assert effect.sizes[0] == pytest.approx(known[8], rel=1e-9)
    assert abs(effect.sizes[0] - 0.8) < 4.0 * effect.stds[0]
    off = without - known[:8]
    np.testing.assert_allclose(effect.bias, np.outer(off, off), rtol=0.05, atol=1e-6)


def test_the_cause_is_preferred_to_what_looks_like_it() -> None:
    forces = A @ np.ones(8) + 0.3 * D[:, :, 0] + 0.5 * noise(3, 0.5)
    others = [Alternative(f"other {k}", "it", "it", columns(k, 1)) for k in range(2, 12)]
    mixed = Alternative("alike", "it", "it", D + 0.4 * columns(20, 1))
    flexible = Alternative("many", "it", "it", np.concatenate([D, columns(21, 20)], axis=2))
    effects = effects_of([*others, mixed, flexible, Alternative("cause", "it", "it", D)], left(forces), 1e-6)
    assert effects[0].alternative.key == "cause"


def test_beside_an_effect_nothing_is_left_of_it() -> None:
    forces = A @ np.ones(8) + 0.8 * D[:, :, 0] + 0.1 * noise(5, 0.5)
    one = Alternative("one", "it", "it", D)
    rest = left(forces).beside(D)
    assert effects_of([one], rest, 1e-3) == []
    both = np.concatenate([A, D], axis=2)
    fit = np.linalg.lstsq(both.reshape(-1, 9), forces.ravel(), rcond=None)[0]
    np.testing.assert_allclose(rest.residuals, forces - both @ fit, atol=1e-9)


def test_what_a_run_hardly_shows_of_an_effect_does_not_widen_the_bias_of_the_next() -> None:
    """Columns that are nearly those of the fit: were they estimated too, parameters would be as good as free."""
    hidden = A[:, :, :4] + 1e-3 * columns(30, 4)
    many = Alternative("many", "it", "it", np.concatenate([D, hidden], axis=2))
    second = columns(31, 1)
    forces = A @ np.ones(8) + 2.0 * D[:, :, 0] + 0.5 * second[:, :, 0] + 0.1 * noise(7, 0.5)
    rest = left(forces)
    first = effects_of([many], rest, 1e-3)[0]
    joint, supported = (
        effects_of([Alternative("next", "it", "it", second)], rest.beside(taken), 1e-3)[0].bias
        for taken in (many.columns, many.columns @ first.supported)
    )
    true = np.linalg.lstsq(A.reshape(-1, 8), 0.5 * second.ravel(), rcond=None)[0]
    widths = np.sqrt(np.trace(supported)), np.sqrt(np.trace(joint))
    assert 0.5 * np.linalg.norm(true) < widths[0] < 2.0 * np.linalg.norm(true)
    assert widths[1] > 5.0 * np.linalg.norm(true)
