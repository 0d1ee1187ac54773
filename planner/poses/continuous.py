"""The approximate design over the continuous pose space: what no number of poses, wherever they are, can exceed.

The largest directional derivative over the space is searched from many starts, so the bound is an estimate and says so;
limits of the machine inside the space are left out, which can only raise it.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.model import Model
from identification.symbolic import over_samples
from planner.poses.joint_space import JointSpace
from planner.poses.pose_criteria import pose_regressors
from planner.poses.space import PoseSpace, space_of

Array = NDArray[np.float64]

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
        regressors = _regressors(model, scaling, space, pool, home)
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


def _regressors(model: Model, scaling: Array, space: PoseSpace | JointSpace, shares: Array, reference: Array) -> Array:
    return pose_regressors(model, space.poses(shares, np.tile(reference, (len(shares), 1)))) * scaling


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
