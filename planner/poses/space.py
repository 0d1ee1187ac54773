"""Candidate poses: the grid of the case, or quasi-random points of the space that the grid spans."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.errors import HexciteError, InfeasiblePlan
from cases.schema import Case
from planner.poses.validity import REASONS, ROUNDING, margins_of, valid_poses

Array = NDArray[np.float64]

MOST = 200_000  # candidates; 20 000 take seconds and half a GB, and more have never told more
# What one candidate costs at most, measured on 20 000: for the estimate in the refusal only.
BYTES_EACH = 12_000
SECONDS_SQUARED = 5e-8


@dataclass(frozen=True, slots=True)
class Candidates:
    """Valid poses to choose from.

    Args:
        poses: shape (n, 6), R = Rz(yaw) Ry(pitch) Rx(roll) [m, rad].
        considered: poses that were looked at, valid or not.
        origin: one phrase that says where they come from.
    """

    poses: Array
    considered: int
    origin: str


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

    Raises:
        HexciteError: the grid is too fine; the message says what it would need.
        InfeasiblePlan: no pose is valid; the message says what stands in the way.
        CaseError: the case lacks machine or poses.
    """
    machine, _, _ = case.need_machine("pose candidates")
    grid = case.need_poses("pose candidates")
    if grid.grid_size > MOST:
        raise HexciteError(_too_many(grid.grid_size, "the grid of the case"))
    axes = np.meshgrid(*grid.lengths, *grid.angles, indexing="ij")
    x, y, z, tilt, azimuth, torsion = (a.ravel() for a in axes)
    radius = np.hypot(x, y)
    ring = (radius >= grid.radius[0] - ROUNDING) & (radius <= grid.radius[1] + ROUNDING)
    position = machine.home.vector[:3] + np.column_stack([x, y, z])
    poses = pose_of_tilt(position, tilt, azimuth, torsion)[ring]
    return _valid(case, poses, "grid")


def sampled_candidates(case: Case, count: int, seed: int) -> Candidates:
    """Quasi-random poses (scrambled Sobol points) of the space that the grid spans, valid ones only.

    The space is the XY range inside the largest radius, every tilt up to the largest, every azimuth, and the ranges of
    z and torsion: the grid leaves out its middle, where poses tell little, the space does not.

    Args:
        case: the ranges.
        count: points that are looked at.
        seed: of the scrambling.

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
    machine, _, _ = case.need_machine("pose candidates")
    grid = case.need_poses("pose candidates")
    from scipy.stats import qmc  # a second to import, for this alone

    share = qmc.Sobol(6, seed=seed).random_base2(int(np.ceil(np.log2(count))))[:count]
    low, high = (np.array([values[k] for values in grid.lengths]) for k in (0, -1))
    radius, azimuth = grid.radius[1] * np.sqrt(share[:, 0]), 2 * np.pi * share[:, 1]
    position = np.column_stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.zeros(count)])
    position[:, 2] = low[2] + share[:, 2] * (high[2] - low[2])
    inside = np.all((position >= low - ROUNDING) & (position <= high + ROUNDING), axis=1)
    tilt, torsion = grid.angles[0][-1] * np.sqrt(share[:, 3]), grid.angles[2]
    turned = torsion[0] + share[:, 5] * (torsion[-1] - torsion[0])
    poses = pose_of_tilt(machine.home.vector[:3] + position, tilt, 2 * np.pi * share[:, 4], turned)
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
        often = int(np.argmax((margins < -ROUNDING).sum(axis=0)))
        share = float((margins[:, often] < -ROUNDING).mean())
        raise InfeasiblePlan(
            f"none of {len(poses)} poses is valid: {REASONS[often]} at {100 * share:.0f} % of them; widen the "
            "workspace or narrow the ranges of [poses]"
        )
    return Candidates(poses[valid], len(poses), origin)


def _too_many(count: int, what: str) -> str:
    gigabytes, hours = count * BYTES_EACH / 1e9, count**2 * SECONDS_SQUARED / 3600
    return (
        f"{what} has {count} poses, at most {MOST} are searched: it would need about {gigabytes:.3g} GB and "
        f"{hours:.3g} h; take larger steps in [poses], or sample with --candidates 20000"
    )
