"""How surely scores differ from what noise makes of them, where that noise is known from a few residuals itself.

The covariance of scores is a sum of parts, whose sizes residuals show with a covariance of their own. The squared
scores over that covariance are then spread wider than chi^2: as F, by the moments of Kenward and Roger (1997,
Biometrics 53:983), which for an unknown covariance of few independent samples give Hotelling's test.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import fdtrc

from cases.base.units import Array


class Noise(NamedTuple):
    """What noise makes of scores, and how surely that is known."""

    covariance: Array  # of the scores, shape (k, k)
    parts: tuple[Array, ...]  # symmetric changes of it, groups of shape (p, k, k)
    spreads: tuple[Array, ...]  # covariance of the sizes of these changes, of each group, shape (p, p)

    def along(self, *directions: Array) -> "Noise":
        """That of sums of the scores, each with a weight of each score, shape (k,)."""
        rows = np.array(directions)
        return Noise(rows @ self.covariance @ rows.T, tuple(rows @ p @ rows.T for p in self.parts), self.spreads)


def chance_of(scores: Array, noise: Noise) -> tuple[float, float]:
    """Squared scores, shape (k,), over their covariance, and the probability of so much by noise; 1 if not known."""
    count = len(scores)
    values, vectors = np.linalg.eigh(noise.covariance)
    if values[0] <= 1e-12 * values[-1]:
        return 0.0, 1.0
    half = vectors / np.sqrt(values)
    statistic = float(np.sum((half.T @ scores) ** 2))
    first = second = 0.0
    for parts, spread in zip(noise.parts, noise.spreads, strict=True):
        changes = half.T @ parts @ half
        traces, flat = np.trace(changes, axis1=1, axis2=2), changes.reshape(len(changes), -1)
        first += float(traces @ spread @ traces)
        second += float(np.sum(spread * (flat @ flat.T)))
    return statistic, _chance(statistic / count, count, first, second)


def _chance(ratio: float, k: int, first: float, second: float) -> float:
    """Probability of F by noise: Kenward and Roger's A1 and A2 are `first` and `second`."""
    if second <= 0.0:
        return max(float(fdtrc(k, 1e9, ratio)), np.finfo(float).tiny)
    b = (first + 6.0 * second) / (2.0 * k)
    g = ((k + 1) * first - (k + 4) * second) / ((k + 2) * second)
    bottom = 3.0 * k + 2.0 * (1.0 - g)
    c1, c2, c3 = g / bottom, (k - g) / bottom, (k + 2.0 - g) / bottom
    if second >= k or c2 * b >= 1.0 or c3 * b >= 1.0:
        return 1.0  # noise is known by less than the scores themselves
    mean = 1.0 / (1.0 - second / k)
    variance = 2.0 / k * (1.0 + c1 * b) / ((1.0 - c2 * b) ** 2 * (1.0 - c3 * b))
    spread = variance / (2.0 * mean**2)
    if spread * k <= 1.0:
        return max(float(fdtrc(k, 1e9, ratio / mean)), np.finfo(float).tiny)
    freedom = 4.0 + (k + 2.0) / (k * spread - 1.0)
    scale = freedom / (mean * (freedom - 2.0))
    return max(float(fdtrc(k, freedom, scale * ratio)), np.finfo(float).tiny)
