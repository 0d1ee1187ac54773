"""Candidate poses, the grid of the case or quasi-random points of the space that it spans, and their best design."""

import numpy as np
from scipy.spatial.transform import Rotation

from cases.errors import HexciteError, InfeasiblePlan
from cases.schema import Case
from identification.limit import TOLERANCE
from identification.motion import Array
from planner.bounds.certificate import Maximum
from planner.bounds.design import EXCHANGED, Design, directional, exchanged
from planner.poses.space import space_of, standing_report, standing_shares
from planner.search.feasibility import remedy

MOST = 200_000  # candidates; 20 000 take seconds and half a GB, and more never had more information
JOINT_CANDIDATES = 2048  # default number for a chain
ROUNDING = 1e-9  # [m] poses on the very edge of the ring are in it


def pose_of_tilt(position: Array, tilt: Array, azimuth: Array, torsion: Array) -> Array:
    """Poses of positions, (n, 3) [m], and angles, (n,) [rad]; R = Rz(azimuth) Ry(tilt) Rz(torsion - azimuth)."""
    turn = Rotation.from_euler("ZYZ", np.column_stack([azimuth, tilt, torsion - azimuth]))
    return np.column_stack([position, turn.as_euler("xyz")])


def grid_candidates(case: Case) -> Array:
    """The case's grid, valid poses only, in the order of Algorithm 1 (x, y, z, tilt, azimuth, torsion).

    Of a chain, which has no grid, quasi-random poses of the motion box.

    Raises:
        HexciteError: the grid is too fine; the message says what it would need.
        InfeasiblePlan: no pose is valid; the message names the limits that are exceeded.
        CaseError: the case lacks machine or poses.
    """
    if case.chain is not None:
        return sampled_candidates(case, JOINT_CANDIDATES, 0)
    grid = case.need_poses("pose candidates")
    _require_count(grid.grid_size)
    machine, _, _ = case.need_machine("pose candidates")
    axes = np.meshgrid(*grid.axes, indexing="ij")
    x, y, z, tilt, azimuth, torsion = (a.ravel() for a in axes)
    radius = np.hypot(x, y)
    ring = (radius >= grid.radius[0] - ROUNDING) & (radius <= grid.radius[1] + ROUNDING)
    position = machine.home.vector[:3] + np.column_stack([x, y, z])
    poses = pose_of_tilt(position, tilt, azimuth, torsion)[ring]
    return _valid(case, poses)


def sampled_candidates(case: Case, count: int, seed: int) -> Array:
    """Quasi-random poses (scrambled Sobol points) of the space that refinement searches, valid ones only.

    The grid of a hexapod leaves out the middle of its space, where poses have little information, the space does not.

    Args:
        count: number of points that are checked.

    Raises:
        HexciteError: too many, or none.
        InfeasiblePlan: no pose is valid.
        CaseError: the case lacks machine or poses.
    """
    _require_count(count)
    from scipy.stats import qmc  # a second to import, for this alone

    space, home = space_of(case), case.need_motion("pose candidates")[0]
    points = qmc.Sobol(space.size, seed=seed).random_base2(int(np.ceil(np.log2(count))))[:count]
    shares = space.ends[0] + points * np.ptp(space.ends, axis=0)
    for disc in space.discs:
        radius, angle = np.sqrt(points[:, disc.start]), 2 * np.pi * points[:, disc.start + 1]
        shares[:, disc] = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    inside = np.all((shares >= space.ends[0]) & (shares <= space.ends[1]), axis=1)
    return _valid(case, space.poses(shares[inside], home))


def _valid(case: Case, poses: Array) -> Array:
    if not len(poses):
        raise InfeasiblePlan("no pose lies inside poses.radius_mm and the XY range; widen one of them")
    kept = standing_shares(case, poses) <= 1.0 + TOLERANCE
    valid = kept.all(axis=1)
    if not valid.any():
        most = int(np.argmin(kept.mean(axis=0)))
        worst, share = standing_report(case, poses).checks[most], 100 * (1 - kept[:, most].mean())
        raise InfeasiblePlan(
            f"none of {len(poses)} poses is valid: {worst.sentence(timed=False)}, exceeded at {share:.0f} % of them; "
            f"{remedy(worst, case)}, or narrow {'[poses]' if case.chain is None else 'limits.motion.joints'}"
        )
    return np.asarray(poses[valid])


def _require_count(count: int) -> None:
    if not 1 <= count <= MOST:
        raise HexciteError(
            f"{count} candidates; choose 1 to {MOST}: take other steps in [poses], or sample with --candidates 20000"
        )


GAP = 5e-4  # dmax <= u (1 + GAP): the bound is then accurate to 0.05 % of efficiency
FIRST = 2000  # candidates that a design begins with, at most


def candidate_design(regressors: Array) -> Design:
    """The D-optimal design over candidates, with its certificate, of regressors of full rank, shape (n, 6, u)."""
    size = regressors.shape[2]

    def largest(inverse: Array, _: Array) -> Maximum:
        derivative = directional(regressors, inverse)
        order = np.argsort(-derivative)[:EXCHANGED]
        fresh = order[derivative[order] > size * (1.0 + GAP / 2)]
        return float(derivative[order[0]]), float(derivative[order[0]]), fresh[:, None]

    first = np.arange(0.0, len(regressors), max(1, len(regressors) // FIRST))[:, None]
    return exchanged(lambda rows: regressors[rows[:, 0].astype(int)], first, largest, GAP)
