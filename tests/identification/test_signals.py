"""The filter family: what it passes, stops, differentiates and shifts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.errors import RecordingError
from identification.signals import Filter
from tests.helpers import one_line

STEP = 1e-3
LOW_PASS = Filter(40.0, STEP)
MARGIN = LOW_PASS.margin
T = np.arange(1500) * STEP
INNER = T[MARGIN:-MARGIN]


def wave(frequency: float, t: np.ndarray, order: int = 0) -> np.ndarray:
    """A wave or the order-th derivative of it divided by its angular frequency to that power."""
    return np.sin(2 * np.pi * frequency * t + 0.3 + order * np.pi / 2)


@pytest.mark.parametrize("order", [0, 1, 2])
@given(frequency=st.floats(0.2, 20.0))
def test_waves_below_half_the_cutoff_pass_and_are_differentiated(order: int, frequency: float) -> None:
    result = LOW_PASS.apply(wave(frequency, T)[:, None], order)[:, 0] / (2 * np.pi * frequency) ** order
    np.testing.assert_allclose(result, wave(frequency, INNER, order), atol=1e-4)


@given(frequency=st.floats(60.0, 490.0))
def test_waves_above_one_and_a_half_times_the_cutoff_are_stopped(frequency: float) -> None:
    assert np.abs(LOW_PASS.apply(wave(frequency, T)[:, None])).max() < 1e-4


def test_half_of_a_wave_at_the_cutoff_passes() -> None:
    result = LOW_PASS.apply(wave(40.0, T)[:, None])[:, 0]
    np.testing.assert_allclose(result, 0.5 * wave(40.0, INNER), atol=0.02)


@given(value=st.floats(-1e3, 1e3), step=st.sampled_from([1e-3, 1.3e-3, 4e-3]), cutoff=st.floats(5.0, 40.0))
def test_constants_pass_unchanged_and_have_no_derivative(value: float, step: float, cutoff: float) -> None:
    low_pass = Filter(cutoff, step)
    constant = np.full((2 * low_pass.margin + 50, 2), value)
    np.testing.assert_allclose(low_pass.apply(constant), value, rtol=1e-13, atol=1e-13)
    for order in (1, 2):
        np.testing.assert_allclose(low_pass.apply(constant, order), 0.0, atol=1e-9)


@given(a=st.floats(-2, 2), b=st.floats(-2, 2), c=st.floats(-2, 2), delay=st.floats(-5e-4, 5e-4))
def test_derivatives_of_parabolas_are_exact_wherever_they_are_taken(a: float, b: float, c: float, delay: float) -> None:
    parabola = (a + b * T + c * T**2)[:, None]
    at = INNER - delay
    np.testing.assert_allclose(LOW_PASS.apply(parabola, 1, delay)[:, 0], b + 2 * c * at, atol=1e-6)
    np.testing.assert_allclose(LOW_PASS.apply(parabola, 2, delay)[:, 0], 2 * c, atol=1e-8)


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("delay_ms", [0.0, 0.25, -0.5, 1.5, 2.5, 8.5, -8.5, 20.0])
def test_a_delay_shifts_a_signal_and_its_derivatives_by_fractions_of_a_sample(order: int, delay_ms: float) -> None:
    """The delay of a force channel may be many samples (MOST_DELAY 20 ms): accelerations must follow all the way."""
    result = LOW_PASS.apply(wave(5.0, T)[:, None], order, delay_ms * 1e-3)[:, 0] / (2 * np.pi * 5.0) ** order
    np.testing.assert_allclose(result, wave(5.0, INNER - delay_ms * 1e-3, order), atol=2e-4)


def test_position_velocity_and_acceleration_pass_the_same_filter() -> None:
    """Filtering then differentiating numerically gives the filter's own derivatives, also in its transition band."""
    signal = (wave(12.0, T) + wave(35.0, T) + wave(80.0, T))[:, None]
    smooth, velocity, acceleration = (LOW_PASS.apply(signal, order)[:, 0] for order in range(3))
    by_differences = (smooth[2:] - smooth[:-2]) / (2 * STEP)
    np.testing.assert_allclose(velocity[1:-1], by_differences, atol=0.01 * np.abs(velocity).max())
    twice = (smooth[2:] - 2 * smooth[1:-1] + smooth[:-2]) / STEP**2
    np.testing.assert_allclose(acceleration[1:-1], twice, atol=0.01 * np.abs(acceleration).max())


def test_channels_do_not_mix_and_the_filter_is_linear() -> None:
    draw = np.random.default_rng(0)
    one, two = draw.normal(size=(2, 800, 1))
    both = LOW_PASS.apply(np.hstack([one, two]))
    np.testing.assert_allclose(both[:, :1], LOW_PASS.apply(one), atol=1e-14)
    np.testing.assert_allclose(LOW_PASS.apply(one + 3 * two), both[:, :1] + 3 * both[:, 1:], atol=1e-13)


def test_a_signal_played_backwards_is_filtered_backwards() -> None:
    """Zero phase: nothing is delayed."""
    signal = np.random.default_rng(1).normal(size=(800, 1))
    np.testing.assert_allclose(LOW_PASS.apply(signal[::-1])[::-1], LOW_PASS.apply(signal), atol=1e-13)


@pytest.mark.parametrize("count", [1, MARGIN, 2 * MARGIN + 1])
def test_a_signal_shorter_than_the_filter_is_refused(count: int) -> None:
    with pytest.raises(RecordingError, match=rf"\b{count} samples.* 40 Hz") as caught:
        LOW_PASS.apply(np.zeros((count, 6)))
    assert "record longer" in one_line(caught.value)
