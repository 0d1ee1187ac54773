"""Noise of the forces as residuals show it, and what it does to an estimate where it has memory.

Where noise has memory, the covariance is the sandwich with an autocovariance from the residuals. Kernel estimates of it
(`long_run_covariance`) need long runs: at the frequencies of the motion, where it matters, a short run leaves them too
few residuals. Here noise is described channel by channel, the channels turned to be independent at lag zero, as a
mixture of white noise and first-order noises with memories of up to the run's length. How much there is of each, their
spectra say below half the cut-off, by Whittle's likelihood (1953): the residuals' against those that the mixture would
leave behind the same fit, exactly, so that what the fit took away is put back. An autoregressive model (Burg's) is part
of it only where there are peaks that the others cannot have: it follows the residuals, and with them the dips that the
fit made. Noise slower than the run looks like a parameter, and no method can show it.

Shares cannot be negative, so that of 300 samples of white noise deviations are 15 to 20 % too wide in half of the fits;
without slow noises, 95 % intervals hold the truth in 88 to 92 % of the cases where noise remembers a sixth of the run.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.special import stdtrit

from cases.base.units import Array, Indices
from identification.estimation.fit import Robust, orthonormal
from identification.finding import Finding, Kind, note

Spectra = NDArray[np.complex128]


class Turned(NamedTuple):
    """Residuals of a weighted fit with six turned channels."""

    half: Array  # F^-1 = half half^T, shape (u, u)
    # B, the parameters half^-1 u answer to noise x with the sum of B_k^T x_k over channels, shape (n, 6, u)
    answer: Array
    taken: Array  # C, the fit takes C_k times that away from channel k, shape (n, 6, u)
    noise: Array  # residuals, of variance 1 but for degrees of freedom, shape (n, 6)
    freedom: float  # degrees of freedom of a channel
    places: Indices  # places of the samples in a series of equal steps, from 0 upwards, shape (n,)
    share: float = 1.0  # share of the run's samples that these are; noise in all of them is known that much better

    @property
    def length(self) -> int:
        """Steps of a series that holds the samples, a few more where spectra of so many are found sooner."""
        return int(next_fast_len(int(self.places[-1]) + 1, real=True))

    def series(self, values: Array) -> Array:
        """Samples, shape (n, ..), at their places in the series, zero between."""
        spread = np.zeros((self.length, *values.shape[1:]))
        spread[self.places] = values
        return spread

    def covariance(self, meat: Array) -> Array:
        """Covariance of u from that of half^-1 u, shape (u, u)."""
        return np.asarray(self.half @ ((meat + meat.T) / 2.0) @ self.half.T)


def turned(regressors: Array, residuals: Array, weights: Array, places: Indices | None = None) -> Turned:
    """The residuals of a fit in turned channels.

    Args:
        regressors: A_j, shape (n, 6, u), of full rank.
        residuals: f - A u of the weighted fit, shape (n, 6).
        weights: diagonal of W for one sample, shape (6,).
        places: places of the samples in a series of equal steps, ascending, shape (n,); by default one after the other.
    """
    basis, half = orthonormal(regressors, weights)  # F = 1 in these coordinates
    return in_turned_channels(basis, half, residuals * np.sqrt(weights), places)


def in_turned_channels(basis: Array, half: Array, noise: Array, places: Indices | None) -> Turned:
    """The same from an orthonormal basis of the weighted regressors, shape (n, 6, u), and weighted residuals."""
    samples, sensors, unknowns = basis.shape
    freedom = samples - unknowns / sensors
    channels = noise.T @ noise / freedom
    jitter = 1e-12 * float(np.trace(channels)) + np.finfo(float).tiny
    mixing = np.linalg.cholesky(channels + jitter * np.eye(sensors))
    unmixing = np.linalg.inv(mixing)
    return Turned(
        half,
        np.einsum("ab,nau->nbu", mixing, basis),
        np.einsum("ab,nbu->nau", unmixing, basis),
        noise @ unmixing.T,
        freedom,
        np.arange(samples) if places is None else places - places[0],
    )


SLOW = 1.0 / 3.0  # of the evaluated samples' Nyquist frequency: half the cut-off, where the filter changes nothing
ROUNDS = 80  # of the search for the shares; what they still change by then is a few percent of a deviation
BEGIN = 1e-3  # shares of slow noises to begin with, of a channel's variance
HARDLY_SHOWN = 3  # slow noises, with memories of the run's length, a half and a quarter of it
TOO_SHORT = 0.4  # share of the variance by these, from which deviations were 1.2 to 1.45 times too small in trials
INSIDE, MANY = 0.975, 1e9  # share below the upper end of an interval of 95 %; degrees of freedom that are no fewer
NOTHING = 1e-9  # share of the largest power, below which no power counts


class Mixture(NamedTuple):
    """Noise of a channel as a mixture of noises: the autoregressive one, and slow ones."""

    shares: Array  # shape (c,)
    covariances: Array  # B^T Gamma B by each alone, shape (c, u, u)
    spread: Array  # covariance of the shares: residuals are few, shape (c, c)
    free: Array  # share of its power that the fit leaves at each frequency that counts, shape (f,)
    autocovariance: Array  # of the whole noise, shape (n,)


def coloured_covariance(found: Turned) -> Robust | None:
    """Covariance of u for noise of any colour that stays the same over the run; None for short runs.

    A finding says where the run is too short for its noise to be known.
    """
    if len(found.noise) < LEAST_SAMPLES:
        return None
    noises = mixtures(found)
    meat = np.sum([np.einsum("c,cij->ij", own.shares, own.covariances) for own in noises], axis=0)
    covariance = found.share * found.covariance(np.asarray(meat))
    # of each channel, variances of u by a unit of each of its noises, shape (c, u)
    each = [np.einsum("ui,cij,uj->cu", found.half, own.covariances, found.half, optimize=True) for own in noises]
    wider = _wider(noises, each)
    findings = () if found.share < 1.0 else _too_short(noises, each)
    return Robust(np.asarray(wider[:, None] * covariance * wider), findings)


def _too_short(noises: Sequence[Mixture], each: Sequence[Array]) -> tuple[Finding, ...]:
    """What to say where much of the variance of u, shapes (c, u), is of noise that a run hardly shows.

    Its lowest frequencies are below those that a run has; how large they are, only their tail says.
    """
    parts = np.sum([own.shares[:, None] * of for own, of in zip(noises, each, strict=True)], axis=0)
    total = np.maximum(np.sum(parts, axis=0), np.finfo(float).tiny)
    share = float(np.mean(np.sum(parts[1 : 1 + HARDLY_SHOWN], axis=0) / total))
    if share < TOO_SHORT:
        return ()
    sentence = (
        f"the run is short for what its noise remembers: {100.0 * share:.0f} % of the variance is of noise that lasts "
        "for a quarter of the run or longer, of which the run shows little, so that +- may be up to 1.5 times too "
        "small; record several times as long, or find what drifts"
    )
    return (note(Kind.NOISE, sentence, slow_noise=share),)


def _wider(noises: Sequence[Mixture], each: Sequence[Array]) -> Array:
    """How much wider deviations are, shape (u,), for noise that is known from few numbers itself.

    The estimate over its deviation is spread like Student's t, with the degrees of freedom that the variance of the
    noise has (Satterthwaite 1946): 1.96 of these deviations hold 95 %.

    Args:
        noises: of each channel.
        each: variances of u by a unit of each of its noises, shapes (c, u).
    """
    variance = np.sum([own.shares @ of for own, of in zip(noises, each, strict=True)], axis=0)
    spread = np.sum([np.sum(of * (own.spread @ of), axis=0) for own, of in zip(noises, each, strict=True)], axis=0)
    freedom = 2.0 * variance**2 / np.maximum(spread, np.finfo(float).tiny)
    return np.asarray(stdtrit(np.clip(freedom, 1.0, MANY), INSIDE) / stdtrit(MANY, INSIDE))


def mixtures(found: Turned) -> list[Mixture]:
    """The noise of each channel by its residuals."""
    answer, basis, white = (found.series(v) for v in (found.answer, found.taken, found.noise))
    mask = found.series(np.ones(len(found.noise)))
    pairs = np.maximum(np.round(products(mask)), 0.0)
    channels = range(found.noise.shape[1])
    return [_mixture(answer[:, k], basis[:, k], white[:, k], mask, pairs, found.freedom) for k in channels]


def _mixture(answer: Array, basis: Array, noise: Array, mask: Array, pairs: Array, freedom: float) -> Mixture:
    """The noise of a channel; B and C as in `Turned`, pairs of samples that are so far apart, shape (n,)."""
    length = len(noise)
    plain = memories(length)
    slow = max(1 + len(plain), int(SLOW * (length // 2)) + 1)
    power = np.abs(rfft(noise)[:slow]) ** 2
    peaked, order = autoregressive(noise, mask, float(mask.sum()) / freedom)
    kinds = np.array([*plain, peaked])
    left, whole, covariances = _seen(*_narrow(answer, basis), mask, pairs, kinds, slow)
    # Noises that the criterion asks for (Akaike 1974): those of short memories, and peaks, which none of these have.
    shares, likelihood = np.zeros(len(left)), -np.inf
    for count, cost in ((1 + MEMORIES, 0), (len(plain), len(plain) - 1 - MEMORIES), (len(left), order + 1)):
        best, more = _shares(power, left[:count])
        if more - likelihood > cost:
            shares, likelihood = np.r_[best, np.zeros(len(left) - count)], more
    floor = NOTHING * float(left.max())
    free = np.clip((shares @ left) / np.maximum(shares @ whole, floor), 0.0, 1.0)
    return Mixture(shares, covariances, _spread(shares, left, free), free, shares @ kinds)


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
    rings = _rings(kinds, period)
    ahead, takes = rfft(spanned.T, period), rfft(taken.T)[:, :slow]
    left, meats = [], []
    for ring, own in zip(rings, raw, strict=True):
        response = irfft(ring * ahead, period)[:, :length]  # Gamma Q
        meat = response @ spanned
        crossed = rfft(response * here)[:, :slow]
        left.append(own + np.sum((meat @ takes - 2.0 * crossed) * takes.conj(), axis=0).real)
        meats.append(back.T @ meat @ back)
    return np.array(left), raw, np.array(meats)


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


def _shares(power: Array, expected: Array) -> tuple[Array, float]:
    """Shares of noises, of which each is expected to make some power, shape (c, f), that make the power likeliest.

    Returns:
        The shares, shape (c,), and the logarithm of the likelihood.
    """
    # By multiplicative steps that never lose likelihood (Fevotte and Idier 2011, Neural Comput. 23:2421, beta = 0).
    floor = NOTHING * float(expected.max())
    expected, power = np.maximum(expected, floor), np.maximum(power, floor)
    shares = np.r_[1.0, np.full(len(expected) - 1, BEGIN)]
    for _ in range(ROUNDS):
        total = np.maximum(shares @ expected, floor)
        shares = shares * np.sqrt((expected @ (power / total**2)) / (expected @ (1.0 / total)))
    total = np.maximum(shares @ expected, floor)
    return np.asarray(shares), -float(np.sum(np.log(total) + power / total))


MOST_ORDER = 30  # of the autoregressive model; behind the filter samples are a quarter of its shortest period apart
MOST_ALIKE = 1.0 - 1e-6  # of reflection coefficients, so that no pole lies on the unit circle
LEAST_SAMPLES = 20  # fewer show no spectrum; here intervals hold already, those of a kernel in four of five cases
PER_ORDER = 16  # samples for each coefficient, at least: more follow what the fit took, dips of the spectrum
MEMORIES = 6  # of slow noises: the run's length, a half, .. of it; those below are short
SHORTEST = 2.0  # samples that a noise remembers, next to which it is white


def slow_noises(length: int) -> list[Array]:
    """Autocovariances of first-order noises with memories of a run of n steps, a half, .. of it, each of shape (n,)."""
    lags = np.arange(length)
    return [np.exp(-lags * 2.0**k / length) for k in range(MEMORIES)]


def memories(length: int) -> list[Array]:
    """Autocovariances of white noise, and of first-order noises of all memories up to a run of n steps, shape (n,)."""
    lags, count = np.arange(length), max(MEMORIES, int(np.log2(max(length / SHORTEST, 1.0))) + 1)
    return [(lags == 0) * 1.0, *(np.exp(-lags * 2.0**k / length) for k in range(count))]


def autoregressive(noise: Array, here: Array, scale: float) -> tuple[Array, int]:
    """Autocovariance of the autoregressive model whose order Akaike's criterion chooses, shape (n,), and the order.

    By Burg's recursion over stretches without gaps (de Waele and Broersen 2000, IEEE Trans. Signal Process. 48:2876),
    which is always stable.

    Args:
        noise: shape (n,), zero where there is no sample.
        here: 1 where there is a sample, shape (n,).
        scale: samples over degrees of freedom.
    """
    count, length = int(here.sum()), len(noise)
    phi, variance = np.zeros(0), max(float(noise @ noise) / count, np.finfo(float).tiny)
    best = (count * (np.log(variance) + 2.0 / (count - 2)), phi, variance)
    forward, backward, whole = noise, noise, here > 0.0
    for order in range(1, min(MOST_ORDER, count // PER_ORDER) + 1):
        whole = whole[1:] & (here[:-order] > 0.0)
        later, earlier = forward[1:], backward[:-1]
        power = float(np.sum((later**2 + earlier**2)[whole]))
        if np.count_nonzero(whole) < LEAST_SAMPLES // 2 or power <= 0.0:
            break
        reflection = float(np.clip(2.0 * (later @ (earlier * whole)) / power, -MOST_ALIKE, MOST_ALIKE))
        forward, backward = later - reflection * earlier, earlier - reflection * later
        phi = np.r_[phi - reflection * phi[::-1], reflection]
        variance *= 1.0 - reflection**2
        criterion = count * (np.log(variance) + 2.0 * (order + 1) / (count - order - 2))
        if criterion < best[0]:
            best = (criterion, phi, variance)
    period = next_fast_len(8 * length, real=True)  # so long that what wraps around is little
    spectrum = scale * best[2] / np.abs(rfft(np.r_[1.0, -best[1]], period)) ** 2
    return np.asarray(irfft(spectrum, period)[:length]), len(best[1])


def products(series: Array) -> Array:
    """Sums of products of samples that are 0, 1, .. steps apart, shape (n,)."""
    length = next_fast_len(2 * len(series), real=True)
    return np.asarray(irfft(np.abs(rfft(series, length)) ** 2, length)[: len(series)])


def toeplitz(autocovariance: Array, columns: Array) -> Array:
    """Gamma B, Gamma the Toeplitz matrix of an autocovariance of n lags, shape (n, u)."""
    count = len(autocovariance)
    period = next_fast_len(2 * count, real=True)
    ring = _rings(autocovariance[None], period)[0]
    return np.asarray(irfft(ring * rfft(columns.T, period), period)[:, :count].T)


def _rings(autocovariances: Array, period: int) -> Spectra:
    """Spectra of noises, shape (c, f), by which products with their Toeplitz matrices are products of spectra."""
    count = autocovariances.shape[1]
    rings = np.zeros((len(autocovariances), period))
    rings[:, :count] = autocovariances
    rings[:, period - count + 1 :] = autocovariances[:, :0:-1]
    return np.asarray(rfft(rings))


def scores(regressors: Array, residuals: Array, weights: Array) -> Array:
    """A_j^T W r_j of each sample, shape (n, u); the covariance of an estimate follows from their spread."""
    return np.asarray(np.einsum("nku,nk->nu", regressors, weights * residuals))


def long_run_covariance(scores: Array) -> Array:
    """Sum over all lags of the autocovariance of a series times its length, by Bartlett's kernel (Newey and West 1987).

    The bandwidth follows Andrews (1991) from the lag-one autocorrelation of each column of the series, shape (n, u).
    """
    count = len(scores)
    variance = np.maximum(np.sum(scores[1:] ** 2, axis=0), np.finfo(float).tiny)
    rho = np.clip(np.sum(scores[1:] * scores[:-1], axis=0) / variance, -0.97, 0.97)
    alpha = float(np.mean(4 * rho**2 / ((1 - rho) ** 2 * (1 + rho) ** 2)))
    width = int(np.clip(np.ceil(1.1447 * (alpha * count) ** (1 / 3)), 1, max(1, count // 4)))
    # A Bartlett-weighted sum of lagged products is the mean product of moving sums over the bandwidth.
    padded = np.vstack([np.zeros((1, scores.shape[1])), np.cumsum(np.pad(scores, ((0, width - 1), (0, 0))), axis=0)])
    upper = np.arange(1, count + width)
    moving = padded[upper] - padded[np.maximum(upper - width, 0)]
    return np.asarray(moving.T @ moving / width)
