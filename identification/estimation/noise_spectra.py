"""What residuals of a fit show of noises with memory, by their spectra, and the shares of noises that are likeliest.

The power of the residuals is compared with that which each noise would leave behind the same fit, exactly, by Whittle's
likelihood (1953): what the fit took away is put back.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from cases.base.units import Array
from identification.estimation.force_noise import Turned, products, rings

SLOW = 1.0 / 3.0  # of the evaluated samples' Nyquist frequency: half the cut-off, where the filter changes nothing
PASSED = 2.0 / 3.0  # of it: the cut-off
BEGIN = 1e-2  # shares of noises beside the white one to begin with, of a channel's variance
# Of an independent number, that is taken to have shown each noise in each channel: no share is zero because a few
# residuals do not show it, and the search has a smooth maximum.
BEFOREHAND = 0.02
STEPS, SMALL, LONGEST = 60, 1e-3, 3.0  # of the search: how many, gain of the last, largest change of a logarithm
MANY = 1e9  # damping of a search that finds nothing better
NOTHING = 1e-9  # share of the largest power, below which no power counts


class ChannelSpectra(NamedTuple):
    """What the residuals of a channel show of noises of some kinds."""

    kinds: Array  # their autocovariances, shape (c, n); the last is the autoregressive one
    power: Array  # of the residuals, shape (f,)
    residual: Array  # that a unit of each kind leaves behind the fit, shape (c, f)
    whole: Array  # that a unit of each kind has, shape (c, f)
    covariances: Array  # as of `Parts`
    order: int  # of the autoregressive model


class Likeliest(NamedTuple):
    """Shares of noises that make the power of one or more channels likeliest."""

    shares: Array  # shape (c,)
    sizes: Array  # by which they are multiplied in each channel, shape (k,)
    likelihood: float  # logarithm
    price: float  # Akaike's: number of shares and sizes that the power determines

    @property
    def criterion(self) -> float:
        """Akaike's, half of its usual size and of the other sign."""
        return self.likelihood - self.price


def lowest(found: Turned, share: float, kinds: int) -> int:
    """Number of frequencies below a share of the highest one, of short runs enough to tell so many noises apart."""
    return max(1 + kinds, int(share * (found.length // 2)) + 1)


def channel_spectra(
    found: Turned, kinds: Array, frequencies: int, peaked: Sequence[tuple[Array, int]] | None = None
) -> list[ChannelSpectra]:
    """What the residuals of each channel show of noises at the lowest frequencies.

    Args:
        found: the residuals.
        kinds: autocovariances of the noises, shape (c, n).
        frequencies: number of frequencies, f.
        peaked: of each channel the autocovariance of one more noise, shape (n,), and its order.
    """
    answer, basis, white = (found.series(v) for v in (found.answer, found.taken, found.noise))
    mask = found.series(np.ones(len(found.noise)))
    pairs = np.maximum(np.round(products(mask)), 0.0)
    answers = []
    for k in range(found.noise.shape[1]):
        autocovariances, order = (kinds, 0) if peaked is None else (np.vstack([kinds, peaked[k][0]]), peaked[k][1])
        effects = _seen(*_narrow(answer[:, k], basis[:, k]), mask, pairs, autocovariances, frequencies)
        answers.append(ChannelSpectra(autocovariances, np.abs(rfft(white[:, k])[:frequencies]) ** 2, *effects, order))
    return answers


def _narrow(answer: Array, basis: Array) -> tuple[Array, Array, Array]:
    """Q with orthonormal columns, shape (n, r), C R^T and R, shape (r, u), so that B = Q R and C B^T = C R^T Q^T.

    What is in other channels alone costs columns of B nothing here.
    """
    values, vectors = np.linalg.eigh(answer.T @ answer)
    some = values > NOTHING**2 * max(float(values[-1]), np.finfo(float).tiny)
    inward = vectors[:, some] / np.sqrt(values[some])
    back = np.sqrt(values[some])[:, None] * vectors[:, some].T
    return answer @ inward, basis @ back.T, back


def _seen(
    spanned: Array, taken: Array, back: Array, here: Array, pairs: Array, kinds: Array, slow: int
) -> tuple[Array, Array, Array]:
    """Effect of noises of some kinds: |rfft|^2 of the residuals and of the noise, shape (c, f), and B^T Gamma B.

    Args:
        spanned: Q, as of `_narrow`, shape (n, r).
        taken: C R^T, shape (n, r).
        back: R, shape (r, u).
        here: 1 where there is a sample, shape (n,).
        pairs: number of pairs of samples that are so far apart, shape (n,).
        kinds: autocovariances of the noises, shape (c, n).
        slow: f, frequencies that count.
    """
    length, period = len(here), next_fast_len(2 * len(here), real=True)
    raw = (2.0 * rfft(pairs * kinds).real - pairs[0] * kinds[:, :1])[:, :slow]
    spectra = rings(kinds, period)
    basis_spectra, response_spectra = rfft(spanned.T, period), rfft(taken.T)[:, :slow]
    residual_spectra, meats = [], []
    for ring, noise_spectrum in zip(spectra, raw, strict=True):
        response = irfft(ring * basis_spectra, period)[:, :length]  # Gamma Q
        meat = response @ spanned
        cross_spectra = rfft(response * here)[:, :slow]
        residual_spectra.append(
            noise_spectrum
            + np.sum((meat @ response_spectra - 2.0 * cross_spectra) * response_spectra.conj(), axis=0).real
        )
        meats.append(back.T @ meat @ back)
    return np.array(residual_spectra), raw, np.array(meats)


def free_of(shares: Array, channel: ChannelSpectra) -> Array:
    """Share of the power of a mixture that the fit leaves at each frequency, shape (f,)."""
    floor = NOTHING * float(channel.residual.max())
    return np.asarray(np.clip((shares @ channel.residual) / np.maximum(shares @ channel.whole, floor), 0.0, 1.0))


def likeliest(
    power: Array, expected: Array, begin: Array | None = None, channels: int = 1, free: Array | float = 1.0
) -> Likeliest:
    """Shares of noises, of which each is expected to make some power, shape (c, f), that make the power likeliest.

    By Fisher's scoring of their logarithms, from shares to begin with.

    Args:
        power: of the residuals of some channels, one after the other, shape (f,).
        expected: what a unit of each noise leaves behind the fit, shape (c, f).
        begin: shares to begin with, shape (c,).
        channels: number of channels.
        free: weights of the frequencies, shape (f,).
    """
    floor = NOTHING * float(expected.max())
    expected, power = np.maximum(expected, floor), np.maximum(power, floor)
    count, beforehand = len(expected), BEFOREHAND * channels
    logs = np.log(np.r_[1.0, np.full(count - 1, BEGIN)] if begin is None else begin)

    def cost(at: Array) -> float:
        total = np.exp(at) @ expected
        return float(np.sum(free * (np.log(total) + power / total))) - beforehand * float(at.sum())

    now, damping = cost(logs), 1e-3
    for _ in range(STEPS):
        total = np.exp(logs) @ expected
        part = np.exp(logs)[:, None] * expected / total
        slope = part @ (free * (1.0 - power / total)) - beforehand
        bend = (part * free) @ part.T + beforehand * np.eye(count)
        step = np.clip(-np.linalg.solve(bend + damping * np.eye(count), slope), -LONGEST, LONGEST)
        then = cost(logs + step)
        if then > now:
            damping = max(8.0 * damping, 0.01)
            if damping > MANY:
                break
            continue
        gain, now, logs, damping = now - then, then, logs + step, max(damping / 4.0, 1e-4)
        if gain < SMALL:
            break
    shares = np.exp(logs)
    total = shares @ expected
    part = shares[:, None] * expected / total
    information = (part * free) @ part.T
    price = float(np.trace(np.linalg.solve(information + beforehand * np.eye(count), information)))
    return Likeliest(shares, np.ones(1), -float(np.sum(free * (np.log(total) + power / total))), price)
