"""W of (24) as its root, for errors of channels that depend on each other."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.estimation.fit import Fit

Array = NDArray[np.float64]


def whitened(whitening: Array | None, matrices: Array, forces: Array) -> tuple[Array, Array]:
    """Both multiplied with the root of W, shapes (6, 6), (n, 6, u) and (n, 6); as they are where it is None."""
    return (matrices, forces) if whitening is None else (whitening @ matrices, forces @ whitening.T)


def of_forces(whitening: Array | None, fit: Fit, matrices: Array, forces: Array) -> Fit:
    """A fit to whitened forces with the residuals of the forces themselves, and the diagonal of W.

    Args:
        whitening: root of W, shape (6, 6); None where nothing was whitened.
        fit: to the whitened forces.
        matrices: A, not whitened, shape (n, 6, u).
        forces: not whitened, shape (n, 6) [N, or N and N m].
    """
    if whitening is None:
        return fit
    return replace(fit, residuals=forces - matrices @ fit.values, weights=np.sum(whitening**2, axis=0))


def w_of(whitening: Array | None, fit: Fit) -> Array:
    """W for one sample, shape (6, 6)."""
    return np.diag(fit.weights) if whitening is None else whitening.T @ whitening
