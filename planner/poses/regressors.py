"""What each pose tells: its scaled regressor, and sums of information over poses."""

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from identification.model import Model

Array = NDArray[np.float64]


def pose_regressors(model: Model, poses: Array) -> Array:
    """A of (21) standing still at each pose, shape (n, 6, u).

    Args:
        model: without inertia.
        poses: shape (n, 6) [m, rad].

    Raises:
        IdentificationError: the model has parameters that no standstill can excite.
    """
    if model.needs_motion:
        raise IdentificationError(
            f"model {model.number} contains inertia, which standstills cannot excite; choose a model from 0 to 5"
        )
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
            f"(rank {rank} of {rows.shape[1]}); choose a model without them"
        )
