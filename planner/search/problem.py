"""The optimal excitation problem of a family: its program with every limit that can bind."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.evaluate import over_samples
from identification.model import Model
from identification.motion import Trajectory
from planner.families.family import Family, Layout
from planner.search.program import Program, regressor_kernel
from planner.search.rows import StateRows
from planner.search.state_limits import LimitGroup, binding_limits

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Problem:
    """Minimise a criterion of the mean information subject to the limits.

    Args:
        layout: the family's motion as functions of the unknowns.
        program: with all rows.
        limits: non-linear limits that can bind, one for each of the program's last rows.
    """

    layout: Layout
    program: Program
    limits: tuple[LimitGroup, ...]

    def _of_states(self) -> tuple[StateRows, ...]:
        return tuple(rows for rows in self.program.rows if isinstance(rows, StateRows))

    def worst(self, unknowns: Array) -> float:
        """The largest share of any limit that unknowns use, at all critical states."""
        shares = [np.abs(rows.values(unknowns)).max() for rows in self.layout.rows if not np.array_equal(rows.lower, rows.upper)]
        shares += [np.abs(rows.all_values(unknowns)).max() for rows in self._of_states()]
        return float(max(shares))

    def with_rows_above(self, unknowns: Array, share: float) -> "Problem":
        """The same with rows for all critical states that use more than a share of a limit."""
        rows = tuple(
            replace(part, chosen=part.chosen | (np.abs(part.all_values(unknowns)) > share)) for part in self._of_states()
        )
        return replace(self, program=self.program.with_rows(*self.layout.rows, *rows))


def build_problem(case: Case, model: Model, family: Family, scaling: Array, margin: float) -> Problem:
    """Builds the program of criterion D.

    Args:
        case: machine and limits.
        model: parameters to be identified.
        family: what the unknowns mean.
        scaling: reference scaling, shape (u,).
        margin: share of each limit that is left free.
    """
    layout, limits = family.layout(case, margin), binding_limits(case)
    rows = tuple(
        StateRows(
            layout.critical,
            group.kernel,
            np.repeat(layout.peaks[group.peak][:, :, None], group.kernel.size, axis=2),
            1.0 - margin,
        )
        for group in limits
    )
    program = Program(
        layout.states, regressor_kernel(model, scaling), (*layout.rows, *rows), layout.lower, layout.upper
    )
    return Problem(layout, program, limits)


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
