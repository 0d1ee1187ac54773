"""The problem of every criterion with exact second derivatives.

A criterion couples all unknowns: its Hessian is full, and automatic differentiation takes seconds for it. Here the mean
information is an unknown of its own, tied to the motion by an equation. Then the Hessian of the Lagrangian falls apart:

- in the information, that of the criterion alone, a function of eigenvalues (`planner.search.curvature`);
- in the motion, a sum over states, each a small matrix in pose, rates and accelerations: of what the equation and the
  non-linear limits weigh it with. Of splines and moves, states depend on few unknowns, so that it is sparse.

With these an interior-point method needs a tenth of the iterations that approximated second derivatives need.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from planner.families.family import Sampling
from planner.search.curvature import curvature_function
from planner.search.objective import objective
from planner.search.problem import Constraints, Problem
from planner.search.solvers import Program

Array = NDArray[np.float64]

STATE = 18  # pose, rates, accelerations
HESSIAN = ["x", "p", "lam_f", "lam_g"], ["hess_gamma_x_x"]  # names that CasADi looks for


@dataclass(frozen=True)
class Lifted:
    """The program in the unknowns of the motion, followed by the lower triangle of its mean information.

    Args:
        program: with second derivatives.
        information: unknowns of the motion -> that triangle.
        curvature: second derivatives of the criterion, which the program calls: CasADi does not keep it alive.
    """

    program: Program
    information: ca.Function
    curvature: ca.Function

    def start(self, unknowns: Array) -> Array:
        """The unknowns of a motion and its information."""
        return np.concatenate([unknowns, self.information(unknowns).full()[:, 0]])


@dataclass(frozen=True)
class _Columns:
    """States as expressions in the unknowns, one column each.

    Args:
        unknowns: the symbol, shape (n,).
        values: shape (d, K).
        derivative: of all columns, stacked, by the unknowns: shape (d K, n), sparse; constant where states are linear.
        linear: whether they are.
    """

    unknowns: ca.MX
    values: ca.MX
    derivative: ca.MX | ca.DM
    linear: bool

    @classmethod
    def of(cls, sampling: Sampling, values: ca.MX) -> "_Columns":
        slope = ca.jacobian(ca.vec(values), sampling.unknowns)
        if sampling.linear:
            slope = ca.Function("slope", [sampling.unknowns], [slope])(np.zeros(sampling.unknowns.shape[0]))
        return cls(sampling.unknowns, values, slope, sampling.linear)

    @property
    def count(self) -> int:
        return int(self.values.shape[1])

    def curvature(self, function: ca.Function, used: list[int], multipliers: ca.MX) -> ca.MX:
        """Second derivative by the unknowns of the sum over states of a function, weighed with multipliers.

        Args:
            function: of a state, shape (d,).
            used: those of its values that count.
            multipliers: of its values in each state, shape (values, K).
        """
        pattern = ca.diagcat(*[ca.Sparsity.dense(self.values.shape[0], self.values.shape[0])] * self.count)
        blocks = _weighed(function, used, 2).map(self.count)(self.values, multipliers)
        result = self.derivative.T @ (ca.MX(pattern, ca.vec(blocks)) @ self.derivative)
        if self.linear:
            return result
        pull = ca.MX.sym("pull", self.values.shape)
        own = _curvature(ca.dot(pull, self.values), self.unknowns)
        bent = ca.Function("bent", [self.unknowns, pull], [own])
        return result + bent(self.unknowns, _weighed(function, used, 1).map(self.count)(self.values, multipliers))


def lifted(problem: Problem, active: NDArray[np.bool_], letter: str, halvings: int, barrier: float) -> Lifted:
    """The lifted program.

    Args:
        problem: of any family; those with linear states are quicker.
        active: non-linear limits that are held, as `Problem.constraints` has them.
        letter: of the criterion.
        halvings: see `planner.search.objective`.
        barrier: see `Program`.
    """
    sampling, n = problem.sampling, problem.unknowns.shape[0]
    size = problem.information.shape[0]
    added = _with_share(problem.sample)
    columns = _Columns.of(sampling, ca.vertcat(*sampling.states.each, sampling.shares.T))
    slopes = _slope(added).map(columns.count)(columns.values) @ columns.derivative
    held = problem.constraints(active)
    multipliers = ca.MX.sym("multipliers", held.rows.shape[0] + size)
    of_rows, of_information = multipliers[: held.rows.shape[0]], multipliers[held.rows.shape[0] :]
    curvature = -columns.curvature(added, list(range(size)), ca.repmat(of_information, 1, columns.count))
    curvature += _of_limits(problem, active, of_rows)
    if not sampling.linear:
        rows = ca.vertcat(sampling.zeros, sampling.rows)
        weights = ca.MX.sym("weights", rows.shape[0])
        bent = ca.Function("rows", [sampling.unknowns, weights], [_curvature(ca.dot(weights, rows), sampling.unknowns)])
        curvature += bent(sampling.unknowns, of_rows[: rows.shape[0]])
    # Functions that are called, not written out: three short graphs instead of one that is copied.
    motion_alone = [sampling.unknowns]
    rows_of = ca.Function("rows", motion_alone, [held.rows, problem.information])
    gradients_of = ca.Function("gradients", motion_alone, [held.jacobian.T, ca.densify(slopes.T)])
    curvature_of = ca.Function("curvature", [sampling.unknowns, multipliers], [curvature])
    everything, factor = ca.MX.sym("everything", n + size), ca.MX.sym("factor")
    motion, triangle = everything[:n], everything[n:]
    rows, information = rows_of(motion)
    gradients, slopes = gradients_of(motion)
    zeros, free = np.zeros(size), np.full(size, np.inf)
    tall = gradients.sparsity()
    tall.resize(n + size, tall.size2())  # rows do not depend on the information
    constraints = Constraints(
        ca.vertcat(rows, triangle - information),
        ca.horzcat(ca.sparsity_cast(gradients, tall), ca.vertcat(-slopes, ca.DM.eye(size))).T,
        np.r_[held.lower, zeros],
        np.r_[held.upper, zeros],
    )
    of_criterion = curvature_function(letter, problem.size, halvings)
    hessian = ca.triu(ca.diagcat(curvature_of(motion, multipliers), factor * of_criterion(triangle)))
    program = Program(
        everything,
        objective(letter, problem.size, halvings)(triangle),
        constraints,
        np.r_[sampling.lower, -free],
        np.r_[sampling.upper, free],
        ca.Function("hessian", [everything, ca.MX.sym("p", 0), factor, multipliers], [hessian], *HESSIAN),
        barrier,
    )
    return Lifted(program, ca.Function("information", [sampling.unknowns], [problem.information]), of_criterion)


def _stacked(function: ca.Function) -> ca.Function:
    """(state as one column, shape (18,)) -> values of a function of pose, rates, accelerations."""
    state = ca.SX.sym("state", STATE)
    return ca.Function("stacked", [state], [ca.vec(function(state[:6], state[6:12], state[12:]))])


def _with_share(function: ca.Function) -> ca.Function:
    """(state and its share of the duration, shape (19,)) -> values of a function, times the share."""
    state = ca.SX.sym("state", STATE + 1)
    return ca.Function("with_share", [state], [state[STATE] * _stacked(function)(state[:STATE])])


def _slope(function: ca.Function) -> ca.Function:
    """(state) -> derivative, shape (values, d)."""
    state = ca.SX.sym("state", function.size1_in(0))
    return ca.Function("slope", [state], [ca.densify(ca.jacobian(function(state), state))])


def _weighed(function: ca.Function, used: list[int], order: int) -> ca.Function:
    """(state, multipliers) -> first, shape (d,), or second derivative, shape (d, d), of the weighed sum of values."""
    state = ca.SX.sym("state", function.size1_in(0))
    multipliers = ca.SX.sym("multipliers", function.size1_out(0))
    total = ca.dot(multipliers[used], function(state)[used])
    derivative = ca.gradient(total, state) if order == 1 else ca.hessian(total, state)[0]
    return ca.Function("weighed", [state, multipliers], [ca.densify(derivative)])


def _curvature(value: ca.MX, unknowns: ca.MX) -> ca.MX:
    return ca.hessian(value, unknowns)[0]


def _of_limits(problem: Problem, active: NDArray[np.bool_], multipliers: ca.MX) -> ca.MX:
    """Second derivatives of the non-linear limits, weighed with their multipliers: the last of the rows."""
    chosen_columns = np.flatnonzero(active.any(axis=0)).tolist()
    n = problem.unknowns.shape[0]
    if not chosen_columns:
        return ca.MX(n, n)
    columns = _Columns.of(problem.sampling, ca.vertcat(*problem.sampling.critical.each)[:, chosen_columns])
    chosen = np.flatnonzero(active[:, chosen_columns].T)
    table = ca.MX.zeros(active.shape[0] * columns.count, 1)
    table[chosen.tolist()] = multipliers[multipliers.shape[0] - len(chosen) :]
    used = np.flatnonzero(active.any(axis=1)).tolist()
    function = _stacked(problem.state_limits.shares)
    return columns.curvature(function, used, ca.reshape(table, active.shape[0], columns.count))
