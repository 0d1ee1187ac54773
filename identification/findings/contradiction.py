"""Whether a case can be right at its tolerances: each size by itself, and all of them together; and which part is not.

The scores c = G d + n of a run have the covariance S = G G^T + N where the sizes d vary as stated (each by 1), N by
noise. Of one size alone, the others as stated, the run tells x = g^T S^-1 c / b with the deviation sqrt((1 - b) / b),
b = g^T S^-1 g, g its column of G: an estimate that does not draw it towards 0 by what is stated of it, so that value,
deviation and tolerance stand beside each other as a reader compares them. x / sqrt(1 + deviation^2) is normal where
the case is right. All together are judged by c^T S^-1 c in the directions in which sizes are not lost in noise. In both
tests N is known by few residuals (`small_sample`).

Where the case cannot be right, either one part is not, or stated tolerances are too small as a whole. In a machine of
the second kind the size that fits best by itself, the others as stated, need not be off at all. So each is tried again
beside others that are t times larger than stated, t with the likelihood of the scores that this size does not change
(half of what is thought of t beforehand is that it is 1). The likeliest is named if the mean of its chance over t is
small, smaller than what doubts the case, for who reads a name takes that part off; and beside it those that make the
scores nearly as likely and that it would explain.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from cases.base.units import Array
from identification.estimation.score_test import Noise, chance_of

UNLIKELY = 1e-3  # chance of so much in a run of a machine that is as its case states, below which the case is doubted
NAMED_BELOW = 1e-4  # mean chance of one part, below which it is named
LOOKED_AT = 3.0  # deviations of both, below which a size is never that unlikely
SEEN = 0.5  # variance by stated sizes over that by noise, from which on a direction tells of all sizes together
SMALLEST, LARGEST = 1.0, 1e3  # times that stated tolerances may be larger in truth
TIMES: Array = np.geomspace(SMALLEST, 30.0, 25)  # the same, as tried beside a part
NEARLY = 20.0  # ratio of likelihoods up to which another part may be the one that is off
MOST_NAMED = 3  # parts of which one is off: among more of them none is named


class Part(NamedTuple):
    """What a run tells of one size, in units of its stated deviation."""

    place: int  # of the size
    size: float
    std: float  # of it, by noise and by the other sizes
    chance: float  # that of all sizes of a machine as stated one is as far off
    times: float  # larger than stated are the other sizes, by which value and deviation are told

    @property
    def deviations(self) -> float:
        """By how many deviations it is off, of what is stated and of what the run tells together."""
        return abs(self.size) / float(np.hypot(1.0, self.std))


def parts_of(news: Array, through: Array, noise: Array) -> tuple[Array, Array, Array]:
    """Each size by itself: estimates, their deviations, and weights of the scores that give it, shape (s, k).

    A size that no score shows has an infinite deviation.

    Args:
        news: scores of a machine with such sizes, shape (s,).
        through: G, shape (s, k).
        noise: covariance of what noise makes of them.
    """
    weights = np.linalg.solve(through @ through.T + noise, through)
    information = np.sum(through * weights, axis=0)
    shown = information > np.finfo(float).eps
    divisor = np.where(shown, information, 1.0)
    sizes = np.where(shown, weights.T @ news, 0.0) / divisor
    variances = np.where(shown, np.maximum(1.0 - information, 0.0) / divisor, np.inf)
    return np.asarray(sizes), np.asarray(np.sqrt(variances)), np.asarray(weights)


def chance_of_one(news: Array, through: Array, noise: Noise) -> float:
    """Probability that one of all sizes is as far off as the one that is least likely, where they vary as stated.

    Args:
        news: scores, as of `parts_of`.
        through: G, likewise.
        noise: what noise makes of them.
    """
    sizes, stds, weights = parts_of(news, through, noise.covariance)
    deviations = np.abs(sizes) / np.hypot(1.0, stds)
    tried = {int(np.argmax(deviations)), *np.flatnonzero(deviations > LOOKED_AT).tolist()}
    return min(_among(len(sizes), _chance(news, through, noise, weights[:, k])) for k in tried)


def standing_out(news: Array, through: Array, noise: Noise) -> tuple[Part, ...]:
    """The part that is off by more than is stated of it, first; with it those that may be off in its place.

    None where the others, if they are larger than stated, may explain as much, or where too many parts may be the one.
    Arguments as of `chance_of_one`.
    """
    sizes, stds, _ = parts_of(news, through, noise.covariance)
    tried = np.flatnonzero(np.abs(sizes) > LOOKED_AT * np.hypot(1.0, stds))
    ranked = sorted((_Tried.of(int(k), news, through, noise) for k in tried), key=lambda one: one.unlikely)
    if not ranked:
        return ()
    first, *others = ranked
    if (part := first.part(news, through, noise)).chance >= NAMED_BELOW:
        return ()
    near = [one for one in others if one.unlikely < first.unlikely + 2.0 * np.log(NEARLY)]
    instead = [one for one in near if _explained(one.place, first.place, news, through, noise)]
    if len(instead) >= MOST_NAMED:
        return ()
    return part, *(one.part(news, through, noise) for one in instead)


class _Tried(NamedTuple):
    """A part of any size, beside others that are larger than stated by what the scores that it leaves say."""

    place: int
    times: float  # larger than stated are the others, by their likelihood
    weights: Array  # of `TIMES`, by likelihood and by what is thought of them beforehand, sum 1
    unlikely: float = 0.0  # -2 log of the likelihood of all

    @classmethod
    def of(cls, k: int, news: Array, through: Array, noise: Noise) -> "_Tried":
        """That of a place; arguments as of `chance_of_one`."""
        column, others = through[:, k], np.delete(through, k, axis=1)
        rest, logs = _beside(column, noise), np.zeros(len(TIMES))
        if len(rest):
            values, directions = _by_strength(rest @ others, noise.along(*rest))
            logs = -0.5 * _unlikely(TIMES, values, (directions @ (rest @ news)) ** 2)
        weights = np.exp(logs - logs.max())
        weights[0] *= len(TIMES) - 1  # as stated, or larger by any factor: both are as likely beforehand
        one = cls(k, float(TIMES[np.argmax(logs)]), weights / weights.sum())
        size, _, _ = one.told(one.times, news, through, noise)
        covariance = one.times**2 * others @ others.T + noise.covariance
        remainder = news - size * column
        prior = min(size**2, 1.0 + 2.0 * np.log(max(abs(size), 1.0)))  # normal, its deviation 1 or what is likeliest
        square = float(remainder @ np.linalg.solve(covariance, remainder))
        return one._replace(unlikely=float(np.linalg.slogdet(covariance)[1]) + square + prior)

    def told(self, times: float, news: Array, through: Array, noise: Noise) -> tuple[float, float, Array]:
        """Its size, the deviation of that, and weights of the scores, where all others are so many times larger."""
        column, others = through[:, self.place], np.delete(through, self.place, axis=1)
        weights = np.linalg.solve(times**2 * others @ others.T + noise.covariance, column)
        information = float(column @ weights)
        return float(weights @ news) / information, float(information**-0.5), np.asarray(weights)

    def part(self, news: Array, through: Array, noise: Noise) -> Part:
        """What is told of it: its chance is the mean over what the others may be."""
        chances = []
        for times in TIMES:
            larger = times * through
            larger[:, self.place] = through[:, self.place]
            chances.append(_chance(news, larger, noise, self.told(float(times), news, through, noise)[2]))
        size, std, _ = self.told(self.times, news, through, noise)
        chance = _among(through.shape[1], float(self.weights @ np.array(chances)))
        return Part(self.place, size, std, chance, self.times)


def _explained(place: int, by: int, news: Array, through: Array, noise: Noise) -> bool:
    """Whether one size is not off where another may have any size."""
    rest = _beside(through[:, by], noise)
    sizes, stds, _ = parts_of(rest @ news, rest @ through, rest @ noise.covariance @ rest.T)
    return bool(abs(sizes[place]) <= LOOKED_AT * np.hypot(1.0, stds[place]))


def _beside(column: Array, noise: Noise) -> Array:
    """Weights of scores, white in noise, in which a size of an effect shows nothing: shapes (s,) -> (s - 1, s)."""
    half = np.linalg.inv(np.linalg.cholesky(noise.covariance))
    return np.asarray(np.linalg.svd((half @ column)[:, None])[0][:, 1:].T @ half)


def _among(count: int, chance: float) -> float:
    """Probability that one of so many is as unlikely (Sidak)."""
    return float(-np.expm1(count * np.log1p(-min(chance, 0.5))))


def chance_of_all(news: Array, through: Array, noise: Noise) -> float:
    """Probability of so large scores, all together, where sizes vary as stated; arguments as of `chance_of_one`.

    Directions count in which stated sizes make half as much as noise or more, in variance: in others larger sizes would
    not be seen, and only hide in noise what these show. 1 where there is none.
    """
    values, directions = _by_strength(through, noise)
    some = values >= SEEN
    return _chance(news, through, noise, *directions[some]) if some.any() else 1.0


def times_stated(news: Array, through: Array, noise: Noise) -> float:
    """By how many times larger deviations than stated the scores are likeliest; arguments as of `chance_of_one`."""
    values, directions = _by_strength(through, noise)
    squares = (directions @ news) ** 2

    def unlikely(log: float) -> float:
        return float(_unlikely(np.exp([log]), values, squares)[0])

    ends = float(np.log(SMALLEST)), float(np.log(LARGEST))
    return float(np.exp(minimize_scalar(unlikely, bounds=ends, method="bounded").x))


def _unlikely(times: Array, values: Array, squares: Array) -> Array:
    """-2 log of the likelihood of sizes so many times larger, shape (n,).

    Args:
        times: shape (n,).
        values: variances, as of `_by_strength`, shape (s,).
        squares: of the sums of scores there, shape (s,).
    """
    variances = 1.0 + times[:, None] ** 2 * values
    return np.asarray(np.sum(np.log(variances) + squares / variances, axis=1))


def _by_strength(through: Array, noise: Noise) -> tuple[Array, Array]:
    """Variances that stated sizes make of independent sums of scores, in those of noise, and the weights of these."""
    half = np.linalg.inv(np.linalg.cholesky(noise.covariance))
    values, vectors = np.linalg.eigh(half @ through @ through.T @ half.T)
    return np.asarray(values), np.asarray(vectors.T @ half)


def _chance(news: Array, through: Array, noise: Noise, *directions: Array) -> float:
    """Of sums of the scores with these weights, shapes (s,)."""
    rows = np.array(directions)
    along = noise.along(*directions)
    covariance = along.covariance + (rows @ through) @ (rows @ through).T
    return chance_of(rows @ news, along._replace(covariance=covariance))[1]
