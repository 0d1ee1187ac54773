"""Log det of an information matrix as a CasADi function."""

import casadi as ca


def _lower(size: int) -> ca.Sparsity:
    return ca.Sparsity.lower(size)


def log_determinant(size: int) -> ca.Function:
    """Lower triangle of a positive definite matrix -> log det, by Cholesky factors (CasADi has no logdet)."""
    triangle = ca.SX.sym("triangle", _lower(size).nnz())
    lower = ca.SX(_lower(size), triangle)
    full = lower + lower.T - ca.diag(ca.diag(lower))
    return ca.Function("log_determinant", [triangle], [2 * ca.sum1(ca.log(ca.diag(ca.chol(full))))])
