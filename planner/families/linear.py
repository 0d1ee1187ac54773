"""Sampling of families whose coordinates are linear in their unknowns (Fourier series, B-splines)."""

from collections.abc import Sequence
from typing import Protocol

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from planner.families.family import Sampling, States, box_middle

Array = NDArray[np.float64]


class Maps(Protocol):
    """Linear maps of a family; unknowns of shape (q * 6,), row by row, in half widths of the box around its middle."""

    @property
    def unknowns(self) -> int:
        """Unknowns of each coordinate, q."""
        ...

    def maps(self) -> tuple[Array, Array, Array, Array]:
        """Matrices (K, q) from unknowns to value, rate, acceleration and jerk at the samples of information."""
        ...

    def weights(self) -> Array:
        """Share of the duration that each sample of `maps` stands for, shape (K,); they add up to 1."""
        ...

    def struts(self) -> NDArray[np.bool_]:
        """At which of the `critical_maps` strut velocities and accelerations are held from the start, shape (2, C)."""
        ...

    def limit_maps(self) -> tuple[Array, Array, Array, Array]:
        """Matrices (L, q) whose rows, kept within the limits, keep the motion within them."""
        ...

    def slips(self) -> tuple[Array, Array]:
        """What values and rates may pass their rows by between two of them, in half widths, shapes (6,)."""
        ...

    def critical_maps(self) -> tuple[Array, Array, Array]:
        """Matrices (C, q) to value, rate and acceleration where non-linear limits are held."""
        ...

    def growth(self) -> float:
        """A bound g with max|x'| <= g max|x| for every motion of the family [1/s]; infinity where there is none."""
        ...


def linear_sampling(case: Case, family: Maps) -> Sampling:
    """States and rows of a linear family.

    Limits of a derivative that others prove to be kept (`growth`) are left out.
    """
    middle, half = box_middle(case)
    box = case.need_machine("planning")[2].motion
    unknowns = ca.MX.sym("unknowns", family.unknowns * 6)
    table = ca.reshape(unknowns, 6, family.unknowns).T
    to_si = ca.diag(ca.DM(half))

    def states_of(maps: Sequence[Array]) -> States:
        value, rate, acceleration = (to_si @ (ca.sparsify(ca.DM(m)) @ table).T for m in maps)
        return States(value + ca.repmat(ca.DM(middle), 1, value.shape[1]), rate, acceleration)

    states, critical = states_of(family.maps()[:3]), states_of(family.critical_maps())
    rows = []
    reached = np.ones(6)  # what is known to bound the derivative before, in half widths
    for order, (matrix, limit) in enumerate(
        zip(family.limit_maps(), (half, box.rate, box.acceleration, box.jerk), strict=True)
    ):
        own = limit / half if order > 1 else limit / half - family.slips()[order]
        needed = list(range(6)) if order == 0 else np.flatnonzero(family.growth() * reached > own).tolist()
        reached = own if order == 0 else np.minimum(family.growth() * reached, own)
        if needed:
            share = ca.sparsify(ca.DM(matrix)) @ table
            rows.append(ca.vec((share @ ca.diag(ca.DM(1.0 / own)))[:, needed]))
    size = family.unknowns * 6
    return Sampling(
        unknowns=unknowns,
        lower=np.full(size, -np.inf),
        upper=np.full(size, np.inf),
        states=states,
        shares=ca.MX(ca.DM(family.weights())),
        rows=ca.vertcat(*rows),
        zeros=ca.MX(0, 1),
        critical=critical,
        struts=family.struts(),
        linear=True,
    )
