"""Candidate poses: the grid of the case, or quasi-random points of the space that the grid spans."""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.errors import HexciteError, InfeasiblePlan
from cases.schema import Case
from cases.units import DEG
from identification.hexapod import Hexapod
from identification.keep_out import distances
from identification.limit_proof import prove
from identification.machines import machine_of
from identification.motion import StandingPoses
from identification.symbolic import over_samples, rotation, rpy
from planner.poses.joint_space import JointSpace

Array = NDArray[np.float64]

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

    def expression(self, share: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Position (z at home) and R of one pose, shapes (3,) and (3, 3)."""
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
        position = ca.vertcat(ca.DM(self.home[:2]) + self.radius * share[:2], float(self.home[2]))
        return position, tilted @ about_z

    def margins(self, share: ca.SX, like: ca.SX) -> ca.SX:
        """What must not be below 0 at a pose of the height of another, `like` of shape (6,): edges, machine."""
        position, turn = self.expression(share)
        pose = ca.vertcat(position[:2], like[2], rpy(turn))
        return ca.vertcat(1 - ca.sumsqr(share[:2]), 1 - ca.sumsqr(share[2:4]), validity_margins(self.case)(pose))

    def valid(self, poses: Array) -> NDArray[np.bool_]:
        """Whether the machine can stand at each pose, shape (n,)."""
        return valid_poses(self.case, poses)


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


def keep_out_distances(case: Case, poses: Array) -> Array:
    """Distance of platform, struts and tools from the nearest keep-out box, shape (n,) [m].

    Below 0 inside one; along the axis that separates them most; infinite where the case has no such box.
    """
    machine, workspace, _ = case.need_machine("the validity of poses")
    turn, origin, base = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix(), poses[:, :3], machine.base.points
    strut = origin[:, None] + machine.platform.points @ turn.transpose(0, 2, 1) - base
    nearest = np.full(len(poses), np.inf)
    for box in workspace.keep_out:
        nearest = np.minimum(nearest, distances(box, workspace, origin, turn, base, strut).min(axis=1))
    return nearest


def valid_poses(case: Case, poses: Array) -> NDArray[np.bool_]:
    """Whether the machine can stand at each pose, shape (n,)."""
    inside = np.all(margins_of(case, poses) >= -ROUNDING, axis=1)
    return np.asarray(inside & (keep_out_distances(case, poses) >= 0.0))


def space_of(case: Case) -> PoseSpace | JointSpace:
    """The poses among which refinement searches; raises CaseError where the case lacks machine or poses."""
    return PoseSpace.of(case) if case.chain is None else JointSpace.of(case)


def places(case: Case, poses: Array) -> Array:
    """Where {P} is at coordinates of a case's machine: poses (x, y, z, roll, pitch, yaw), shape (n, 6) [m, rad]."""
    machine = machine_of(case)
    return poses if machine.of_pose else machine.kinematics(poses, 0.0 * poses, 0.0 * poses).pose


MOST = 200_000  # candidates; 20 000 take seconds and half a GB, and more have never told more
JOINT_CANDIDATES = 2048  # of a chain, where no other number is asked for
# What one candidate costs at most, measured on 20 000: for the estimate in the refusal only.
BYTES_EACH = 12_000
SECONDS_SQUARED = 5e-8


@dataclass(frozen=True, slots=True)
class Candidates:
    """Valid poses to choose from."""

    poses: Array  # shape (n, 6), R = Rz(yaw) Ry(pitch) Rx(roll) [m, rad]
    considered: int  # poses that were looked at, valid or not
    origin: str  # one phrase that says where they come from


def pose_of_tilt(position: Array, tilt: Array, azimuth: Array, torsion: Array) -> Array:
    """Poses from tilt-and-torsion angles, R = Rz(azimuth) Ry(tilt) Rz(torsion - azimuth), shape (n, 6) [m, rad].

    Args:
        position: origin of {P} in {B}, shape (n, 3) [m].
        tilt: shape (n,) [rad].
        azimuth: direction of the tilt, shape (n,) [rad].
        torsion: shape (n,) [rad].
    """
    turn = Rotation.from_euler("ZYZ", np.column_stack([azimuth, tilt, torsion - azimuth]))
    return np.column_stack([position, turn.as_euler("xyz")])


def grid_candidates(case: Case) -> Candidates:
    """The case's grid, valid poses only, in the order of Algorithm 1 (x, y, z, tilt, azimuth, torsion).

    Of a chain, which has no grid, quasi-random poses of the motion box.

    Raises:
        HexciteError: the grid is too fine; the message says what it would need.
        InfeasiblePlan: no pose is valid; the message says what stands in the way.
        CaseError: the case lacks machine or poses.
    """
    if case.chain is not None:
        return sampled_candidates(case, JOINT_CANDIDATES, 0)
    grid = case.need_poses("pose candidates")
    if grid.grid_size > MOST:
        raise HexciteError(_too_many(grid.grid_size, "the grid of the case"))
    machine, _, _ = case.need_machine("pose candidates")
    axes = np.meshgrid(*grid.lengths, *grid.angles, indexing="ij")
    x, y, z, tilt, azimuth, torsion = (a.ravel() for a in axes)
    radius = np.hypot(x, y)
    ring = (radius >= grid.radius[0] - ROUNDING) & (radius <= grid.radius[1] + ROUNDING)
    position = machine.home.vector[:3] + np.column_stack([x, y, z])
    poses = pose_of_tilt(position, tilt, azimuth, torsion)[ring]
    return _valid(case, poses, "grid")


def sampled_candidates(case: Case, count: int, seed: int) -> Candidates:
    """Quasi-random poses (scrambled Sobol points) of the space that the grid spans, valid ones only.

    The space of a chain is its motion box. Of a hexapod it is the XY range inside the largest radius, every tilt up to
    the largest, every azimuth, and the ranges of z and torsion: the grid leaves out its middle, where poses tell
    little, the space does not.

    Args:
        count: points that are looked at.

    Raises:
        HexciteError: too many, too few, or a negative seed.
        InfeasiblePlan: no pose is valid.
        CaseError: the case lacks machine or poses.
    """
    if not count >= 1:
        raise HexciteError(f"{count} candidates; sample at least as many as poses are wanted")
    if count > MOST:
        raise HexciteError(_too_many(count, "a sample"))
    if seed < 0:
        raise HexciteError(f"seed {seed} is negative; choose 0 or more")
    from scipy.stats import qmc  # a second to import, for this alone

    if case.chain is not None:
        joints = JointSpace.of(case)
        points = qmc.Sobol(joints.size, seed=seed).random_base2(int(np.ceil(np.log2(count))))[:count]
        every = joints.poses(2.0 * points - 1.0, points)
        if not (valid := joints.valid(every)).any():
            worst = prove(StandingPoses(every), case, 1.0).violations[0].sentence(timed=False)
            raise InfeasiblePlan(f"none of {count} poses is valid: {worst}; narrow limits.motion.joints or move home")
        return Candidates(every[valid], count, f"{count} quasi-random points")
    machine, _, _ = case.need_machine("pose candidates")
    grid = case.need_poses("pose candidates")
    share = qmc.Sobol(6, seed=seed).random_base2(int(np.ceil(np.log2(count))))[:count]
    low, high = (np.array([values[k] for values in grid.lengths]) for k in (0, -1))
    radius, azimuth = grid.radius[1] * np.sqrt(share[:, 0]), 2 * np.pi * share[:, 1]
    position = np.column_stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.zeros(count)])
    position[:, 2] = low[2] + share[:, 2] * (high[2] - low[2])
    inside = np.all((position >= low - ROUNDING) & (position <= high + ROUNDING), axis=1)
    tilt, torsion = grid.angles[0][-1] * np.sqrt(share[:, 3]), grid.angles[2]
    angles = torsion[0] + share[:, 5] * (torsion[-1] - torsion[0])
    poses = pose_of_tilt(machine.home.vector[:3] + position, tilt, 2 * np.pi * share[:, 4], angles)
    return _valid(case, poses[inside], f"{count} quasi-random points")


def _valid(case: Case, poses: Array, origin: str) -> Candidates:
    if not len(poses):
        raise InfeasiblePlan("no pose lies inside poses.radius_mm and the XY range; widen one of them")
    margins = margins_of(case, poses)
    valid = valid_poses(case, poses)
    if not valid.any():
        if not (margins < -ROUNDING).any(axis=1).all():
            raise InfeasiblePlan(
                f"none of {len(poses)} poses is valid: all within reach lie in workspace.keep_out; narrow it"
            )
        worst = int(np.argmax((margins < -ROUNDING).sum(axis=0)))
        share = float((margins[:, worst] < -ROUNDING).mean())
        raise InfeasiblePlan(
            f"none of {len(poses)} poses is valid: {REASONS[worst]} at {100 * share:.0f} % of them; widen the "
            "workspace or narrow the ranges of [poses]"
        )
    return Candidates(poses[valid], len(poses), origin)


def _too_many(count: int, name: str) -> str:
    gigabytes, hours = count * BYTES_EACH / 1e9, count**2 * SECONDS_SQUARED / 3600
    return (
        f"{name} has {count} poses, at most {MOST} are searched: it would need about {gigabytes:.3g} GB and "
        f"{hours:.3g} h; take larger steps in [poses], or sample with --candidates 20000"
    )
