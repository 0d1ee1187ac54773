"""The approximate design over the continuous pose space: what no number of poses, wherever they are, can exceed.

The largest directional derivative over the space is searched from many starts, so the bound is an estimate and says so;
limits of the machine inside the space are left out, which can only raise it.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.evaluate import over_samples
from identification.model import Model
from planner.poses.approximate import approximate_design
from planner.poses.coordinates import SIZE, PoseSpace
from planner.poses.regressors import pose_regressors

Array = NDArray[np.float64]

GAP = 1.5e-3  # an efficiency to 0.15 %
ROUNDS = 25
STARTS = 200
STEPS = 60


@dataclass(frozen=True, slots=True)
class ContinuousBound:
    """An estimated upper bound of log det of the mean information.

    Args:
        logdet: the bound, in the scaling that was given.
        dmax: largest directional derivative that was found.
        poses: poses of the design that carry weight.
    """

    logdet: float
    dmax: float
    poses: int


def continuous_bound(case: Case, model: Model, scaling: Array, seeds: Array) -> ContinuousBound:
    """Approximate design over the pose space.

    Args:
        case: gives the space.
        model: static.
        scaling: of the columns, shape (u,).
        seeds: poses to start from, better many, together of full rank, shape (n, 6) [m, rad].
    """
    space = PoseSpace.of(case)
    function = _derivative(model, scaling, space)
    size = len(scaling)
    pool = space.project(space.shares(seeds))
    for _ in range(ROUNDS):
        regressors = _regressors(model, scaling, space, pool)
        design = approximate_design(regressors, GAP / 5)
        inverse: Array = np.asarray(np.linalg.inv(design.information), dtype=np.float64)
        derivative = np.einsum("nki,ij,nkj->n", regressors, inverse, regressors, optimize=True)
        starts = pool[np.argsort(-derivative)[:STARTS]]
        found, values = _maximise(function, space, starts, inverse)
        dmax = max(float(values.max()), design.dmax)
        if dmax <= size * (1.0 + GAP):
            break
        pool = np.vstack([pool[design.weights > 0.0], starts, found[values > size]])
    bound = float(np.linalg.slogdet(design.information)[1] + size * np.log(dmax / size))
    return ContinuousBound(bound, dmax, int(np.sum(design.weights > 1e-4)))


def _regressors(model: Model, scaling: Array, space: PoseSpace, shares: Array) -> Array:
    return pose_regressors(model, space.poses(shares, np.full(len(shares), space.home[2]))) * scaling


def _derivative(model: Model, scaling: Array, space: PoseSpace) -> ca.Function:
    share, inverse, none = ca.SX.sym("share", SIZE), ca.SX.sym("inverse", len(scaling) ** 2), ca.SX.zeros(6)
    position, turn = space.expression(share)
    matrix = model.expression(position, turn, none, none) @ ca.diag(ca.DM(scaling))
    weighted = matrix @ ca.reshape(inverse, len(scaling), len(scaling))
    value = ca.sum1(ca.vec(weighted * matrix))
    return ca.Function("derivative", [share, inverse], [value, ca.densify(ca.gradient(value, share))], {"cse": True})


def _maximise(function: ca.Function, space: PoseSpace, starts: Array, inverse: Array) -> tuple[Array, Array]:
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
