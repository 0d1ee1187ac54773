"""What residuals follow: a test of each thing that a model leaves out, and the bias that it may have made.

An alternative is a set of columns D beside those of the regression, the effect on the forces of something that the
model does not know (a gain of a channel, an offset of a strut, a spring, time). What the fit cannot take over of it,
D_ = D - A A^+ D, is compared with the residuals r: the scores c = U^T r, U an orthonormal basis of D_, are zero but for
noise where the model is right (Rao's test). Their covariance is that of noise with the spectrum of what r leaves beside
this alternative, channel by channel, the channels turned to be independent: a large effect so never hides in the noise
by which it is judged, and noise with memory is not taken for one.

Of an effect that is seen, the size of D in the directions that the fit took is as large as in those that are left: with
effects of D's columns of variance tau^2 by the scores, the estimate is biased with the covariance tau^2 B B^T, where
B = A^+ D. Of a single column this is the bias that its estimated effect makes.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len, rfft
from scipy.special import fdtrc

from cases.units import Array, Indices
from identification.estimation.fit import orthonormal

Spectra = NDArray[np.complex128]

UNSEEN = 1e-8  # of a column's square, below which what the fit leaves of it is rounding
WIDTHS = (5, 15)  # half widths of the windows of frequencies over which power is averaged, in each channel
NARROW = 1  # the same of all channels together
LEAST_BINS = 3.0  # frequencies of a window that the fit leaves, by which its power is known
SURPRISE = 2.0  # standard deviations of scores, below which an alternative is not looked at
NEAR = 7.0  # of the logarithm of the odds, within which alternatives explain the residuals alike: one to a thousand
MOST_TRIED = 12  # alternatives of which the noise is judged
LEAST_FREEDOM = 20.0  # degrees of freedom that residuals have beside an alternative, to judge noise by


class Alternative(NamedTuple):
    """Something that a model leaves out, by the effect that it has on the forces."""

    key: str  # for programs
    follow: str  # words for what the residuals then follow
    cause: str  # words for what makes it; {} stands for its size
    columns: Array  # effect on the forces of a unit of each of its sizes, shape (n, 6, k)
    unit: float = 1.0  # of the size in SI, in which people read it
    # of each column, what it follows and in which channel, counted from 0; none where there is nothing to choose from
    each: tuple[tuple[str, int], ...] = ()


class Effect(NamedTuple):
    """What residuals show of an alternative."""

    alternative: Alternative
    statistic: float  # squared scores over their variance; about k where there is nothing but noise
    tested: int  # number of scores, k or fewer
    chance: float  # probability of so much by noise alone
    evidence: float  # logarithm of the odds by which it explains the residuals better than noise alone
    sizes: Array  # estimated size of each column, shape (k,); the smallest where columns depend on each other
    stds: Array  # their standard deviations
    explained: Array  # what it explains of the residuals, weighted, shape (n, 6)
    share: float  # share of the residuals' weighted squares that it explains
    bias: Array  # covariance of the parameters by effects of that size, shape (v, v)


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
        """What is left where effects of columns, shape (n, 6, k), are estimated too."""
        left, inside = self.without_fit(self.root @ columns)
        norms = np.sqrt(np.maximum(np.sum(left**2, axis=(0, 1)), np.finfo(float).tiny))
        values, vectors = np.linalg.eigh(np.tensordot(left / norms, left / norms, ((0, 1), (0, 1))))
        seen = values > UNSEEN
        back = vectors[:, seen] / np.sqrt(values[seen])
        new = (left / norms) @ back
        rest = without(new, self.residuals)
        # to what the new directions take, parameters answer with minus what the columns had of the fit
        half = np.hstack([self.half, -self.half @ ((inside / norms) @ back)])
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
    series = np.zeros((int(places[-1]) + 1, 6))
    series[places] = noise
    power = np.abs(rfft(series, axis=0)) ** 2 / len(noise)
    half = min(WIDTHS[1], len(power) - 2)
    passed = max(1, len(power) // 3)
    return float((_moving(power, half)[half:passed] if passed > half else power).min() / (2 * half + 1))


class _Scores(NamedTuple):
    """Scores of an alternative, before it is known what noise makes of them."""

    alternative: Alternative
    left: Array  # what the fit leaves of its scaled columns, shape (n, 6, k)
    inside: Array  # their scores in the basis of the fit, shape (v, k)
    scale: Array  # of its columns, shape (k,)
    back: Array  # U = left back, shape (k, c)
    strength: float  # sum of the squares of what the fit leaves
    scores: Array  # shape (c,)
    share: float  # share of the residuals' weighted squares that it explains
    evidence: float  # as `Effect.evidence`


def _scores_of(alternative: Alternative, rest: Remainder) -> _Scores | None:
    """The scores; None where the fit takes all of it, too few residuals are left, or noise makes as much anyway."""
    weighted = rest.root @ alternative.columns
    norms = np.sqrt(np.sum(weighted**2, axis=(0, 1)))
    some = norms > 0.0
    if not some.any():
        return None
    scale = np.where(some, 1.0 / np.where(some, norms, 1.0), 0.0)
    left, inside = rest.without_fit(weighted * scale)
    values, vectors = np.linalg.eigh(np.tensordot(left, left, ((0, 1), (0, 1))))
    seen = values > UNSEEN
    count = int(seen.sum())
    if not count or rest.freedom - count < LEAST_FREEDOM:
        return None
    back = vectors[:, seen] / np.sqrt(values[seen])
    scores = back.T @ np.tensordot(left, rest.residuals, ((0, 1), (0, 1)))
    explained = float(scores @ scores)
    if explained < rest.floor * (count + SURPRISE * np.sqrt(2.0 * count)):
        return None
    share = explained / float(np.sum(rest.residuals**2))
    evidence = -0.5 * (rest.independent * float(np.log1p(-min(share, 1.0 - 1e-12))) + count * np.log(rest.independent))
    return _Scores(alternative, left, inside, scale, back, float(values[seen].sum()), scores, share, evidence)


def _effect_of(found: _Scores, rest: Remainder) -> Effect:
    """What residuals show of an alternative, judged by what they leave beside it."""
    count = len(found.scores)
    basis = found.left @ found.back
    explained = basis @ found.scores
    covariance, freedom = _covariance(basis, rest, rest.residuals - explained)
    if freedom < max(LEAST_FREEDOM, count):  # beside it, too little is left in its own band to judge noise by
        covariance, freedom = _covariance(basis, rest, rest.residuals, own=False)
    statistic = float(found.scores @ np.linalg.lstsq(covariance, found.scores, rcond=1e-12)[0])
    size = max(float(found.scores @ found.scores - np.trace(covariance)), 0.0) / found.strength  # tau^2, scaled columns
    answer = rest.half @ found.inside  # how parameters answer to a unit of each
    return Effect(
        found.alternative,
        statistic,
        count,
        max(float(fdtrc(count, freedom, statistic / count)), np.finfo(float).tiny),
        found.evidence,
        found.scale * (found.back @ found.scores),
        found.scale * np.sqrt(np.maximum(np.sum((found.back @ covariance) * found.back, axis=1), 0.0)),
        explained,
        found.share,
        size * answer @ answer.T,
    )


def _covariance(basis: Array, rest: Remainder, noise: Array, own: bool = True) -> tuple[Array, float]:
    """Covariance of the scores of a basis under noise, and its degrees of freedom in the basis' own band.

    Args:
        basis: U, shape (n, 6, k).
        noise: what is left, by which noise is judged, shape (n, 6).
        own: whether the alternative is taken out of it.
    """
    count, used = noise.size, rest.basis.shape[2] + (basis.shape[2] if own else 0)
    channels = noise.T @ noise / (len(noise) - used / 6.0)
    mixing = np.linalg.cholesky(channels + 1e-12 * np.trace(channels) * np.eye(6) + np.finfo(float).tiny * np.eye(6))
    if not rest.coloured:
        turned = mixing.T @ basis
        return np.tensordot(turned, turned, ((0, 1), (0, 1))), float(count - used)
    unmixing = np.linalg.inv(mixing)
    length = int(rest.places[-1]) + 1
    size = next_fast_len(2 * length, real=True)

    def spectra(values: Array) -> Spectra:
        series = np.zeros((length, *values.shape[1:]))
        series[rest.places] = values
        return np.asarray(rfft(series, size, axis=0))

    power = np.abs(spectra(noise @ unmixing.T)) ** 2 / len(noise)  # 1 for white noise
    ours, fitted = spectra(basis), spectra(rest.basis)
    taken = np.zeros_like(power)  # power of each frequency that fit and alternative take from white noise
    for columns in (ours, fitted) if own else (fitted,):
        taken += np.sum(((unmixing @ columns) * (mixing.T @ columns).conj()).real, axis=2)
    free = np.clip(1.0 - taken / len(noise), 0.0, 1.0)
    density = _smoothed(power, free, size / length)
    through = mixing.T @ ours
    twice = np.full(len(density), 2.0)
    twice[0] = 1.0
    if size % 2 == 0:
        twice[-1] = 1.0
    weights = density * twice[:, None] / size
    covariance = np.einsum("fki,fk,fkj->ij", through.conj(), weights, through, optimize=True).real
    energy = np.sum(np.abs(through) ** 2, axis=2)
    width = max(1, int((2 * WIDTHS[0] + 1) * size / length))
    blocks = np.add.reduceat(energy, np.arange(0, len(energy), width), axis=0)
    freedom = 2.0 * (2 * WIDTHS[0] + 1) * float(blocks.sum() ** 2 / np.sum(blocks**2))
    return np.asarray(covariance), max(1.0, freedom * float(np.sum(energy * free) / energy.sum()))


def _smoothed(power: Array, free: Array, oversampled: float) -> Array:
    """Spectral density of noise from the power that a fit leaves, shape (f, 6): the largest over windows.

    The narrowest window is one over all channels together, for slow noise lies in few frequencies.
    """
    together = power.mean(axis=1, keepdims=True), free.mean(axis=1, keepdims=True)
    densities = [_averaged(*together, NARROW, oversampled)]
    densities += [_averaged(power, free, width, oversampled) for width in WIDTHS]
    best = np.max(np.broadcast_arrays(*densities), axis=0)
    everything = power.sum(axis=0) / np.maximum(free.sum(axis=0), 1e-9)
    return np.asarray(np.where(best > 0.0, best, everything))


def _averaged(power: Array, free: Array, width: float, oversampled: float) -> Array:
    """Power over the share that is free, in windows of a half width; 0 where too little is free."""
    half = min(max(1, round(width * oversampled)), len(power) - 2)
    sums, rooms = _moving(power, half), _moving(free, half)
    return np.where(
        rooms >= LEAST_BINS * oversampled / (1.0 if free.shape[1] > 1 else 6.0), sums / np.maximum(rooms, 1e-9), 0.0
    )


def _moving(values: Array, half: int) -> Array:
    """Sums over windows of frequencies, mirrored at both ends, shape (f, 6)."""
    padded = np.concatenate([values[half:0:-1], values, values[-2 : -half - 2 : -1]])
    total = np.vstack([np.zeros((1, values.shape[1])), np.cumsum(padded, axis=0)])
    return np.asarray(total[2 * half + 1 :] - total[: -2 * half - 1])


def effects_of(alternatives: Sequence[Alternative], rest: Remainder, chance: float) -> list[Effect]:
    """Effects that explain the residuals best, and nearly as well, the best one first.

    None where noise makes as much as the best with more than a chance.
    """
    found = [scores for scores in (_scores_of(alternative, rest) for alternative in alternatives) if scores is not None]
    found.sort(key=lambda scores: -scores.evidence)
    effects: list[Effect] = []
    for scores in found[:MOST_TRIED]:
        if effects and scores.evidence < effects[0].evidence - NEAR:
            break
        effect = _effect_of(scores, rest)
        if effects or effect.chance < chance:
            effects.append(effect)
    return effects
