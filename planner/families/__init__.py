"""What every family of excitations offers to the optimiser: unknowns -> motion, with CasADi's exact derivatives.

Families whose coordinates are linear in their unknowns (Fourier series, B-splines) are a `LinearFamily`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self, runtime_checkable

import numpy as np

from cases.schema import Case
from cases.units import Array, Flags
from identification.motion import Trajectory
from planner.families.rows import LinearRows, Rows
from planner.families.states import States, linear_states


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
    """A family of motions from rest to rest."""

    name: ClassVar[str]  # name on the command line
    iterations: ClassVar[int]  # number of iterations, at most, that explore from a start
    mending: ClassVar[int]  # the same where a refined motion is solved again more tightly

    @property
    def shipped(self) -> str:
        """Name of the motion that comes with hexcite from which a search begins."""
        ...

    @property
    def duration(self) -> float:
        """Duration of the excitation [s]."""
        ...

    @property
    def settings(self) -> dict[str, Any]:
        """Settings that were chosen before the search, for `plan.json`."""
        ...

    def layout(self, case: Case, margin: float) -> Layout:
        """The motion as functions of the unknowns; margin: share of each limit that stays unused."""
        ...

    def like(self, table: Array) -> Array | None:
        """Unknowns that resemble the motion of another machine, whatever the limits; None where it does not fit."""
        ...

    def motion(self, unknowns: Array) -> Trajectory:
        """The motion of unknowns of shape (n,)."""
        ...

    def shrunk(self, unknowns: Array, share: float) -> Array:
        """Unknowns of the motion shrunk towards the middle of the box: all distances times share, at equal times."""
        ...

    @property
    def once(self) -> Self:
        """The family of one period of these motions: limits need no check in the periods that repeat it."""
        ...

    def refined(self, unknowns: Array) -> Self:
        """The family with its open choices made: the first result is improved in it."""
        ...


@dataclass(frozen=True)
class LinearMaps:
    """How coordinates depend on their own unknowns, all in the same way: matrices from q unknowns to half widths."""

    samples: tuple[Array, ...]  # maps to value, rate and acceleration at the samples of information, (K, q) each
    shares: Array  # share of the duration that each sample stands for, shape (K,); they add up to 1
    critical: tuple[Array, ...]  # the same three at the instants where non-linear limits are constrained, (C, q)
    peaks: tuple[Flags, ...]  # as `Layout.peaks`
    blocks: int  # number B of blocks of equally many successive samples that depend on few unknowns each
    # maps to value, rate, acceleration and jerk: where these rows satisfy the limits the motion does, (L, q) each
    limits: tuple[Array, ...]
    first: tuple[Flags, ...]  # which of these rows an optimisation begins with, shapes (L,)
    slips: Array  # by how much values and rates may exceed the limit between two rows, in half widths, shape (2, n)
    growth: float = np.inf  # a bound g with max|x'| <= g max|x| for every motion [1/s]


@runtime_checkable
class LinearFamily(Protocol):
    """A family whose coordinates are linear in its unknowns.

    Unknowns have the shape (q n,), row by row, in half widths of the box around its middle.
    """

    name: ClassVar[str]
    middle: Array  # middle of the box of coordinates, shape (n,) [m or rad]
    half: Array  # half of its width, shape (n,) [m or rad]

    @property
    def shipped(self) -> str:
        """The same motion for every machine."""
        return self.name

    def maps(self) -> LinearMaps:
        """How the coordinates depend on the unknowns."""
        ...

    def start(self, draw: np.random.Generator, worst: Callable[[Array], float]) -> Array:
        """Random unknowns well inside the limits, shape (n,).

        Args:
            worst: unknowns -> the largest share of any limit that they use.
        """
        ...

    def layout(self, case: Case, margin: float) -> Layout:
        """The motion as functions of the unknowns.

        Limits of a derivative that other limits prove to be satisfied (`LinearMaps.growth`) are omitted.
        """
        from scipy.sparse import csr_array, kron, vstack

        maps, middle, half = self.maps(), self.middle, self.half
        box = case.need_motion("planning")[1]
        rows, first, orders = [], [], []
        bounds = np.ones(len(half))  # what is known to bound the derivative before, in half widths
        for order, (matrix, limit) in enumerate(
            zip(maps.limits, (half, box.rate, box.acceleration, box.jerk), strict=True)
        ):
            own = limit / half if order > 1 else limit / half - maps.slips[order]
            needed = np.ones(len(half), dtype=bool) if order == 0 else maps.growth * bounds > own
            bounds = own if order == 0 else np.minimum(maps.growth * bounds, own)
            if needed.any():
                rows.append(kron(csr_array(matrix), csr_array(np.diag(1.0 / own)[needed]), format="csr"))
                first.append(np.repeat(maps.first[order], needed.sum()))
                orders.append(np.full(rows[-1].shape[0], order))
        table, starts = csr_array(vstack(rows, format="csr")), np.concatenate(first)
        free = np.full(table.shape[1], np.inf)
        still = np.zeros(len(maps.critical[0]))
        return Layout(
            states=linear_states(maps.samples, middle, half, maps.shares, maps.blocks),
            critical=linear_states(maps.critical, middle, half, still, maps.blocks),
            peaks=maps.peaks,
            rows=(LinearRows(table, np.concatenate(orders), starts, np.full(len(starts), 1.0 - margin)),),
            lower=-free,
            upper=free,
        )

    def shrunk(self, unknowns: Array, share: float) -> Array:
        """Unknowns of the motion shrunk towards the middle of the box."""
        return unknowns * share

    @property
    def once(self) -> Self:
        """The family itself: no motion repeats."""
        return self

    def refined(self, unknowns: Array) -> Self:
        """The family itself: no choice is open."""
        return self
