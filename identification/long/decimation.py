"""A low-pass at the samples that are kept: one transform of the signals for all its kernels, folded to their rate.

Every s-th sample of a circular convolution of length N = s M has the spectrum of the whole folded to M, (1/s) times the
sum over a of X(q + a M) H(q + a M) e^(2 pi i p (q + a M) / N) with the phase p (Crochiere & Rabiner 1983, chapter 2):
the way back costs a transform of M, not of N. Signals go through in overlapping parts (overlap-save), so that memory
stays small.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, irfft, next_fast_len

from identification.signals import Filter

Array = NDArray[np.float64]
Spectrum = NDArray[np.complex128]

PART = 1 << 14  # samples transformed at once: they stay in the cache of the processor


def decimated(
    low_pass: Filter, values: Array, rows: NDArray[np.int64], wanted: Sequence[tuple[int, float]]
) -> list[Array]:
    """`low_pass.apply(values, order, delay)[rows]` for several orders and delays, up to rounding.

    Args:
        low_pass: the filter.
        values: shape (n, channels).
        rows: filtered samples that are wanted, ascending, counted after the filter's margin, shape (k,).
        wanted: orders of the time derivative and delays [s].

    Returns:
        One array for each of `wanted`, shape (k, channels).

    Raises:
        RecordingError: fewer samples than the filter is long.
    """
    for _, delay in wanted:
        low_pass.require(values, delay)
    stride, reach = low_pass.stride, 2 * low_pass.margin
    kept = next_fast_len(-(-min(len(values), max(PART, 4 * reach)) // stride), real=True)
    size = kept * stride
    responses = [_response(low_pass, kept, order, delay) for order, delay in wanted]
    mean = values.mean(axis=0)  # keeps rounding small against the oscillation, not against 1 m of strut
    results = [np.empty((len(rows), values.shape[1])) for _ in wanted]
    for begin in range(0, len(values) - reach, size - reach):
        first, end = np.searchsorted(rows, (begin, begin + size - reach))
        if first == end:
            continue
        part = np.zeros((values.shape[1], size))
        signals = values[begin : begin + size]
        part[:, : len(signals)] = (signals - mean).T
        spectrum = fft(part).reshape(-1, stride, kept)[:, :, : kept // 2 + 1]
        at = rows[first:end] - begin + reach
        phases = at % stride
        for phase in np.unique(phases):
            chosen = np.flatnonzero(phases == phase)
            turned = spectrum * _turn(stride, kept, int(phase))
            for result, response in zip(results, responses, strict=True):
                series = irfft(np.einsum("cam,am->cm", turned, response), kept)
                result[first + chosen] = series[:, at[chosen] // stride].T
    for result, (order, _) in zip(results, wanted, strict=True):
        if order == 0:
            result += mean
    return results


@lru_cache(maxsize=32)
def _response(low_pass: Filter, kept: int, order: int, delay: float) -> Spectrum:
    """H / s at the frequencies that fold together, shape (stride, kept // 2 + 1)."""
    kernel = low_pass.kernel(order, delay)
    spectrum = fft(kernel, kept * low_pass.stride).reshape(low_pass.stride, kept)
    return np.asarray(spectrum[:, : kept // 2 + 1] / low_pass.stride)


@lru_cache(maxsize=32)
def _turn(stride: int, kept: int, phase: int) -> Spectrum:
    """e^(2 pi i p (q + a M) / N), shape (stride, kept // 2 + 1)."""
    index = np.arange(stride)[:, None] * kept + np.arange(kept // 2 + 1)
    return np.asarray(np.exp(2j * np.pi * ((phase * index) % (stride * kept)) / (stride * kept)))
