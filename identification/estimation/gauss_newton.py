"""Least squares of a non-linear residual by Gauss-Newton steps with halving (Nocedal & Wright 2006, section 10.3)."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from identification.estimation.compressed import column_scale

Array = NDArray[np.float64]
Residual = Callable[[Array], tuple[Array, Array]]
"""theta, shape (p,) -> residuals, shape (k,), and their Jacobian, shape (k, p)."""

STEPS = 50
HALVINGS = 30
RESOLVED = 1e-10  # of |r|^2: less of it than a step promises may drown in rounding, and the step is taken unseen


class Minimum(NamedTuple):
    """Where the search ended.

    Args:
        at: theta, shape (p,).
        steps: taken.
        failure: why this is no minimum, and what to do; None where it is one.
    """

    at: Array
    steps: int
    failure: str | None


def gauss_newton(residual: Residual, start: Array, tolerance: float) -> Minimum:
    """Minimises |r(theta)|^2.

    Directions that nothing determines stay where they started: rank is the caller's to judge at the end.

    Args:
        residual: r and its Jacobian.
        start: theta, shape (p,).
        tolerance: length of a step, as the change of r that it predicts, below which it is the last. Where r is in
            standard deviations of the noise no parameter is then further from the minimum than so many of its own.
    """
    at = np.asarray(start, dtype=float)
    r, jacobian = residual(at)
    if not np.isfinite(r).all() or not np.isfinite(jacobian).all():
        return Minimum(at, 0, "the model has no finite value at the start; start from a mass above zero")
    for steps in range(1, STEPS + 1):
        scale = column_scale(jacobian)
        step = scale * np.linalg.lstsq(jacobian * scale, -r, rcond=None)[0]
        predicted = float(np.linalg.norm(jacobian @ step))
        cost, share = float(r @ r), 1.0
        for _ in range(HALVINGS):
            new, new_jacobian = residual(at + share * step)
            finite = bool(np.isfinite(new).all() and np.isfinite(new_jacobian).all())
            if finite and (float(new @ new) < cost or predicted**2 <= max(tolerance**2, RESOLVED * cost)):
                break
            share /= 2.0
        else:
            return Minimum(at, steps, "no step lowers chi^2 any more, yet the gradient is not zero; start nearer")
        at, r, jacobian = at + share * step, new, new_jacobian
        if predicted <= tolerance:
            return Minimum(at, steps, None)
    return Minimum(at, STEPS, f"the steps did not become small within {STEPS}; start nearer or give more known values")
