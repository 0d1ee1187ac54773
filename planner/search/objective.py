"""The objective of a search: the criteria of Table 4 as smooth functions of an information matrix, twice derived.

A and D are exact. K and N contain the largest and the smallest eigenvalue, which have no derivative where eigenvalues
meet; they are replaced by p-norms, max <= (sum lambda^p)^(1/p) <= u^(1/p) max, and rated exactly afterwards.

Every criterion is a function of the eigenvalues of F alone. With f_a and f_ab its derivatives by them, and
h = U^T dF U in the eigenvectors U of F (Lewis and Sendov, SIAM J. Matrix Anal. Appl. 23, 2001, 368),

    df   = sum_a f_a h_aa
    d^2f = sum_ab f_ab h_aa h_bb + sum_a!=b (f_a - f_b) / (lambda_a - lambda_b) h_ab^2.
"""

from typing import NamedTuple

import numpy as np

from cases.units import Array
from identification.criteria import Criterion
from planner.families.states import SHARE, States

EQUAL = 1e-7  # relative difference of eigenvalues below which their quotient is taken as the derivative


class Local(NamedTuple):
    """A criterion, to be minimised and of order one, near an information matrix."""

    # A: log(trace F^-1 / u); D: -log det F / u; K: log of mu_1 / mu_u; N: log of mu_1 / mu_u^2. Not a number where F is
    # not positive definite
    value: float
    eigenvalues: Array  # of F, ascending, shape (u,)
    vectors: Array  # eigenvectors of F, one a column, shape (u, u)
    first: Array  # derivatives by the eigenvalues, shape (u,)
    second: Array  # second derivatives by the eigenvalues, shape (u, u)

    @property
    def slope(self) -> Array:
        """Derivative by F, shape (u, u), symmetric."""
        return np.asarray((self.vectors * self.first) @ self.vectors.T)

    @property
    def quotients(self) -> Array:
        """(f_a - f_b) / (lambda_a - lambda_b), shape (u, u), where both eigenvalues are equal its limit."""
        difference = self.eigenvalues[:, None] - self.eigenvalues[None, :]
        equal = np.abs(difference) <= EQUAL * self.eigenvalues
        own = np.diag(self.second)[:, None] - self.second
        return np.where(equal, own, (self.first[:, None] - self.first) / np.where(equal, 1.0, difference))


def criterion_at(letter: Criterion, information: Array, halvings: int = 0) -> Local:
    """The criterion and its derivatives.

    Args:
        information: F, shape (u, u).
        halvings: exponent of the p-norms of K and N, p = 2^(halvings + 1).
    """
    size = len(information)
    nothing = np.full((size, size), np.nan)
    if not np.isfinite(information).all():
        return Local(np.nan, nothing[0], nothing, nothing[0], nothing)
    eigenvalues, vectors = np.linalg.eigh(information)
    if eigenvalues[0] <= 0.0:
        return Local(np.nan, eigenvalues, vectors, nothing[0], nothing)
    if letter == Criterion.D:
        value = -float(np.log(eigenvalues).mean())
        return Local(value, eigenvalues, vectors, -1 / eigenvalues / size, np.diag(1 / eigenvalues**2) / size)
    if letter == Criterion.A:
        inverse = _log_norm(eigenvalues, vectors, -1.0)
        return inverse._replace(value=-inverse.value - np.log(size), first=-inverse.first, second=-inverse.second)
    largest, smallest = (_log_norm(eigenvalues, vectors, sign * 2.0 ** (halvings + 1)) for sign in (1, -1))
    share = 0.5 if letter == Criterion.K else 1.0
    return largest._replace(
        value=largest.value / 2 - share * smallest.value,
        first=largest.first / 2 - share * smallest.first,
        second=largest.second / 2 - share * smallest.second,
    )


def _log_norm(eigenvalues: Array, vectors: Array, exponent: float) -> Local:
    """Log (sum lambda^p) / p; p below zero: of the inverse's p-norm, with its sign."""
    logs = exponent * np.log(eigenvalues)
    weights = np.exp(logs - logs.max())
    total = weights.sum()
    weights /= total
    shares = weights / eigenvalues
    second = np.diag((exponent - 1) * shares / eigenvalues) - exponent * np.outer(shares, shares)
    return Local(float(np.log(total) + logs.max()) / exponent, eigenvalues, vectors, shares, second)


class InformationOfStates(NamedTuple):
    """An information matrix F and its derivatives by K states: dF = share (A^T slopes + slopes^T A)."""

    states: Array  # shape (K, d)
    regressors: Array  # A of (21) at each, row by row, shape (K, 6 u)
    slopes: Array  # their slopes by the components of the state, shape (K, d, 6 u)
    information: Array  # F, shape (u, u)


def weighted_square(states: Array, regressors: Array, size: int) -> Array:
    """Mean of A^T A over states, shape (u, u)."""
    weighted = (regressors * states[:, SHARE, None]).reshape(-1, size)  # shares of moves may be negative on the way
    return np.asarray(weighted.T @ regressors.reshape(-1, size))


def curvature_through_information(
    states: States, unknowns: Array, local: Local, point: InformationOfStates, count: int
) -> Array:
    """Second derivative of a criterion through the information by all `count` unknowns, shape (count, count)."""
    from scipy.sparse import csr_array

    size, index, slopes = len(point.information), states.index, states.slopes(unknowns)
    blocks, width = index.shape
    shares = point.states[:, SHARE, None, None]
    # In the eigenvectors of F: what each unknown of a block adds to F, from all of the block's states at once.
    projections = (point.regressors.reshape(-1, size) @ local.vectors).reshape(len(shares), -1)
    turned_slopes = (point.slopes.reshape(-1, size) @ local.vectors).reshape(*point.slopes.shape)
    flat_slopes = slopes.reshape(len(shares), -1, width)
    own = (flat_slopes.transpose(0, 2, 1) @ turned_slopes) * shares
    own = own.reshape(blocks, -1, width, projections.shape[1] // size, size).transpose(0, 2, 1, 3, 4)
    own = own.reshape(blocks, width, -1, size)
    rows = projections.reshape(blocks, 1, -1, size)
    products = (rows.transpose(0, 1, 3, 2) @ own).reshape(blocks, width, -1)
    upper, lower = np.triu_indices(size)
    elements = products[:, :, upper * size + lower] + products[:, :, lower * size + upper]
    if flat_slopes[:, SHARE].any():
        matrices = projections.reshape(len(shares), -1, size)
        squares = (matrices.transpose(0, 2, 1) @ matrices).reshape(blocks, -1, size * size)
        lengths = slopes[:, :, SHARE].transpose(0, 2, 1)
        elements += lengths @ squares[:, :, upper * size + lower]
    flat = index.ravel()
    spread = csr_array((np.ones(len(flat)), (flat, np.arange(len(flat)))), shape=(count, len(flat)))
    through = spread @ elements.reshape(-1, len(upper))
    diagonal = upper == lower
    weights = np.where(diagonal, 0.0, 2.0 * local.quotients[upper, lower])  # above the diagonal: each for two
    main = through[:, diagonal]
    return np.asarray((through * weights) @ through.T + main @ local.second @ main.T)
