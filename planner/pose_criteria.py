"""Criteria A, D, K, N of Table 4 for sets of poses.

With F the sum of A^T A over the set, all in one scaling, each criterion is a value that is better the larger it is.
"""

from dataclasses import dataclass

import numpy as np

from cases.errors import IdentificationError
from identification.criteria import Criterion
from identification.model import Model
from identification.motion import Array
from identification.symbolic import over_samples


def pose_regressors(model: Model, poses: Array) -> Array:
    """Regressors A of (21) for standing still at coordinates, shape (n, k) [m or rad], shape (n, 6, u).

    Raises IdentificationError where the model has parameters that standstills cannot excite.
    """
    if model.needs_motion:
        raise IdentificationError(
            f"model {model.number} contains inertia, which standstills cannot excite; choose a model from 0 to 5"
        )
    return over_samples(model.coordinate_regressor, poses, 0.0 * poses, 0.0 * poses)[0]


def candidate_scaling(regressors: Array) -> Array:
    """Reference scaling of pose sets: one over the RMS of each column over the candidates, or 1, shape (u,)."""
    mean_square = np.mean(np.sum(regressors**2, axis=1), axis=0)
    return np.asarray(1.0 / np.sqrt(np.where(mean_square > 0.0, mean_square, 1.0)))


def total_information(regressors: Array) -> Array:
    """Sum of A^T A over poses, shape (u, u)."""
    rows = regressors.reshape(-1, regressors.shape[2])
    return np.asarray(rows.T @ rows)


@dataclass(frozen=True, slots=True)
class PoseCriterion:
    """A criterion of pose sets."""

    letter: Criterion  # of Table 4

    @property
    def losses_grow(self) -> bool:
        """Whether a pose costs the more, the fewer others are left."""
        return self.letter is Criterion.D

    def value(self, information: Array) -> Array:
        """Criterion (30) to (33) of one or more informations, shape (..., u, u) -> (...); -inf where singular."""
        if self.letter is Criterion.D:
            return _log_det(information)
        values = np.maximum(np.linalg.eigvalsh(information), 0.0)  # mu^2, ascending
        smallest, largest = values[..., 0], values[..., -1]
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.letter is Criterion.A:
                found = -np.sum(1.0 / values, axis=-1)
            else:
                found = -np.sqrt(largest / smallest) if self.letter is Criterion.K else smallest / np.sqrt(largest)
        return np.where(smallest > 0.0, found, -np.inf)

    def after_removal(self, information: Array, regressors: Array) -> Array:
        """Value without each pose, F - A_j^T A_j, shape (k,), of its regressors A_j, shape (k, 6, u)."""
        if self.letter is not Criterion.D:
            return self.value(information - regressors.transpose(0, 2, 1) @ regressors)
        weighted = (regressors.reshape(-1, len(information)) @ np.linalg.inv(information)).reshape(regressors.shape)
        left = np.eye(6) - weighted @ regressors.transpose(0, 2, 1)  # log det F + log det(1 - A F^-1 A^T)
        return np.asarray(_log_det(information) + _log_det(left))


def _log_det(matrices: Array) -> Array:
    sign, logdet = np.linalg.slogdet(matrices)
    return np.where(sign > 0, logdet, -np.inf)


POSE_CRITERIA: dict[str, PoseCriterion] = {letter: PoseCriterion(letter) for letter in Criterion}
