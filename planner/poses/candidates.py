"""Candidate poses, and what no choice among them or anywhere in the pose space can exceed.

Candidates are the grid of the case, or quasi-random points of the space that the grid spans. The approximate design
over them is certified. That over the continuous pose space is an estimate and says so: the largest directional
derivative is searched from many starts; limits of the machine inside the space are left out, which can only raise it.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation

from cases.errors import HexciteError, InfeasiblePlan
from cases.schema import Case
from identification.limit_proof import prove
from identification.model import Model
from identification.motion import Array, StandingPoses
from identification.symbolic import over_samples
from planner.poses.pose_criteria import pose_regressors
from planner.poses.space import REASONS, ROUNDING, JointSpace, PoseSpace, margins_of, space_of, valid_poses

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


GAP = 1e-3  # dmax <= u (1 + GAP): the bound is then known to 0.1 % of efficiency
ROUNDS = 200
STEPS = 60
NEGLIGIBLE = 1e-9


@dataclass(frozen=True, slots=True)
class ApproximateDesign:
    """A design with its certificate."""

    weights: Array  # weights of the poses, shape (n,), sum 1
    information: Array  # mean information, shape (u, u)
    dmax: float  # largest directional derivative over all poses

    @property
    def logdet_bound(self) -> float:
        """What the log det of no mean information of these poses exceeds."""
        size = len(self.information)
        return float(np.linalg.slogdet(self.information)[1] + size * np.log(self.dmax / size))

    def efficiency(self, regressors: Array) -> float:
        """Lower bound of the D-efficiency of a set of poses against every design over the candidates.

        Args:
            regressors: regressors of the set, shape (k, 6, u), in the scaling of the design.
        """
        rows = regressors.reshape(-1, regressors.shape[2])
        sign, logdet = np.linalg.slogdet(rows.T @ rows / len(regressors))
        if sign <= 0:
            return 0.0
        return float(np.exp((logdet - self.logdet_bound) / len(self.information)))


def approximate_design(regressors: Array, gap: float = GAP) -> ApproximateDesign:
    """Multiplicative algorithm (Titterington 1976) on an active set that grows by whatever poses violate optimality.

    Args:
        regressors: regressors of all candidates, shape (n, 6, u); together of full rank.
        gap: stops when dmax <= u (1 + gap).
    """
    count, _, size = regressors.shape
    products = (regressors.transpose(0, 2, 1) @ regressors).reshape(count, -1)
    weights = np.full(count, 1.0 / count)
    information, derivative = _derivatives(products, weights, size)
    for _ in range(ROUNDS):
        active = np.flatnonzero((weights > NEGLIGIBLE) | (derivative > size))
        # What has no weight but would help gets a small share, so that it can grow.
        weights[active] = np.maximum(weights[active], 1e-3 / len(active))
        active_products, share = products[active], weights[active] / weights[active].sum()
        for _ in range(STEPS):
            share = share * _derivatives(active_products, share, size)[1] / size
        share[share < NEGLIGIBLE] = 0.0
        weights = np.zeros(count)
        weights[active] = share / share.sum()
        information, derivative = _derivatives(products, weights, size)
        if derivative.max() <= size * (1.0 + gap):
            break
    return ApproximateDesign(weights, information, float(derivative.max()))


def _derivatives(products: Array, weights: Array, size: int) -> tuple[Array, Array]:
    information = (weights @ products).reshape(size, size)
    return information, np.asarray(products @ np.linalg.inv(information).ravel())


SPACE_GAP = 1.5e-3  # an efficiency to 0.15 %
SPACE_ROUNDS = 25
STARTS = 200


def continuous_bound(case: Case, model: Model, scaling: Array, seeds: Array) -> float:
    """Estimated upper bound of log det of the mean information of any poses, by an approximate design over the space.

    Args:
        scaling: scaling of the columns, shape (u,).
        seeds: poses to start from, better many, together of full rank, shape (n, 6) [m, rad].
    """
    space = space_of(case)
    function = _derivative_function(model, scaling, space)
    size = len(scaling)
    pool, home = space.project(space.shares(seeds)), case.need_motion("a plan of poses")[0]
    for _ in range(SPACE_ROUNDS):
        regressors = pose_regressors(model, space.poses(pool, np.tile(home, (len(pool), 1)))) * scaling
        design = approximate_design(regressors, SPACE_GAP / 5)
        inverse: Array = np.asarray(np.linalg.inv(design.information), dtype=np.float64)
        derivative = np.einsum("nki,ij,nkj->n", regressors, inverse, regressors, optimize=True)
        starts = pool[np.argsort(-derivative)[:STARTS]]
        maxima, values = _maximise(function, space, starts, inverse)
        dmax = max(float(values.max()), design.dmax)
        if dmax <= size * (1.0 + SPACE_GAP):
            break
        pool = np.vstack([pool[design.weights > 0.0], starts, maxima[values > size]])
    return float(np.linalg.slogdet(design.information)[1] + size * np.log(dmax / size))


def _derivative_function(model: Model, scaling: Array, space: PoseSpace | JointSpace) -> ca.Function:
    share, inverse, none = ca.SX.sym("share", space.size), ca.SX.sym("inverse", len(scaling) ** 2), ca.SX.zeros(6)
    position, turn = space.expression(share)
    matrix = model.expression(position, turn, none, none) @ ca.diag(ca.DM(scaling))
    weighted = matrix @ ca.reshape(inverse, len(scaling), len(scaling))
    value = ca.sum1(ca.vec(weighted * matrix))
    return ca.Function("derivative", [share, inverse], [value, ca.densify(ca.gradient(value, share))], {"cse": True})


def _maximise(
    function: ca.Function, space: PoseSpace | JointSpace, starts: Array, inverse: Array
) -> tuple[Array, Array]:
    """Local maxima by projected gradient steps from each start; coordinates and values."""
    repeated = np.tile(inverse.ravel(), (len(starts), 1))
    shares = starts.copy()
    value, gradient = over_samples(function, shares, repeated)
    step = np.full(len(shares), 0.3)
    for _ in range(STEPS):
        norm = np.maximum(np.abs(gradient).max(axis=1, keepdims=True), 1e-300)
        trial = space.project(shares + step[:, None] * gradient / norm)
        new, slope = over_samples(function, trial, repeated)
        better = new[:, 0] > value[:, 0]
        shares[better], value[better], gradient[better] = trial[better], new[better], slope[better]
        step = np.where(better, np.minimum(step * 1.5, 1.0), step * 0.4)
    return shares, value[:, 0]
