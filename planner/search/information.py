"""Information of a motion as CasADi functions: what each sample adds to F = A^T A, and log det of the sum."""

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from identification.model import Model

Array = NDArray[np.float64]


def _lower(size: int) -> ca.Sparsity:
    return ca.Sparsity.lower(size)


def sample_information(model: Model, scaling: Array) -> ca.Function:
    """(pose, rates, accelerations) -> lower triangle of H A^T A H of one sample, column by column, shape (u (u+1)/2,).

    Args:
        model: gives A (21).
        scaling: diagonal of H (25), shape (u,).
    """
    pose, rates, accelerations = (ca.SX.sym(n, 6) for n in ("pose", "rates", "accelerations"))
    scaled = model.coordinate_regressor(pose, rates, accelerations) @ ca.diag(ca.DM(scaling))
    product = ca.densify(scaled.T @ scaled)
    return ca.Function(
        "sample_information",
        [pose, rates, accelerations],
        [product[_lower(len(scaling)).find()]],
        {"cse": True},
    )


def log_determinant(size: int) -> ca.Function:
    """Lower triangle of a positive definite matrix -> log det, by Cholesky factors (CasADi has no logdet)."""
    triangle = ca.SX.sym("triangle", _lower(size).nnz())
    lower = ca.SX(_lower(size), triangle)
    full = lower + lower.T - ca.diag(ca.diag(lower))
    return ca.Function("log_determinant", [triangle], [2 * ca.sum1(ca.log(ca.diag(ca.chol(full))))])
