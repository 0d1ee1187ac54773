"""Noise of one memory: the mean over all that residuals allow it to be.

A short run shows slow noise by few numbers, and how much of it there is below the lowest frequency of the run by none.
The square of an error is, on average, what each noise that residuals allow makes of it, as often as they make that
noise likely (Bayes). So noise that they do not show counts by the little that it may have, and noise that few of them
show by what it may have at most. A mixture of many memories at its maximum does neither: a little of each stays in
white noise, and slow noise comes out too small.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases.base.units import Array
from identification.estimation.force_noise import SHORTEST, Turned
from identification.estimation.noise_spectra import NOTHING, ChannelSpectra, channel_spectra, likeliest

PER_OCTAVE, OCTAVES_BEYOND = 2, 1  # memories that are tried, from so many octaves above the run's length downwards
HARDLY_SHOWN = 1 + PER_OCTAVE * (OCTAVES_BEYOND + 2)  # of them: those of a quarter of the run or longer
SIZES, REACH = 24, 5.0  # of the noise with memory that are tried, over so many of their deviations to either side
LEAST = 1e-5  # of the white noise: the least size that counts
LEAST_KNOWN = 1e-2  # independent numbers that tell of a size, at least
RISES = 1.0  # logarithm of the likelihood that noise of accelerations must gain
PRICE = 3.0  # of a size, a memory and how much of it there is: Akaike's


class Mean(NamedTuple):
    """Shares of white noise, of noises of each memory and of noise of accelerations, and how well they explain."""

    shares: Array  # shape (c,)
    likelihood: float  # logarithm, of the likeliest memory and size
    price: float

    @property
    def criterion(self) -> float:
        """Akaike's, half of its usual size and of the other sign."""
        return self.likelihood - self.price


class _Memory(NamedTuple):
    """Sizes of the noise of one memory beside others."""

    chances: Array  # logarithms of the likelihood over the width of a size, shape (s,)
    shares: Array  # shape (s, c)
    likelihood: float  # logarithm, of the likeliest


def channels_of(found: Turned, frequencies: int) -> list[ChannelSpectra]:
    """What residuals show of white noise, of noises of each memory, and of accelerations, at the lowest frequencies."""
    lags = np.arange(found.length)
    finest = max(int(PER_OCTAVE * np.log2(found.length / SHORTEST)), 1)
    octaves = np.arange(-PER_OCTAVE * OCTAVES_BEYOND, finest + 1) / PER_OCTAVE
    kinds = [(lags == 0) * 1.0, *(np.exp(-lags * 2.0**octave / found.length) for octave in octaves)]
    if found.sources is not None:
        kinds.append(found.lags(found.sources[1]))
    return channel_spectra(found, np.array(kinds), frequencies)


def mean_of(channels: Sequence[ChannelSpectra], sizes: Array, free: Array, rising: bool) -> Mean:
    """The mean over memories and sizes of the noise with memory, beforehand alike in their logarithms.

    Args:
        channels: of `channels_of`, which remember alike.
        sizes: of their noise, shape (k,).
        free: shares of their power that the fit leaves, one channel after the other, shape (f,): what a frequency
            counts by.
        rising: whether noise of accelerations is among their kinds.
    """
    spectra = np.concatenate([channel.residual for channel in channels], axis=1)
    power = np.concatenate([channel.power / size for channel, size in zip(channels, sizes, strict=True)])
    floor = NOTHING * float(spectra.max())
    spectra, power = np.maximum(spectra, floor), np.maximum(power, floor)
    memories = range(1, len(spectra) - rising)
    mean, best = _averaged(power, spectra, free, memories, [0])
    if rising:
        last = len(spectra) - 1
        with_it = likeliest(power, spectra[[0, best, last]], free=free)
        if with_it.likelihood - mean.likelihood > RISES:
            mean, _ = _averaged(power, spectra, free, memories, [0, last])
    return mean


def _averaged(power: Array, left: Array, free: Array, memories: range, others: list[int]) -> tuple[Mean, int]:
    """The mean with some noises beside the one with memory, and which memory is the likeliest."""
    begin, candidates = None, list[_Memory]()
    for memory in memories:
        likeliest_shares = likeliest(power, left[[*others, memory]], begin, free=free)
        begin = likeliest_shares.shares
        shares = np.zeros(len(left))
        shares[[*others, memory]] = likeliest_shares.shares
        candidates.append(_sizes(power, left, free, shares, memory))
    chances = np.array([of.chances for of in candidates])
    weights = np.exp(chances - chances.max())
    mean = np.tensordot(weights / weights.sum(), np.array([of.shares for of in candidates]), 2)
    best = max(range(len(candidates)), key=lambda k: candidates[k].likelihood)
    return Mean(mean, candidates[best].likelihood, PRICE + len(others) - 1.0), memories[best]


def _sizes(power: Array, left: Array, free: Array, shares: Array, memory: int) -> _Memory:
    """Sizes of the noise of a memory about the likeliest shares, shape (c,); the size of all follows each."""
    remembered_power = shares[memory] * left[memory]
    other_power = shares @ left - remembered_power
    part, count = remembered_power / (remembered_power + other_power), float(np.sum(free))
    fisher_information = max(float(np.sum(free * part**2) - np.sum(free * part) ** 2 / count), LEAST_KNOWN)
    width = REACH / np.sqrt(fisher_information)
    upper = float(np.log(shares[memory])) + min(width, REACH)
    least = float(np.log(LEAST * shares[0]))
    lower = min(max(float(np.log(shares[memory])) - width, least), upper - 1.0)
    logs = np.linspace(lower, upper, SIZES)
    total = other_power + np.exp(logs)[:, None] * left[memory]
    scale = np.sum(free * power / total, axis=1) / count
    likelihoods = -np.sum(free * np.log(total), axis=1) - count * (np.log(scale) + 1.0)
    each = np.tile(shares, (SIZES, 1))
    each[:, memory] = np.exp(logs)
    # the mean of a size that `count` pairs of numbers show is that much larger than the likeliest
    each *= (scale * count / max(count - 1.0, 1.0))[:, None]
    return _Memory(likelihoods + np.log(upper - lower), each, float(likelihoods.max()))
