"""The criteria of Table 4 as smooth functions of an information matrix, with two derivatives.

A and D are exact. K and N contain the largest and the smallest eigenvalue, which have no derivative where eigenvalues
meet; they are replaced by p-norms, max <= (sum lambda^p)^(1/p) <= u^(1/p) max, and rated exactly afterwards.

Every criterion is a function of the eigenvalues of F alone. With f_a and f_ab its derivatives by them, and
h = U^T dF U in the eigenvectors U of F (Lewis and Sendov, SIAM J. Matrix Anal. Appl. 23, 2001, 368),

    df   = sum_a f_a h_aa
    d^2f = sum_ab f_ab h_aa h_bb + sum_a!=b (f_a - f_b) / (lambda_a - lambda_b) h_ab^2.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

EQUAL = 1e-7  # relative difference of eigenvalues below which their quotient is taken as the derivative


class Local(NamedTuple):
    """A criterion, to be minimised and of order one, near an information matrix."""

    # A: log(trace F^-1 / u); D: -log det F / u; K: log of mu_1 / mu_u; N: log of mu_1 / mu_u^2. Not a number where F is
    # not positive definite
    value: float
    vectors: Array  # eigenvectors of F, one a column, shape (u, u)
    first: Array  # derivatives by the eigenvalues, shape (u,)
    second: Array  # second derivatives by the eigenvalues, shape (u, u)
    quotients: Array  # (f_a - f_b) / (lambda_a - lambda_b), shape (u, u)

    @property
    def slope(self) -> Array:
        """Derivative by F, shape (u, u), symmetric."""
        return np.asarray((self.vectors * self.first) @ self.vectors.T)


def criterion_at(letter: str, information: Array, halvings: int = 0) -> Local:
    """The criterion and its derivatives.

    Args:
        letter: A, D, K or N.
        information: F, shape (u, u).
        halvings: exponent of the p-norms of K and N, p = 2^(halvings + 1).
    """
    size = len(information)
    nothing = np.full((size, size), np.nan)
    if not np.isfinite(information).all():
        return Local(np.nan, nothing, nothing[0], nothing, nothing)
    eigenvalues, vectors = np.linalg.eigh(information)
    if eigenvalues[0] <= 0.0:
        return Local(np.nan, vectors, nothing[0], nothing, nothing)
    value, first, second = _of_eigenvalues(letter, eigenvalues, halvings)
    difference = eigenvalues[:, None] - eigenvalues[None, :]
    equal = np.abs(difference) <= EQUAL * eigenvalues
    own = np.diag(second)[:, None] - second
    quotients = np.where(equal, own, (first[:, None] - first) / np.where(equal, 1.0, difference))
    return Local(value, vectors, first, second, quotients)


class _OfEigenvalues(NamedTuple):
    """A function of the eigenvalues: value, first and second derivatives, shapes (), (u,) and (u, u)."""

    value: float
    first: Array
    second: Array


def _log_norm(eigenvalues: Array, exponent: float) -> _OfEigenvalues:
    """Log (sum lambda^p) / p; p below zero: of the inverse's p-norm, with its sign."""
    logs = exponent * np.log(eigenvalues)
    weights = np.exp(logs - logs.max())
    total = weights.sum()
    weights /= total
    shares = weights / eigenvalues
    second = np.diag((exponent - 1) * shares / eigenvalues) - exponent * np.outer(shares, shares)
    return _OfEigenvalues(float(np.log(total) + logs.max()) / exponent, shares, second)


def _of_eigenvalues(letter: str, eigenvalues: Array, halvings: int) -> _OfEigenvalues:
    size = len(eigenvalues)
    if letter == "D":
        value = -float(np.log(eigenvalues).mean())
        return _OfEigenvalues(value, -1 / eigenvalues / size, np.diag(1 / eigenvalues**2) / size)
    if letter == "A":
        inverse = _log_norm(eigenvalues, -1.0)
        return _OfEigenvalues(-inverse.value - np.log(size), -inverse.first, -inverse.second)
    largest, smallest = (_log_norm(eigenvalues, sign * 2.0 ** (halvings + 1)) for sign in (1, -1))
    share = 0.5 if letter == "K" else 1.0
    return _OfEigenvalues(
        largest.value / 2 - share * smallest.value,
        largest.first / 2 - share * smallest.first,
        largest.second / 2 - share * smallest.second,
    )
