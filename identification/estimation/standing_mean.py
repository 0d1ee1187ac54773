"""Means of channels that stand: their covariance, where noise remembers for a time that the record itself must show.

A record shows a memory of a quarter of its own length by few numbers, and the sum of correlations that it shows is then
too small. So no single memory is taken: how the mean is off is averaged over all noises that the record allows, each as
often as it makes the record likely (Bayes), as for runs (`one_memory`). Here the likelihood is exact, for records are
short: of means of up to 64 stretches, of white noise and noise of one memory. What remembers less than a stretch is
white in them.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import toeplitz
from scipy.special import ndtr

from cases.base.units import Array

STRETCHES = 64  # of a record, whose means are looked at
PER_OCTAVE = 2  # memories that are tried, from that of a stretch to that of the record
RATIOS = np.logspace(-2.0, 3.0, 24)  # of the noise with memory over the white one, in a stretch
WHITE = 0.8  # chance beforehand that noise remembers nothing
QUARTER = 0.25  # of the record: of what remembers as long it shows little
TOO_SHORT = 0.4  # share of the variance by such noise, from which a record is short
HOLDS = 1.96  # deviations to either side, which hold 95 %
BISECTIONS = 40
TINY = 1e-9  # of a channel's variance that counts as independent of the others


class StandingMean(NamedTuple):
    """How the means of channels are off."""

    white: Array  # covariance by noise that remembers nothing, shape (c, c)
    covariance: Array  # by all noise that the record allows: 1.96 of its deviations hold 95 %, shape (c, c)
    slow: float  # share of the variance that is of noise which remembers a quarter of the record or longer

    @property
    def short(self) -> bool:
        """Whether the record is short for what its noise remembers."""
        return self.slow >= TOO_SHORT

    @classmethod
    def of_white_noise(cls, values: Array) -> "StandingMean":
        """That of noise that remembers nothing, of values of channels, shape (n, c)."""
        white = np.diag(np.maximum(values.var(axis=0, ddof=1), np.finfo(float).tiny)) / len(values)
        return cls(white, white, 0.0)


class _Memory(NamedTuple):
    """Noise of one memory in means of stretches, less their mean."""

    share: float  # of the record that it remembers
    variances: Array  # in independent directions, shape (b - 1,)
    directions: Array  # shape (b, b - 1)
    mean: float  # variance of the mean of the record


@cache
def _memories(stretches: int) -> tuple[_Memory, ...]:
    """Noises of variance 1, of memories from a stretch to the record."""
    others = np.linalg.qr(np.c_[np.ones(stretches), np.eye(stretches)[:, :-1]])[0][:, 1:]
    apart, answer = np.arange(stretches), []
    for octave in np.arange(0.0, np.log2(stretches) + 1e-9, 1.0 / PER_OCTAVE):
        memory = 2.0**octave
        # covariances of means of exp(-|t| / memory) over stretches of length 1
        alike = memory**2 * (np.exp(1.0 / memory) - 2.0 + np.exp(-1.0 / memory)) * np.exp(-apart / memory)
        alike[0] = 2.0 * (memory - memory**2 * (1.0 - np.exp(-1.0 / memory)))
        whole = toeplitz(alike)
        variances, turned = np.linalg.eigh(others.T @ whole @ others)
        answer.append(_Memory(memory / stretches, np.maximum(variances, 0.0), others @ turned, float(whole.mean())))
    return tuple(answer)


def standing_mean(values: Array) -> StandingMean:
    """Covariance of the means of channels over a record at equal steps, shape (n, c), n at least c + 4.

    Channels are taken to remember alike, each with noise of its own size.
    """
    count = len(values)
    off = values - values.mean(axis=0)
    size = -(-count // STRETCHES)  # so long that nearly all samples are in one
    stretches = count // size
    means = off[: stretches * size].reshape(stretches, size, -1).mean(axis=1)
    # what channels have in common, by steps between stretches: slow noise itself would be alike in any few channels
    steps = np.diff(means, axis=0)
    together = steps.T @ steps / len(steps)
    live = np.flatnonzero(np.diag(together) > 0.0)  # a channel that stays the same shows nothing
    white = StandingMean.of_white_noise(values).white
    if not len(live):
        return StandingMean(white, white, 0.0)
    common = together[np.ix_(live, live)]
    mixing = np.linalg.cholesky(common + TINY * np.diag(np.diag(common)))
    independent = np.linalg.solve(mixing, (means - means.mean(axis=0))[:, live].T).T
    chances, variances, memories = _noises(independent)
    remembered = mixing @ np.diag(_deviations(chances, np.sqrt(variances)) ** 2) @ mixing.T
    # all samples show white noise better than the stretches do: no mean is off by less than it makes
    wider = np.sqrt(np.maximum(np.diag(white)[live] / np.diag(remembered), 1.0))
    covariance = white.copy()
    covariance[np.ix_(live, live)] = wider[:, None] * (remembered + remembered.T) / 2.0 * wider
    each = chances * variances.mean(axis=1)
    return StandingMean(white, covariance, float(each[memories >= QUARTER].sum() / each.sum()))


def _noises(means: Array) -> tuple[Array, Array, Array]:
    """All noises that are tried, of independent channels with means of stretches, shape (b, c).

    Returns:
        how likely each is, shape (h,); variances of the mean of the record, shape (h, c); its memory, as a share of the
        record, shape (h,).
    """
    stretches, channels = means.shape
    free, memories = stretches - 1, _memories(stretches)
    size = np.sum(means**2, axis=0)
    chances = [np.array([np.log(WHITE) - 0.5 * free * np.sum(np.log(size))])]
    variances, remembered = [size[None] / stretches], [np.zeros(1)]
    beforehand = np.log((1.0 - WHITE) / (len(memories) * len(RATIOS)))
    for of in memories:
        widths = 1.0 + RATIOS[:, None] * of.variances  # shape (r, b - 1)
        sizes = (1.0 / widths) @ (of.directions.T @ means) ** 2  # of the white noise, times `free`, shape (r, c)
        likely = -0.5 * free * np.sum(np.log(sizes), axis=1) - 0.5 * channels * np.sum(np.log(widths), axis=1)
        chances.append(beforehand + likely)
        variances.append(sizes * (1.0 / stretches + RATIOS * of.mean)[:, None])
        remembered.append(np.full(len(RATIOS), of.share))
    logs = np.concatenate(chances)
    weights = np.exp(logs - logs.max())
    # a variance that `free` numbers show is on average that much larger than the likeliest
    return weights / weights.sum(), np.concatenate(variances) / (free - 2.0), np.concatenate(remembered)


def _deviations(chances: Array, deviations: Array) -> Array:
    """Deviations of which 1.96 hold 95 % of errors that have one of some deviations, shape (h, c), each by its chance.

    Shape (c,).
    """
    low, high = np.log(deviations.min(axis=0)), np.log(deviations.max(axis=0))
    for _ in range(BISECTIONS):
        middle = (low + high) / 2.0
        outside = 2.0 * (chances @ ndtr(-HOLDS * np.exp(middle) / deviations)) > 0.05
        low, high = np.where(outside, middle, low), np.where(outside, high, middle)
    return np.asarray(np.exp(high))
