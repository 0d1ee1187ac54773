"""Second derivatives of the criteria by the information matrix.

Every criterion of `planner.search.objective` is a function of the eigenvalues of F alone. With f_a and f_ab its
derivatives by them, and h = U^T dF U in the eigenvectors U of F (Lewis and Sendov, SIAM J. Matrix Anal. Appl. 23, 2001,
368),

    d^2 f = sum_ab f_ab h_aa h_bb + sum_a!=b (f_a - f_b) / (lambda_a - lambda_b) h_ab^2,

which takes a hundredth of the time of automatic differentiation.
"""

from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

EQUAL = 1e-7  # relative difference of eigenvalues below which their quotient is taken as the derivative


class _OfEigenvalues(NamedTuple):
    """First and second derivatives by the eigenvalues, shapes (u,) and (u, u)."""

    first: Array
    second: Array


def _log_norm(eigenvalues: Array, exponent: float) -> _OfEigenvalues:
    """Of log (sum lambda^p) / p; p below zero: of the inverse's p-norm, with its sign."""
    logs = exponent * np.log(eigenvalues)
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    shares = weights / eigenvalues
    return _OfEigenvalues(shares, np.diag((exponent - 1) * shares / eigenvalues) - exponent * np.outer(shares, shares))


def _of_eigenvalues(letter: str, eigenvalues: Array, halvings: int) -> _OfEigenvalues:
    """Of what `planner.search.objective` minimises."""
    if letter == "D":
        size = len(eigenvalues)
        return _OfEigenvalues(-1 / eigenvalues / size, np.diag(1 / eigenvalues**2) / size)
    if letter == "A":
        inverse = _log_norm(eigenvalues, -1.0)
        return _OfEigenvalues(-inverse.first, -inverse.second)
    largest, smallest = (_log_norm(eigenvalues, sign * 2.0 ** (halvings + 1)) for sign in (1, -1))
    share = 0.5 if letter == "K" else 1.0
    return _OfEigenvalues(largest.first / 2 - share * smallest.first, largest.second / 2 - share * smallest.second)


def curvature(letter: str, information: Array, halvings: int = 0) -> Array:
    """Second derivative of what `planner.search.objective` minimises, by the lower triangle of F, column by column.

    Args:
        letter: A, D, K or N.
        information: F, shape (u, u).
        halvings: see `planner.search.objective`.

    Returns:
        Shape (u (u+1)/2, u (u+1)/2); not a number where F is not positive definite. Elements off the diagonal stand
        for two of F.
    """
    size = len(information)
    column, row = np.triu_indices(size)  # of the lower triangle, column by column
    if not np.isfinite(information).all():
        return np.full((len(row), len(row)), np.nan)
    eigenvalues, vectors = np.linalg.eigh(information)
    if eigenvalues[0] <= 0.0:
        return np.full((len(row), len(row)), np.nan)
    first, second = _of_eigenvalues(letter, eigenvalues, halvings)
    own = np.diag(second)
    difference = eigenvalues[:, None] - eigenvalues[None, :]
    equal = np.abs(difference) <= EQUAL * eigenvalues
    quotients = np.where(equal, own[:, None] - second, (first[:, None] - first) / np.where(equal, 1.0, difference))
    # U^T dF U for each element of the triangle: first its diagonal, then what is above it
    first_of, second_of = np.triu_indices(size, 1)
    twice = np.where(row == column, 1.0, 2.0)[:, None]
    left, right = vectors[row], vectors[column]
    diagonal = twice * left * right
    above = left[:, first_of] * right[:, second_of] + left[:, second_of] * right[:, first_of]
    above *= twice / 2
    bent = (above * (2 * quotients[first_of, second_of])) @ above.T
    return np.asarray(diagonal @ second @ diagonal.T + bent)


def curvature_function(letter: str, size: int, halvings: int = 0) -> ca.Function:
    """`curvature` as a function of the triangle; what is returned must live as long as the functions that call it."""
    return _Callback(letter, size, halvings)


class _Callback(ca.Callback):  # type: ignore[misc]
    def __init__(self, letter: str, size: int, halvings: int) -> None:
        super().__init__()
        self.letter, self.halvings, self.size = letter, halvings, size
        self.construct("curvature", {})

    def get_n_in(self) -> int:
        return 1

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, k: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self.size * (self.size + 1) // 2, 1)

    def get_sparsity_out(self, k: int) -> ca.Sparsity:
        return ca.Sparsity.dense(*[self.size * (self.size + 1) // 2] * 2)

    def eval(self, arguments: list[ca.DM]) -> list[Array]:
        full = np.zeros((self.size, self.size))
        column, row = np.triu_indices(self.size)
        full[row, column] = full[column, row] = arguments[0].full()[:, 0]
        return [curvature(self.letter, full, self.halvings)]
