"""Poses of a chain to stand still at: positions of joints in the box of `[limits.motion]`, clear of everything."""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.limit import TOLERANCE
from identification.limit_proof import everything, shares_at
from identification.machines import Machine, machine_of
from identification.motion import StandingPoses
from planner.search.state_limits import standing_limits

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class JointSpace:
    """The joints' part of the motion box among which refinement searches; a `PoseSpace` of chains."""

    case: Case  # case with a chain
    machine: Machine  # its kinematics
    middle: Array  # of the box, shape (n,) [m or rad]
    half: Array  # half of its sides, shape (n,) [m or rad]

    @classmethod
    def of(cls, case: Case) -> "JointSpace":
        """The space of a case; raises CaseError where it has no chain or no limits."""
        chain, limits = case.need_chain("pose candidates")
        return cls(case, machine_of(case), chain.home + limits.pose.mean(axis=0), np.ptp(limits.pose, axis=0) / 2)

    @property
    def size(self) -> int:
        """Number of joints n."""
        return len(self.middle)

    def bounds(self) -> Array:
        """Lower and upper bound of each coordinate, shape (2, n)."""
        return np.vstack([-np.ones(self.size), np.ones(self.size)])

    def shares(self, poses: Array) -> Array:
        """Coordinates of poses, shape (k, n)."""
        return np.asarray((poses - self.middle) / self.half)

    def project(self, shares: Array) -> Array:
        """The nearest shares that lie in the box, shape (k, n)."""
        return np.clip(shares, -1.0, 1.0)

    def poses(self, shares: Array, like: Array) -> Array:
        """Poses of coordinates, shape (k, n) [m or rad]; `like` is not needed."""
        del like
        return np.asarray(self.middle + self.half * shares)

    def expression(self, share: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Position and R of one pose, shapes (3,) and (3, 3)."""
        still = ca.SX.zeros(self.size)
        frame = self.machine.frame(self._pose(share), still, still)
        return frame.position, frame.rotation

    def margins(self, share: ca.SX, like: ca.SX) -> ca.SX:
        """What must not be below 0: clearances, torques and sensor forces at rest; `like` is not needed."""
        del like
        return 1 - ca.fabs(standing_limits(self.case)(self._pose(share)))

    def valid(self, poses: Array) -> NDArray[np.bool_]:
        """Whether the machine can stand at each pose, by the proof of limits, shape (k,)."""
        if not len(poses):
            return np.zeros(0, dtype=bool)
        shares = shares_at(StandingPoses(poses), self.case, np.arange(len(poses), dtype=float), True, everything)
        return np.asarray(shares.max(axis=1) <= 1.0 + TOLERANCE)

    def _pose(self, share: ca.SX) -> ca.SX:
        return ca.DM(self.middle) + ca.DM(self.half) * share
