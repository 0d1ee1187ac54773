"""What every family of excitations offers to the optimiser: unknowns -> motion, with CasADi's exact derivatives."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, Self

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.motion import Trajectory

Array = NDArray[np.float64]


@dataclass(frozen=True)
class States:
    """States of a motion as expressions, one column each.

    Args:
        pose: shape (6, K) [m, rad].
        rates: shape (6, K) [m/s, rad/s].
        accelerations: shape (6, K) [m/s^2, rad/s^2].
    """

    pose: ca.MX
    rates: ca.MX
    accelerations: ca.MX

    @property
    def count(self) -> int:
        """K."""
        return int(self.pose.shape[1])

    @property
    def each(self) -> tuple[ca.MX, ca.MX, ca.MX]:
        """Pose, rates, accelerations."""
        return self.pose, self.rates, self.accelerations


@dataclass(frozen=True)
class Sampling:
    """A family's motion as expressions in its unknowns.

    Args:
        unknowns: the symbol, shape (n,).
        lower: of each unknown, shape (n,).
        upper: of each unknown, shape (n,).
        states: over which information is averaged.
        shares: weight of each state, its share of the duration, shape (K, 1); they add up to 1.
        rows: limits of the coordinates, in units of their limits: -1 <= rows <= 1.
        zeros: what must be 0.
        critical: states at which non-linear limits (struts, joints) are held where they come close.
        struts: at which of these struts' velocities and which their accelerations peak, so that these limits are held
            from the start, shape (2, number of critical states).
        linear: whether the states are linear in the unknowns.
    """

    unknowns: ca.MX
    lower: Array
    upper: Array
    states: States
    shares: ca.MX
    rows: ca.MX
    zeros: ca.MX
    critical: States
    struts: NDArray[np.bool_]
    linear: bool


class Family(Protocol):
    """A family of motions from rest to rest."""

    @property
    def name(self) -> str:
        """As the command line calls it."""
        ...

    @property
    def settings(self) -> dict[str, Any]:
        """What was chosen beforehand, for `plan.json`."""
        ...

    def sampling(self, case: Case) -> Sampling:
        """The motion as expressions."""
        ...

    def start(self, draw: np.random.Generator, worst: Callable[[Array], float]) -> Array:
        """Random unknowns well inside the limits, shape (n,).

        Args:
            draw: the source of chance.
            worst: largest share of any limit that is used, of unknowns.
        """
        ...

    def motion(self, unknowns: Array) -> Trajectory:
        """The motion of unknowns of shape (n,)."""
        ...

    def shrunk(self, unknowns: Array, share: float) -> Array:
        """Unknowns of the same motion drawn towards the middle of the box: all ways times share, at equal times."""
        ...

    def refined(self, unknowns: Array) -> Self:
        """The family in which a first result is improved: a finer grid, or choices that were open and are now made."""
        ...


def box_middle(case: Case) -> tuple[Array, Array]:
    """Middle of the box of poses and half of its width, shapes (6,) [m, rad]."""
    machine, _, limits = case.need_machine("planning")
    low, high = limits.motion.pose
    return machine.home.vector + (low + high) / 2, np.asarray((high - low) / 2)
