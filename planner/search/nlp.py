"""The optimal excitation problem as a non-linear program with exact first and second derivatives.

The criterion couples all unknowns, so that its second derivative is full; yet it is a sum of two parts that are cheap
(`planner.search.objective`): one of rank u (u + 1) / 2 in the information, and a sum over states of small matrices.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from cases.base.units import Array, Indices
from identification.estimation.criteria import Criterion
from identification.model.model import Model
from planner.families.rows import LinearRows, PacedRows, Rows, StateRows, pulled_back
from planner.families.states import SHARE, Kernel, States, state_size
from planner.search.objective import (
    FieldByStates,
    InformationOfStates,
    Local,
    criterion_at,
    curvature_through_information,
    weighted_square,
)


def regressor_kernel(model: Model, scaling: Array) -> Kernel:
    """State -> A H of (21) and (25), row by row, shape (6 u,); H has the diagonal `scaling`."""
    n = model.coordinates
    state = ca.SX.sym("state", state_size(n))
    matrix = model.coordinate_regressor(state[:n], state[n : 2 * n], state[2 * n : 3 * n]) @ ca.diag(ca.DM(scaling))
    return Kernel(state, ca.vec(matrix.T))


@dataclass(frozen=True)
class NonlinearProgram:
    """Minimise a criterion of the mean information over unknowns within bounds and rows."""

    states: States  # states over which the information is averaged, with their shares of the duration
    regressor: Kernel  # regressor of one state, see `regressor_kernel`
    rows: tuple[Rows, ...]  # rows of the limits; those of non-linear limits that can bind are the last, one for each
    lower: Array  # lower limit of each unknown, shape (n,)
    upper: Array  # upper limit of each unknown, shape (n,)
    letter: Criterion = Criterion.D  # of Table 4
    halvings: int = 0  # see `planner.search.objective`
    # whether second derivatives omit the curvature of the information itself. That part is negative nearly everywhere:
    # without it Newton steps are longer, need no correction, and lead to better optima from afar; the last digits take
    # more of them
    convex: bool = False
    # errors of the pose, which the information then counts; second derivatives are convex with them
    errors: FieldByStates | None = None
    known: Array | None = None  # information that earlier results add to that of the motion, shape (u, u)
    limits: tuple[Kernel, ...] = ()  # state -> shares of each non-linear limit that can bind
    own: int = 0  # how many of the rows, the first ones, are those of the family itself

    @property
    def unknowns(self) -> int:
        """Number of unknowns n."""
        return len(self.lower)

    @property
    def size(self) -> int:
        """Number of parameters u."""
        return self.regressor.size // 6

    def worst(self, unknowns: Array) -> float:
        """The largest share of a limit that unknowns use, at all critical states, those without rows included."""
        return max(float(np.abs(part.all_values(unknowns)).max()) for part in self.rows if part.equal is None)

    def unseen(self, unknowns: Array) -> float:
        """The largest share of a limit that unknowns use at critical states where it has no row."""
        return max(
            float(np.abs(part.all_values(unknowns)[~part.chosen]).max(initial=0.0))
            for part in self.rows
            if part.equal is None
        )

    def outside(self, unknowns: Array) -> float:
        """By how much unknowns are outside their bounds."""
        return float(max((self.lower - unknowns).max(), (unknowns - self.upper).max(), 0.0))

    def with_own_rows(self, rows: Sequence[Rows]) -> "NonlinearProgram":
        """The program with other rows of the family itself, whose choices were made."""
        return replace(self, rows=(*rows, *self.rows[self.own :]), own=len(rows))

    def with_rows_above(self, unknowns: Array, share: float) -> "NonlinearProgram":
        """The program with further rows for all that use more than a share of a limit."""
        rows: list[Rows] = []
        for part in self.rows:
            if part.equal is None:
                part = part.choosing(part.chosen | (np.abs(part.all_values(unknowns)) > share))
            rows.append(part)
        return replace(self, rows=tuple(rows))

    def with_rows_near(self, unknowns: Array, share: float, near: float) -> "NonlinearProgram":
        """The program with further rows as `with_rows_above(near)`, and without those of non-linear limits below share.

        A motion that hardly uses half of a limit at an instant seldom comes to exceed it there, and each of these rows
        depends on all unknowns of its block.
        """
        before = len(self.rows) - len(self.limits)
        rows = [
            part.choosing(part.chosen & (np.abs(part.all_values(unknowns)) > share)) if k >= before else part
            for k, part in enumerate(self.rows)
        ]
        return replace(self, rows=tuple(rows)).with_rows_above(unknowns, near)

    def tightened(self, shares: Sequence[float], bound: float) -> "NonlinearProgram":
        """The program with bounds lowered by as much as `largest_shares` exceed a bound that all should satisfy."""
        factors = np.array([bound / max(bound, share) for share in shares])  # 0 is the share of jerk without a limit
        before = len(self.rows) - len(self.limits)
        rows: list[Rows] = []
        for k, part in enumerate(self.rows):
            if isinstance(part, LinearRows | PacedRows):
                part = part.tightened(factors)
            elif k >= before:
                part = replace(part, bound=part.bound * factors[4 + k - before])
            rows.append(part)
        return replace(self, rows=tuple(rows))

    def bounded(self, bounds: Mapping[str, float]) -> "NonlinearProgram":
        """The program with further bounds of the shares of some non-linear limits, by their names."""
        before = len(self.rows) - len(self.limits)
        rows = list(self.rows)
        for k, kernel in enumerate(self.limits, before):
            part = rows[k]
            assert isinstance(part, StateRows)
            rows[k] = replace(part, bound=min(part.bound, bounds.get(kernel.name, part.bound)))
        return replace(self, rows=tuple(rows))

    @cached_property
    def row_bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of all rows, shapes (R,)."""
        lower = [part.upper if part.equal is not None else -part.upper for part in self.rows]
        return np.concatenate(lower), np.concatenate([part.upper for part in self.rows])

    @cached_property
    def pattern(self) -> tuple[Indices, Indices]:
        """Row and column of each derivative of the rows."""
        first, rows, columns = 0, [], []
        for part in self.rows:
            pattern = part.pattern
            rows.append(pattern[0] + first)
            columns.append(pattern[1])
            first += len(part.upper)
        return np.concatenate(rows), np.concatenate(columns)

    def information(self, unknowns: Array) -> Array:
        """Mean of H A^T A H over the motion, less what errors of the pose cost, and what is known, shape (u, u)."""
        states = np.concatenate(self.states.at(unknowns))
        regressors = self.regressor.values(states)
        if self.errors is not None:
            return self._with_known(self.errors.information(states, regressors))
        return self._with_known(weighted_square(states, regressors, self.size))

    def _with_known(self, information: Array) -> Array:
        return information if self.known is None else information + self.known

    def value(self, unknowns: Array) -> float:
        """Value of the criterion."""
        value: float = self._remembered(
            "value", unknowns, lambda: criterion_at(self.letter, self.information(unknowns), self.halvings).value
        )
        return value

    def row_values(self, unknowns: Array) -> Array:
        """Values of all rows, shape (R,)."""
        rows: Array = self._remembered(
            "rows", unknowns, lambda: np.concatenate([part.values(unknowns) for part in self.rows])
        )
        return rows

    def _remembered(self, what: str, unknowns: Array, compute: Callable[[], Any]) -> Any:
        """What is computed of unknowns; the last answer is kept, because solvers ask for each several times."""
        last: dict[str, tuple[Array, Any]] = self.__dict__.setdefault("_last", {})
        if what not in last or not np.array_equal(last[what][0], unknowns):
            last[what] = unknowns.copy(), compute()
        return last[what][1]

    def row_slopes(self, unknowns: Array) -> Array:
        """Derivatives of the rows, in the order of `pattern`."""
        return np.concatenate([part.jacobian(unknowns) for part in self.rows])

    def _point(self, unknowns: Array) -> InformationOfStates:
        """The information with its derivatives."""
        point: InformationOfStates = self._remembered("point", unknowns, lambda: self._with_slopes(unknowns))
        return point

    def _with_slopes(self, unknowns: Array) -> InformationOfStates:
        states = np.concatenate(self.states.at(unknowns))
        regressors, slopes = self.regressor.slopes(states)
        if self.errors is None:
            point = InformationOfStates.white(states, regressors, slopes, self.size)
        else:
            point = self.errors.with_slopes(states, regressors, slopes)
        return point._replace(information=self._with_known(point.information))

    def _pull(self, point: InformationOfStates, local: Local) -> tuple[Array, Array]:
        """Derivatives of the criterion by the states, for a share of one and times it, shapes (K, d)."""
        gradient = (point.rows.reshape(len(point.states), -1, self.size) @ local.slope).reshape(len(point.states), -1)
        plain = 2.0 * (point.slopes @ gradient[:, :, None])[:, :, 0]
        pull = plain * point.states[:, SHARE, None]
        pull[:, SHARE] = np.einsum("ki,ki->k", gradient, point.own)
        return plain, pull

    def gradient(self, unknowns: Array) -> Array:
        """Derivative of the criterion, shape (n,)."""
        point = self._point(unknowns)
        _, pull = self._pull(point, criterion_at(self.letter, point.information, self.halvings))
        index = self.states.index
        pull = pull.reshape(len(index), -1)
        slopes = self.states.slopes(unknowns).reshape(len(index), pull.shape[1], -1)
        slope = (pull[:, None, :] @ slopes)[:, 0]
        return np.asarray(np.bincount(index.ravel(), slope.ravel(), self.unknowns), dtype=float)

    @cached_property
    def hessian_pattern(self) -> tuple[Indices, Indices]:
        """Row and column of each value of `hessian`: the upper triangle, which is full."""
        return np.triu_indices(self.unknowns)

    def hessian(self, unknowns: Array, factor: float, multipliers: Array) -> Array:
        """Second derivative of factor times the criterion plus the rows times multipliers, as `hessian_pattern`."""
        size = self.unknowns
        total = np.zeros((size, size))
        blocks = self._curvatures_of_rows(unknowns, multipliers)
        if factor != 0.0:
            point = self._point(unknowns)
            local = criterion_at(self.letter, point.information, self.halvings)
            total += factor * curvature_through_information(self.states, unknowns, local, point, size)
            if self.errors is not None:  # where field and motion change together this part is flat, and steps too long
                white = InformationOfStates.white(point.states, point.regressors, point.changes, self.size)
                local = criterion_at(Criterion.D, self._with_known(white.information))
                total += factor * curvature_through_information(self.states, unknowns, local, white, size)
            elif not self.convex:
                blocks.append((self.states.index, factor * self._curvature_at_states(unknowns, local, point)))
        for index, matrices in blocks:
            flat = (index[:, :, None] * size + index[:, None, :]).ravel()
            total += np.bincount(flat, matrices.ravel(), total.size).reshape(total.shape)
        return np.asarray(total[np.triu_indices(size)])

    def _curvatures_of_rows(self, unknowns: Array, multipliers: Array) -> list[tuple[Indices, Array]]:
        """Second derivatives of the rows by blocks of unknowns; limits at the same states are pulled back together."""
        first = 0
        at_states: dict[int, list[tuple[StateRows, Array]]] = {}
        blocks: list[tuple[Indices, Array]] = []
        for part in self.rows:
            weights = multipliers[first : first + len(part.upper)]
            first += len(weights)
            if isinstance(part, PacedRows):
                blocks.append(part.curvature(unknowns, weights))
            elif isinstance(part, StateRows):
                at_states.setdefault(id(part.states), []).append((part, weights))
        for parts in at_states.values():
            states = parts[0][0].states
            at = states.at(unknowns)
            second, pull = np.zeros((*at.shape, at.shape[2])), np.zeros(at.shape)
            for limits, weights in parts:
                limits.add_curvature(at, weights, second, pull)
            blocks.append((states.index, pulled_back(states, unknowns, second, pull)))
        return blocks

    def _curvature_at_states(self, unknowns: Array, local: Local, point: InformationOfStates) -> Array:
        """Second derivative of the criterion that the information's own makes, along the blocks, shape (B, m, m)."""
        size, shape = self.size, (len(self.states.index), -1, point.states.shape[1])
        shares = point.states[:, SHARE]
        plain, pull = self._pull(point, local)
        projections = (point.regressors.reshape(-1, size) @ local.vectors).reshape(len(point.states), -1)
        turned_slopes = (point.changes.reshape(-1, size) @ local.vectors).reshape(*point.changes.shape)
        products = (projections.reshape(-1, size) * local.first) @ local.vectors.T
        along = self.regressor.curvature(point.states, 2.0 * products.reshape(len(point.states), -1))
        scaled = (turned_slopes.reshape(-1, size) * local.first).reshape(*turned_slopes.shape)
        along += 2.0 * scaled @ turned_slopes.transpose(0, 2, 1)
        along *= shares[:, None, None]
        along[:, SHARE, :SHARE] = along[:, :SHARE, SHARE] = plain[:, :SHARE]
        return pulled_back(self.states, unknowns, along.reshape(*shape, shape[2]), pull.reshape(shape))
