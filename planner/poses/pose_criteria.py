"""Criteria A, D, K, N of Table 4 for sets of poses: exact values after a removal or an addition, and cheap bounds.

With F the sum of A^T A over the set, all in one scaling, each criterion is a value that is better the larger it is. A
`Screen` bounds from above what the value can be after the removal of each pose, in O(1) a pose and step: Algorithm 1
then evaluates only poses that can still be the best, and removes the same ones as if it evaluated all.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from identification.model import Model
from identification.symbolic import over_samples

Array = NDArray[np.float64]


def pose_regressors(model: Model, poses: Array) -> Array:
    """A of (21) standing still at each pose, shape (n, 6, u).

    Args:
        poses: coordinates of the machine, shape (n, k) [m or rad].

    Raises:
        IdentificationError: the model has parameters that no standstill can excite.
    """
    if model.needs_motion:
        raise IdentificationError(
            f"model {model.number} contains inertia, which standstills cannot excite; choose a model from 0 to 5"
        )
    if model.machine is not None and not model.machine.of_pose:
        return over_samples(model.coordinate_regressor, poses, 0.0 * poses, 0.0 * poses)[0]
    from scipy.spatial.transform import Rotation  # here: reading a plan does without it, and it loads slowly

    still = np.zeros((len(poses), 6))
    rotations = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()
    return model.matrices(poses[:, :3], rotations, still, still)


def candidate_scaling(regressors: Array) -> Array:
    """Reference scaling of pose sets: one over the RMS of each column over the candidates, shape (u,).

    A column of zeros keeps the scale 1.
    """
    mean_square = np.mean(np.sum(regressors**2, axis=1), axis=0)
    return np.asarray(np.where(mean_square > 0.0, 1.0 / np.sqrt(np.where(mean_square > 0.0, mean_square, 1.0)), 1.0))


def total_information(regressors: Array) -> Array:
    """Sum of A^T A over poses, shape (u, u)."""
    rows = regressors.reshape(-1, regressors.shape[2])
    return np.asarray(rows.T @ rows)


def require_full_rank(regressors: Array, model: Model) -> None:
    """Raises IdentificationError, naming the parameters, where poses, shape (n, 6, u), do not determine the model."""
    rows = regressors.reshape(-1, regressors.shape[2])
    singular, directions = (
        np.linalg.svd(rows, full_matrices=True)[1:]
        if len(rows) < 60
        else np.linalg.svd(np.linalg.qr(rows, mode="r"))[1:]
    )
    zero = len(rows) * np.finfo(float).eps * singular[0]
    rank = int(np.sum(singular > zero))
    if rank < rows.shape[1]:
        share = np.abs(directions[rank:]).max(axis=0)
        hidden = [n for n, s in zip(model.names, share, strict=True) if s > 1e-3]
        raise IdentificationError(
            f"model {model.number}: {', '.join(hidden)} cannot be told apart by any of {len(regressors)} poses "
            f"(rank {rank} of {rows.shape[1]}); let them turn about more axes, or choose a model without them"
        )


Index = NDArray[np.int64]


class Screen(NamedTuple):
    """Upper bounds of a criterion after the removal of each of n poses, valid while poses are removed."""

    upper: Callable[[Array], Array]  # information, shape (u, u) -> bound for each pose, shape (n,)
    # takes note of exact values, shape (rows,), of some poses at an information; most bounds do not sharpen by them
    learn: Callable[[Array, Index, Array], None] = lambda information, rows, values: None


class PoseCriterion(Protocol):
    """A criterion of pose sets."""

    @property
    def letter(self) -> str:
        """In Table 4."""
        ...

    def value(self, information: Array) -> Array:
        """Value of one or more informations, shape (..., u, u) -> (...); -inf where singular."""
        ...

    def after_removal(self, information: Array, regressors: Array) -> Array:
        """Value without each pose: F - A_j^T A_j, shape (k, 6, u) -> (k,)."""
        ...

    def screen(self, regressors: Array, information: Array) -> Screen:
        """A fresh screen of n poses, shape (n, 6, u): nearly exact for `information`, valid for what removals leave."""
        ...


def _products(regressors: Array) -> Array:
    return np.asarray(regressors.transpose(0, 2, 1) @ regressors)


def _eigenvalues(information: Array) -> Array:
    """Ascending; what rounding makes negative is 0."""
    return np.asarray(np.maximum(np.linalg.eigvalsh(information), 0.0))


def _leverage(information: Array, regressors: Array) -> tuple[Array, Array]:
    """Y_j = A_j F^-1, and A_j F^-1 A_j^T, shapes (k, 6, u) and (k, 6, 6)."""
    inverse = np.linalg.inv(information)
    weighted = (regressors.reshape(-1, len(inverse)) @ inverse).reshape(regressors.shape)
    return weighted, weighted @ regressors.transpose(0, 2, 1)


class DOptimal:
    """Log det F (31)."""

    letter = "D"

    def value(self, information: Array) -> Array:
        """Log det, -inf where singular."""
        sign, logdet = np.linalg.slogdet(information)
        return np.where(sign > 0, logdet, -np.inf)

    def after_removal(self, information: Array, regressors: Array) -> Array:
        """Log det F + log det(1 - A F^-1 A^T)."""
        return self.value(information) + self.value(np.eye(6) - _leverage(information, regressors)[1])

    def screen(self, regressors: Array, information: Array) -> Screen:
        """Losses only grow while poses are removed: an old loss bounds the present one."""
        gains = self.after_removal(information, regressors) - self.value(information)

        def learn(information: Array, rows: Index, values: Array) -> None:
            gains[rows] = values - self.value(information)

        return Screen(lambda information: np.asarray(self.value(information) + gains), learn)


class AOptimal:
    """-trace F^-1 (30)."""

    letter = "A"

    def value(self, information: Array) -> Array:
        """Minus the sum of the variances, -inf where singular."""
        values = _eigenvalues(information)
        with np.errstate(divide="ignore"):
            return np.asarray(-np.sum(1.0 / values, axis=-1))

    def after_removal(self, information: Array, regressors: Array) -> Array:
        """-trace F^-1 - trace((1 - A F^-1 A^T)^-1 A F^-2 A^T)."""
        weighted, leverage = _leverage(information, regressors)
        try:
            solved = np.linalg.solve(np.eye(6) - leverage, weighted)
        except np.linalg.LinAlgError:  # one of them loses rank exactly
            return self.value(information - _products(regressors))
        loss = np.einsum("nkl,nkl->n", solved, weighted)
        # Losses are positive; where rank is lost, rounding decides their sign.
        return np.asarray(self.value(information) - np.where(loss > 0.0, loss, np.inf))

    def screen(self, regressors: Array, information: Array) -> Screen:
        """Trace M^-1 >= 2 trace X - trace X M X for every symmetric X; X is the inverse when the screen was made."""
        inverse: Array = np.asarray(np.linalg.inv(information), dtype=np.float64)
        rows = (regressors.reshape(-1, len(inverse)) @ inverse).reshape(len(regressors), -1)
        seen = np.einsum("nk,nk->n", rows, rows)

        def upper(information: Array) -> Array:
            common = 2.0 * np.trace(inverse) - np.sum((inverse @ information) * inverse)
            return np.asarray(-(common + seen))

        return Screen(upper)


@dataclass(frozen=True, slots=True)
class Extremes:
    """Criterion of the smallest and the largest eigenvalue of F."""

    letter: str
    of: Callable[[Array, Array], Array]  # value from both

    def value(self, information: Array) -> Array:
        """Value, -inf where singular."""
        values = _eigenvalues(information)
        return self.of(values[..., 0], values[..., -1])

    def after_removal(self, information: Array, regressors: Array) -> Array:
        """From the eigenvalues of F - A^T A."""
        return self.value(information - _products(regressors))

    def screen(self, regressors: Array, information: Array) -> Screen:
        """Ritz values in the two lowest and the two highest eigenvectors when the screen was made."""
        directions = np.linalg.eigh(information)[1][:, [0, 1, -2, -1]]
        seen = (regressors.reshape(-1, len(directions)) @ directions).reshape(len(regressors), 6, 4)
        pairs = ((0, 0), (0, 1), (1, 1), (2, 2), (2, 3), (3, 3))
        products = np.array([np.einsum("nk,nk->n", seen[:, :, i], seen[:, :, j]) for i, j in pairs])

        def upper(information: Array) -> Array:
            whole = directions.T @ information @ directions
            low = _outer_eigenvalue(
                whole[0, 0] - products[0], whole[0, 1] - products[1], whole[1, 1] - products[2], -1.0
            )
            high = _outer_eigenvalue(
                whole[2, 2] - products[3], whole[2, 3] - products[4], whole[3, 3] - products[5], 1.0
            )
            return self.of(np.maximum(low, 0.0), np.maximum(high, 0.0))

        return Screen(upper)


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
    c.letter: c for c in (AOptimal(), DOptimal(), Extremes("K", _minus_condition), Extremes("N", _noise_amplification))
}
