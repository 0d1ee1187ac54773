"""What every family of excitations offers to the optimiser: unknowns -> motion, with CasADi's exact derivatives."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol, Self

import numpy as np

from cases.base.units import Array, Flags
from cases.schema import Case
from identification.motion.motion import Trajectory
from planner.families.plan_settings import PlanSettings
from planner.families.rows import LinearRows, Rows
from planner.families.states import States


@dataclass(frozen=True)
class Layout:
    """A family's motion as functions of its unknowns."""

    states: States  # states over which information is averaged, with their shares of the duration
    critical: States  # states at which non-linear limits (struts, joints) are constrained
    # which of these states use the limits of poses, of velocities and of accelerations most, shape (B, S) each
    peaks: tuple[Flags, ...]
    rows: tuple[Rows, ...]  # limits of the coordinates, linear ones and those of the family
    lower: Array  # bound of each unknown, shape (n,)
    upper: Array  # bound of each unknown, shape (n,)
    standing: States | None = None  # further states at which limits of poses are constrained


class Family(Protocol):
    """A family of motions from rest to rest.

    What stands here suits families whose coordinates are linear in their unknowns (Fourier series, splines): these have
    the shape (q n,), row by row, in half widths of the box around its middle.
    """

    name: ClassVar[str]  # name on the command line
    iterations: ClassVar[int]  # number of iterations, at most, that explore from a start
    refining: ClassVar[int]  # the same of refinements: most end before, where no more is gained
    mending: ClassVar[int]  # the same where a refined motion is solved again more tightly
    duration: float  # duration of the excitation [s]
    middle: Array  # middle of the box of coordinates, shape (n,) [m or rad]
    half: Array  # half of its width, shape (n,) [m or rad]

    @property
    def settings(self) -> PlanSettings:
        """Settings that were chosen before the search."""
        ...

    def found(self, unknowns: Array) -> PlanSettings:
        """The same with what the search found itself in the place of first values."""
        return self.settings

    def layout(self, case: Case, margin: float) -> Layout:
        """The motion as functions of the unknowns; margin: share of each limit that stays unused."""
        ...

    def start(self, draw: np.random.Generator, worst: Callable[[Array], float]) -> Array:
        """Random unknowns well inside the limits, shape (n,).

        Args:
            worst: unknowns -> the largest share of any limit that they use.
        """
        ...

    def motion(self, unknowns: Array) -> Trajectory:
        """The motion of unknowns of shape (n,)."""
        ...

    def shrunk(self, unknowns: Array, share: float) -> Array:
        """Unknowns of the motion shrunk towards the middle of the box: all distances times share, at equal times."""
        return unknowns * share

    @property
    def once(self) -> Self:
        """The family of one period of these motions: limits need no check in the periods that repeat it."""
        return self

    def refined(self, unknowns: Array) -> Self:
        """The family with its open choices made: the first result is improved in it."""
        return self


def linear_rows(
    family: Family,
    case: Case,
    margin: float,
    limits: Sequence[tuple[Array, Flags]],
    slips: Array,
) -> LinearRows:
    """Limits of coordinates that are linear in their own q unknowns, all in the same way.

    Args:
        margin: share of each limit that stays unused.
        limits: maps to value, rate, acceleration and jerk in half widths: where these rows satisfy the limits the
            motion does, (L, q) each; and with which of them an optimisation begins, shape (L,).
        slips: by how much values and rates may exceed the limit between two rows, in half widths, shape (2, n).
    """
    from scipy.sparse import csr_array, kron, vstack

    box, half = case.need_motion("planning")[1], family.half
    rows, first, orders = [], [], []
    for order, limit in enumerate((half, box.rate, box.acceleration, box.jerk)):
        matrix, begins = limits[order]
        limit_of_shares = limit / half if order > 1 else limit / half - slips[order]
        limited = np.isfinite(limit_of_shares)
        if limited.any():
            rows.append(kron(csr_array(matrix), csr_array(np.diag(1.0 / limit_of_shares)[limited]), format="csr"))
            first.append(np.repeat(begins, limited.sum()))
            orders.append(np.full(rows[-1].shape[0], order))
    starts = np.concatenate(first)
    bound = np.full(len(starts), 1.0 - margin)
    return LinearRows(csr_array(vstack(rows, format="csr")), np.concatenate(orders), starts, bound)
