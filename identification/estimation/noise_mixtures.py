"""Noise with memory as a mixture of noises, by the spectra of residuals, and the covariance of an estimate under it.

Where noise has memory, the covariance is the sandwich with an autocovariance from the residuals. Kernels need long
runs: at the frequencies of the motion, where it matters, a short run leaves them too few residuals. Here noise is
described in turned channels, independent at lag zero, as a mixture of white noise, first-order noises with memories of
up to the run's length, and noise of accelerations, which rises with the frequency. How much there is of each, spectra
say below half the cut-off, by Whittle's likelihood (1953): the residuals' against those that the mixture would leave
behind the same fit, exactly, so that what the fit took away is put back. Six channels of one machine as a rule
remember alike, and then tell of it together; where their spectra speak against it, each is judged by itself. An
autoregressive model (Burg's) is part of it only where there are peaks that the others cannot have: it follows the
residuals, and with them the dips that the fit made. Noise slower than the run looks like a parameter, and no method can
show it.

In 4 s of a wrist and a hexapod deviations are 5 to 15 % too wide in white noise, 5 to 10 % where noise remembers 50 ms
and 2 to 5 % too small where it remembers 0.3 s; where it remembers two fifths of the run, a third too small.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.special import stdtrit

from cases.base.phrases import phrase
from cases.base.units import Array
from identification.estimation.fit import Robust
from identification.estimation.force_noise import (
    LEAST_SAMPLES,
    Turned,
    autoregressive,
    memories,
    products,
    rings,
)
from identification.finding import Finding, Kind, note

SLOW = 1.0 / 3.0  # of the evaluated samples' Nyquist frequency: half the cut-off, where the filter changes nothing
PASSED = 2.0 / 3.0  # of it: the cut-off
BEGIN = 1e-2  # shares of noises beside the white one to begin with, of a channel's variance
# Of an independent number, that is taken to have shown each noise in each channel: no share is zero because a few
# residuals do not show it, and the search has a smooth maximum. Without it, noise of a sixth of the run makes
# deviations a sixth too small; with twice as much, those of white noise are an eighth too wide.
BEFOREHAND = 0.02
STEPS, SMALL, LONGEST = 60, 1e-3, 3.0  # of the search: how many, gain of the last, largest change of a logarithm
SIZES = 4  # rounds in which the sizes of channels that remember alike follow their shares
UNLIKE = 5.0  # of the logarithm of the likelihood beyond Akaike's price, from which on channels remember unlike
HARDLY_SHOWN = 3  # slow noises, with memories of the run's length, a half and a quarter of it
TOO_SHORT = 0.35  # share of the variance by these, from which deviations were 1.0 to 1.5 times too small in trials
INSIDE, MANY = 0.975, 1e9  # share below the upper end of an interval of 95 %; degrees of freedom that are no fewer
NOTHING = 1e-9  # share of the largest power, below which no power counts


class Parts(NamedTuple):
    """Noises whose sizes are known together, and what they make of the parameters."""

    shares: Array  # shape (c,)
    covariances: Array  # B^T Gamma B by a unit of each alone, shape (c, u, u)
    spread: Array  # covariance of the shares: residuals are few, shape (c, c)

    @property
    def meat(self) -> Array:
        """B^T Gamma B by all of them, shape (u, u)."""
        return np.asarray(np.tensordot(self.shares, self.covariances, 1))


class Mixture(NamedTuple):
    """Noise of a channel as a mixture of noises: white, with memories, of accelerations, and the autoregressive one."""

    parts: Parts
    free: Array  # share of its power that the fit leaves at each frequency that counts, shape (f,)
    autocovariance: Array  # of the whole noise, shape (n,)


class _Shown(NamedTuple):
    """What the residuals of a channel show of noises of some kinds."""

    kinds: Array  # their autocovariances, shape (c, n); the last is the autoregressive one
    power: Array  # of the residuals, shape (f,)
    left: Array  # that a unit of each kind leaves behind the fit, shape (c, f)
    whole: Array  # that a unit of each kind has, shape (c, f)
    covariances: Array  # as of `Parts`
    order: int  # of the autoregressive model


class _Likeliest(NamedTuple):
    """Shares of noises that make the power of one or more channels likeliest."""

    shares: Array  # shape (c,)
    sizes: Array  # by which they are multiplied in each channel, shape (k,)
    likelihood: float  # logarithm
    price: float  # Akaike's: number of shares and sizes that the power determines

    @property
    def criterion(self) -> float:
        return self.likelihood - self.price


def coloured_covariance(found: Turned) -> Robust | None:
    """Covariance of u for noise of any colour that stays the same over the run; None for short runs.

    A finding says where the run is too short for its noise to be known.
    """
    if len(found.noise) < LEAST_SAMPLES:
        return None
    noises = _noises(found)
    covariance = found.share * found.covariance(np.sum([own.meat for own in noises], axis=0))
    # of each group, variances of u by a unit of each of its noises, shape (c, u)
    each = [np.einsum("ui,cij,uj->cu", found.half, own.covariances, found.half, optimize=True) for own in noises]
    wider = _wider(noises, each)
    findings = () if found.share < 1.0 else _too_short(noises, each)
    return Robust(np.asarray(wider[:, None] * covariance * wider), findings, sources=source_covariance(found))


def source_covariance(found: Turned) -> Array | None:
    """Covariance of u for noise that is white before the filter, in forces and in accelerations, shape (u, u).

    Accelerations are places that were differentiated twice: white noise of encoders, as of their steps, then grows with
    the square of the frequency, and parameters, which answer to those of the motion, have little of it. None where
    residuals show no such noise, and of unfiltered samples.
    """
    if found.sources is None or len(found.noise) < LEAST_SAMPLES:
        return None
    kinds, meats, risen = np.array([found.lags(source) for source in found.sources]), [], False
    for channel in _shown(found, kinds, PASSED):
        white = _likeliest(channel.power, channel.left[:1])
        both = _likeliest(channel.power, channel.left)
        chosen = both if both.criterion > white.criterion else white
        risen = risen or chosen is both
        meats.append(np.tensordot(chosen.shares, channel.covariances[: len(chosen.shares)], 1))
    return found.share * found.covariance(np.sum(meats, axis=0)) if risen else None


def mixtures(found: Turned) -> list[Mixture]:
    """The noise of each channel by its own residuals."""
    answers = []
    for channel in _channels(found):
        likeliest = _chosen([channel])
        shares = likeliest.shares * likeliest.sizes[0]
        free = _free(shares, channel)
        parts = Parts(shares, channel.covariances, _spread(shares, channel.left, free))
        answers.append(Mixture(parts, free, shares @ channel.kinds))
    return answers


def _noises(found: Turned) -> list[Parts]:
    """The noise of all channels together, where they remember alike, else of each."""
    channels = _channels(found)
    each, alike = [_chosen([channel]) for channel in channels], _chosen(channels)
    if sum(own.criterion for own in each) - alike.criterion > UNLIKE:
        return [
            Parts(own.shares, of.covariances, _spread(own.shares, of.left, _free(own.shares, of)))
            for own, of in zip(each, channels, strict=True)
        ]
    free = np.concatenate([_free(alike.shares, of) for of in channels])
    left = np.concatenate([of.left for of in channels], axis=1)
    together = np.tensordot(alike.sizes, np.array([of.covariances for of in channels]), 1)
    return [Parts(alike.shares, together, _spread(alike.shares, left, free))]


def _too_short(noises: Sequence[Parts], each: Sequence[Array]) -> tuple[Finding, ...]:
    """What to say where much of the variance of u, shapes (c, u), is of noise that a run hardly shows.

    Its lowest frequencies are below those that a run has; how large they are, only their tail says.
    """
    parts = np.sum([own.shares[:, None] * of for own, of in zip(noises, each, strict=True)], axis=0)
    total = np.maximum(np.sum(parts, axis=0), np.finfo(float).tiny)
    share = float(np.mean(np.sum(parts[1 : 1 + HARDLY_SHOWN], axis=0) / total))
    if share < TOO_SHORT:
        return ()
    sentence = phrase(
        "slow_noise",
        "the run is short for what its noise remembers: {share} % of the variance is of noise that lasts for a quarter "
        "of the run or longer, of which the run shows little, so that +- may be up to 1.5 times too small; record "
        "several times as long, or find what drifts",
        share=f"{100.0 * share:.0f}",
    )
    return (note(Kind.NOISE, sentence, slow_noise=share),)


def _wider(noises: Sequence[Parts], each: Sequence[Array]) -> Array:
    """How much wider deviations are, shape (u,), for noise that is known from few numbers itself.

    The estimate over its deviation is spread like Student's t, with the degrees of freedom that the variance of the
    noise has (Satterthwaite 1946): 1.96 of these deviations hold 95 %.

    Args:
        noises: of each channel, or of all of them.
        each: variances of u by a unit of each of its noises, shapes (c, u).
    """
    variance = np.sum([own.shares @ of for own, of in zip(noises, each, strict=True)], axis=0)
    spread = np.sum([np.sum(of * (own.spread @ of), axis=0) for own, of in zip(noises, each, strict=True)], axis=0)
    freedom = 2.0 * variance**2 / np.maximum(spread, np.finfo(float).tiny)
    return np.asarray(stdtrit(np.clip(freedom, 1.0, MANY), INSIDE) / stdtrit(MANY, INSIDE))


def _channels(found: Turned) -> list[_Shown]:
    """What the residuals of each channel show of all noises that are tried."""
    kinds = memories(found.length)
    if found.sources is not None:
        kinds.append(found.lags(found.sources[1]))
    mask = found.series(np.ones(len(found.noise)))
    scale = float(mask.sum()) / found.freedom
    peaked = [autoregressive(noise, mask, scale) for noise in found.series(found.noise).T]
    return _shown(found, np.array(kinds), SLOW, peaked)


def _shown(
    found: Turned, kinds: Array, share: float, peaked: Sequence[tuple[Array, int]] | None = None
) -> list[_Shown]:
    """What the residuals of each channel show of noises, shape (c, n), below a share of the highest frequency."""
    answer, basis, white = (found.series(v) for v in (found.answer, found.taken, found.noise))
    mask = found.series(np.ones(len(found.noise)))
    pairs = np.maximum(np.round(products(mask)), 0.0)
    slow = max(1 + len(kinds), int(share * (found.length // 2)) + 1)
    answers = []
    for k in range(found.noise.shape[1]):
        own, order = (kinds, 0) if peaked is None else (np.vstack([kinds, peaked[k][0]]), peaked[k][1])
        seen = _seen(*_narrow(answer[:, k], basis[:, k]), mask, pairs, own, slow)
        answers.append(_Shown(own, np.abs(rfft(white[:, k])[:slow]) ** 2, *seen, order))
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
    ahead, takes = rfft(spanned.T, period), rfft(taken.T)[:, :slow]
    left, meats = [], []
    for ring, own in zip(spectra, raw, strict=True):
        response = irfft(ring * ahead, period)[:, :length]  # Gamma Q
        meat = response @ spanned
        crossed = rfft(response * here)[:, :slow]
        left.append(own + np.sum((meat @ takes - 2.0 * crossed) * takes.conj(), axis=0).real)
        meats.append(back.T @ meat @ back)
    return np.array(left), raw, np.array(meats)


def _free(shares: Array, channel: _Shown) -> Array:
    """Share of the power of a mixture that the fit leaves at each frequency, shape (f,)."""
    floor = NOTHING * float(channel.left.max())
    return np.asarray(np.clip((shares @ channel.left) / np.maximum(shares @ channel.whole, floor), 0.0, 1.0))


def _spread(shares: Array, expected: Array, free: Array) -> Array:
    """Covariance of shares, shape (c, c), by Fisher's information.

    None is known worse than by one independent number: of noises that leave no trace, as those slower than the run,
    there may be as much as is estimated, or none, but not any amount.

    Args:
        shares: shape (c,).
        expected: power that each noise leaves in the residuals, shape (c, f).
        free: as in `Mixture`: where the fit takes all, a frequency says nothing, shape (f,).
    """
    left = np.maximum(shares @ expected, NOTHING * float(expected.max()))
    part = shares[:, None] * np.maximum(expected, 0.0) / left
    relative = np.linalg.inv((part * free) @ part.T + 0.5 * np.eye(len(shares)))
    return np.asarray(shares[:, None] * relative * shares)


def _chosen(channels: Sequence[_Shown]) -> _Likeliest:
    """Shares that are the same in some channels, with the autoregressive noises where Akaike's criterion asks for them.

    Its price is the number of their coefficients. Shares are of all kinds, shape (c,).
    """
    plain, peaked = _in_common(channels, -1), _in_common(channels, None)
    orders = float(sum(channel.order for channel in channels))
    if peaked.criterion - orders > plain.criterion:
        return peaked._replace(price=peaked.price + orders)
    return plain._replace(shares=np.r_[plain.shares, 0.0])


def _in_common(channels: Sequence[_Shown], last: int | None) -> _Likeliest:
    """Shares of the kinds up to one that are the same in some channels, whose noise has sizes of their own."""
    power, expected = [of.power for of in channels], [of.left[:last] for of in channels]
    counts = [len(of) for of in power]
    sizes, begin = np.ones(len(channels)), None
    for rest in reversed(range(SIZES if len(channels) > 1 else 1)):
        scale = np.repeat(sizes, counts)
        found = _likeliest(np.concatenate(power) / scale, np.concatenate(expected, axis=1), begin, len(channels))
        begin = found.shares
        if rest:
            sizes = np.array(
                [np.mean(p / np.maximum(begin @ e, NOTHING * e.max())) for p, e in zip(power, expected, strict=True)]
            )
    likelihood = found.likelihood - float(np.sum(np.log(scale)))
    return _Likeliest(found.shares, sizes, likelihood, found.price + len(channels) - 1.0)


def _likeliest(power: Array, expected: Array, begin: Array | None = None, channels: int = 1) -> _Likeliest:
    """Shares of noises, of which each is expected to make some power, shape (c, f), that make the power likeliest.

    By Fisher's scoring of their logarithms, from shares to begin with.
    """
    floor = NOTHING * float(expected.max())
    expected, power = np.maximum(expected, floor), np.maximum(power, floor)
    count, beforehand = len(expected), BEFOREHAND * channels
    logs = np.log(np.r_[1.0, np.full(count - 1, BEGIN)] if begin is None else begin)

    def cost(at: Array) -> float:
        total = np.exp(at) @ expected
        return float(np.sum(np.log(total) + power / total)) - beforehand * float(at.sum())

    now, damping = cost(logs), 1e-3
    for _ in range(STEPS):
        total = np.exp(logs) @ expected
        part = np.exp(logs)[:, None] * expected / total
        slope, bend = part @ (1.0 - power / total) - beforehand, part @ part.T + beforehand * np.eye(count)
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
    information = part @ part.T
    price = float(np.trace(np.linalg.solve(information + beforehand * np.eye(count), information)))
    return _Likeliest(shares, np.ones(1), -float(np.sum(np.log(total) + power / total)), price)
