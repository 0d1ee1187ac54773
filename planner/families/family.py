"""What every family of excitations offers to the optimiser: unknowns -> motion, with CasADi's exact derivatives."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.motion import Trajectory
from planner.search.rows import Rows
from planner.search.states import Peak, States

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Layout:
    """A family's motion as functions of its unknowns.

    Args:
        states: states over which information is averaged, with their shares of the duration.
        critical: states at which non-linear limits (struts, joints) are constrained.
        peaks: peaks at which of these, of each kind, shape (B, S) each.
        rows: limits of the coordinates, linear ones and those of the family.
        lower: bound of each unknown, shape (n,).
        upper: bound of each unknown, shape (n,).
        standing: states besides, at which limits of poses are constrained.
    """

    states: States
    critical: States
    peaks: Mapping[Peak, NDArray[np.bool_]]
    rows: tuple[Rows, ...]
    lower: Array
    upper: Array
    standing: States | None = None


class Family(Protocol):
    """A family of motions from rest to rest."""

    @property
    def name(self) -> str:
        """As the command line calls it."""
        ...

    @property
    def shipped(self) -> str:
        """Name of the motion that comes with hexcite from which a search begins."""
        ...

    @property
    def iterations(self) -> int:
        """Largest number of the solver's that explore from a start."""
        ...

    @property
    def duration(self) -> float:
        """Of the excitation [s]."""
        ...

    @property
    def settings(self) -> dict[str, Any]:
        """What was chosen beforehand, for `plan.json`."""
        ...

    def layout(self, case: Case, margin: float) -> Layout:
        """The motion as functions of the unknowns; margin: share of each limit that is left free."""
        ...

    def start(self, draw: np.random.Generator, worst: Callable[[Array], float]) -> Array:
        """Random unknowns well inside the limits, shape (n,).

        Args:
            draw: the source of chance.
            worst: largest share of any limit that is used, of unknowns.
        """
        ...

    def like(self, table: Array) -> Array | None:
        """Unknowns like those of another machine's motion, limits apart; None where it does not fit.

        Args:
            table: what `table` gave there.
        """
        ...

    def table(self, unknowns: Array) -> Array:
        """Unknowns in units that do not depend on the machine."""
        ...

    def motion(self, unknowns: Array) -> Trajectory:
        """The motion of unknowns of shape (n,)."""
        ...

    def shrunk(self, unknowns: Array, share: float) -> Array:
        """Unknowns of the same motion drawn towards the middle of the box: all ways times share, at equal times."""
        ...

    def refined(self, unknowns: Array) -> Self:
        """The family with choices made that were open: the first result is improved in it."""
        ...


def box_middle(case: Case) -> tuple[Array, Array]:
    """Middle of the box of coordinates and half of its width, shapes (n,) [m or rad]."""
    home, limits = case.need_motion("planning")
    low, high = limits.pose
    return home + (low + high) / 2, np.asarray((high - low) / 2)
