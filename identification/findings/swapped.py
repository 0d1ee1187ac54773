"""Forces of two channels that were exchanged, or one with its sign turned: found by what the model leaves of them."""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from identification.estimation.compressed import inverse_root

Array = NDArray[np.float64]

FACTOR = 4.0  # by which another wiring must lower chi^2: chance does not, with so many forces to judge by
LEAST = 60  # forces beyond the unknowns


def other_wiring(regressors: Array, forces: Array, weights: Array) -> str | None:
    """What the channels seem to be wired like, or None where they are as they should be.

    One QR serves all wirings: Q^T f of permuted forces is a sum of blocks that are known.

    Args:
        regressors: A_j, shape (n, 6, u), of full rank.
        forces: shape (n, 6) [N, or N and N m].
        weights: diagonal of W for one sample, shape (6,).
    """
    if forces.size - regressors.shape[2] < LEAST:
        return None
    root = np.sqrt(weights)
    weighted = regressors * root[:, None]
    half = inverse_root(np.asarray(np.linalg.qr(weighted.reshape(-1, regressors.shape[2]), mode="r")))
    blocks = np.einsum("nau,nb->abu", weighted @ half, forces)  # channel a of Q against forces b
    total = np.sum(forces**2, axis=0)

    def left(order: NDArray[np.int64], signs: Array) -> float:
        explained = np.einsum("a,a,au->u", root, signs, blocks[np.arange(6), order])
        return float(np.sum(weights * total[order]) - explained @ explained)

    straight, ones = np.arange(6), np.ones(6)
    found: list[tuple[float, str]] = []
    for a, b in combinations(range(6), 2):
        order = straight.copy()
        order[[a, b]] = b, a
        found.append((left(order, ones), f"the forces of channels {a + 1} and {b + 1} seem to be exchanged"))
    for a in range(6):
        signs = ones.copy()
        signs[a] = -1.0
        found.append((left(straight, signs), f"the sign of channel {a + 1} seems to be turned"))
    best, text = min(found)
    now = left(straight, ones)
    if now <= 0.0 or best * FACTOR > now:
        return None
    ratio = np.sqrt(max(best, 0.0) / now)
    return (
        f"{text}: with that undone {100 * ratio:.2g} % of the residuals are left; correct wiring or [recording.columns]"
    )
