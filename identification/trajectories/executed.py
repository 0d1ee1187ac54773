"""A motion as a controller executed it: continuous in time, with struts and platform kinematics at any instant."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from identification.hexapod import Hexapod, Kinematics

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

Array = NDArray[np.float64]


class Execution(Protocol):
    """What the machine did, from time 0 to `duration`."""

    @property
    def hexapod(self) -> Hexapod:
        """The machine's kinematics."""
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
        """Strut lengths at times t, or their first or second derivatives, shape (n, 6) [m, m/s, m/s^2]."""
        ...

    def kinematics(self, t: ArrayLike) -> Kinematics:
        """Motion of the platform at times t, shape (n,) [s]."""
        ...


@dataclass(frozen=True, slots=True)
class StrutExecution:
    """A controller that interpolates strut lengths by cubic splines between its cycles, as LinuxCNC does.

    Its interpolator makes a uniform cubic B-spline of the inverse kinematics, and logs the lengths on it; accelerations
    are straight lines between those of the cycles, and known exactly.

    Args:
        hexapod: kinematics.
        spline: strut lengths over time [m].
    """

    hexapod: Hexapod
    spline: "BSpline"

    @classmethod
    def of_log(cls, hexapod: Hexapod, period: float, lengths: Array) -> "StrutExecution":
        """Through logged lengths, shape (n, 6) [m], one each `period` [s]."""
        from scipy.interpolate import make_interp_spline

        return cls(hexapod, make_interp_spline(np.arange(len(lengths)) * period, lengths, k=3))

    @classmethod
    def of_set_points(cls, hexapod: Hexapod, period: float, lengths: Array) -> "StrutExecution":
        """The uniform B-spline whose control points are set points, shape (n, 6) [m], one each `period` [s].

        It begins and ends standing still, and accelerates no more than the set points do from cycle to cycle.
        """
        held = np.vstack([lengths[:1], lengths, lengths[-1:]])
        return cls.of_log(hexapod, period, (held[:-2] + 4.0 * held[1:-1] + held[2:]) / 6.0)

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return float(self.spline.t[-1])

    @property
    def extremes(self) -> Array:
        """The spline's knots, shape (n,) [s]: accelerations of the struts are straight lines between them."""
        return np.unique(self.spline.t)

    def struts(self, t: ArrayLike, order: int = 0) -> Array:
        """Strut lengths at times t, or their first or second derivatives, shape (n, 6) [m, m/s, m/s^2]."""
        return np.asarray(self.spline(t, nu=order))

    def kinematics(self, t: ArrayLike) -> Kinematics:
        """Motion of the platform at times t, shape (n,) [s]."""
        return self.hexapod.kinematics(self.spline(t), self.spline(t, nu=1), self.spline(t, nu=2))
