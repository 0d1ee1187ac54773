"""Filtered samples that are kept, without those between: what the filter gives at them."""

import numpy as np
import pytest

from cases.base.errors import RecordingError
from identification import signals
from identification.signals import Filter, decimated

RNG = np.random.default_rng(4)
WANTED = [(order, delay) for delay in (0.0, 0.0123, -0.04) for order in range(3)]


@pytest.mark.parametrize(("cutoff", "count"), [(40.0, 5000), (40.0, 20_011), (15.0, 4001), (190.0, 3000)])
@pytest.mark.parametrize("part", [1000, signals.PART])
def test_they_are_those_of_the_whole_signal(
    cutoff: float, count: int, part: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows as blocks and gaps leave them: every stride-th, in stretches that begin anywhere; also no stride at all."""
    monkeypatch.setattr(signals, "PART", part)
    low_pass = Filter(cutoff, 1e-3)
    values = 1.0 + 0.05 * np.cumsum(RNG.normal(size=(count, 6)), axis=0) / 50
    most = count - 2 * low_pass.margin
    stretches = [np.arange(begin, most // 3 * (k + 1), low_pass.stride) for k, begin in enumerate((0, most // 3 + 5))]
    for rows in (np.concatenate(stretches), np.arange(most), np.array([most - 1]), np.array([], dtype=np.int64)):
        for found, (order, delay) in zip(decimated(low_pass, values, rows, WANTED), WANTED, strict=True):
            kernel = low_pass.kernel(order, delay)
            whole = np.array([np.convolve(channel, kernel, "valid") for channel in values.T]).T
            np.testing.assert_allclose(found, whole[rows], atol=1e-13 * (2 * np.pi * cutoff) ** order, rtol=1e-11)


def test_a_signal_shorter_than_the_filter_is_refused() -> None:
    with pytest.raises(RecordingError, match=r"too few.* 40 Hz"):
        decimated(Filter(40.0, 1e-3), np.zeros((200, 6)), np.array([0]), [(0, 0.0)])
    with pytest.raises(ValueError, match="beyond the filter's reach"):
        decimated(Filter(40.0, 1e-3), np.zeros((2000, 6)), np.array([0]), [(0, 0.05)])
