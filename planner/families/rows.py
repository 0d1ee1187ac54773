"""Rows of a program: what must lie between two bounds, with sparse derivatives."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from cases.units import Array, Flags, Indices
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

    def all_values(self, unknowns: Array) -> Array:
        """Values of all rows of the matrix, shape (L,)."""
        return np.asarray(self.matrix @ unknowns)

    def values(self, unknowns: Array) -> Array:
        """Values of the rows, shape (R,)."""
        return np.asarray(self._matrix @ unknowns)

    def jacobian(self, unknowns: Array) -> Array:
        """Values of the matrix, which is constant."""
        return np.asarray(self._matrix.data)


@dataclass(frozen=True)
class StateRows:
    """Limits of states: values of a kernel between -bound and bound where they are chosen."""

    states: States  # states of the motion, S in each of B blocks
    kernel: Kernel  # state -> r values
    chosen: Flags  # which of them are rows, shape (B, S, r)
    bound: float  # bound of all of them

    @property
    def upper(self) -> Array:
        """Upper bound of each row; the lower one is its negative."""
        return np.full(int(self.chosen.sum()), self.bound)

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

    def add_curvature(self, at: Array, multipliers: Array, own: Array, pull: Array) -> None:
        """Adds derivatives of the weighted rows by the states `at`, shape (B, S, d).

        Args:
            multipliers: weights of the rows, shape (R,).
            own: second derivatives, to which is added, shape (B, S, d, d).
            pull: first ones, shape (B, S, d).
        """
        if not len(multipliers):
            return
        weights = np.zeros(self.chosen.shape)
        weights[self.chosen] = multipliers
        needed, weights = self.needed, weights[self.needed]
        own[needed] += self.kernel.curvature(at[needed], weights)
        pull[needed] += (self.kernel.slopes(at[needed])[1] @ weights[:, :, None])[:, :, 0]


Rows = LinearRows | StateRows


def pulled_back(states: States, unknowns: Array, own: Array, pull: Array) -> Array:
    """Second derivative of a function of states by the unknowns of their blocks, shape (B, m, m).

    Args:
        own: second derivatives of the function by each state, shape (B, S, d, d).
        pull: its first derivatives, shape (B, S, d).
    """
    blocks, width = states.index.shape
    slopes = states.slopes(unknowns)
    tall = (own @ slopes).reshape(blocks, -1, width)
    result = slopes.reshape(blocks, -1, width).transpose(0, 2, 1) @ tall
    curvature = states.curvature(unknowns, pull)
    return np.asarray(result if curvature is None else result + curvature)
