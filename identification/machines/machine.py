"""What a machine offers to motions, models and the search: from its coordinates to the frame that carries the load.

Coordinates are what motions are planned in, drives what encoders measure: the pose and the struts of a hexapod, for a
chain both the positions of its joints. A new kind of machine is a class with the members of `Machine`, and a line in
`machine_of` of `of_case.py`.
"""

from dataclasses import dataclass
from typing import Protocol

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from cases.base.units import Array
from cases.schema import Case
from identification.limits.limit import LimitKind

FrameMotion = tuple[ca.SX, ca.SX, ca.SX, ca.SX]
"""Motion of the frame {P} of the load in {B}: position of its origin [m], R, twist [m/s, rad/s] and twist rate."""


VICINITY = 0.25  # [m] in which the share of a named distance falls by a factor of e: as far as motions travel
Share = tuple[LimitKind, int, ca.SX]
"""A limit beside those of the coordinates: its kind, the order of the derivative with which it grows (0 coordinates,
1 rates, 2 accelerations), and the shares that are used; it is satisfied between -1 and 1."""


@dataclass(frozen=True, slots=True)
class Kinematics:
    """Motion of the platform, one row a sample."""

    pose: Array  # (x, y, z, roll, pitch, yaw), shape (n, 6) [m, rad]
    twist: Array  # velocity of the origin of {P} and angular velocity in {B}, shape (n, 6) [m/s, rad/s]
    twist_rate: Array  # its time derivative, shape (n, 6) [m/s^2, rad/s^2]


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

    @property
    def named_distances(self) -> list[str]:
        """Names, as a proof gives them, of the first `shares`: distances with a name of their own."""
        ...

    def shares(self, case: Case, coordinates: ca.SX, rates: ca.SX, accelerations: ca.SX, /) -> list[Share]:
        """Limits of the case beside those of the coordinates, for the search; the proof has its own."""

    def positions(self, coordinates: Array) -> Array:
        """Positions of the origin of the load's frame, shape (k, 3) [m]."""

    def drives(self, coordinates: ArrayLike, /) -> Array:
        """Positions of the drives, which encoders measure, at coordinates, shape (k, n) [m or rad]."""

    def further_drives(
        self, case: Case, coordinates: Array, rates: Array, accelerations: Array, /
    ) -> tuple[list[Array], tuple[Array, Array]]:
        """Rates and accelerations of drives that are not the coordinates, shapes (k, d), and limits of both, (d,)."""

    def coordinates(self, drives: ArrayLike, /) -> Array:
        """The coordinates of measured drives, shapes (k, n) [m or rad]; raises IdentificationError without any."""

    def kinematics(
        self, drives: ArrayLike, velocities: ArrayLike, accelerations: ArrayLike, near: Array | None = None, /
    ) -> Kinematics:
        """Motion of the load's frame from that of the drives, shapes (k, n) [m or rad].

        Poses `near` those of the load's frame, shape (k, 6) [m, rad], are where a search for them may begin.
        Raises IdentificationError where no coordinates have such drives.
        """
