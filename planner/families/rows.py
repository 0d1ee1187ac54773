"""Rows of a program: what must lie between two bounds, with sparse derivatives."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from cases.base.units import Array, Flags, Indices
from planner.families.states import Kernel, States

if TYPE_CHECKING:
    from scipy.sparse import csr_array


@dataclass(frozen=True)
class LinearRows:
    """Rows that are linear in the unknowns: shares of limits, between -bound and bound, or equal to what is stated."""

    matrix: "csr_array"  # sparse, shape (L, n)
    order: Indices  # order of the derivative that each limits, 0 (pose) to 3 (jerk), shape (L,)
    chosen: Flags  # which of its rows count, shape (L,)
    bound: Array  # bound of each, shape (L,)
    equal: float | None = None  # value that they are equal to; None where they have bounds

    @property
    def upper(self) -> Array:
        """Upper bound of each row; the lower one is its negative, or the same where rows are equal to a value."""
        return self.bound[self.chosen] if self.equal is None else np.full(int(self.chosen.sum()), self.equal)

    @cached_property
    def _matrix(self) -> "csr_array":
        return self.matrix[np.flatnonzero(self.chosen)]

    @cached_property
    def pattern(self) -> tuple[Indices, Indices]:
        """Row and column of each value of the matrix."""
        table = self._matrix.tocoo()
        return table.coords[0].astype(np.intp), table.coords[1].astype(np.intp)

    def choosing(self, chosen: Flags) -> "LinearRows":
        """The same with other rows that count."""
        return replace(self, chosen=chosen)

    def all_values(self, unknowns: Array) -> Array:
        """Values of all rows of the matrix, shape (L,)."""
        return np.asarray(self.matrix @ unknowns)

    def values(self, unknowns: Array) -> Array:
        """Values of the rows, shape (R,)."""
        return np.asarray(self._matrix @ unknowns)

    def jacobian(self, unknowns: Array) -> Array:
        """Values of the matrix, which is constant."""
        return np.asarray(self._matrix.data)

    def tightened(self, factors: Array) -> "LinearRows":
        """The rows with bounds times a factor for each order of derivatives, shape (4,); equations stay."""
        return self if self.equal is not None else replace(self, bound=self.bound * factors[self.order])


@dataclass(frozen=True)
class PacedRows:
    """Linear rows at a pace of one; the pace is a further unknown, the last, with whose powers their values grow."""

    linear: LinearRows
    equal: None = None

    @property
    def chosen(self) -> Flags:
        """Which rows count, shape (L,)."""
        return self.linear.chosen

    def choosing(self, chosen: Flags) -> "PacedRows":
        """The same with other rows that count."""
        return PacedRows(self.linear.choosing(chosen))

    @property
    def upper(self) -> Array:
        """Upper bound of each row; the lower one is its negative."""
        return self.linear.upper

    @property
    def _powers(self) -> Indices:
        """Powers of the pace in the rows that count, shape (R,)."""
        return self.linear.order[self.linear.chosen]

    @cached_property
    def pattern(self) -> tuple[Indices, Indices]:
        """Row and column of each derivative: those of the linear rows, and of each by the pace."""
        row, column = self.linear.pattern
        count = len(self.upper)
        pace = np.full(count, self.linear.matrix.shape[1])
        return np.concatenate([row, np.arange(count)]), np.concatenate([column, pace])

    def all_values(self, unknowns: Array) -> Array:
        """Values of all rows, those that do not count as well, shape (L,)."""
        return np.asarray(self.linear.all_values(unknowns[:-1]) * unknowns[-1] ** self.linear.order)

    def values(self, unknowns: Array) -> Array:
        """Values of the rows, shape (R,)."""
        return np.asarray(self.linear.values(unknowns[:-1]) * unknowns[-1] ** self._powers)

    def jacobian(self, unknowns: Array) -> Array:
        """Derivatives, in the order of `pattern`."""
        pace, powers, row = unknowns[-1], self._powers, self.linear.pattern[0]
        by_others = self.linear.jacobian(unknowns[:-1]) * pace ** powers[row]
        return np.concatenate(
            [by_others, self.linear.values(unknowns[:-1]) * powers * pace ** np.maximum(powers - 1, 0)]
        )

    def curvature(self, unknowns: Array, multipliers: Array) -> tuple[Indices, Array]:
        """All unknowns, shape (1, m), and second derivatives of the weighted rows by them, shape (1, m, m)."""
        pace, powers, (row, column) = unknowns[-1], self._powers, self.linear.pattern
        size = len(unknowns)
        first = multipliers * powers * pace ** np.maximum(powers - 1, 0)
        second = multipliers * powers * (powers - 1) * pace ** np.maximum(powers - 2, 0)
        result = np.zeros((1, size, size))
        mixed = np.bincount(column, self.linear.jacobian(unknowns[:-1]) * first[row], size - 1)
        result[0, -1, :-1] = result[0, :-1, -1] = mixed
        result[0, -1, -1] = second @ self.linear.values(unknowns[:-1])
        return np.arange(size)[None], result

    def tightened(self, factors: Array) -> "PacedRows":
        """The rows with bounds times a factor for each order of derivatives, shape (4,)."""
        return PacedRows(self.linear.tightened(factors))


@dataclass(frozen=True)
class StateRows:
    """Limits of states: values of a kernel between -bound and bound where they are chosen."""

    states: States  # states of the motion, S in each of B blocks
    kernel: Kernel  # state -> r values
    chosen: Flags  # which of them are rows, shape (B, S, r)
    bound: float  # bound of all of them
    equal: float | None = None  # value that they are equal to; None where they have bounds

    @property
    def upper(self) -> Array:
        """Upper bound of each row; the lower one is its negative, or the same where rows are equal to a value."""
        return np.full(int(self.chosen.sum()), self.bound if self.equal is None else self.equal)

    @cached_property
    def needed(self) -> Flags:
        """States with at least one row, shape (B, S)."""
        return np.asarray(self.chosen.any(axis=2))

    @cached_property
    def pattern(self) -> tuple[Indices, Indices]:
        """Row and column of each derivative: a row depends on all unknowns of its block."""
        block = np.nonzero(self.chosen)[0]
        width = self.states.index.shape[1]
        return np.repeat(np.arange(len(block)), width), self.states.index[block].ravel()

    def choosing(self, chosen: Flags) -> "StateRows":
        """The same with other rows that count."""
        return replace(self, chosen=chosen)

    def all_values(self, unknowns: Array) -> Array:
        """All values of the kernel, those of no row as well, shape (B, S, r)."""
        at = self.states.at(unknowns)
        return self.kernel.values(at.reshape(-1, at.shape[2])).reshape(*at.shape[:2], -1)

    def values(self, unknowns: Array) -> Array:
        """Shape (R,)."""
        return self.kernel.values(self.states.at(unknowns)[self.needed])[self.chosen[self.needed]]

    def jacobian(self, unknowns: Array) -> Array:
        """Derivatives by all unknowns of the block, row by row."""
        slopes = self.kernel.slopes(self.states.at(unknowns)[self.needed])[1]
        rows = slopes.transpose(0, 2, 1) @ self.states.slopes(unknowns)[self.needed]
        return np.asarray(rows[self.chosen[self.needed]]).ravel()

    def add_curvature(self, at: Array, multipliers: Array, second: Array, pull: Array) -> None:
        """Adds derivatives of the weighted rows by the states `at`, shape (B, S, d).

        Args:
            multipliers: weights of the rows, shape (R,).
            second: second derivatives, to which is added, shape (B, S, d, d).
            pull: first ones, shape (B, S, d).
        """
        if not len(multipliers):
            return
        weights = np.zeros(self.chosen.shape)
        weights[self.chosen] = multipliers
        needed, weights = self.needed, weights[self.needed]
        second[needed] += self.kernel.curvature(at[needed], weights)
        pull[needed] += (self.kernel.slopes(at[needed])[1] @ weights[:, :, None])[:, :, 0]


Rows = LinearRows | PacedRows | StateRows


def pulled_back(states: States, unknowns: Array, second: Array, pull: Array) -> Array:
    """Second derivative of a function of states by the unknowns of their blocks, shape (B, m, m).

    Args:
        second: second derivatives of the function by each state, shape (B, S, d, d).
        pull: its first derivatives, shape (B, S, d).
    """
    blocks, width = states.index.shape
    slopes = states.slopes(unknowns)
    tall = (second @ slopes).reshape(blocks, -1, width)
    result = slopes.reshape(blocks, -1, width).transpose(0, 2, 1) @ tall
    curvature = states.curvature(unknowns, pull)
    return np.asarray(result if curvature is None else result + curvature)
