"""The objective of a search: the criteria of Table 4 as smooth functions of an information matrix, twice derived.

A and D are exact. K and N contain the largest and the smallest eigenvalue, which have no derivative where eigenvalues
meet; they are replaced by p-norms, max <= (sum lambda^p)^(1/p) <= u^(1/p) max, and rated exactly afterwards.

Every criterion is a function of the eigenvalues of F alone. With f_a and f_ab its derivatives by them, and
h = U^T dF U in the eigenvectors U of F (Lewis and Sendov, SIAM J. Matrix Anal. Appl. 23, 2001, 368),

    df   = sum_a f_a h_aa
    d^2f = sum_ab f_ab h_aa h_bb + sum_a!=b (f_a - f_b) / (lambda_a - lambda_b) h_ab^2.

Where sensors have errors of the pose, F is the information that these leave, by the states of a motion: with y = A X,
X = M^-1 F, and r = R X, R_i = sum_j C_ij w_j A_j (see `planner.noise`), a change dA of the regressor of state i, of
share w_i, and a change dC of its correlations change S = F M^-1 F by w_i (B + B^T), where
B = y^T (dA - h) + (A - y - r)^T dA X and h = sum_j dC_ij w_j A_j X: a product of rows with slopes, like that of F.
"""

from typing import NamedTuple

import casadi as ca
import numpy as np

from cases.base.units import Array
from identification.estimation.criteria import Criterion
from identification.estimation.pose_field import squared_distances
from planner.families.states import SHARE, Kernel, States, state_size
from planner.noise import PoseErrors

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
    """An information matrix S and its derivatives by K states: dS = share (rows^T slopes + slopes^T rows)."""

    states: Array  # shape (K, d)
    regressors: Array  # A of (21) at each, row by row, shape (K, 6 u)
    changes: Array  # their slopes by the components of the state, shape (K, d, 6 u)
    information: Array  # S, shape (u, u)
    rows: Array  # shape (K, r u)
    slopes: Array  # slopes by the components of the state, shape (K, d, r u)
    own: Array  # dS/d share = (rows^T own + own^T rows) / 2, shape (K, r u)

    @classmethod
    def white(cls, states: Array, regressors: Array, changes: Array, size: int) -> "InformationOfStates":
        """Information of u = `size` parameters, where nothing but white noise counts."""
        square = weighted_square(states, regressors, size)
        return cls(states, regressors, changes, square, regressors, changes, regressors)


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
    projections = (point.rows.reshape(-1, size) @ local.vectors).reshape(len(shares), -1)
    turned_slopes = (point.slopes.reshape(-1, size) @ local.vectors).reshape(*point.slopes.shape)
    flat_slopes = slopes.reshape(len(shares), -1, width)
    curvature = (flat_slopes.transpose(0, 2, 1) @ turned_slopes) * shares
    curvature = curvature.reshape(blocks, -1, width, projections.shape[1] // size, size).transpose(0, 2, 1, 3, 4)
    curvature = curvature.reshape(blocks, width, -1, size)
    rows = projections.reshape(blocks, 1, -1, size)
    products = (rows.transpose(0, 1, 3, 2) @ curvature).reshape(blocks, width, -1)
    upper, lower = np.triu_indices(size)
    elements = products[:, :, upper * size + lower] + products[:, :, lower * size + upper]
    if flat_slopes[:, SHARE].any():
        right = left = projections.reshape(len(shares), -1, size)
        if point.own is not point.rows:
            right = (point.own.reshape(-1, size) @ local.vectors).reshape(left.shape)
        squares = left.transpose(0, 2, 1) @ right
        if point.own is not point.rows:
            squares = (squares + squares.transpose(0, 2, 1)) / 2.0
        squares = squares.reshape(blocks, -1, size * size)
        lengths = slopes[:, :, SHARE].transpose(0, 2, 1)
        elements += lengths @ squares[:, :, upper * size + lower]
    flat = index.ravel()
    spread = csr_array((np.ones(len(flat)), (flat, np.arange(len(flat)))), shape=(count, len(flat)))
    through = spread @ elements.reshape(-1, len(upper))
    diagonal = upper == lower
    weights = np.where(diagonal, 0.0, 2.0 * local.quotients[upper, lower])  # above the diagonal: each for two
    main = through[:, diagonal]
    return np.asarray((through * weights) @ through.T + main @ local.second @ main.T)


class FieldByStates:
    """Errors of the pose at the states of a motion that lasts for `duration` [s]."""

    def __init__(self, errors: PoseErrors, duration: float) -> None:
        state = ca.SX.sym("state", state_size(6))
        self.errors, self.gain = errors, errors.rate * duration
        self.struts = Kernel(state, errors.hexapod.inverse(state[:6]))

    def _parts(self, states: Array, regressors: Array, struts: Array) -> tuple[Array, Array, Array, Array, Array]:
        """A, w Q A (Q mixes channels) and R of K states, shapes (K, 6, u), X and S, shapes (u, u).

        X and S are not a number where M is singular: the solver then steps back.
        """
        shares = states[:, SHARE, None, None]
        matrices = regressors.reshape(len(states), 6, -1)
        weighted_rows = matrices * shares
        mixed = weighted_rows if self.errors.mixing is None else self.errors.mixing @ weighted_rows
        answer = self.errors.correlation(struts, struts) @ mixed.reshape(len(states), -1)
        answer = self.gain * answer.reshape(matrices.shape)
        scatter = np.tensordot(weighted_rows, matrices + answer, ((0, 1), (0, 1)))
        plain = np.tensordot(weighted_rows, matrices, ((0, 1), (0, 1)))
        try:
            turn = np.linalg.solve(scatter, plain)
        except np.linalg.LinAlgError:
            turn = np.full(plain.shape, np.nan)
        information = plain @ turn
        return matrices, mixed, answer, np.asarray(turn), np.asarray((information + information.T) / 2.0)

    def information(self, states: Array, regressors: Array) -> Array:
        """S, shape (u, u), of states, shape (K, d), and A, shape (K, 6 u)."""
        return self._parts(states, regressors, self.struts.values(states))[-1]

    def with_slopes(self, states: Array, regressors: Array, slopes: Array) -> InformationOfStates:
        """S and its derivatives; arguments as in `information`, and slopes of A by the states, shape (K, d, 6 u)."""
        struts, ways = self.struts.slopes(states)
        matrices, mixed, answer, turn, information = self._parts(states, regressors, struts)
        y, rotated_answer = matrices @ turn, answer @ turn
        slopes_by_sensor = slopes.reshape(*slopes.shape[:2], 6, -1)
        shifted = slopes_by_sensor - (ways @ self._pulled(struts, mixed @ turn)).reshape(slopes_by_sensor.shape)
        flat = (len(states), -1)
        return InformationOfStates(
            states,
            regressors,
            slopes,
            information,
            np.concatenate([y, matrices - y - rotated_answer], axis=1).reshape(flat),
            np.concatenate([shifted, slopes_by_sensor @ turn], axis=2).reshape(*slopes.shape[:2], -1),
            np.concatenate([2.0 * (matrices - rotated_answer) - y, np.zeros_like(y)], axis=1).reshape(flat),
        )

    def _pulled(self, struts: Array, answer: Array) -> Array:
        """Sum over j of dC_ij/dl_i times answer_j, by each strut, shape (K, 6, 6 u)."""
        length, flat = self.errors.field.length, answer.reshape(len(answer), -1)
        distance = np.sqrt(squared_distances(struts, struts)) / length
        kernel = -3.0 * self.gain / length**2 * np.exp(-np.sqrt(3.0) * distance)
        whole = kernel @ flat
        return np.stack([struts[:, k, None] * whole - kernel @ (struts[:, k, None] * flat) for k in range(6)], axis=1)
