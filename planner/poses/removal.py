"""Algorithm 1: from many poses to few; each step removes the pose that costs the criterion least.

As printed, the last line removes for A and K, which are minimised, the most useful pose; the sign is corrected. For K
the text can be read in two ways, both of which are here: the best value after the removal, or the smallest change in
either direction, since the condition can improve by a removal.

Refinement then lets the poses of a set move freely through the pose space until the criterion is best.
"""

from collections.abc import Callable

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.base.phrases import phrase
from cases.schema import Case
from identification.estimation.criteria import Criterion, pose_regressors, total_information
from identification.model.model import Model
from identification.motion.motion import Array
from planner.poses.space import Space, space_of, valid_poses
from planner.search.objective import Local, criterion_at
from planner.search.record import SolverStatus
from planner.search.solvers import NumpyFunction

TIE = 1e-10  # relative; the first of equally good removals is taken, so that symmetric grids give one answer anywhere
CHUNK = 64  # number of poses that are evaluated together
EXACT = 500  # removals after which the information is summed anew: differences accumulate rounding
FEW = 60  # poses from which on the information is summed anew and the rank is watched at every step
MOST_EXHAUSTIVE = 2500  # poses to start from where all are evaluated at every step

Index = NDArray[np.int64]


def full_rank(regressors: Array) -> bool:
    """Whether poses, shape (n, 6, u), determine all parameters: singular values against the paper's zero (Fig. 3)."""
    rows = regressors.reshape(-1, regressors.shape[2])
    if len(rows) < rows.shape[1]:
        return False
    singular = np.linalg.svd(rows, compute_uv=False)
    return bool(singular[-1] > len(rows) * np.finfo(float).eps * singular[0])


def reduce_best(
    regressors: Array,
    criterion: Criterion,
    count: int,
    done: Callable[[int], None] = lambda _: None,
    smallest_change: bool = False,
    known: Array | None = None,
) -> tuple[Index, Index]:
    """Removes poses one by one, each time the one without which the criterion is best, or changes least.

    Stops early where every further removal would lose rank: what remains is the smallest set that the algorithm finds.
    The poses alone keep their rank, whatever is known: they are evaluated by themselves before they are pooled.

    Args:
        regressors: scaled regressors of all poses, shape (n, 6, u); together of full rank.
        done: called with the number of remaining poses after each removal.
        smallest_change: whether the criterion shall change least, for better or worse.
        known: information that earlier results add to the sum over poses, shape (u, u).

    Returns:
        Indices of the remaining poses, ascending, shape (r,), and of the others in the order of removal, (n - r,).
    """
    rest: Index = np.arange(len(regressors))
    # Lower bounds of what each pose costs: where losses grow, that in a larger set; else all poses are evaluated.
    losses = np.zeros(len(rest)) if criterion.losses_grow and not smallest_change else np.full(len(rest), -np.inf)
    beforehand = 0.0 if known is None else known
    information = total_information(regressors) + beforehand
    removed: list[int] = []
    while len(rest) > count:
        if len(rest) <= FEW or len(removed) % EXACT == 0:
            information = total_information(regressors[rest]) + beforehand
        now, open_to = float(criterion.of(information)), np.arange(len(rest))
        if known is not None and len(rest) <= FEW:  # the criterion does not see that poses alone would lose rank
            open_to = open_to[[full_rank(regressors[np.delete(rest, k)]) for k in open_to]]
            if not len(open_to):
                break
        after = _after_removals(regressors, criterion, information, rest[open_to], losses)
        merit = -np.abs(after - now) if smallest_change else after
        best = float(merit.max())
        position = int(open_to[np.argmax(merit >= best - TIE * abs(now if smallest_change else best))])
        if not np.isfinite(best) or (len(rest) <= FEW and not full_rank(regressors[np.delete(rest, position)])):
            break
        removed.append(int(rest[position]))
        information = information - regressors[rest[position]].T @ regressors[rest[position]]
        rest = np.delete(rest, position)
        done(len(rest))
    return rest, np.array(removed, dtype=np.int64)


def _after_removals(regressors: Array, criterion: Criterion, information: Array, rest: Index, losses: Array) -> Array:
    """Value after the removal of each pose, shape (r,); -inf of those that cannot be the best.

    Poses are evaluated in the order of what they cost at least, until no other can be better; `losses` are sharpened.
    """
    now, after = float(criterion.of(information)), np.full(len(rest), -np.inf)
    order = np.argsort(losses[rest], kind="stable")
    for rows in np.split(order, range(CHUNK, len(order), CHUNK)):
        best = float(after.max())
        if now - losses[rest[rows[0]]] < best - TIE * abs(best):
            break
        after[rows] = criterion.after_removal(information, regressors[rest[rows]])
        if np.isfinite(losses[rest[rows[0]]]):
            losses[rest[rows]] = now - after[rows]
    return after


STEPS = 300
HALVINGS = 2  # halvings of the p-norm that smooths extreme eigenvalues, p = 8
INSIDE = 1e-7  # distance from every edge, so that rounding of the solver cannot leave the space


def refine(
    case: Case, model: Model, scaling: Array, criterion: Criterion, poses: Array, known: Array | None = None
) -> tuple[Array, str]:
    """Valid poses of full rank refined by IPOPT, or themselves where nothing better was found; the solver's status.

    K and N are optimised by a smooth p-norm of the eigenvalues and rated by their exact values.

    Args:
        scaling: of the columns of the regressor, shape (u,).
        poses: shape (n, k) [m or rad].
        known: information that earlier results add to the sum over poses, shape (u, u).
    """
    space = space_of(case)
    count = len(poses)
    shares = ca.MX.sym("shares", space.size, count)
    information, limits = _pose_functions(model, scaling, space, poses.shape[1])
    like = ca.DM(poses).T
    triangle = ca.sum2(information.map(count)(shares, like)) / count
    if known is not None:
        triangle += ca.densify(ca.DM(known)[ca.Sparsity.lower(len(scaling)).find()]) / count
    margins = ca.vec(limits.map(count)(shares, like))
    objective = _objective(criterion, len(scaling))  # it must live as long as the solver
    low, high = space.ends
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
    solver = ca.nlpsol("refine", "ipopt", {"x": ca.vec(shares), "f": objective(triangle), "g": margins}, options)
    solution = solver(x0=start.ravel(), lbx=np.tile(low, count), ubx=np.tile(high, count), lbg=INSIDE, ubg=np.inf)
    status = SolverStatus(solver.stats()["return_status"]).words
    refined = space.poses(space.project(solution["x"].full().reshape(count, space.size)), poses)
    before, after = (_value(model, scaling, criterion, p, known) for p in (poses, refined))
    if not (after > before and valid_poses(case, refined).all()):
        return poses, phrase("nothing_better", "{status}; nothing better found", status=status)
    return refined, status


def _value(model: Model, scaling: Array, criterion: Criterion, poses: Array, known: Array | None) -> float:
    """Of poses, with what is known; minus infinity of those that alone do not determine all parameters."""
    if not np.isfinite(poses).all():
        return -np.inf
    regressors = pose_regressors(model, poses) * scaling
    if known is not None and not full_rank(regressors):
        return -np.inf
    return float(criterion.of(total_information(regressors) + (0.0 if known is None else known)))


def _pose_functions(model: Model, scaling: Array, space: Space, coordinates: int) -> tuple[ca.Function, ca.Function]:
    """Functions of one pose: lower triangle of its information, and margins, which must not be negative."""
    share, like, none = ca.SX.sym("share", space.size), ca.SX.sym("like", coordinates), ca.SX.zeros(coordinates)
    matrix = model.coordinate_regressor(space.pose(share, like), none, none) @ ca.diag(ca.DM(scaling))
    triangle = ca.densify(matrix.T @ matrix)[ca.Sparsity.lower(len(scaling)).find()]
    return (
        ca.Function("information", [share, like], [triangle], {"cse": True}),
        ca.Function("limits", [share, like], [ca.densify(space.margins(share, like))], {"cse": True}),
    )


def _objective(letter: Criterion, size: int) -> NumpyFunction:
    """Objective as a function of the lower triangle of the mean information, smooth and of the order of 1."""
    lower = ca.Sparsity.lower(size)
    rows, columns = np.array(lower.row()), np.array(lower.get_col())

    def at(triangle: Array) -> Local:
        information = np.zeros((size, size))
        information[rows, columns] = information[columns, rows] = triangle
        return criterion_at(letter, information, HALVINGS)

    def value(triangle: Array) -> tuple[Array]:
        return (np.array([at(triangle).value]),)

    def slope(triangle: Array, _: Array) -> tuple[Array]:
        return (at(triangle).slope[rows, columns] * np.where(rows == columns, 1.0, 2.0),)

    x, count = ("x", len(rows)), len(rows)
    table = [("jac_f_x", ca.Sparsity.dense(1, count))]
    jacobian = NumpyFunction("jac_objective", [x, ("out_f", 1)], table, slope)
    return NumpyFunction("objective", [x], [("f", ca.Sparsity.dense(1, 1))], value, jacobian)
