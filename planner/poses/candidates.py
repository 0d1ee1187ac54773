"""Candidate poses, and bounds for every choice among them or anywhere in the pose space.

Candidates are the grid of the case, or quasi-random points of the space that the grid spans. The approximate design
over them is certified. That over the continuous pose space is an estimate and says so: the largest directional
derivative is searched from many starts; limits of the machine inside the space are omitted, which can only raise it.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from cases.errors import HexciteError, InfeasiblePlan
from cases.schema import Case
from identification.limit import TOLERANCE
from identification.model import Model
from identification.motion import Array
from planner.bounds.certificate import Maximum
from planner.bounds.design import CLIMBS, EXCHANGED, LEVELS, SWEEPS, Design, climb, directional, exchanged
from planner.pose_criteria import pose_regressors
from planner.poses.space import JointSpace, space_of, standing_report, standing_shares
from planner.search.feasibility import remedy

MOST = 200_000  # candidates; 20 000 take seconds and half a GB, and more never had more information
JOINT_CANDIDATES = 2048  # default number for a chain
# What one candidate costs at most, measured on 20 000: for the estimate in the refusal only.
BYTES_EACH = 12_000
SECONDS_SQUARED = 5e-8
ROUNDING = 1e-9  # [m] poses on the very edge of the ring are in it


Candidates = tuple[Array, int, str]
"""Valid poses to choose from, shape (n, k) [m or rad]; how many were checked, valid or not; where they come from."""


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
        InfeasiblePlan: no pose is valid; the message names the limits that are exceeded.
        CaseError: the case lacks machine or poses.
    """
    if case.chain is not None:
        return sampled_candidates(case, JOINT_CANDIDATES, 0)
    grid = case.need_poses("pose candidates")
    if grid.grid_size > MOST:
        raise HexciteError(_too_many(grid.grid_size, "the grid of the case"))
    machine, _, _ = case.need_machine("pose candidates")
    axes = np.meshgrid(*grid.axes, indexing="ij")
    x, y, z, tilt, azimuth, torsion = (a.ravel() for a in axes)
    radius = np.hypot(x, y)
    ring = (radius >= grid.radius[0] - ROUNDING) & (radius <= grid.radius[1] + ROUNDING)
    position = machine.home.vector[:3] + np.column_stack([x, y, z])
    poses = pose_of_tilt(position, tilt, azimuth, torsion)[ring]
    return _valid(case, poses, "grid")


def sampled_candidates(case: Case, count: int, seed: int) -> Candidates:
    """Quasi-random poses (scrambled Sobol points) of the space that the grid spans, valid ones only.

    The space of a chain is its motion box. Of a hexapod it is the XY range inside the largest radius, every tilt up to
    the largest, every azimuth, and the ranges of z and torsion: the grid leaves out its middle, where poses have
    little information, the space does not.

    Args:
        count: number of points that are checked.

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
        return _valid(case, joints.poses(2.0 * points - 1.0, points), f"{count} quasi-random points")
    machine, _, _ = case.need_machine("pose candidates")
    grid = case.need_poses("pose candidates")
    share = qmc.Sobol(6, seed=seed).random_base2(int(np.ceil(np.log2(count))))[:count]
    low, high = (np.array([values[k] for values in grid.axes[:3]]) for k in (0, -1))
    radius, azimuth = grid.radius[1] * np.sqrt(share[:, 0]), 2 * np.pi * share[:, 1]
    position = np.column_stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.zeros(count)])
    position[:, 2] = low[2] + share[:, 2] * (high[2] - low[2])
    inside = np.all((position >= low - ROUNDING) & (position <= high + ROUNDING), axis=1)
    tilt, torsion = grid.axes[3][-1] * np.sqrt(share[:, 3]), grid.axes[5]
    angles = torsion[0] + share[:, 5] * (torsion[-1] - torsion[0])
    poses = pose_of_tilt(machine.home.vector[:3] + position, tilt, 2 * np.pi * share[:, 4], angles)
    return _valid(case, poses[inside], f"{count} quasi-random points")


def _valid(case: Case, poses: Array, origin: str) -> Candidates:
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
    return poses[valid], len(poses), origin


def _too_many(count: int, name: str) -> str:
    gigabytes, hours = count * BYTES_EACH / 1e9, count**2 * SECONDS_SQUARED / 3600
    return (
        f"{name} has {count} poses, at most {MOST} are searched: it would need about {gigabytes:.3g} GB and "
        f"{hours:.3g} h; take larger steps in [poses], or sample with --candidates 20000"
    )


GAP = 5e-4  # dmax <= u (1 + GAP): the bound is then accurate to 0.05 % of efficiency
SPACE_GAP = 1e-3
FIRST = 2000  # candidates that a design begins with, at most
STARTS = 60  # poses from which the largest derivative is searched for


def candidate_design(regressors: Array) -> Design:
    """The D-optimal design over candidates, with its certificate; its states are rows of the regressors.

    Args:
        regressors: regressors of all candidates, shape (n, 6, u); together of full rank.
    """
    size = regressors.shape[2]

    def largest(inverse: Array, _: Array) -> Maximum:
        derivative = directional(regressors, inverse)
        order = np.argsort(-derivative)[:EXCHANGED]
        fresh = order[derivative[order] > size * (1.0 + GAP / 2)]
        return float(derivative[order[0]]), float(derivative[order[0]]), fresh[:, None]

    first = np.arange(0.0, len(regressors), max(1, len(regressors) // FIRST))[:, None]
    return exchanged(lambda rows: regressors[rows[:, 0].astype(int)], first, largest, GAP)


def continuous_design(case: Case, model: Model, scaling: Array, seeds: Array) -> Design:
    """The D-optimal design over the whole pose space; its largest derivative is searched for, an estimate.

    Args:
        scaling: scaling of the columns, shape (u,).
        seeds: poses to start from, many if possible, together of full rank, shape (n, 6) [m, rad].
    """
    space, home = space_of(case), case.need_motion("a plan of poses")[0]
    pool = space.project(space.shares(seeds))

    def matrices_of(shares: Array) -> Array:
        poses = space.poses(space.project(shares), home)
        return np.asarray(pose_regressors(model, poses) * scaling)

    def largest(inverse: Array, known: Array) -> Maximum:
        def derivative(shares: Array) -> Array:
            return directional(matrices_of(shares), inverse)

        variations = ((k, () if sweep else LEVELS, CLIMBS) for sweep in range(SWEEPS) for k in range(space.size))
        climbed, values = climb(derivative, pool, STARTS, known, variations)
        return np.inf, float(values.max()), climbed[values > len(scaling) * (1.0 + SPACE_GAP / 2)]

    return exchanged(matrices_of, pool, largest, SPACE_GAP)
