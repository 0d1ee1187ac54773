"""Continuous refinement: the poses of a set move freely through the pose space until the criterion is best."""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.model import Model
from planner.poses.joint_space import JointSpace
from planner.poses.pose_criteria import PoseCriterion, pose_regressors, total_information
from planner.poses.space import PoseSpace, space_of
from planner.search.ipopt import last_words

Array = NDArray[np.float64]

STEPS = 300
POWER_SQUARINGS = 3  # extreme eigenvalues are smoothed by a p-norm, p = 2^3
INSIDE = 1e-7  # kept from every edge, so that rounding of the solver cannot leave the space


@dataclass(frozen=True, slots=True)
class Refinement:
    """What refinement made of a set of poses."""

    poses: Array  # shape (n, 6) [m, rad]; the start where nothing better was found
    value: float  # value of the criterion, exact
    status: str  # what the solver said


def refine(case: Case, model: Model, scaling: Array, criterion: PoseCriterion, poses: Array) -> Refinement:
    """Refines poses by IPOPT; K and N by a smooth p-norm of the eigenvalues, rated by their exact values.

    Args:
        scaling: scaling of the columns, shape (u,).
        poses: valid, of full rank, shape (n, 6) [m, rad].
    """
    space = space_of(case)
    count = len(poses)
    shares = ca.MX.sym("shares", space.size, count)
    information, limits = _pose_functions(model, scaling, space, poses.shape[1])
    triangle = ca.sum2(information.map(count)(shares)) / count
    margins = ca.vec(limits.map(count)(shares, ca.DM(poses).T))
    objective = _objective(criterion.letter, len(scaling))(triangle)
    low, high = space.bounds()
    start = space.project(space.shares(poses))
    options = {
        "ipopt.hessian_approximation": "limited-memory",
        "ipopt.max_iter": STEPS,
        "ipopt.tol": 1e-5,
        "ipopt.acceptable_tol": 1e-4,
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "print_time": False,
    }
    solver = ca.nlpsol("refine", "ipopt", {"x": ca.vec(shares), "f": objective, "g": margins}, options)
    found = solver(x0=start.ravel(), lbx=np.tile(low, count), ubx=np.tile(high, count), lbg=INSIDE, ubg=np.inf)
    status = last_words(solver.stats()["return_status"])
    refined = space.poses(space.project(found["x"].full().reshape(count, space.size)), poses)
    before, after = (_value(model, scaling, criterion, p) for p in (poses, refined))
    if not (after > before and space.valid(refined).all()):
        return Refinement(poses, before, f"{status}; nothing better found")
    return Refinement(refined, after, status)


def _value(model: Model, scaling: Array, criterion: PoseCriterion, poses: Array) -> float:
    if not np.isfinite(poses).all():
        return -np.inf
    return float(criterion.value(total_information(pose_regressors(model, poses) * scaling)))


def _pose_functions(
    model: Model, scaling: Array, space: PoseSpace | JointSpace, coordinates: int
) -> tuple[ca.Function, ca.Function]:
    """Of one pose: lower triangle of its information; what must not be below 0."""
    share, like, none = ca.SX.sym("share", space.size), ca.SX.sym("like", coordinates), ca.SX.zeros(6)
    position, turn = space.expression(share)
    matrix = model.expression(position, turn, none, none) @ ca.diag(ca.DM(scaling))
    product = ca.densify(matrix.T @ matrix)
    triangle = product[ca.Sparsity.lower(len(scaling)).find()]
    return (
        ca.Function("information", [share], [triangle], {"cse": True}),
        ca.Function("limits", [share, like], [ca.densify(space.margins(share, like))], {"cse": True}),
    )


def _objective(letter: str, size: int) -> ca.Function:
    """Lower triangle of the mean information -> what is minimised, smooth and of the order of 1."""
    if letter == "D":
        triangle = ca.SX.sym("triangle", size * (size + 1) // 2)
        return ca.Function("objective", [triangle], [-log_determinant(size)(triangle) / size])
    triangle = ca.SX.sym("triangle", size * (size + 1) // 2)
    lower = ca.SX(ca.Sparsity.lower(size), triangle)
    full = ca.densify(lower + lower.T - ca.diag(ca.diag(lower)))
    root = ca.solve(ca.chol(full).T, ca.SX.eye(size))
    inverse = ca.densify(root.T @ root)
    if letter == "A":
        return ca.Function("objective", [triangle], [ca.log(ca.trace(inverse))], {"cse": True})
    smallest, largest = -_log_norm(inverse), _log_norm(full)
    better = {"K": (smallest - largest) / 2, "N": smallest - largest / 2}[letter]
    return ca.Function("objective", [triangle], [-better], {"cse": True})


def _log_norm(matrix: ca.SX) -> ca.SX:
    """Log of the p-norm of the eigenvalues of a positive definite matrix, which is scaled against overflow."""
    scale = ca.trace(matrix)
    power = matrix / scale
    for _ in range(POWER_SQUARINGS):
        power = power @ power
    return ca.log(scale) + ca.log(ca.trace(power)) / 2**POWER_SQUARINGS


def _lower(size: int) -> ca.Sparsity:
    return ca.Sparsity.lower(size)


def log_determinant(size: int) -> ca.Function:
    """Lower triangle of a positive definite matrix -> log det, by Cholesky factors (CasADi has no logdet)."""
    triangle = ca.SX.sym("triangle", _lower(size).nnz())
    lower = ca.SX(_lower(size), triangle)
    full = lower + lower.T - ca.diag(ca.diag(lower))
    return ca.Function("log_determinant", [triangle], [2 * ca.sum1(ca.log(ca.diag(ca.chol(full))))])
