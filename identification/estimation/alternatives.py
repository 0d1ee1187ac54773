"""What residuals follow: a test of each thing that a model leaves out, and the bias that it may have made.

An alternative is a set of columns D beside those of the regression, the effect on the forces of something that the
model does not know (a gain of a channel, an offset of a strut, a spring, time). What the fit cannot take over of it,
D_ = D - A A^+ D, is compared with the residuals r: the scores c = U^T r, U an orthonormal basis of D_, are zero but for
noise where the model is right (Rao's test). Their covariance is that of noise as what r leaves beside this alternative
shows it (`noise_mixtures.mixtures`): a large effect so never hides in the noise by which it is judged, and noise with
memory is not taken for one. What is left shows the noise itself by few independent numbers, the fewer the slower it is
and the more the alternative takes: by that much more must be seen (`score_test`).

Of an effect that is seen, the size of D in the directions that the fit took is as large as in those that are left: with
effects of D's columns of variance tau^2 by the scores, the estimate is biased with the covariance tau^2 B B^T, where
B = A^+ D. Of a single column this is the bias that its estimated effect makes.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.fft import next_fast_len, rfft

from cases.base.phrases import Phrase
from cases.base.units import Array, Indices
from identification.estimation.fit import orthonormal
from identification.estimation.force_noise import LEAST_SAMPLES, in_turned_channels, toeplitz
from identification.estimation.noise_mixtures import mixtures
from identification.estimation.score_test import Noise, chance_of

UNSEEN = 1e-8  # of a column's square, below which what the fit leaves of it is rounding
WIDTH = 15  # half width of the windows of frequencies over which power is averaged for the quietest of them
ALIKE = 0.9  # of what the best column explains, from which on another explains as much
NEXT = 5  # frequencies to either side of one, at which noise is about as large
SURPRISE = 2.0  # standard deviations of scores, below which an alternative is not looked at
NEAR = 7.0  # of the logarithm of the odds, within which alternatives explain the residuals alike: one to a thousand
MOST_TRIED = 12  # alternatives of which the noise is judged
LESS = 1.0  # share of the variance of one score that it may be thought to have too much; of k scores one k-th
LEAST_FREEDOM = 20.0  # residuals that an alternative leaves, at least


class Alternative(NamedTuple):
    """Something that a model leaves out, by the effect that it has on the forces."""

    key: str  # for programs
    follow: Phrase  # words for what the residuals then follow
    cause: Phrase  # words for what makes it, with an open place `size` where it has one
    columns: Array  # effect on the forces of a unit of each of its sizes, shape (n, 6, k)
    unit: float = 1.0  # of the size in SI, in which people read it
    # of each column, what it follows and in which channel, counted from 0; none where there is nothing to choose from
    each: tuple[tuple[Phrase, int], ...] = ()
    chosen: int = 1  # number of columns that this is the best one of, by what they explain

    def caused(self, size: str) -> Phrase:
        """Words for what makes it, with its size where it has one."""
        return self.cause.filled(size=size) if "size" in self.cause.values else self.cause


class Effect(NamedTuple):
    """What residuals show of an alternative."""

    alternative: Alternative
    statistic: float  # squared scores over their variance; about k where there is nothing but noise
    tested: int  # number of scores, k or fewer
    chance: float  # probability of so much by noise alone
    evidence: float  # logarithm of the odds by which it explains the residuals better than noise alone
    sizes: Array  # estimated size of each column, shape (k,); the smallest where columns depend on each other
    stds: Array  # their standard deviations
    best: int  # column that explains most by itself
    explained: Array  # what it explains of the residuals, weighted, shape (n, 6)
    share: float  # share of the residuals' weighted squares that it explains
    bias: Array  # covariance of the parameters by effects of that size, shape (v, v)
    supported: Array  # combinations of columns whose effect is larger than noise by itself, shape (k, s)


class Sizes(NamedTuple):
    """Sizes of effects that residuals show."""

    values: Array  # shape (k,)
    noise: Noise  # of these
    answer: Array  # bias of what was fitted by a unit of each, shape (v, k)
    explained: float  # squares of the weighted residuals that they explain


class Remainder(NamedTuple):
    """Residuals of a fit, by which alternatives are judged.

    What a fit takes of an alternative follows from regressors without the noise of the drives: that noise is in the
    residuals, and what smooth columns differ by from noisy regressors would be it.
    """

    basis: Array  # Q, orthonormal basis of the weighted regressors, shape (n, 6, v)
    smooth: Array  # the same of regressors without noise of the drives
    half: Array  # F^-1 = half half^T, from these, shape (v, v)
    residuals: Array  # weighted, shape (n, 6)
    root: Array  # root of W for one sample, shape (6, 6)
    places: Indices  # places of the samples in a series of equal steps, from 0 upwards, shape (n,)
    coloured: bool  # whether noise may have memory; else samples are independent
    floor: float  # of the spectral density of the residuals where they are least, as variance of a white noise
    independent: float  # number of residuals that are independent where noise is white before the filter

    @classmethod
    def of(
        cls,
        regressors: Array,
        smooth: Array,
        residuals: Array,
        w: Array,
        places: Indices,
        *,
        coloured: bool,
        freedom: float,
    ) -> "Remainder":
        """What a fit leaves.

        Args:
            regressors: A with the columns of the nuisances, of full rank, shape (n, 6, v).
            smooth: the same without noise of the drives.
            residuals: f - A u, shape (n, 6).
            w: W for one sample, shape (6, 6).
            places: as above, from any number upwards.
            coloured: as above.
            freedom: as `independent`.
        """
        root = np.asarray(np.linalg.cholesky(w).T, dtype=np.float64)
        basis, _ = orthonormal(root @ regressors, np.ones(6))
        clean, half = orthonormal(root @ smooth, np.ones(6))
        rest = without(basis, residuals @ root.T)
        places = places - places[0]
        floor = _floor(rest, places) if coloured else 0.0
        return cls(basis, clean, half, rest, root, places, coloured, floor, freedom)

    def beside(self, columns: Array) -> "Remainder":
        """What is left where effects of columns, shape (n, 6, k), are estimated too.

        Of an effect with many columns these should be what it supports (`Effect.supported`): parameters answer to
        directions that a run hardly shows as if they were of any size.
        """
        residuals, inside = self.without_fit(self.root @ columns)
        norms = np.sqrt(np.maximum(np.sum(residuals**2, axis=(0, 1)), np.finfo(float).tiny))
        values, vectors = np.linalg.eigh(np.tensordot(residuals / norms, residuals / norms, ((0, 1), (0, 1))))
        significant = values > UNSEEN
        whitening = vectors[:, significant] / np.sqrt(values[significant])
        new = (residuals / norms) @ whitening
        rest = without(new, self.residuals)
        # to what the new directions take, parameters answer with minus what the columns had of the fit
        half = np.hstack([self.half, -self.half @ ((inside / norms) @ whitening)])
        basis, smooth = (np.concatenate([columns, new], axis=2) for columns in (self.basis, self.smooth))
        floor = _floor(rest, self.places) if self.coloured else 0.0
        return self._replace(basis=basis, smooth=smooth, half=half, residuals=rest, floor=floor)

    @property
    def freedom(self) -> float:
        """Number of residuals less that of parameters."""
        return float(self.residuals.size - self.basis.shape[2])

    def without_fit(self, columns: Array) -> tuple[Array, Array]:
        """What the fit leaves of weighted columns, shape (n, 6, k), and their scores in its basis, shape (v, k)."""
        inside = np.tensordot(self.smooth, columns, ((0, 1), (0, 1)))
        return without(self.basis, columns - np.tensordot(self.smooth, inside, 1)), inside


def without(basis: Array, columns: Array) -> Array:
    """What an orthonormal basis, shape (n, 6, v), leaves of columns, shape (n, 6, ..)."""
    return np.asarray(columns - np.tensordot(basis, np.tensordot(basis, columns, ((0, 1), (0, 1))), 1))


def _floor(noise: Array, places: Indices) -> float:
    """Spectral density of the quietest channel where it is least, below half the cut-off, over that of white noise."""
    series = np.zeros((next_fast_len(int(places[-1]) + 1, real=True), 6))
    series[places] = noise
    power = np.abs(rfft(series, axis=0)) ** 2 / len(noise)
    half = min(WIDTH, len(power) - 2)
    count = max(1, len(power) // 3)
    sums = np.vstack([np.zeros((1, power.shape[1])), np.cumsum(power, axis=0)])
    averages = (sums[2 * half + 1 :] - sums[: -2 * half - 1]) / (2 * half + 1)
    return float((averages[: count - half] if count > half else power).min())


class _Scores(NamedTuple):
    """Scores of an alternative, before it is known what noise makes of them."""

    alternative: Alternative
    residuals: Array  # what the fit leaves of its scaled columns, shape (n, 6, k)
    inside: Array  # their scores in the basis of the fit, shape (v, k)
    scale: Array  # of its columns, shape (k,)
    back: Array  # U = residuals back, shape (k, c)
    strength: float  # sum of the squares of what the fit leaves
    scores: Array  # shape (c,)
    alone: Array  # squares of the residuals that each column explains by itself, shape (k,)
    share: float  # share of the residuals' weighted squares that it explains
    evidence: float  # as `Effect.evidence`


def _scores_of(alternative: Alternative, rest: Remainder) -> _Scores | None:
    """The scores; None where the fit takes all of it, too few residuals are left, or noise makes as much anyway."""
    space = _space_of(alternative.columns, rest)
    if space is None:
        return None
    residuals, inside, scale, whitening, strength = space
    count = whitening.shape[1]
    each = np.tensordot(residuals, rest.residuals, ((0, 1), (0, 1)))
    size = np.sum(residuals**2, axis=(0, 1))
    alone = np.where(size > UNSEEN, each**2 / np.maximum(size, UNSEEN), 0.0)
    scores = whitening.T @ each
    explained = float(scores @ scores)
    if explained < rest.floor * (count + SURPRISE * np.sqrt(2.0 * count)):
        return None
    share = explained / float(np.sum(rest.residuals**2))
    evidence = -0.5 * (rest.independent * float(np.log1p(-min(share, 1.0 - 1e-12))) + count * np.log(rest.independent))
    evidence -= float(np.log(alternative.chosen))
    return _Scores(alternative, residuals, inside, scale, whitening, strength, scores, alone, share, evidence)


def _best_column(found: _Scores) -> int:
    """The column that explains most by itself, of several that explain as much the one that needs the smallest size."""
    alike = np.flatnonzero(found.alone >= ALIKE * found.alone.max())
    return int(alike[np.argmin(found.scale[alike])])


def _best_of(found: _Scores) -> Alternative | None:
    """That column as an alternative; None where there is nothing to choose from."""
    of, best = found.alternative, _best_column(found)
    if len(of.each) < 2:
        return None
    columns, each = of.columns[:, :, best : best + 1], of.each[best]
    return of._replace(follow=each[0], columns=columns, each=(each,), chosen=len(of.each))


def _space_of(columns: Array, rest: Remainder) -> tuple[Array, Array, Array, Array, float] | None:
    """What the fit leaves of columns, as in `_Scores`; None where it takes all of it, or too few residuals are left."""
    weighted = rest.root @ columns
    norms = np.sqrt(np.sum(weighted**2, axis=(0, 1)))
    some = norms > 0.0
    if not some.any():
        return None
    scale = np.where(some, 1.0 / np.where(some, norms, 1.0), 0.0)
    residuals, inside = rest.without_fit(weighted * scale)
    values, vectors = np.linalg.eigh(np.tensordot(residuals, residuals, ((0, 1), (0, 1))))
    significant = values > UNSEEN
    count = int(significant.sum())
    if not count or rest.freedom - count < LEAST_FREEDOM:
        return None
    return (
        residuals,
        inside,
        scale,
        vectors[:, significant] / np.sqrt(values[significant]),
        float(values[significant].sum()),
    )


def sizes_of(columns: Array, rest: Remainder, *, roughly: bool = False) -> Sizes | None:
    """Sizes of effects of columns, shape (n, 6, k); None where the fit takes all of them, or too few are left.

    Args:
        columns: as above.
        rest: what a fit leaves.
        roughly: whether `rough_noise` will do, which takes no time.
    """
    space = _space_of(columns, rest)
    if space is None:
        return None
    residuals, inside, scale, whitening, _ = space
    basis = residuals @ whitening
    scores = np.tensordot(basis, rest.residuals, ((0, 1), (0, 1)))
    noise = (rough_noise if roughly else noise_of)(basis, rest, rest.residuals - basis @ scores)
    answer = rest.half @ inside / np.where(scale > 0.0, scale, 1.0)
    return Sizes(
        scale * (whitening @ scores), noise.along(*(scale[:, None] * whitening)), answer, float(scores @ scores)
    )


def _effect_of(found: _Scores, rest: Remainder, most: float) -> Effect | None:
    """What residuals show of an alternative, judged by what they leave beside it; None above a chance."""
    basis = found.residuals @ found.back
    explained = basis @ found.scores
    rough = chance_of(found.scores, rough_noise(basis, rest, rest.residuals - explained))[1]
    if rough * found.alternative.chosen > most:
        return None
    noise = noise_of(basis, rest, rest.residuals - explained)
    statistic, chance = chance_of(found.scores, noise)
    chance = min(1.0, chance * found.alternative.chosen)
    if chance > most:
        return None
    excess = max(float(found.scores @ found.scores - np.trace(noise.covariance)), 0.0)
    answer = rest.half @ found.inside  # how parameters answer to a unit of each
    size = excess / found.strength  # tau^2, of scaled columns
    # of orthogonal directions, whose effects have the variances tau^2 / |back|^2, those where noise is less
    large = size > np.diag(noise.covariance) * np.sum(found.back**2, axis=0)
    large[np.argmax(found.scores**2)] = True
    return Effect(
        found.alternative,
        statistic,
        len(found.scores),
        chance,
        found.evidence,
        found.scale * (found.back @ found.scores),
        found.scale * np.sqrt(np.maximum(np.sum((found.back @ noise.covariance) * found.back, axis=1), 0.0)),
        _best_column(found),
        explained,
        found.share,
        size * answer @ answer.T,
        found.scale[:, None] * found.back[:, large],
    )


def rough_noise(basis: Array, rest: Remainder, noise: Array) -> Noise:
    """What `noise_of` finds, about, in no time: by the power that is left at each frequency and next to it.

    It is taken for known, and for less than it is; where effects are not certain by this noise, they are not by that.
    """
    if not rest.coloured or len(noise) < LEAST_SAMPLES:
        return noise_of(basis, rest, noise)
    joint = np.concatenate([rest.basis, basis], axis=2)
    channels = in_turned_channels(joint, np.eye(joint.shape[2]), noise, rest.places)
    power = np.abs(rfft(channels.series(channels.noise), axis=0)) ** 2
    takes, answers = (rfft(channels.series(each), axis=0) for each in (channels.taken, channels.answer))
    white_power = np.sum((takes - 2.0 * answers) * takes.conj(), axis=2).real / len(
        noise
    )  # of white noise, less all of it
    power = _beside(power) / np.maximum(_beside(np.clip(1.0 + white_power, 0.0, 1.0)), UNSEEN)
    power[1 : (channels.length + 1) // 2] *= 2.0  # of both signs of a frequency
    spectra = answers[:, :, rest.basis.shape[2] :] * np.sqrt(power / (channels.length * len(noise)))[:, :, None]
    flat = spectra.reshape(-1, basis.shape[2])
    return Noise((flat.conj().T @ flat).real / (1.0 + LESS / basis.shape[2]), (), ())


def _beside(values: Array) -> Array:
    """Sums over each frequency and those next to it, shape (f, c)."""
    sums = np.cumsum(np.pad(values, ((NEXT + 1, NEXT), (0, 0))), axis=0)
    return np.asarray(sums[2 * NEXT + 1 :] - sums[: -2 * NEXT - 1])


def noise_of(basis: Array, rest: Remainder, noise: Array) -> Noise:
    """What noise makes of the scores of a basis U, shape (n, 6, k), by what is left beside it, shape (n, 6)."""
    joint = np.concatenate([rest.basis, basis], axis=2)
    channels = in_turned_channels(joint, np.eye(joint.shape[2]), noise, rest.places)
    columns = slice(rest.basis.shape[2], None)
    if rest.coloured and len(noise) >= LEAST_SAMPLES:
        each = mixtures(channels)
        parts = [mixture.parts.covariances[:, columns, columns] for mixture in each]
        spreads, shares = [mixture.parts.spread for mixture in each], [mixture.parts.shares for mixture in each]
        total = np.sum([np.tensordot(of, part, 1) for of, part in zip(shares, parts, strict=True)], axis=0)
        # how much slow noise there is in the band of these scores follows from what is left of it in that band alone
        slow = np.array([np.tensordot(of[1:], part[1:], 1) for of, part in zip(shares, parts, strict=True)])
        bands = np.sum(np.abs(rfft(channels.series(channels.answer[:, :, columns]), axis=0)) ** 2, axis=2).T
        levels = [_left_in_band(band, mixture.free) for band, mixture in zip(bands, each, strict=True)]
        return Noise(total, (*parts, slow), (*spreads, np.diag(2.0 / np.array(levels))))
    through = channels.answer[:, :, columns].transpose(1, 0, 2)
    # samples that are independent: of each channel there are as many residuals as fit and effect leave
    freedom = np.maximum(len(noise) - np.einsum("nkv,nkv->k", channels.taken, channels.answer), 1.0)
    size = np.sqrt(np.sum(channels.noise**2, axis=0) / freedom)
    through = through * size[:, None, None]
    crossed = np.einsum("ani,bnj->abij", through, through)
    first, second = np.triu_indices(6, 1)
    diagonal = crossed[np.arange(6), np.arange(6)]
    mixed = crossed[first, second] + crossed[second, first]
    spread = np.diag(np.r_[2.0 / freedom, 1.0 / np.sqrt(freedom[first] * freedom[second])])
    return Noise(diagonal.sum(axis=0), (np.concatenate([diagonal, mixed]),), (spread,))


class Unseen(NamedTuple):
    """An effect of one size, and how well a run shows it."""

    alternative: Alternative
    std: float  # of its size, by noise
    answer: Array  # bias of what was fitted by a unit of it, shape (v,)


def unseen(alternatives: Sequence[Alternative], rest: Remainder) -> list[Unseen]:
    """How well residuals show each effect that has one size; without those that the fit takes all of."""
    effects = []
    for alternative in alternatives:
        space = _space_of(alternative.columns, rest) if alternative.columns.shape[2] == 1 else None
        if space is not None:
            residuals, inside, scale, _, strength = space
            effects.append(
                (alternative, residuals[:, :, 0] / strength * scale[0], (rest.half @ inside)[:, 0] / scale[0])
            )
    if not effects:
        return []
    channels = in_turned_channels(rest.basis, np.eye(rest.basis.shape[2]), rest.residuals, rest.places)
    mixing = np.linalg.lstsq(channels.noise, rest.residuals, rcond=None)[0]  # residuals = noise mixing
    takes = channels.series(np.stack([take for _, take, _ in effects], axis=2).transpose(0, 2, 1) @ mixing.T)
    variances = np.sum(takes**2, axis=(0, 2))
    if rest.coloured and len(rest.residuals) >= LEAST_SAMPLES:
        noises = enumerate(mixtures(channels))
        responses = [np.sum(takes[:, :, k] * toeplitz(m.autocovariance, takes[:, :, k]), axis=0) for k, m in noises]
        variances = np.sum(responses, axis=0)
    return [Unseen(of, float(np.sqrt(v)), answer) for (of, _, answer), v in zip(effects, variances, strict=True)]


def _left_in_band(band: Array, free: Array) -> float:
    """Number of independent residuals in a band and next to it, by which noise in it is known.

    Args:
        band: weights of frequencies, shape (f,).
        free: share of their power that is left, of the slow ones; of others all is, shape (<= f,).
    """
    shares = np.convolve(band, np.ones(2 * NEXT + 1), "same")
    shares = shares / max(float(shares.sum()), np.finfo(float).tiny)
    share = 1.0 - float(shares[: len(free)] @ (1.0 - free))
    return max(2.0 * share / max(float(shares @ shares), np.finfo(float).tiny), 1.0)


def effects_of(alternatives: Sequence[Alternative], rest: Remainder, chance: float) -> list[Effect]:
    """Effects that explain the residuals best, and nearly as well, the best one first.

    None where noise makes as much as the best with more than a chance.
    """
    scores_of_effects = [
        scores for scores in (_scores_of(alternative, rest) for alternative in alternatives) if scores is not None
    ]
    single = [best for best in map(_best_of, scores_of_effects) if best is not None]
    scores_of_effects += [scores for scores in (_scores_of(best, rest) for best in single) if scores is not None]
    scores_of_effects.sort(key=lambda scores: -scores.evidence)
    effects: list[Effect] = []
    for scores in scores_of_effects[:MOST_TRIED]:
        if effects and scores.evidence < effects[0].evidence - NEAR:
            break
        effect = _effect_of(scores, rest, 1.0 if effects else chance)
        if effect is not None:
            effects.append(effect)
    return effects
