"""A motion as a controller executed it: continuous in time, with struts and platform kinematics at any instant."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from identification.hexapod import Kinematics
from identification.machine import Machine

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

Array = NDArray[np.float64]


class Execution(Protocol):
    """What the machine did, from time 0 to `duration`."""

    @property
    def machine(self) -> Machine:
        """Its kinematics."""
        ...

    @property
    def duration(self) -> float:
        """Duration [s]."""
        ...

    @property
    def extremes(self) -> Array:
        """Instants among which the largest accelerations are found, shape (n,) [s]."""
        ...

    def struts(self, t: ArrayLike, order: int = 0) -> Array:
        """What drives are at at times t (struts, or joints), or its first or second derivatives, shape (n, k)."""
        ...

    def kinematics(self, t: ArrayLike) -> Kinematics:
        """Motion of the load's frame at times t, shape (n,) [s]."""
        ...


@dataclass(frozen=True, slots=True)
class DriveExecution:
    """A controller that interpolates drives by cubic splines between its cycles, as LinuxCNC does.

    Its interpolator makes a uniform cubic B-spline of the inverse kinematics, and logs positions on it; accelerations
    are straight lines between those of the cycles, and known exactly.

    Args:
        machine: kinematics.
        spline: drives over time [m or rad].
    """

    machine: Machine
    spline: "BSpline"

    @classmethod
    def of_log(cls, machine: Machine, period: float, drives: Array) -> "DriveExecution":
        """Through logged drives, shape (n, k) [m or rad], one each `period` [s]."""
        from scipy.interpolate import make_interp_spline

        return cls(machine, make_interp_spline(np.arange(len(drives)) * period, drives, k=3))

    @classmethod
    def of_set_points(cls, machine: Machine, period: float, drives: Array) -> "DriveExecution":
        """The uniform B-spline whose control points are set points, shape (n, k) [m or rad], one each `period` [s].

        It begins and ends standing still, and accelerates no more than the set points do from cycle to cycle.
        """
        held = np.vstack([drives[:1], drives, drives[-1:]])
        return cls.of_log(machine, period, (held[:-2] + 4.0 * held[1:-1] + held[2:]) / 6.0)

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return float(self.spline.t[-1])

    @property
    def extremes(self) -> Array:
        """The spline's knots, shape (n,) [s]: accelerations of the drives are straight lines between them."""
        return np.unique(self.spline.t)

    def struts(self, t: ArrayLike, order: int = 0) -> Array:
        """Drives at times t, or their first or second derivatives, shape (n, k)."""
        return np.asarray(self.spline(t, nu=order))

    def kinematics(self, t: ArrayLike) -> Kinematics:
        """Motion of the platform at times t, shape (n,) [s]."""
        return self.machine.kinematics(self.spline(t), self.spline(t, nu=1), self.spline(t, nu=2))
