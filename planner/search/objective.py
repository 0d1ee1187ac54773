"""The criteria of Table 4 as CasADi functions of an information matrix, smooth enough for gradient methods.

A and D are exact. K and N contain the largest and the smallest eigenvalue, which have no derivative where eigenvalues
meet; they are replaced by p-norms, max <= (sum lambda^p)^(1/p) <= u^(1/p) max, and rated exactly afterwards.
"""

import casadi as ca

EXACT = 0  # sharpness of criteria that need no p-norm


def _full(triangle: ca.SX, size: int) -> ca.SX:
    lower = ca.SX(ca.Sparsity.lower(size), triangle)
    return lower + lower.T - ca.diag(ca.diag(lower))


def _factor(matrix: ca.SX) -> ca.SX:
    """L of a positive definite matrix, L L^T."""
    return ca.chol(matrix).T


def _inverse_factor(lower: ca.SX) -> ca.SX:
    """L^-1, by forward substitution."""
    size = lower.shape[0]
    inverse = ca.SX.zeros(size, size)
    for column in range(size):
        inverse[column, column] = 1 / lower[column, column]
        for row in range(column + 1, size):
            done = ca.dot(lower[row, column:row], inverse[column:row, column].T)
            inverse[row, column] = -done / lower[row, row]
    return inverse


def _log_norm(matrix: ca.MX, halvings: int) -> ca.MX:
    """Log of the p-norm of the eigenvalues of a positive definite matrix, p = 2^(halvings + 1): at least the largest.

    trace(M^p) is the squared Frobenius norm of M^(p/2), which comes from squaring; each power is divided by its
    trace so that nothing overflows. In MX a product is one operation, with a derivative of two: written out element by
    element the powers take four times as long, to build and to evaluate.
    """
    log_scale, power = ca.MX(0), matrix
    exponent = 1
    for _ in range(halvings):
        trace = ca.trace(power)
        log_scale += ca.log(trace) / exponent
        power = power / trace
        power = power @ power
        exponent *= 2
    return log_scale + ca.log(ca.sumsqr(power)) / (2 * exponent)


def objective(letter: str, size: int, halvings: int = EXACT) -> ca.Function:
    """Lower triangle of F (u (u+1)/2 numbers, column by column) -> what to minimise, of order one and smooth.

    Args:
        letter: A: log(trace F^-1 / u); D: -log det F / u; K: log of mu_1 / mu_u; N: log of mu_1 / mu_u^2.
        size: u.
        halvings: of K and N: p = 2^(halvings + 1).
    """
    triangle = ca.SX.sym("triangle", ca.Sparsity.lower(size).nnz())
    full = _full(triangle, size)
    lower = _factor(full)
    if letter == "D":
        return _of_triangle(triangle, -2 * ca.sum1(ca.log(ca.diag(lower))) / size)
    inverse_factor = _inverse_factor(lower)
    if letter == "A":
        return _of_triangle(triangle, ca.log(ca.sum1(ca.vec(inverse_factor**2)) / size))
    inverse = ca.densify(inverse_factor.T @ inverse_factor)
    both = ca.Function("both", [triangle], [full, inverse])
    symbol = ca.MX.sym("triangle", triangle.shape[0])
    largest, of_inverse = (_log_norm(matrix, halvings) for matrix in both(symbol))
    return _of_triangle(symbol, (largest + (1 if letter == "K" else 2) * of_inverse) / 2)


def _of_triangle(triangle: ca.SX | ca.MX, value: ca.SX | ca.MX) -> ca.Function:
    return ca.Function("objective", [triangle], [value], ["triangle"], ["value"])
