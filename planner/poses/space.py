"""Poses to stand still at: the space that a case's grid spans, or the box of a chain's joints, and which are valid.

A chain's poses are positions of joints in the box of `[limits.motion]`, clear of everything.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.schema import Case
from cases.units import DEG
from identification.hexapod import Hexapod
from identification.keep_out import distances
from identification.limit import TOLERANCE
from identification.limit_proof import everything, shares_at
from identification.model import machine_of
from identification.motion import Array, StandingPoses
from identification.symbolic import over_samples, rotation, rpy
from planner.search.problem import standing_limits

SIZE = 5  # x, y, two of tilt, torsion; z stays where it is, for no static model depends on it


@dataclass(frozen=True, slots=True)
class PoseSpace:
    """The poses among which refinement searches: a disc, all tilts up to the largest, a range of torsion."""

    case: Case  # case with a hexapod
    home: Array  # position of {P} at home, shape (3,) [m]
    radius: float  # radius of the disc [m]
    low: Array  # lower end of the XY range relative to home, shape (2,) [m]
    high: Array  # upper end, shape (2,) [m]
    tilt: float  # tangent of half the largest tilt
    torsion: Array  # smallest and largest, shape (2,) [rad]

    @classmethod
    def of(cls, case: Case) -> "PoseSpace":
        """The space that the case's grid spans; raises CaseError where the case lacks machine or poses."""
        home = case.need_machine("pose candidates")[0].home.vector[:3]
        grid = case.need_poses("pose candidates")
        x, y, _ = grid.lengths
        torsion = grid.angles[2][[0, -1]]
        low, high = np.array([x[0], y[0]]), np.array([x[-1], y[-1]])
        return cls(case, home, float(grid.radius[1]), low, high, float(np.tan(grid.angles[0][-1] / 2)), torsion)

    @property
    def _torsion_middle(self) -> tuple[float, float]:
        half = float(np.ptp(self.torsion)) / 2
        return float(self.torsion.mean()), half if half > 0.0 else 1.0

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return SIZE

    def bounds(self) -> Array:
        """Lower and upper bound of each coordinate, shape (2, 5)."""
        middle, half = self._torsion_middle
        ends = np.column_stack([self.low / self.radius, self.high / self.radius]).T
        ends = np.clip(ends, -1.0, 1.0)
        torsion = (self.torsion - middle) / half
        return np.column_stack([ends, [[-1.0, -1.0], [1.0, 1.0]], torsion])

    def shares(self, poses: Array) -> Array:
        """Coordinates of poses, shape (n, 5)."""
        turn = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()
        normal = turn[:, :, 2]
        tilt = np.column_stack([-normal[:, 1], normal[:, 0]]) / (1.0 + normal[:, 2])[:, None]
        tilted = Rotation.from_quat(np.column_stack([tilt, np.zeros(len(poses)), np.ones(len(poses))])).as_matrix()
        rotation = tilted.transpose(0, 2, 1) @ turn
        middle, half = self._torsion_middle
        torsion = (np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0]) - middle) / half
        return np.column_stack([(poses[:, :2] - self.home[:2]) / self.radius, tilt / self.tilt, torsion])

    def project(self, shares: Array) -> Array:
        """The nearest shares that lie in the space, shape (n, 5): ranges first, then disc and largest tilt."""
        low, high = self.bounds()
        inside = np.clip(shares, low, high)
        for part in (slice(0, 2), slice(2, 4)):
            inside[:, part] /= np.maximum(np.linalg.norm(inside[:, part], axis=1, keepdims=True), 1.0)
        return inside

    def poses(self, shares: Array, like: Array) -> Array:
        """Poses of coordinates, shape (n, 6) [m, rad].

        Args:
            shares: shape (n, 5).
            like: poses at the same heights, shape (n, 6) [m, rad].
        """
        middle, half = self._torsion_middle
        one, none = np.ones(len(shares)), np.zeros(len(shares))
        tilted = Rotation.from_quat(np.column_stack([shares[:, 2:4] * self.tilt, none, one]))
        turn = tilted * Rotation.from_rotvec(np.column_stack([none, none, middle + half * shares[:, 4]]))
        return np.column_stack([self.home[:2] + self.radius * shares[:, :2], like[:, 2], turn.as_euler("xyz")])

    def pose(self, share: ca.SX, like: ca.SX) -> ca.SX:
        """One pose of the height of another, `like`, shape (6,)."""
        middle, half = self._torsion_middle
        a, b = self.tilt * share[2], self.tilt * share[3]
        norm = 1 + a * a + b * b
        tilted = (
            ca.vertcat(
                ca.horzcat(1 + a * a - b * b, 2 * a * b, 2 * b),
                ca.horzcat(2 * a * b, 1 - a * a + b * b, -2 * a),
                ca.horzcat(-2 * b, 2 * a, 1 - a * a - b * b),
            )
            / norm
        )
        c, s = ca.cos(middle + half * share[4]), ca.sin(middle + half * share[4])
        about_z = ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))
        return ca.vertcat(ca.DM(self.home[:2]) + self.radius * share[:2], like[2], rpy(tilted @ about_z))

    def margins(self, share: ca.SX, like: ca.SX) -> ca.SX:
        """Margins at such a pose, which must not be negative: edges of the space, machine."""
        inside = validity_margins(self.case)(self.pose(share, like))
        return ca.vertcat(1 - ca.sumsqr(share[:2]), 1 - ca.sumsqr(share[2:4]), inside)

    def valid(self, poses: Array) -> NDArray[np.bool_]:
        """Whether the machine can stand at each pose, shape (n,)."""
        return valid_poses(self.case, poses)


@dataclass(frozen=True, slots=True)
class JointSpace:
    """The joints' part of the motion box among which refinement searches; a `PoseSpace` of chains."""

    case: Case  # case with a chain
    middle: Array  # middle of the box, shape (n,) [m or rad]
    half: Array  # half of its sides, shape (n,) [m or rad]

    @classmethod
    def of(cls, case: Case) -> "JointSpace":
        """The space of a case; raises CaseError where it has no chain or no limits."""
        chain, limits = case.need_chain("pose candidates")
        return cls(case, chain.home + limits.pose.mean(axis=0), np.ptp(limits.pose, axis=0) / 2)

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

    def pose(self, share: ca.SX, like: ca.SX) -> ca.SX:
        """One pose, shape (n,); `like` is not needed."""
        del like
        return ca.DM(self.middle) + ca.DM(self.half) * share

    def margins(self, share: ca.SX, like: ca.SX) -> ca.SX:
        """Margins, which must not be negative: clearances, torques and sensor forces at rest."""
        return 1 - ca.fabs(standing_limits(self.case)(self.pose(share, like)))

    def valid(self, poses: Array) -> NDArray[np.bool_]:
        """Whether the machine can stand at each pose, by the proof of limits, shape (k,)."""
        if not len(poses):
            return np.zeros(0, dtype=bool)
        shares = shares_at(StandingPoses(poses), self.case, np.arange(len(poses), dtype=float), True, everything)
        return np.asarray(shares.max(axis=1) <= 1.0 + TOLERANCE)


def space_of(case: Case) -> PoseSpace | JointSpace:
    """The poses among which refinement searches; raises CaseError where the case lacks machine or poses."""
    return PoseSpace.of(case) if case.chain is None else JointSpace.of(case)


ROUNDING = 1e-9  # poses on the very edge of the workspace are valid
REASONS = (
    *(f"strut {k} too short" for k in range(1, 7)),
    *(f"strut {k} too long" for k in range(1, 7)),
    *(f"base joint {k} beyond its angle" for k in range(1, 7)),
    *(f"platform joint {k} beyond its angle" for k in range(1, 7)),
    "too close to a singularity",
    *("x below the workspace", "x above the workspace", "y below the workspace", "y above the workspace"),
)


def validity_margins(case: Case) -> ca.Function:
    """Pose -> margins, shape (29,), each a share of its limit; the pose is valid where none is below 0.

    In the order of `REASONS`: strut lengths from below and above over the range of lengths; cosines of the angles at
    base and platform less those of their limits; determinant of J_Hex^-1 over that at home less the smallest share;
    position in the XY range over its width.

    Raises:
        CaseError: the case lacks machine, workspace or poses.
    """
    machine, workspace, _ = case.need_machine("the validity of poses")
    hexapod = Hexapod.of(case)
    pose = ca.SX.sym("pose", 6)
    lengths, jacobian = hexapod.inverse_jacobian(pose)
    normal = rotation(pose[3:])[:, 2]
    directions = jacobian[:, :3]  # unit vectors along the struts, row by row
    at_base = directions[:, 2] - float(np.cos(workspace.base_joint_angle_deg * DEG))
    at_platform = directions @ normal - float(np.cos(workspace.platform_joint_angle_deg * DEG))
    shortest, longest = workspace.strut_length
    home = np.linalg.det(hexapod.inverse_jacobian(machine.home.vector)[1].full())
    singularity = ca.det(jacobian) / float(home) - case.need_poses("the validity of poses").singularity_distance
    in_range = []
    for axis, (low, high) in enumerate((workspace.x_mm, workspace.y_mm)):
        value = (pose[axis] - machine.home.vector[axis]) / 1e-3
        in_range += [(value - low) / (high - low), (high - value) / (high - low)]
    width = longest - shortest
    margins = ca.vertcat(
        (lengths - shortest) / width, (longest - lengths) / width, at_base, at_platform, singularity, *in_range
    )
    return ca.Function("validity_margins", [pose], [ca.densify(margins)], {"cse": True})


def margins_of(case: Case, poses: Array) -> Array:
    """Margins of poses, shape (n, 29)."""
    return over_samples(validity_margins(case), poses)[0]


def valid_poses(case: Case, poses: Array) -> NDArray[np.bool_]:
    """Whether the machine can stand at each pose, outside every keep-out box, shape (n,)."""
    machine, workspace, _ = case.need_machine("the validity of poses")
    valid = np.all(margins_of(case, poses) >= -ROUNDING, axis=1)
    turn, origin, base = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix(), poses[:, :3], machine.base.points
    strut = origin[:, None] + machine.platform.points @ turn.transpose(0, 2, 1) - base
    for box in workspace.keep_out:
        valid &= distances(box, workspace, origin, turn, base, strut).min(axis=1) >= 0.0
    return np.asarray(valid)


def places(case: Case, poses: Array) -> Array:
    """Poses of {P} (x, y, z, roll, pitch, yaw) at coordinates of a case's machine, shape (n, 6) [m, rad]."""
    machine = machine_of(case)
    return poses if machine.of_pose else machine.kinematics(poses, 0.0 * poses, 0.0 * poses).pose
