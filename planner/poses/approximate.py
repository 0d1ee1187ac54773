"""The D-optimal approximate design over finitely many poses, and what it certifies about every set of them.

Maximise log det sum_i w_i A_i^T A_i over weights w >= 0 of sum 1. By the general equivalence theorem (Kiefer and
Wolfowitz 1960) no mean information F of these poses has a log det above log det F_w + u log(dmax / u), dmax being the
largest directional derivative trace(A_i F_w^-1 A_i^T) over *all* of them: with finitely many poses a proof, not an
estimate.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GAP = 1e-3  # dmax <= u (1 + GAP): the bound is then known to 0.1 % of efficiency
ROUNDS = 200
STEPS = 60
NEGLIGIBLE = 1e-9


@dataclass(frozen=True, slots=True)
class ApproximateDesign:
    """A design with its certificate.

    Args:
        weights: of the poses, shape (n,), sum 1.
        information: mean information, shape (u, u).
        dmax: largest directional derivative over all poses.
    """

    weights: Array
    information: Array
    dmax: float

    @property
    def logdet_bound(self) -> float:
        """What the log det of no mean information of these poses exceeds."""
        size = len(self.information)
        return float(np.linalg.slogdet(self.information)[1] + size * np.log(self.dmax / size))

    def efficiency(self, regressors: Array) -> float:
        """Lower bound of the D-efficiency of a set of poses against every design over the candidates.

        Args:
            regressors: of the set, shape (k, 6, u), in the scaling of the design.
        """
        rows = regressors.reshape(-1, regressors.shape[2])
        sign, logdet = np.linalg.slogdet(rows.T @ rows / len(regressors))
        if sign <= 0:
            return 0.0
        return float(np.exp((logdet - self.logdet_bound) / len(self.information)))


def approximate_design(regressors: Array, gap: float = GAP) -> ApproximateDesign:
    """Multiplicative algorithm (Titterington 1976) on an active set that grows by whatever poses violate optimality.

    Args:
        regressors: of all candidates, shape (n, 6, u); together of full rank.
        gap: stops when dmax <= u (1 + gap).
    """
    count, _, size = regressors.shape
    products = (regressors.transpose(0, 2, 1) @ regressors).reshape(count, -1)
    weights = np.full(count, 1.0 / count)
    information, derivative = _derivative(products, weights, size)
    for _ in range(ROUNDS):
        active = np.flatnonzero((weights > NEGLIGIBLE) | (derivative > size))
        # What has no weight but would help gets a small share, so that it can grow.
        weights[active] = np.maximum(weights[active], 1e-3 / len(active))
        some, share = products[active], weights[active] / weights[active].sum()
        for _ in range(STEPS):
            share = share * _derivative(some, share, size)[1] / size
        share[share < NEGLIGIBLE] = 0.0
        weights = np.zeros(count)
        weights[active] = share / share.sum()
        information, derivative = _derivative(products, weights, size)
        if derivative.max() <= size * (1.0 + gap):
            break
    return ApproximateDesign(weights, information, float(derivative.max()))


def _derivative(products: Array, weights: Array, size: int) -> tuple[Array, Array]:
    information = (weights @ products).reshape(size, size)
    return information, np.asarray(products @ np.linalg.inv(information).ravel())
