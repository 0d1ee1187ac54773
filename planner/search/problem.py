"""The optimal excitation problem of a family as a non-linear program.

Limits of coordinates are rows from the start. Non-linear limits (struts, joints) bind at few states: they enter only
where they are named.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.evaluate import over_samples
from identification.model import Model
from identification.motion import Trajectory
from planner.families.family import Family, Sampling
from planner.search.information import sample_information
from planner.search.objective import objective
from planner.search.state_limits import STRUT_ACCELERATION, STRUT_VELOCITY, StateLimits, state_limits

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Constraints:
    """Rows of a program with their exact derivatives.

    Args:
        rows: expressions in the unknowns.
        jacobian: their derivatives, sparse.
        lower: of each row.
        upper: of each row.
    """

    rows: ca.MX
    jacobian: ca.MX
    lower: Array
    upper: Array


@dataclass(frozen=True)
class Problem:
    """Minimise a criterion of the mean information subject to the limits.

    Args:
        sampling: unknowns, states and rows of the family.
        information: lower triangle of the mean of H A^T A H over the motion, an expression in the unknowns.
        sample: that of one state: pose, rates, accelerations -> lower triangle of H A^T A H.
        state_limits: shares of the non-linear limits of one state, and their derivatives.
        size: number of parameters.
        loads: numbers of payloads with which sensor forces are among these limits.
    """

    sampling: Sampling
    information: ca.MX
    sample: ca.Function
    state_limits: StateLimits
    size: int
    loads: tuple[int, ...] = ()

    def with_loads(self, case: Case, loads: tuple[int, ...]) -> "Problem":
        """The same with the sensor forces of more loads among its limits, behind all others."""
        loads = (*self.loads, *(load for load in loads if load not in self.loads))
        return self if loads == self.loads else replace(self, state_limits=state_limits(case, loads), loads=loads)

    @property
    def unknowns(self) -> ca.MX:
        """The symbol."""
        return self.sampling.unknowns

    def objective(self, letter: str, halvings: int = 0) -> ca.MX:
        """What to minimise; see `planner.search.objective`."""
        return objective(letter, self.size, halvings)(self.information)

    @cached_property
    def limits(self) -> ca.Function:
        """Unknowns -> shares of the non-linear limits at the critical states, shape (limits, K)."""
        critical = self.sampling.critical
        shares = self.state_limits.shares.map(critical.count)(*critical.each)
        return ca.Function("limits", [self.unknowns], [shares])

    def limit_shares(self, unknowns: Array) -> Array:
        """Share of each non-linear limit that is used at each critical state, shape (limits, K)."""
        return np.asarray(np.abs(self.limits(unknowns).full()))

    def held_from_the_start(self) -> NDArray[np.bool_]:
        """Which non-linear limits are rows at once, shape (limits, K)."""
        active = np.zeros((self.state_limits.shares.size1_out(0), self.sampling.critical.count), dtype=bool)
        active[STRUT_VELOCITY], active[STRUT_ACCELERATION] = self.sampling.struts
        return active

    def constraints(self, active: NDArray[np.bool_]) -> Constraints:
        """All linear rows, and the non-linear limits where `active`, shape (limits, K), is set.

        CasADi's own Jacobian of the same rows takes ten times as long: it does not see that a limit depends on one
        state only. Here it is the block-diagonal derivative by the states times that of the states. Matrices are stored
        by columns: its transpose is put together, which only appends.
        """
        zeros, rows = self.sampling.zeros, self.sampling.rows
        lower = np.r_[np.zeros(zeros.shape[0]), -np.ones(rows.shape[0])]
        values, gradients = [zeros, rows], [ca.jacobian(part, self.unknowns).T for part in (zeros, rows)]
        columns = np.flatnonzero(active.any(axis=0))
        if len(columns):
            some = [m[:, columns.tolist()] for m in self.sampling.critical.each]
            count, height = len(columns), self.state_limits.shares.size1_out(0)
            chosen = np.flatnonzero(active[:, columns].T).tolist()
            blocks = ca.diagcat(*[ca.Sparsity.dense(18, height)] * count)
            by_states = ca.MX(blocks, ca.vec(self.state_limits.gradients.map(count)(*some)))
            states = ca.jacobian(ca.vec(ca.vertcat(*some)), self.unknowns)
            values.append(ca.vec(self.state_limits.shares.map(count)(*some))[chosen])
            gradients.append(states.T @ by_states[:, chosen])
            lower = np.r_[lower, -np.ones(len(chosen))]
        return Constraints(ca.vertcat(*values), ca.horzcat(*gradients).T, lower, -lower)

    def worst(self) -> Callable[[Array], float]:
        """The largest share of any limit that unknowns use."""
        rows = ca.Function("rows", [self.unknowns], [self.sampling.rows])
        return lambda values: max(float(np.abs(rows(values).full()).max()), float(self.limit_shares(values).max()))


def build_problem(case: Case, model: Model, family: Family, scaling: Array) -> Problem:
    """Builds the program.

    Args:
        case: machine and limits.
        model: parameters to be identified.
        family: what the unknowns mean.
        scaling: reference scaling, shape (u,).
    """
    sampling = family.sampling(case)
    states = sampling.states
    sample = sample_information(model, scaling)
    information = sample.map(states.count)(*states.each) @ sampling.shares
    return Problem(sampling, information, sample, state_limits(case), len(scaling))


def mean_information(model: Model, scaling: Array, trajectory: Trajectory, rate: float = 1000.0) -> Array:
    """Time average of H A^T A H over a trajectory, shape (u, u); W = 1.

    Args:
        model: gives A.
        scaling: diagonal of H, shape (u,).
        trajectory: the whole excitation.
        rate: samples a second [1/s].
    """
    count = max(2, int(np.ceil(trajectory.duration * rate)))
    motion = trajectory.at((np.arange(count) + 0.5) * trajectory.duration / count)
    matrices = over_samples(model.coordinate_regressor, motion.pose, motion.rates, motion.accelerations)[0]
    rows = matrices.reshape(-1, len(scaling)) * scaling
    return np.asarray(rows.T @ rows / count)
