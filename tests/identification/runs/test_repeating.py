"""Where a run repeats itself, and the refusal of what does not, with what was measured."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

from cases.errors import RecordingError
from identification.runs.fourier_series import FourierSeries
from identification.runs.repeating import find_part, given_part
from tests.helpers import one_line

STEP = 2e-3


def run(period: float, periods: int, seed: int = 0, harmonics: int = 5, rest: float = 0.7) -> tuple:
    """Rest, a smooth way to the first pose, the periods from rest to rest, a way back, rest: time, struts, start."""
    draw = np.random.default_rng(seed)
    weight = 1.0 / np.arange(1, harmonics + 1)
    cosines, sines = draw.normal(size=(2, harmonics, 6)) * 0.1 * weight[:, None]
    h = np.arange(1, harmonics + 1)[:, None]
    sines -= h * np.sum(h * sines, axis=0) / np.sum(h**2)  # no rate at phase 0
    cosines -= h**2 * np.sum(h**2 * cosines, axis=0) / np.sum(h**4)  # no acceleration
    coefficients = np.zeros((2 * harmonics + 1, 6))
    coefficients[1::2], coefficients[2::2] = cosines, sines
    start, way = rest + 0.8, 0.8
    series = FourierSeries(coefficients, period, start)
    first, home = series.at(np.array([start]))[0], draw.normal(size=6) * 0.1
    t = np.arange(int((2 * start + periods * period) / STEP)) * STEP
    ease = lambda s: (10 * s**3 - 15 * s**4 + 6 * s**5)[:, None]  # noqa: E731
    struts = series.at(t)
    before, after = np.clip((t - rest) / way, 0, 1), np.clip((t - start - periods * period) / way, 0, 1)
    struts[t < start] = (home + (first - home) * ease(before))[t < start]
    late = t > start + periods * period
    struts[late] = (first + (home - first) * ease(after))[late]
    return t, 1.0 + struts, start


@pytest.mark.slow
@settings(max_examples=12)
@given(period=st.floats(0.6, 2.0), periods=st.integers(2, 4), seed=st.integers(0, 1000))
def test_the_periodic_part_is_found_between_approach_and_return(period: float, periods: int, seed: int) -> None:
    t, struts, start = run(period, periods, seed)
    part = find_part(t, struts, np.arange(len(t)))
    assert part.period == pytest.approx(period, rel=2e-3)
    assert part.periods == periods
    assert t[part.first] == pytest.approx(start, abs=0.06 * period)
    assert part.relative < 2e-3


@pytest.mark.parametrize("noise", [0.0, 1e-5, 2e-4])
def test_with_the_window_known_the_period_is_exact_to_its_noise(noise: float) -> None:
    t, struts, start = run(1.2347, 3)
    struts = struts + noise * np.random.default_rng(0).normal(size=struts.shape)
    window = np.flatnonzero((t >= start) & (t < start + 3 * 1.2347))
    part = find_part(t, struts, window)
    assert part.period == pytest.approx(1.2347, abs=1e-8 + 0.5 * noise)
    assert (part.periods, part.first) == (3, pytest.approx(window[0], abs=1))
    assert part.misfit == pytest.approx(np.sqrt(2) * noise, rel=0.1, abs=1e-6)


def test_a_multiple_of_the_period_is_not_taken_for_it() -> None:
    t, struts, _ = run(0.5, 8)
    assert find_part(t, struts, np.arange(len(t))).period == pytest.approx(0.5, rel=1e-3)


@given(period=st.floats(0.7, 1.5))
@settings(max_examples=10)
def test_a_given_period_is_kept_as_it_is(period: float) -> None:
    t, struts, _ = run(period, 3)
    part = given_part(t, struts, np.arange(len(t)), period)
    assert (part.period, part.periods) == (period, 3)


def test_a_single_period_can_be_given_where_it_ends_as_it_began() -> None:
    t, struts, start = run(2.0, 1)
    window = np.flatnonzero((t >= start) & (t < start + 2.0))
    part = given_part(t, struts, window, 2.0)
    assert (part.periods, part.end - part.first) == (1, len(window))
    with pytest.raises(RecordingError, match="not periodic"):
        find_part(t, struts, window)


def test_a_wrong_period_is_refused_with_the_right_one() -> None:
    t, struts, _ = run(1.25, 3)
    with pytest.raises(RecordingError, match=r"period 1: .* mm rms .*period of 1\.25\d* s") as e:
        given_part(t, struts, np.arange(len(t)), 1.0)
    assert "leave period out" in one_line(e.value)


@pytest.mark.parametrize("period", [1e-9, 0.004, 1e3])
def test_a_period_that_no_run_can_have_is_refused(period: float) -> None:
    t, struts, _ = run(1.0, 2)
    with pytest.raises(RecordingError, match="fits into it") as e:
        given_part(t, struts, np.arange(len(t)), period)
    one_line(e.value)


def random_motion(seed: int) -> tuple[np.ndarray, np.ndarray]:
    knots = np.random.default_rng(seed).normal(size=(25, 6)) * 0.1
    t = np.arange(4000) * STEP
    return t, 1.0 + make_interp_spline(np.linspace(0.0, t[-1], 25), knots, k=5)(t)


@pytest.mark.parametrize("seed", range(6))
def test_a_motion_that_does_not_repeat_is_refused_with_how_far_the_best_period_misses(seed: int) -> None:
    t, struts = random_motion(seed)
    with pytest.raises(RecordingError, match=r"period, [\d.]+ s, .* [\d.]+ mm rms .*at most 1 %") as e:
        find_part(t, struts, np.arange(len(t)))
    one_line(e.value)


def test_periods_that_become_slower_are_refused() -> None:
    """A feed that changes by a tenth is not a period."""
    t, struts, start = run(1.0, 4, rest=0.0)
    slower = start + np.sign(t - start) * np.abs(t - start) ** 1.04
    struts = np.column_stack([np.interp(slower, t, s) for s in struts.T])
    with pytest.raises(RecordingError, match="not periodic"):
        find_part(t, struts, np.arange(len(t)))


@pytest.mark.parametrize("struts", [np.ones((500, 6)), np.linspace(1.0, 1.2, 500)[:, None] * np.ones(6)])
def test_rest_and_straight_lines_are_not_periodic(struts: np.ndarray) -> None:
    with pytest.raises(RecordingError, match="not periodic") as e:
        find_part(np.arange(500) * STEP, struts, np.arange(500))
    one_line(e.value)


@pytest.mark.parametrize("seed", range(4))
def test_a_start_that_is_slower_than_the_rest_is_left_out(seed: int) -> None:
    """As LinuxCNC does on a busy computer: half a second at nine tenths of the feed, then in time."""
    t, struts, start = run(1.5, 4, seed)
    late = start + np.where(t < start + 0.4, 0.9 * (t - start), t - start - 0.04)
    late = np.where(t < start, t, late)
    window = np.flatnonzero((t >= start) & (t < start + 6.0))
    part = find_part(t, np.column_stack([np.interp(late, t, s) for s in struts.T]), window)
    assert part.period == pytest.approx(1.5, abs=2e-4)
    assert part.periods == 3
    assert t[part.first] > start + 0.4
    assert part.relative < 1e-3
