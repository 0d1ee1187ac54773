"""Criteria A, D, K, N of Table 4 for sets of poses: exact values after a removal or an addition, and cheap bounds.

With F the sum of A^T A over the set, all in one scaling, each criterion is a value that is better the larger it is. A
`Screen` bounds from above what the value can be after the removal of each pose, in O(1) a pose and step: Algorithm 1
then evaluates only poses that can still be the best, and removes the same ones as if it evaluated all.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from identification.criteria import Criterion
from identification.model import Model
from identification.motion import Array
from identification.symbolic import over_samples


def pose_regressors(model: Model, poses: Array) -> Array:
    """Regressors A of (21) for standing still at each pose, shape (n, 6, u).

    Args:
        poses: coordinates of the machine, shape (n, k) [m or rad].

    Raises:
        IdentificationError: the model has parameters that standstills cannot excite.
    """
    if model.needs_motion:
        raise IdentificationError(
            f"model {model.number} contains inertia, which standstills cannot excite; choose a model from 0 to 5"
        )
    return over_samples(model.coordinate_regressor, poses, 0.0 * poses, 0.0 * poses)[0]


def candidate_scaling(regressors: Array) -> Array:
    """Reference scaling of pose sets: one over the RMS of each column over the candidates, shape (u,).

    A column of zeros has the scale 1.
    """
    mean_square = np.mean(np.sum(regressors**2, axis=1), axis=0)
    return np.asarray(1.0 / np.sqrt(np.where(mean_square > 0.0, mean_square, 1.0)))


def total_information(regressors: Array) -> Array:
    """Sum of A^T A over poses, shape (u, u)."""
    rows = regressors.reshape(-1, regressors.shape[2])
    return np.asarray(rows.T @ rows)


Index = NDArray[np.int64]


Screen = tuple[Callable[[Array], Array], Callable[[Array, Index, Array], None]]
"""Upper bounds of a criterion after the removal of each of n poses, valid while poses are removed.

The first function gives the bound of each pose, shape (n,), at an information, shape (u, u). The second records
exact values, shape (rows,), of some poses at an information; most bounds do not sharpen by them.
"""


@dataclass(frozen=True, slots=True)
class PoseCriterion:
    """A criterion of pose sets."""

    letter: Criterion  # of Table 4
    value: Callable[[Array], Array]  # of one or more informations, shape (..., u, u) -> (...); -inf where singular
    # information and regressors, shape (k, 6, u) -> value without each pose, F - A_j^T A_j, shape (k,)
    after_removal: Callable[[Array, Array], Array]
    # regressors of n poses and information -> a new screen: nearly exact for these, valid for all subsets
    screen: Callable[[Array, Array], Screen]


def _forgets(information: Array, rows: Index, values: Array) -> None:
    """The second function of a screen that does not sharpen."""


def _products(regressors: Array) -> Array:
    return np.asarray(regressors.transpose(0, 2, 1) @ regressors)


def _eigenvalues(information: Array) -> Array:
    """Eigenvalues, ascending; those that are negative by rounding are 0."""
    return np.asarray(np.maximum(np.linalg.eigvalsh(information), 0.0))


def _leverage(information: Array, regressors: Array) -> tuple[Array, Array]:
    """Y_j = A_j F^-1, and A_j F^-1 A_j^T, shapes (k, 6, u) and (k, 6, 6)."""
    inverse = np.linalg.inv(information)
    weighted = (regressors.reshape(-1, len(inverse)) @ inverse).reshape(regressors.shape)
    return weighted, weighted @ regressors.transpose(0, 2, 1)


def _log_det(information: Array) -> Array:
    """Log det F (31), -inf where singular."""
    sign, logdet = np.linalg.slogdet(information)
    return np.where(sign > 0, logdet, -np.inf)


def _log_det_after(information: Array, regressors: Array) -> Array:
    """Log det F + log det(1 - A F^-1 A^T)."""
    return _log_det(information) + _log_det(np.eye(6) - _leverage(information, regressors)[1])


def _log_det_screen(regressors: Array, information: Array) -> Screen:
    """Screen of criterion D: losses only grow while poses are removed, so that an old loss bounds the present one."""
    gains = _log_det_after(information, regressors) - _log_det(information)

    def learn(information: Array, rows: Index, values: Array) -> None:
        gains[rows] = values - _log_det(information)

    return lambda information: np.asarray(_log_det(information) + gains), learn


def _minus_trace(information: Array) -> Array:
    """-trace F^-1 (30), minus the sum of the variances, -inf where singular."""
    values = _eigenvalues(information)
    with np.errstate(divide="ignore"):
        return np.asarray(-np.sum(1.0 / values, axis=-1))


def _minus_trace_after(information: Array, regressors: Array) -> Array:
    """-trace F^-1 - trace((1 - A F^-1 A^T)^-1 A F^-2 A^T)."""
    weighted, leverage = _leverage(information, regressors)
    try:
        solved = np.linalg.solve(np.eye(6) - leverage, weighted)
    except np.linalg.LinAlgError:  # one of them loses rank exactly
        return _minus_trace(information - _products(regressors))
    loss = np.einsum("nkl,nkl->n", solved, weighted)
    # Losses are positive; where rank is lost, rounding decides their sign.
    return np.asarray(_minus_trace(information) - np.where(loss > 0.0, loss, np.inf))


def _minus_trace_screen(regressors: Array, information: Array) -> Screen:
    """Screen of criterion A: trace M^-1 >= 2 trace X - trace X M X for symmetric X, here the inverse at its start."""
    inverse: Array = np.asarray(np.linalg.inv(information), dtype=np.float64)
    rows = (regressors.reshape(-1, len(inverse)) @ inverse).reshape(len(regressors), -1)
    seen = np.einsum("nk,nk->n", rows, rows)

    def upper(information: Array) -> Array:
        common = 2.0 * np.trace(inverse) - np.sum((inverse @ information) * inverse)
        return np.asarray(-(common + seen))

    return upper, _forgets


def _of_extremes(letter: Criterion, of: Callable[[Array, Array], Array]) -> PoseCriterion:
    """The criterion of the smallest and the largest eigenvalue of F, `of` both."""

    def value(information: Array) -> Array:
        values = _eigenvalues(information)
        return of(values[..., 0], values[..., -1])

    def screen(regressors: Array, information: Array) -> Screen:
        """Screen by Ritz values in the two lowest and the two highest eigenvectors at its start."""
        directions = np.linalg.eigh(information)[1][:, [0, 1, -2, -1]]
        seen = (regressors.reshape(-1, len(directions)) @ directions).reshape(len(regressors), 6, 4)
        products = np.einsum("nki,nkj->ijn", seen, seen)

        def upper(information: Array) -> Array:
            left = (directions.T @ information @ directions)[:, :, None] - products
            low = _outer_eigenvalue(left[0, 0], left[0, 1], left[1, 1], -1.0)
            high = _outer_eigenvalue(left[2, 2], left[2, 3], left[3, 3], 1.0)
            return of(np.maximum(low, 0.0), np.maximum(high, 0.0))

        return upper, _forgets

    return PoseCriterion(letter, value, lambda information, rows: value(information - _products(rows)), screen)


def _outer_eigenvalue(a: Array, b: Array, c: Array, side: float) -> Array:
    """Lower (side -1) or upper (side 1) eigenvalue of [[a, b], [b, c]]."""
    half = (a - c) / 2
    return np.asarray((a + c) / 2 + side * np.sqrt(half * half + b * b))


def _minus_condition(smallest: Array, largest: Array) -> Array:
    """-mu_1 / mu_u (32)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(smallest > 0.0, -np.sqrt(largest / smallest), -np.inf)


def _noise_amplification(smallest: Array, largest: Array) -> Array:
    """mu_u^2 / mu_1 (33); -inf where the smallest eigenvalue is 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(smallest > 0.0, smallest / np.sqrt(largest), -np.inf)


POSE_CRITERIA: dict[str, PoseCriterion] = {
    c.letter: c
    for c in (
        PoseCriterion(Criterion.A, _minus_trace, _minus_trace_after, _minus_trace_screen),
        PoseCriterion(Criterion.D, _log_det, _log_det_after, _log_det_screen),
        _of_extremes(Criterion.K, _minus_condition),
        _of_extremes(Criterion.N, _noise_amplification),
    )
}
