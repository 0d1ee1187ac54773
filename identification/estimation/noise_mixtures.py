"""Noise with memory as a mixture of noises, by the spectra of residuals, and the covariance of an estimate under it.

Where noise has memory, the covariance is the sandwich with an autocovariance from the residuals. Kernels need long
runs: at the frequencies of the motion, where it matters, a short run leaves them too few residuals. Here noise is
described in turned channels, independent at lag zero, as white noise and first-order noise of one memory, the mean over
all memories and sizes of it that spectra allow (`one_memory`), with noise of accelerations, which rises with the
frequency, where they show that. Where they show clearly more, it is a mixture of noises with memories of up to the
run's length in the likeliest shares. Six channels of one machine as a rule remember alike, and then tell of it
together; where their spectra speak against it, each is judged by itself. An autoregressive model (Burg's) is part of it
only where there are peaks that the others cannot have: it follows the residuals, and with them the dips that the fit
made. Noise slower than the run looks like a parameter, and no method can show it.

In 40 runs of 4 to 6 s of each of four machines errors over reported deviations are (rms over parameters) 0.91 to 1.02
in white noise, 0.99 to 1.14 where it remembers 50 ms, 0.97 to 1.04 where it remembers 0.3 s, and 1.02 to 1.17 where it
remembers 1 s.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from cases.base.phrases import phrase
from cases.base.units import Array
from identification.estimation.fit import Robust
from identification.estimation.force_noise import LEAST_SAMPLES, Turned, autoregressive, memories
from identification.estimation.noise_spectra import (
    MANY,
    NOTHING,
    PASSED,
    SLOW,
    ChannelSpectra,
    Likeliest,
    channel_spectra,
    free_of,
    likeliest,
    lowest,
)
from identification.estimation.one_memory import HARDLY_SHOWN, channels_of, mean_of
from identification.finding import Finding, Kind, note

SIZES = 4  # rounds in which the sizes of channels that remember alike follow their shares
UNLIKE = 5.0  # of the logarithm of the likelihood beyond Akaike's price, from which on channels remember unlike
RICHER = 2.0  # the same, from which on noise is a mixture of many memories
SLOWEST = 3  # of a mixture's memories: the run's length, a half and a quarter of it
TOO_SHORT = 0.4  # share of the variance by such memories, from which deviations were too small in trials
INSIDE = 0.975  # share below the upper end of an interval of 95 %


class Parts(NamedTuple):
    """Noises whose sizes are known together, and what they make of the parameters."""

    shares: Array  # shape (c,)
    covariances: Array  # B^T Gamma B by a unit of each alone, shape (c, u, u)
    spread: Array  # covariance of the shares: residuals are few, shape (c, c)
    slowest: int = SLOWEST  # noises after the first that remember a quarter of the run or longer

    @property
    def meat(self) -> Array:
        """B^T Gamma B by all of them, shape (u, u)."""
        return np.asarray(np.tensordot(self.shares, self.covariances, 1))


class Mixture(NamedTuple):
    """Noise of a channel as a mixture of noises: white, with memories, of accelerations, and the autoregressive one."""

    parts: Parts
    free: Array  # share of its power that the fit leaves at each frequency that counts, shape (f,)
    autocovariance: Array  # of the whole noise, shape (n,)


def coloured_covariance(found: Turned) -> Robust | None:
    """Covariance of u for noise of any colour that stays the same over the run; None for short runs.

    A finding says where the run is too short for its noise to be known.
    """
    if len(found.noise) < LEAST_SAMPLES:
        return None
    noises = _noises(found)
    covariance = found.share * found.covariance(np.sum([parts.meat for parts in noises], axis=0))
    # of each group, variances of u by a unit of each of its noises, shape (c, u)
    each = [np.einsum("ui,cij,uj->cu", found.half, parts.covariances, found.half, optimize=True) for parts in noises]
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
    for channel in channel_spectra(found, kinds, lowest(found, PASSED, len(kinds))):
        white = likeliest(channel.power, channel.residual[:1])
        both = likeliest(channel.power, channel.residual)
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
        free = free_of(shares, channel)
        parts = Parts(shares, channel.covariances, _spread(shares, channel.residual, free))
        answers.append(Mixture(parts, free, shares @ channel.kinds))
    return answers


def _noises(found: Turned) -> list[Parts]:
    """The noise of all channels together, where they remember alike, else of each."""
    channels = _channels(found)
    single = channels_of(found, len(channels[0].power))
    each, alike = [_chosen([channel]) for channel in channels], _chosen(channels)
    rising = found.sources is not None
    if sum(likeliest.criterion for likeliest in each) - alike.criterion > UNLIKE:
        alone = zip(channels, single, each, strict=True)
        return [_described([many], [one], likely, rising) for many, one, likely in alone]
    return [_described(channels, single, alike, rising)]


def _described(
    channels: Sequence[ChannelSpectra], single: Sequence[ChannelSpectra], many: Likeliest, rising: bool
) -> Parts:
    """Noise of one memory, which few numbers show best; the mixture where that explains clearly more.

    Args:
        channels: what residuals show of the noises of the mixture.
        single: what they show of noises of one memory, and of those beside it.
        many: the mixture.
        rising: whether noise of accelerations is among both.
    """
    free = np.concatenate([free_of(many.shares, of) for of in channels])
    spectra = np.concatenate([of.residual for of in channels], axis=1)
    one = mean_of(single, many.sizes, free, rising)
    power = np.concatenate([of.power / size for of, size in zip(channels, many.sizes, strict=True)])
    total = np.maximum(many.shares @ spectra, NOTHING * float(spectra.max()))
    likelihood = -float(np.sum(free * (np.log(total) + power / total)))
    if likelihood - (many.price - len(channels) + 1.0) - one.criterion > RICHER:
        return Parts(many.shares, _together(many.sizes, channels), _spread(many.shares, spectra, free))
    certain = np.zeros((len(one.shares), len(one.shares)))  # what is not known of the shares is part of their mean
    return Parts(one.shares, _together(many.sizes, single), certain, HARDLY_SHOWN)


def _together(sizes: Array, channels: Sequence[ChannelSpectra]) -> Array:
    """B^T Gamma B by a unit of each noise in channels of these sizes, shape (c, u, u)."""
    return np.asarray(np.tensordot(sizes, np.array([of.covariances for of in channels]), 1))


def _too_short(noises: Sequence[Parts], each: Sequence[Array]) -> tuple[Finding, ...]:
    """What to say where much of the variance of u, shapes (c, u), is of noise that a run hardly shows.

    Its lowest frequencies are below those that a run has; how large they are, only their tail says.
    """
    parts = [noise.shares[:, None] * of for noise, of in zip(noises, each, strict=True)]
    total = np.maximum(np.sum([np.sum(of, axis=0) for of in parts], axis=0), np.finfo(float).tiny)
    slowest = [np.sum(of[1 : 1 + noise.slowest], axis=0) for noise, of in zip(noises, parts, strict=True)]
    share = float(np.mean(np.sum(slowest, axis=0) / total))
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
    variance = np.sum([parts.shares @ of for parts, of in zip(noises, each, strict=True)], axis=0)
    spread = np.sum([np.sum(of * (parts.spread @ of), axis=0) for parts, of in zip(noises, each, strict=True)], axis=0)
    freedom = 2.0 * variance**2 / np.maximum(spread, np.maximum(2.0 * variance**2 / MANY, np.finfo(float).tiny))
    return np.asarray(stdtrit(np.clip(freedom, 1.0, MANY), INSIDE) / stdtrit(MANY, INSIDE))


def _channels(found: Turned) -> list[ChannelSpectra]:
    """What the residuals of each channel show of all noises that are tried."""
    kinds = memories(found.length)
    if found.sources is not None:
        kinds.append(found.lags(found.sources[1]))
    mask = found.series(np.ones(len(found.noise)))
    scale = float(mask.sum()) / found.freedom
    resonances = [autoregressive(noise, mask, scale) for noise in found.series(found.noise).T]
    return channel_spectra(found, np.array(kinds), lowest(found, SLOW, len(kinds)), resonances)


def _spread(shares: Array, expected: Array, free: Array) -> Array:
    """Covariance of shares, shape (c, c), by Fisher's information.

    None is known worse than by one independent number: of noises that leave no trace, as those slower than the run,
    there may be as much as is estimated, or none, but not any amount.

    Args:
        shares: shape (c,).
        expected: power that each noise leaves in the residuals, shape (c, f).
        free: as in `Mixture`: where the fit takes all, a frequency says nothing, shape (f,).
    """
    total = np.maximum(shares @ expected, NOTHING * float(expected.max()))
    part = shares[:, None] * np.maximum(expected, 0.0) / total
    relative = np.linalg.inv((part * free) @ part.T + 0.5 * np.eye(len(shares)))
    return np.asarray(shares[:, None] * relative * shares)


def _chosen(channels: Sequence[ChannelSpectra]) -> Likeliest:
    """Shares that are the same in some channels, with the autoregressive noises where Akaike's criterion asks for them.

    Its price is the number of their coefficients. Shares are of all kinds, shape (c,).
    """
    plain, resonant = _in_common(channels, -1), _in_common(channels, None)
    orders = float(sum(channel.order for channel in channels))
    if resonant.criterion - orders > plain.criterion:
        return resonant._replace(price=resonant.price + orders)
    return plain._replace(shares=np.r_[plain.shares, 0.0])


def _in_common(channels: Sequence[ChannelSpectra], last: int | None) -> Likeliest:
    """Shares of the kinds up to one that are the same in some channels, whose noise has sizes of their own."""
    power, expected = [of.power for of in channels], [of.residual[:last] for of in channels]
    counts = [len(of) for of in power]
    sizes, begin = np.ones(len(channels)), None
    for rest in reversed(range(SIZES if len(channels) > 1 else 1)):
        scale = np.repeat(sizes, counts)
        mixture = likeliest(np.concatenate(power) / scale, np.concatenate(expected, axis=1), begin, len(channels))
        begin = mixture.shares
        if rest:
            sizes = np.array(
                [np.mean(p / np.maximum(begin @ e, NOTHING * e.max())) for p, e in zip(power, expected, strict=True)]
            )
    likelihood = mixture.likelihood - float(np.sum(np.log(scale)))
    return Likeliest(mixture.shares, sizes, likelihood, mixture.price + len(channels) - 1.0)
