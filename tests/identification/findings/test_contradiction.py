"""A case is doubted where its machine is off by more than stated, and seldom where it is not."""

import numpy as np
import pytest

from cases.base.units import Array
from identification.estimation.score_test import Noise
from identification.findings.contradiction import (
    NAMED_BELOW,
    UNLIKELY,
    chance_of_all,
    chance_of_one,
    parts_of,
    standing_out,
    times_stated,
)

SIZES, SCORES = 30, 12
THROUGH: Array = np.random.default_rng(5).normal(size=(SCORES, SIZES)) * np.geomspace(3.0, 0.05, SCORES)[:, None]
UNIT = np.eye(SCORES)


def known(freedom: float = 1e9, variance: float = 1.0) -> Noise:
    """White noise whose variance is known by so many residuals."""
    return Noise(variance * UNIT, (variance * UNIT[None],), (np.array([[2.0 / freedom]]),))


def scores(draw: np.random.Generator, times: float = 1.0) -> Array:
    return np.asarray(THROUGH @ draw.normal(0.0, times, SIZES) + draw.normal(size=SCORES))


def test_a_size_by_itself_is_what_generalised_least_squares_make_of_it() -> None:
    news = scores(np.random.default_rng(1), 3.0)
    sizes, stds, _ = parts_of(news, THROUGH, UNIT)
    for k in (0, 17):
        others = np.delete(THROUGH, k, axis=1)
        w = np.linalg.inv(others @ others.T + UNIT)
        strength = float(THROUGH[:, k] @ w @ THROUGH[:, k])
        assert sizes[k] == pytest.approx(float(THROUGH[:, k] @ w @ news) / strength)
        assert stds[k] == pytest.approx(strength**-0.5)


@pytest.mark.parametrize("freedom", [1e9, 15.0])
def test_machines_as_stated_are_seldom_accused(freedom: float) -> None:
    """One of a hundred has a chance of one in a hundred, also where noise is known by few residuals."""
    draw, alone, together = np.random.default_rng(2), [], []
    for _ in range(2000):
        noise = known(freedom, float(draw.chisquare(freedom) / freedom) if freedom < 1e6 else 1.0)
        news = scores(draw)
        alone.append(chance_of_one(news, THROUGH, noise))
        together.append(chance_of_all(news, THROUGH, noise))
    for chances in (np.array(alone), np.array(together)):
        assert np.mean(chances < 0.01) < 0.016
        assert np.sum(chances < UNLIKELY) <= 7
    assert np.mean(np.array(together) < 0.01) > 0.006


def test_one_part_that_is_far_off_is_named_with_its_size() -> None:
    draw, size = np.random.default_rng(3), 25.0
    best = int(np.argmax(np.sum(THROUGH**2, axis=0)))
    for _ in range(20):
        news = scores(draw) + size * THROUGH[:, best]
        part = standing_out(news, THROUGH, known())[0]
        assert part.place == best
        assert part.chance < NAMED_BELOW
        assert chance_of_one(news, THROUGH, known()) < UNLIKELY
        assert abs(part.size - size) < 3.5 * np.hypot(1.0, part.std)
        assert part.deviations == pytest.approx(abs(part.size) / np.hypot(1.0, part.std))


def test_a_case_is_doubted_before_a_part_is_named() -> None:
    """A name costs a part that is taken off: it wants more than the doubt does."""
    draw = np.random.default_rng(5)
    best, noise = int(np.argmax(np.sum(THROUGH**2, axis=0))), scores(draw)
    doubted, named = [], []
    for size in np.arange(2.0, 30.0):
        news = noise + size * THROUGH[:, best]
        doubted.append(chance_of_one(news, THROUGH, known()) < UNLIKELY)
        parts = standing_out(news, THROUGH, known())
        named.append(bool(parts))
        assert not parts or parts[0].chance < 1e-4
    assert 0 < np.argmax(doubted) < np.argmax(named)
    assert named[-1]


def test_a_part_that_another_equals_is_named_with_it() -> None:
    """Two sizes whose effects differ by next to nothing: which of them is off no run can tell."""
    draw = np.random.default_rng(9)
    best = int(np.argmax(np.sum(THROUGH**2, axis=0)))
    twin = np.column_stack([THROUGH, THROUGH[:, best] + 0.02 * THROUGH[:, 0]])
    for _ in range(20):
        parts = standing_out(scores(draw) + 25.0 * THROUGH[:, best], twin, known())
        assert {part.place for part in parts} == {best, SIZES}


@pytest.mark.parametrize("times", [2.0, 3.0])
def test_of_machines_whose_tolerances_are_too_small_no_part_is_named_that_is_right(times: float) -> None:
    """What is said of a part is true within its deviation, also where all others are larger than stated."""
    draw, doubted, named, wrong = np.random.default_rng(8), 0, 0, 0
    for _ in range(300):
        true = draw.normal(0.0, times, SIZES)
        news = THROUGH @ true + draw.normal(size=SCORES)
        doubted += min(chance_of_one(news, THROUGH, known()), chance_of_all(news, THROUGH, known())) < UNLIKELY
        if parts := standing_out(news, THROUGH, known()):
            named += 1
            wrong += min(abs(part.size - true[part.place]) / part.std for part in parts) > 3.5
    assert doubted > 0.4 * 300
    assert named < 0.2 * doubted
    assert wrong <= 0.02 * 300


def test_a_part_that_stands_out_of_larger_others_is_named_beside_them() -> None:
    """Three sizes, each with a score of its own: two are off by some deviations, the third by many."""
    news, through = np.array([0.0, -0.3, 3.0, 5.0, 20.0]), np.vstack([np.zeros((2, 3)), np.eye(3) * 50.0])
    news[2:] *= 50.0
    noise = Noise(np.eye(5), (np.eye(5)[None],), (np.array([[2e-9]]),))
    (part,) = standing_out(news, through, noise)
    assert (part.place, part.size) == (2, pytest.approx(20.0, abs=0.1))
    assert part.std < 0.03
    assert 3.0 < part.times < 6.0


def test_tolerances_that_are_three_times_too_small_show_it_together() -> None:
    draw = np.random.default_rng(4)
    news = [scores(draw, 3.0) for _ in range(200)]
    assert np.mean([chance_of_all(of, THROUGH, known()) < UNLIKELY for of in news]) > 0.8
    assert np.median([times_stated(of, THROUGH, known()) for of in news]) == pytest.approx(3.0, rel=0.1)


def test_directions_that_noise_hides_take_nothing_from_what_others_show() -> None:
    draw, more = np.random.default_rng(7), 30
    faint = np.zeros((more, SIZES))
    faint[:, :1] = 0.01
    through = np.vstack([THROUGH, faint])
    whole = Noise(np.eye(SCORES + more), (np.eye(SCORES + more)[None],), (np.array([[2e-9]]),))
    for _ in range(20):
        news = scores(draw, 2.0)
        beside = chance_of_all(np.r_[news, draw.normal(size=more)], through, whole)
        assert beside == pytest.approx(chance_of_all(news, THROUGH, known()), rel=0.05)


def test_a_size_that_no_score_shows_is_never_named() -> None:
    through = THROUGH.copy()
    through[:, 4] = 0.0
    news = scores(np.random.default_rng(6), 9.0)
    sizes, stds, _ = parts_of(news, through, UNIT)
    assert (sizes[4], stds[4]) == (0.0, np.inf)
    assert all(part.place != 4 for part in standing_out(news, through, known()))
