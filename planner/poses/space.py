"""Poses to stand still at: the space that a case's grid spans, or the box of a chain's joints, and which are valid."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.schema import Case
from identification.limits.limit import TOLERANCE, LimitKind, LimitReport, Quantity
from identification.limits.proof import everything, prove_at, shares_at
from identification.machines.casadi_batch import over_samples
from identification.machines.hexapod import Hexapod
from identification.machines.of_case import machine_of
from identification.machines.rotations import rotation, rpy
from identification.motion.motion import Array, Motion, StandingPoses
from planner.search.problem import standing_limits


class Space(Protocol):
    """Poses among which refinement searches, as functions of shares: coordinates of the order of one."""

    case: Case
    ends: Array  # lower and upper bound of each share, shape (2, m)
    discs: ClassVar[tuple[slice, ...]] = ()  # pairs of shares that lie in a disc of radius 1

    def shares(self, poses: Array) -> Array:
        """Shares of poses, shape (n, m)."""

    def pose(self, share: ca.SX, like: ca.SX) -> ca.SX:
        """One pose; what no share determines is that of another, `like`, shape (k,)."""

    def margins(self, share: ca.SX, like: ca.SX) -> ca.SX:
        """Margins at such a pose by the search's own limits, which must not be negative."""
        return 1 - ca.fabs(standing_limits(self.case)(self.pose(share, like)))

    @property
    def size(self) -> int:
        """Number m of shares."""
        return int(self.ends.shape[1])

    def project(self, shares: Array) -> Array:
        """The nearest shares that lie in the space, shape (n, m): ranges first, then discs."""
        inside = np.clip(shares, *self.ends)
        for part in self.discs:
            inside[:, part] /= np.maximum(np.linalg.norm(inside[:, part], axis=1, keepdims=True), 1.0)
        return inside

    def poses(self, shares: Array, like: Array) -> Array:
        """Poses of shares, shape (n, k) [m or rad]; `like` as of `pose`, one for each or for all."""
        symbols = ca.SX.sym("share", self.size), ca.SX.sym("like", like.shape[-1])
        function = ca.Function("pose", [*symbols], [ca.densify(self.pose(*symbols))])
        return over_samples(function, shares, np.broadcast_to(like, (len(shares), like.shape[-1])))[0]


@dataclass(frozen=True)
class PoseSpace(Space):
    """The poses that a case's grid spans: a disc, all tilts up to the largest, a range of torsion.

    Shares are x, y, two of tilt, and torsion; z stays where it is, for no static model depends on it.
    """

    case: Case  # case with a hexapod
    ends: Array
    home: Array  # position of {P} at home, shape (3,) [m]
    radius: float  # radius of the disc [m]
    tilt: float  # tangent of half the largest tilt
    torsion: tuple[float, float]  # middle of the range and half of it, 1 where it is none [rad]
    discs = slice(0, 2), slice(2, 4)

    @classmethod
    def of(cls, case: Case) -> "PoseSpace":
        """The space that the case's grid spans; raises CaseError where the case lacks machine or poses."""
        home = case.need_machine("pose candidates")[0].home.vector[:3]
        grid = case.need_poses("pose candidates")
        (x, y, _, tilt, _, torsion), radius = ([axis[[0, -1]] for axis in grid.axes], float(grid.radius[1]))
        middle, half = float(torsion.mean()), float(np.ptp(torsion)) / 2 or 1.0
        plane = np.clip(np.column_stack([x, y]) / radius, -1.0, 1.0)
        ends = np.column_stack([plane, [[-1.0, -1.0], [1.0, 1.0]], (torsion - middle) / half])
        return cls(case, ends, home, radius, float(np.tan(tilt[-1] / 2)), (middle, half))

    def shares(self, poses: Array) -> Array:
        """Shares of poses, shape (n, 5)."""
        turn = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()
        normal = turn[:, :, 2]
        tilt = np.column_stack([-normal[:, 1], normal[:, 0]]) / (1.0 + normal[:, 2])[:, None]
        tilted = Rotation.from_quat(np.column_stack([tilt, np.zeros(len(poses)), np.ones(len(poses))])).as_matrix()
        rotation = tilted.transpose(0, 2, 1) @ turn
        torsion = (np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0]) - self.torsion[0]) / self.torsion[1]
        return np.column_stack([(poses[:, :2] - self.home[:2]) / self.radius, tilt / self.tilt, torsion])

    def pose(self, share: ca.SX, like: ca.SX) -> ca.SX:
        """One pose of the height of another, `like`, shape (6,)."""
        cross = ca.skew(ca.vertcat(self.tilt * share[2:4], 0))  # of the tilt's Gibbs vector
        tilted = ca.DM.eye(3) + 2 * (cross + cross @ cross) / (1 + self.tilt**2 * ca.sumsqr(share[2:4]))
        about_z = rotation(ca.vertcat(0, 0, self.torsion[0] + self.torsion[1] * share[4]))
        return ca.vertcat(ca.DM(self.home[:2]) + self.radius * share[:2], like[2], rpy(tilted @ about_z))

    def margins(self, share: ca.SX, like: ca.SX) -> ca.SX:
        """Margins at such a pose, which must not be negative: edges of the space, machine."""
        machine, workspace, _ = self.case.need_machine("pose candidates")
        pose, hexapod = self.pose(share, like), Hexapod.of(self.case)
        (low, high), at = workspace.room[:, :2], pose[:2] - ca.DM(machine.home.vector[:2])
        determinants = [ca.det(hexapod.inverse_jacobian(q)[1]) for q in (pose, ca.DM(machine.home.vector))]
        singularity = determinants[0] / determinants[1] - self.case.need_poses("pose candidates").singularity_distance
        discs = 1 - ca.sumsqr(share[:2]), 1 - ca.sumsqr(share[2:4])
        rest = super().margins(share, like)
        return ca.vertcat(*discs, (at - low) / (high - low), (high - at) / (high - low), singularity, rest)


@dataclass(frozen=True)
class JointSpace(Space):
    """The joints' part of the motion box; shares are those of the half sides from its middle."""

    case: Case  # case with a chain
    ends: Array
    middle: Array  # middle of the box, shape (k,) [m or rad]
    half: Array  # half of its sides, shape (k,) [m or rad]

    @classmethod
    def of(cls, case: Case) -> "JointSpace":
        """The space of a case; raises CaseError where it has no chain or no limits."""
        chain, limits = case.need_chain("pose candidates")
        ends = np.outer([-1.0, 1.0], np.ones(len(chain.home)))
        return cls(case, ends, chain.home + limits.coordinates.mean(axis=0), np.ptp(limits.coordinates, axis=0) / 2)

    def shares(self, poses: Array) -> Array:
        """Shares of poses, shape (n, k)."""
        return np.asarray((poses - self.middle) / self.half)

    def pose(self, share: ca.SX, like: ca.SX) -> ca.SX:
        """One pose, shape (k,); shares determine all of it."""
        return ca.DM(self.middle) + ca.DM(self.half) * share


def space_of(case: Case) -> Space:
    """The poses among which refinement searches; raises CaseError where the case lacks machine or poses.

    They keep `limits.margin`, but for the room of a platform, which the grid of the case may use to its ends.
    """
    if case.chain is not None:
        return JointSpace.of(case.within_margin())
    _, workspace, _ = case.need_machine("pose candidates")
    inner = case.within_margin()
    _, narrowed, _ = inner.need_machine("pose candidates")
    room = {key: getattr(workspace, key) for key in ("x_mm", "y_mm", "z_mm")}
    return PoseSpace.of(inner.model_copy(update={"workspace": narrowed.model_copy(update=room)}))


def valid_poses(case: Case, poses: Array) -> NDArray[np.bool_]:
    """Whether the machine can stand at each pose, by the proof of limits, shape (n,)."""
    return np.asarray((standing_shares(case, poses) <= 1.0 + TOLERANCE).all(axis=1))


def standing_shares(case: Case, poses: Array) -> Array:
    """Share of each limit, in the order of `standing_report`, that standing at each pose uses, shape (n, limits)."""
    if not len(poses):
        return np.zeros((0, 1))
    return shares_at(StandingPoses(poses), case, np.arange(float(len(poses))), _in_box(case), _standing)


def standing_report(case: Case, poses: Array) -> LimitReport:
    """The limits of standing at poses, shape (n, k), the worst of each; see `valid_poses`."""
    return prove_at(StandingPoses(poses), case, np.arange(float(len(poses))), in_box=_in_box(case), limited=_standing)


def _in_box(case: Case) -> bool:
    """Whether poses stay in the motion box: those of a platform may lie anywhere in its workspace."""
    return not case.need_motion("pose candidates")[1].of_pose


def _standing(motion: Motion, case: Case, in_box: bool) -> Iterator[Quantity]:
    """All limits, singularities at the distance that `[poses]` states."""
    for quantity in everything(motion, case, in_box):
        if quantity.of.kind is LimitKind.SINGULARITY:
            least = case.need_poses("the validity of poses").singularity_distance or 0.0
            ends = np.full_like(quantity.limits, least)
            yield replace(quantity, limits=ends, ratio=quantity.ratio / (1.0 - least))
        else:
            yield quantity


def places(case: Case, poses: Array) -> Array:
    """Poses of {P} (x, y, z, roll, pitch, yaw) at coordinates of a case's machine, shape (n, 6) [m, rad]."""
    machine = machine_of(case)
    return poses if machine.of_pose else machine.kinematics(poses, 0.0 * poses, 0.0 * poses).pose
