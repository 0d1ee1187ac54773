"""States of a motion as functions of its unknowns, block by block: each block depends on few of them.

A state is (coordinates, rates, accelerations, share of the duration): d = 3 n + 1 numbers for n coordinates.
Derivatives are small dense matrices, one a block, and only gathered where they are needed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from cases.base.units import Array, Indices
from identification.machines.casadi_batch import over_samples


class Kernel:
    """Values, slopes and weighted second derivatives of a vector function.

    Each is built when it is first asked for: second derivatives of strut accelerations take longest.

    Args:
        variables: the symbol, shape (d,).
        values: the expression, shape (r,).
        name: of the limit whose shares they are, as a proof names it; empty where it has no name of its own.
    """

    def __init__(self, variables: ca.SX, values: ca.SX, name: str = "") -> None:
        self.name = name
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
        hessian = ca.hessian(ca.dot(weights, self.expression), self.variables)[0]
        return ca.Function("curvature", [self.variables, weights], [ca.densify(hessian)], {"cse": True})

    def values(self, at: Array) -> Array:
        """Values at vectors of shape (n, d), shape (n, r)."""
        return over_samples(self._values, at)[0]

    def slopes(self, at: Array) -> tuple[Array, Array]:
        """Values, shape (n, r), and derivatives, shape (n, d, r), at vectors of shape (n, d).

        The last ones are remembered: first and second derivatives of a program ask for the same.
        """
        last = self._last
        if last is None or not np.array_equal(last[0], at):
            values, slopes = over_samples(self._slopes, at)
            slopes = slopes.transpose(0, 2, 1)  # CasADi's columns are rows in memory
            values.flags.writeable = slopes.flags.writeable = False
            self._last = last = (at.copy(), values, slopes)
        return last[1], last[2]

    def curvature(self, at: Array, weights: Array) -> Array:
        """Second derivatives of the sum of the values weighted by shape (n, r) at vectors (n, d), shape (n, d, d)."""
        curvature = over_samples(self._curvature, at, weights)[0]
        d = int(self.variables.shape[0])
        return curvature.reshape(len(at), d, d)


SHARE = -1  # component of a state


def state_size(coordinates: int) -> int:
    """Length d of a state of a machine with n coordinates."""
    return 3 * coordinates + 1


@dataclass(frozen=True, slots=True)
class LinearStates:
    """States that are linear in the unknowns (Fourier series, splines): S in each of B blocks of m unknowns."""

    index: Indices  # the unknowns on which each block depends, none twice in a block, shape (B, m)
    offset: Array  # shape (B, S, d)
    slope: Array  # shape (B, S, d, m)

    def at(self, unknowns: Array) -> Array:
        """States, shape (B, S, d)."""
        return np.asarray(self.offset + np.einsum("bsdm,bm->bsd", self.slope, unknowns[self.index], optimize=True))

    def slopes(self, unknowns: Array) -> Array:
        """Slopes of the states, which are constant."""
        return self.slope

    def curvature(self, unknowns: Array, weights: Array) -> None:
        """None: the second derivative is zero."""
        return


def linear_states(maps: Sequence[Array], middle: Array, half: Array, shares: Array, blocks: int = 1) -> LinearStates:
    """States of a motion whose coordinates are linear in the same way in their own unknowns.

    Args:
        maps: matrices (K, q) from the unknowns of a coordinate to its value, rate and acceleration in half widths;
            those of further derivatives do not count.
        middle: middle of the box, shape (n,) [m or rad].
        half: half of its width, shape (n,) [m or rad].
        shares: share of the duration of each state, shape (K,).
        blocks: number B of blocks of equally many successive states.
    """
    table = np.stack(maps[:3], axis=1).reshape(blocks, -1, 3, maps[0].shape[1])
    count = table.shape[1]
    active = np.abs(table).max(axis=(1, 2)) > 0.0
    width = int(active.sum(axis=1).max())
    columns = np.argsort(~active, axis=1, kind="stable")[:, :width]  # those in use first
    splines = np.take_along_axis(table, columns[:, None, None, :], axis=3)
    n = len(middle)
    slope = np.zeros((blocks, count, state_size(n), width, n))
    for order in range(3):
        for k in range(n):
            slope[:, :, n * order + k, :, k] = splines[:, :, order] * half[k]
    offset = np.zeros((blocks, count, state_size(n)))
    offset[:, :, :n] = middle
    offset[:, :, SHARE] = shares.reshape(blocks, -1)
    index = (n * columns[:, :, None] + np.arange(n)).reshape(blocks, -1)
    return LinearStates(index, offset, slope.reshape(blocks, count, state_size(n), -1))


@dataclass(frozen=True, slots=True)
class KernelStates:
    """States that a kernel makes of each block's unknowns (moves): S in each of B blocks of m unknowns."""

    index: Indices  # the unknowns on which each block depends, none twice in a block, shape (B, m)
    kernel: Kernel  # m unknowns -> S states of d numbers, one after the other
    size: int  # d

    def at(self, unknowns: Array) -> Array:
        """States, shape (B, S, d)."""
        return self.kernel.values(unknowns[self.index]).reshape(len(self.index), -1, self.size)

    def slopes(self, unknowns: Array) -> Array:
        """Derivatives of the states by the block's unknowns, shape (B, S, d, m)."""
        slopes = self.kernel.slopes(unknowns[self.index])[1]
        return slopes.transpose(0, 2, 1).reshape(len(self.index), -1, self.size, self.index.shape[1])

    def curvature(self, unknowns: Array, weights: Array) -> Array:
        """Second derivative of the weighted sum of the states, shape (B, m, m)."""
        return self.kernel.curvature(unknowns[self.index], weights.reshape(len(self.index), -1))


@dataclass(frozen=True)
class PacedStates:
    """Linear states of one block whose pace is a further unknown, the last: rates grow with it, accelerations squared.

    Args:
        linear: the states at a pace of one.
        coordinates: their number n.
    """

    linear: LinearStates
    coordinates: int

    @cached_property
    def index(self) -> Indices:
        """The unknowns on which the block depends, shape (1, m)."""
        unknowns = self.linear.index
        return np.hstack([unknowns, np.full((1, 1), unknowns.max() + 1)])

    def _powers(self, pace: float, derivative: int) -> Array:
        """A derivative of the powers of the pace with which each component of a state grows, shape (d, 1)."""
        n = self.coordinates
        powers = np.zeros(state_size(n))
        for order in range(derivative, 3):
            factor = 1.0 if derivative == 0 or order == derivative == 1 else 2.0
            powers[n * order : n * (order + 1)] = factor * pace ** (order - derivative)
        if derivative == 0:
            powers[SHARE] = 1.0
        return powers[:, None]

    def at(self, unknowns: Array) -> Array:
        """States, shape (1, S, d)."""
        ways = self.linear.at(unknowns) - self.linear.offset
        return np.asarray(self.linear.offset + ways * self._powers(unknowns[-1], 0)[:, 0])

    def slopes(self, unknowns: Array) -> Array:
        """Derivatives of the states by the unknowns, shape (1, S, d, m)."""
        ways = self.linear.at(unknowns) - self.linear.offset
        by_pace = ways * self._powers(unknowns[-1], 1)[:, 0]
        return np.concatenate([self.linear.slope * self._powers(unknowns[-1], 0), by_pace[..., None]], axis=3)

    def curvature(self, unknowns: Array, weights: Array) -> Array:
        """Second derivative of the weighted sum of the states, shape (1, m, m): of pairs with the pace alone."""
        ways = self.linear.at(unknowns) - self.linear.offset
        size = self.index.shape[1]
        result = np.zeros((1, size, size))
        mixed = np.einsum("bsd,bsdm->bm", weights * self._powers(unknowns[-1], 1)[:, 0], self.linear.slope)
        result[:, -1, :-1] = result[:, :-1, -1] = mixed
        result[:, -1, -1] = (weights * ways * self._powers(unknowns[-1], 2)[:, 0]).sum(axis=(1, 2))
        return result


States = LinearStates | KernelStates | PacedStates
