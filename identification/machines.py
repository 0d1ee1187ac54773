"""What planning, runs and evaluation ask of a machine: from its coordinates to the frame that carries the load.

Coordinates are what motions are planned in, drives what encoders measure: the pose and the struts of a hexapod, for a
chain both the positions of its joints. Whoever asks for less than a hexapod's struts takes a machine from here, and so
knows no kind of machine; a new kind is a class with these members, and a line in `machine_of`.
"""

from typing import Protocol

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from cases.errors import CaseError
from cases.schema import Case
from identification.hexapod import Hexapod, Kinematics
from identification.machine_limits import Share
from identification.serial_chain import SerialChain
from identification.symbolic import FrameMotion, over_samples

Array = NDArray[np.float64]


class Machine(Protocol):
    """A machine that moves the frame of the load."""

    @property
    def count(self) -> int:
        """Number of coordinates n."""

    @property
    def of_pose(self) -> bool:
        """Whether its coordinates are the pose (x, y, z, roll, pitch, yaw) of the load's frame."""

    @property
    def elastic(self) -> bool:
        """Whether its sensors err with the pose as the error terms K1 to K5 say."""

    @property
    def turns(self) -> NDArray[np.bool_]:
        """Which drives measure angles, shape (n,)."""

    def frame(self, coordinates: ca.SX, rates: ca.SX, accelerations: ca.SX, /) -> FrameMotion:
        """Motion of the load's frame from coordinates and their derivatives, shapes (n,)."""

    def shares(self, case: Case, coordinates: ca.SX, rates: ca.SX, accelerations: ca.SX, /) -> list[Share]:
        """Limits of the case beside those of the coordinates, for the search; the proof has its own."""

    def positions(self, coordinates: Array) -> Array:
        """Where the origin of the load's frame is, shape (k, 3) [m]."""

    def drives(self, coordinates: ArrayLike, /) -> Array:
        """What encoders measure at coordinates, shape (k, n) [m or rad]."""

    def coordinates(self, drives: ArrayLike, /) -> Array:
        """The coordinates that belong to measured drives, shape (k, n) [m or rad].

        Raises:
            IdentificationError: no coordinates do.
        """

    def kinematics(
        self, drives: ArrayLike, velocities: ArrayLike, accelerations: ArrayLike, start: Array | None = None, /
    ) -> Kinematics:
        """Motion of the load's frame from that of the drives, shapes (k, n) [m or rad].

        From poses near by, where they are known, shape (k, 6).

        Raises:
            IdentificationError: no coordinates belong to the drives.
        """

    def earlier(self, motion: Kinematics, time: float) -> Array | None:
        """Poses about a short time [s] before, for `start`, shape (k, 6); None where they are of no use."""


def machine_of(case: Case) -> Machine:
    """The machine of a case.

    Raises:
        CaseError: the case has no machine, or one that does not move the sensors.
    """
    return SerialChain.of(case) if case.chain is not None else Hexapod.of(case)


def machine_if_any(case: Case) -> Machine | None:
    """The machine of a case; None where it has none that can be planned for."""
    try:
        return machine_of(case)
    except CaseError:
        return None


def kinetic(
    case: Case, pose: Array, rates: Array, accelerations: Array
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Motion of what has limits of rates and accelerations beside the coordinates, along a motion in these.

    Args:
        pose: coordinates, shape (n, c); `rates` and `accelerations` are their derivatives.

    Returns:
        Velocities [m/s] and accelerations [m/s^2] of the k = 6 struts of a hexapod, shapes (n, k), and the limits of
        both, shapes (k,); a chain has none, k = 0.

    Raises:
        CaseError: the case has no machine or no limits.
    """
    if case.chain is not None:
        none = np.zeros((len(pose), 0))
        return (none, none), (none[:0].ravel(), none[:0].ravel())
    limits = case.need_machine("the motion of struts")[2]
    _, velocities, second = over_samples(Hexapod.of(case).strut_motion, pose, rates, accelerations)
    six = np.ones(6)
    return (velocities, second), (limits.strut_velocity_m_s * six, limits.strut_acceleration_m_s2 * six)
