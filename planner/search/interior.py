"""An interior-point method whose iterates satisfy every limit, for programs with few unknowns and many rows.

The criterion couples all unknowns, so that the second derivative is full, while rows outnumber unknowns by ten. With
slacks s of the bounds and their multipliers z, a step of Newton's method for the barrier problem

    minimise f - mu sum log s      solves      (H + J^T (z / s) J) dx = -(grad f - mu J^T (1 / s))

for the unknowns alone: one Cholesky factor of a dense matrix, where general solvers factorise a sparse one of all rows.
The start must satisfy all bounds. Whenever the search is stopped, its motion does too.

The barrier falls only when the iterate is in the middle of what is allowed: on the way along the boundary, with a small
barrier from the beginning, steps are short, and the optima that are found are worse. What the barrier still costs is at
most sum s z in a convex program, and that is how it is told when to end.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from cases.base.units import Array, Flags, Indices
from planner.search.nlp import NonlinearProgram
from planner.search.record import SolverStatus

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Watch = Callable[[float], bool]
"""Function of the objective, called at every iteration; a true answer stops the solver."""

FALL = 0.3  # factor of the barrier from one centre to the next
CENTRED = 0.1  # share of what the barrier costs, below which a step's promise means that its centre is reached
LONG = 0.3  # share of a step that must be possible there
BOUNDARY = 0.99  # share of a slack that a step may use up at most
LEAST = 1e-3  # share of each slack that must be left
DESCENT = 1e-4  # share of its promise that a step must keep (Armijo)
ROUNDING = 1e-12  # of the objective
HALVINGS = 25  # of a step at most
FIRST_SHIFT, GROWTH = 1e-4, 8.0  # of the diagonal, where a matrix is not positive definite
BLENDS = (1.0, 0.5)  # shares of the curvature that is not convex, tried before none
PATIENCE, GAIN = 8, 5e-4  # steps in which so little is gained of the objective that they are the last ones
NEAR = 4.0  # factor of the final gap: what the barrier may still cost then
FAR = 1e8  # factor by which multipliers may differ from what the barrier makes of slacks


class _Sides:
    """Bounds of rows and unknowns, as slacks that are to stay positive."""

    def __init__(self, program: NonlinearProgram) -> None:
        low, high = program.row_bounds
        self.equal: Indices = np.flatnonzero(low == high)
        limited = np.flatnonzero(np.isfinite(program.lower) | np.isfinite(program.upper))
        self.own: Indices = limited[program.lower[limited] < program.upper[limited]]  # unknowns with bounds
        low, high = (np.concatenate(b) for b in ((low, program.lower[self.own]), (high, program.upper[self.own])))
        self.rows, self.unknowns = len(low) - len(self.own), program.unknowns
        self.above: Indices = np.flatnonzero(np.isfinite(high) & (low < high))
        self.below: Indices = np.flatnonzero(np.isfinite(low) & (low < high))
        self.high, self.low = high[self.above], low[self.below]
        self.pattern = program.pattern

    def slacks(self, values: Array) -> Array:
        """Slacks s at values of rows and limited unknowns: of upper bounds, then of lower ones."""
        return np.concatenate([self.high - values[self.above], values[self.below] - self.low])

    def values(self, program: NonlinearProgram, unknowns: Array) -> Array:
        """Values of rows and limited unknowns."""
        return np.concatenate([program.row_values(unknowns), unknowns[self.own]])

    def changes(self, ways: Array) -> Array:
        """How slacks change where values change by so much."""
        return np.concatenate([-ways[self.above], ways[self.below]])

    def weights(self, of_slacks: Array, upward: float = -1.0) -> Array:
        """Weights of slacks, added up for each value: those of upper bounds plus `upward` times those of lower ones."""
        count = self.rows + len(self.own)
        above, below = of_slacks[: len(self.above)], of_slacks[len(self.above) :]
        return np.asarray(np.bincount(self.above, above, count) + upward * np.bincount(self.below, below, count))

    def slopes(self, program: NonlinearProgram, unknowns: Array) -> "csr_array":
        """Derivatives of rows and limited unknowns, shape (values, n)."""
        from scipy.sparse import csr_array

        own = np.arange(len(self.own))
        data = np.concatenate([program.row_slopes(unknowns), np.ones(len(own))])
        row = np.concatenate([self.pattern[0], self.rows + own])
        column = np.concatenate([self.pattern[1], self.own])
        return csr_array((data, (row, column)), shape=(self.rows + len(own), self.unknowns))


def solve_inside(
    program: NonlinearProgram, start: Array, iterations: int, watch: Watch, first: float, gap: float
) -> tuple[Array, SolverStatus, int]:
    """Minimises from a start inside all bounds; each step stays there.

    Args:
        start: shape (n,). Equations are satisfied, and remain so.
        iterations: number of steps at most.
        watch: called with the objective after each; a true answer stops the search.
        first: what the barrier costs at first, in units of the objective: mu times the number of bounds.
        gap: what it may cost at the end.

    Returns:
        The unknowns, how it ended, and the number of steps.
    """
    sides, free = _Sides(program), program.lower < program.upper
    x, values, objective, shift = start, sides.values(program, start), program.value(start), 0.0
    s = sides.slacks(values)
    mu = first / len(s)
    if not (s.min(initial=1.0) > 0.0 and np.isfinite(objective)):
        return start, SolverStatus.FAILED, 0
    z, latest = mu / s, [objective]
    for number in range(1, iterations + 1):
        slopes = sides.slopes(program, x)
        convex, rest = program.curvatures(x, 1.0, sides.weights(z)[: sides.rows])
        pull = program.gradient(x) - slopes.T @ sides.weights(-mu / s)
        matrix = convex + _square(slopes, sides.weights(z / s, upward=1.0))
        step, shift = _newton(matrix, rest, pull, slopes[sides.equal].toarray(), free, shift)
        change, promise = sides.changes(slopes @ step), -float(pull @ step)
        length, merit = _longest(s, change), objective - mu * float(np.log(s).sum())
        for _ in range(HALVINGS):
            there = x + length * step
            reached = sides.values(program, there)
            slacks = sides.slacks(reached)
            if (slacks > LEAST * s).all():
                value = program.value(there)
                if value - mu * float(np.log(slacks).sum()) <= merit - DESCENT * length * promise + ROUNDING:
                    break
            length /= 2.0
        else:
            return x, SolverStatus.SHORT_STEP, number - 1
        lift = mu / s - z - z / s * change
        z = z + _longest(z, lift) * lift
        x, values, objective, s = there, reached, value, slacks
        z = np.clip(z, mu / s / FAR, mu / s * FAR)
        latest[:] = [*latest[-PATIENCE:], objective]
        if watch(objective):
            return x, SolverStatus.STOPPED, number
        cost = float(s @ z)
        if length > LONG and promise < CENTRED * mu * len(s):
            if cost < gap:
                return x, SolverStatus.CONVERGED, number
            mu *= FALL
        if cost < NEAR * gap and len(latest) > PATIENCE and max(latest) < min(latest) + GAIN:
            return x, SolverStatus.SETTLED, number
    return x, SolverStatus.ITERATION_LIMIT, iterations


def _longest(values: Array, change: Array) -> float:
    """The longest part of a change, 1 at most, after which a share of each value is left."""
    falling = change < 0.0
    return min(1.0, float((BOUNDARY * values[falling] / -change[falling]).min(initial=1.0)))


def _square(slopes: "csr_array", weights: Array) -> Array:
    """J^T W J, dense."""
    from scipy.sparse import csr_array

    root = np.repeat(np.sqrt(weights), np.diff(slopes.indptr))
    scaled = csr_array((slopes.data * root, slopes.indices, slopes.indptr), shape=slopes.shape)
    return np.asarray((scaled.T @ scaled).toarray())


def _newton(
    convex: Array, rest: Array | None, pull: Array, equal: Array, free: Flags, shift: float
) -> tuple[Array, float]:
    """Newton's step for the barrier problem, with as much of the curvature as leaves the matrix positive definite.

    Args:
        convex: curvature of the barrier, of the rows, and the convex part of the criterion's, shape (n, n).
        rest: the other part of the criterion's, shape (n, n); None where it is left out.
        pull: gradient, shape (n,).
        equal: derivatives of equations, which the step leaves satisfied, shape (e, n).
        free: unknowns that are not fixed, shape (n,).
        shift: what the diagonal was raised by in the last step.

    Returns:
        The step, shape (n,), and what the diagonal was raised by.
    """
    from scipy.linalg import cho_solve
    from scipy.linalg.lapack import dpotrf

    every = np.flatnonzero(free)
    if len(every) < len(free):
        convex, equal, pull = convex[np.ix_(every, every)], equal[:, every], pull[every]
        rest = None if rest is None else rest[np.ix_(every, every)]
    failed, factor = 1, convex
    for share in () if rest is None else BLENDS:
        factor, failed = dpotrf(convex + share * np.asarray(rest))
        if not failed:
            shift = 0.0
            break
    else:
        diagonal = np.arange(len(every))
        shift /= GROWTH
        shift = 0.0 if shift < FIRST_SHIFT else shift
        while failed:
            raised = convex.copy()
            raised[diagonal, diagonal] += shift
            factor, failed = dpotrf(raised)
            if failed:
                if not np.isfinite(convex).all():
                    return np.zeros(len(free)), shift
                shift = max(FIRST_SHIFT, shift * GROWTH)
    step = np.zeros(len(free))
    answers = cho_solve((factor, False), np.column_stack([-pull, *equal]))
    own = answers[:, 0]
    if len(equal):
        own = own - answers[:, 1:] @ np.linalg.solve(equal @ answers[:, 1:], equal @ own)
    step[every] = own
    return step, shift
