"""A CasADi expression with its first and second derivatives, evaluated at many vectors at once."""

from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from identification.evaluate import over_samples

Array = NDArray[np.float64]


class Kernel:
    """Values, slopes and weighted second derivatives of a vector function.

    Each is built when it is first asked for: second derivatives of strut accelerations take longest.

    Args:
        variables: the symbol, shape (d,).
        values: the expression, shape (r,).
    """

    def __init__(self, variables: ca.SX, values: ca.SX) -> None:
        self.variables, self.expression = variables, ca.densify(ca.cse(values))
        self.size = int(values.shape[0])
        self._last: tuple[Array, Array, Array] | None = None

    @cached_property
    def _values(self) -> ca.Function:
        return ca.Function("values", [self.variables], [self.expression], {"cse": True})

    @cached_property
    def _slopes(self) -> ca.Function:
        slopes = ca.jacobian(self.expression, self.variables)
        return ca.Function("slopes", [self.variables], [self.expression, ca.densify(slopes)], {"cse": True})

    @cached_property
    def _curvature(self) -> ca.Function:
        weights = ca.SX.sym("weights", self.size)
        bent = ca.hessian(ca.dot(weights, self.expression), self.variables)[0]
        return ca.Function("curvature", [self.variables, weights], [ca.densify(bent)], {"cse": True})

    def values(self, at: Array) -> Array:
        """Values at vectors of shape (n, d), shape (n, r)."""
        return over_samples(self._values, at)[0]

    def slopes(self, at: Array) -> tuple[Array, Array]:
        """Values, shape (n, r), and derivatives, shape (n, d, r), at vectors of shape (n, d).

        The last ones are remembered: first and second derivatives of a program ask for the same.
        """
        if self._last is None or not np.array_equal(self._last[0], at):
            values, slopes = over_samples(self._slopes, at)
            slopes = slopes.transpose(0, 2, 1)  # CasADi's columns are rows in memory
            values.flags.writeable = slopes.flags.writeable = False
            self._last = (at.copy(), values, slopes)
        return self._last[1], self._last[2]

    def curvature(self, at: Array, weights: Array) -> Array:
        """Second derivatives of the weighted sum of the values, shape (n, d, d).

        Args:
            at: shape (n, d).
            weights: shape (n, r).
        """
        curvature = over_samples(self._curvature, at, weights)[0]
        d = int(self.variables.shape[0])
        return curvature.reshape(len(at), d, d)
