"""Whether a case can be right at its tolerances: each size by itself, and all of them together.

The scores c = G d + n of a run have the covariance S = G G^T + N where the sizes d vary as stated (each by 1), N by
noise. Of one size alone, the others as stated, the run tells x = g^T S^-1 c / b with the deviation sqrt((1 - b) / b),
b = g^T S^-1 g, g its column of G: an estimate that does not draw it towards 0 by what is stated of it, so that value,
deviation and tolerance stand beside each other as a reader compares them. x / sqrt(1 + deviation^2) is normal where
the case is right. All together are judged by c^T S^-1 c in the directions in which sizes are not lost in noise. In both
tests N is known by few residuals (`small_sample`).
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from cases.base.units import Array
from identification.estimation.score_test import Noise, chance_of

UNLIKELY = 1e-3  # chance of so much in a run of a machine that is as its case states, below which the case is doubted
LOOKED_AT = 3.0  # deviations of both, below which a size is never that unlikely
SEEN = 0.5  # variance by stated sizes over that by noise, from which on a direction tells of all sizes together
SMALLEST, LARGEST = 1.0, 1e3  # times that stated tolerances may be larger in truth


class Part(NamedTuple):
    """What a run tells of one size, the others as stated, in units of its stated deviation."""

    place: int  # of the size
    size: float
    std: float  # of it, by noise and by the other sizes
    chance: float  # that of all sizes of a machine as stated one is as far off

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


def worst_part(news: Array, through: Array, noise: Noise) -> Part:
    """The size that is off by what is least likely.

    Args:
        news: scores, as of `parts_of`.
        through: G, likewise.
        noise: what noise makes of them.
    """
    sizes, stds, weights = parts_of(news, through, noise.covariance)
    deviations = np.abs(sizes) / np.hypot(1.0, stds)
    first = int(np.argmax(deviations))
    chances = {
        k: _chance(news, through, noise, weights[:, k]) for k in {first, *np.flatnonzero(deviations > LOOKED_AT)}
    }
    worst = min(chances, key=lambda k: chances[k])
    among_all = -np.expm1(len(sizes) * np.log1p(-min(chances[worst], 0.5)))
    return Part(int(worst), float(sizes[worst]), float(stds[worst]), float(among_all))


def chance_of_all(news: Array, through: Array, noise: Noise) -> float:
    """Probability of so large scores, all together, where sizes vary as stated; arguments as of `worst_part`.

    Directions count in which stated sizes make half as much as noise or more, in variance: in others larger sizes would
    not be seen, and only hide in noise what these show. 1 where there is none.
    """
    values, directions = _by_strength(through, noise)
    some = values >= SEEN
    return _chance(news, through, noise, *directions[some]) if some.any() else 1.0


def times_stated(news: Array, through: Array, noise: Noise) -> float:
    """By how many times larger deviations than stated the scores are likeliest; arguments as of `worst_part`."""
    values, directions = _by_strength(through, noise)
    squares = (directions @ news) ** 2

    def unlikely(log: float) -> float:
        variances = 1.0 + np.exp(2.0 * log) * values
        return float(np.sum(np.log(variances) + squares / variances))

    ends = float(np.log(SMALLEST)), float(np.log(LARGEST))
    return float(np.exp(minimize_scalar(unlikely, bounds=ends, method="bounded").x))


def _by_strength(through: Array, noise: Noise) -> tuple[Array, Array]:
    """Variances that stated sizes make of independent sums of scores, in those of noise, and the weights of these."""
    half = np.linalg.inv(np.linalg.cholesky(noise.covariance))
    values, vectors = np.linalg.eigh(half @ through @ through.T @ half.T)
    return np.asarray(values), np.asarray(vectors.T @ half)


def _chance(news: Array, through: Array, noise: Noise, *directions: Array) -> float:
    """Of sums of the scores with these weights, shapes (s,)."""
    rows = np.array(directions)
    own = noise.along(*directions)
    return chance_of(rows @ news, own._replace(covariance=own.covariance + (rows @ through) @ (rows @ through).T))[1]
