"""Algorithm 1: from many poses to few; each step removes the pose that costs the criterion least.

As printed, the last line removes for A and K, which are minimised, the most useful pose; the sign is corrected. For K
the text can be read in two ways, both of which are here: the best value after the removal (`reduce_best`), or the
smallest change in either direction (`reduce_smallest_change`), since the condition can improve by a removal.

Refinement then lets the poses of a set move freely through the pose space until the criterion is best.
"""

from collections.abc import Callable

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.criteria import Criterion
from identification.model import Model
from identification.motion import Array
from planner.pose_criteria import Index, PoseCriterion, Screen, pose_regressors, total_information
from planner.poses.space import Space, space_of, valid_poses
from planner.search import SolverStatus
from planner.search.ipopt import NumpyFunction
from planner.search.objective import Local, criterion_at

TIE = 1e-10  # relative; the first of equally good removals is taken, so that symmetric grids give one answer anywhere
CHUNK = 16  # number of poses that are evaluated together at first
REFRESH = 48  # evaluations in one step after which new bounds are cheaper
EXACT = 500  # removals after which the information is summed anew: differences accumulate rounding
FEW = 60  # poses from which on the information is summed anew and the rank is watched at every step
MOST_EXHAUSTIVE = 2500  # poses that `reduce_smallest_change` starts from: it evaluates all of them at every step


def full_rank(regressors: Array) -> bool:
    """Whether poses, shape (n, 6, u), determine all parameters: singular values against the paper's zero (Fig. 3)."""
    rows = regressors.reshape(-1, regressors.shape[2])
    if len(rows) < rows.shape[1]:
        return False
    singular = np.linalg.svd(rows, compute_uv=False)
    return bool(singular[-1] > len(rows) * np.finfo(float).eps * singular[0])


def reduce_best(
    regressors: Array, criterion: PoseCriterion, count: int, done: Callable[[int], None] = lambda _: None
) -> tuple[Index, Index]:
    """Removes poses one by one, each time the one without which the criterion is best; evaluates as few as possible.

    Stops early where every further removal would lose rank: what remains is the smallest set that the algorithm finds.

    Args:
        regressors: scaled regressors of all poses, shape (n, 6, u); together of full rank.
        done: called with the number of remaining poses after each removal.

    Returns:
        Indices of the remaining poses, ascending, shape (r,), and of the others in the order of removal, (n - r,).
    """
    members: Index = np.arange(len(regressors))  # poses of the screen; `alive` are those that are not yet removed
    alive = np.ones(len(members), dtype=bool)
    information = total_information(regressors)
    present, screen = regressors, criterion.screen(regressors, information)
    removed, summed = [], EXACT
    for size in range(len(regressors), count, -1):
        removal = None
        if size > FEW:
            removal = _best_removal(present, criterion, screen, information, alive, REFRESH)
        if removal is None:  # the bounds have become loose, or the sum must be exact
            members = members[alive]
            present, alive = regressors[members], np.ones(size, dtype=bool)
            if size <= FEW or size < len(regressors) - summed:
                information, summed = total_information(present), len(regressors) - size + EXACT
            screen = criterion.screen(present, information)
            removal = _best_removal(present, criterion, screen, information, alive, size)
        assert removal is not None
        position, value = removal
        alive[position] = False
        if not np.isfinite(value) or (size <= FEW and not full_rank(present[alive])):
            alive[position] = True
            break
        removed.append(members[position])
        information = information - present[position].T @ present[position]
        done(size - 1)
    return members[alive], np.array(removed, dtype=np.int64)


def _best_removal(
    regressors: Array, criterion: PoseCriterion, screen: Screen, information: Array, alive: NDArray[np.bool_], most: int
) -> tuple[int, float] | None:
    """Position and value of the best removal; None where more than `most` poses would have to be evaluated.

    Poses are evaluated in the order of their bounds until no bound reaches the best value found.
    """
    upper, learn = screen
    pending = np.where(alive, upper(information), -np.inf)
    exact = np.full(len(alive), -np.inf)
    best, evaluated, chunk = -np.inf, 0, CHUNK
    while True:
        rows = np.argpartition(-pending, chunk)[:chunk] if chunk < len(pending) else np.arange(len(pending))
        rows = rows[(pending[rows] > -np.inf) & (pending[rows] >= _tied(best))]
        if not len(rows):
            break
        if evaluated + len(rows) > max(most, CHUNK):
            return None
        exact[rows] = criterion.after_removal(information, regressors[rows])
        learn(information, rows, exact[rows])
        pending[rows] = -np.inf
        best = max(best, float(exact[rows].max()))
        evaluated += len(rows)
        chunk *= 2
    if not np.isfinite(best):
        return int(np.argmax(alive)), -np.inf
    first = int(np.argmax(exact >= _tied(best)))
    return first, float(exact[first])


def _tied(best: float) -> float:
    """The value from which another counts as equally good."""
    return best - TIE * abs(best) if np.isfinite(best) else best


def reduce_smallest_change(
    regressors: Array, criterion: PoseCriterion, count: int, done: Callable[[int], None] = lambda _: None
) -> tuple[Index, Index]:
    """Removes poses one by one, each time the one whose removal changes the criterion least, for better or worse.

    Arguments and answer as of `reduce_best`; at most `MOST_EXHAUSTIVE` poses, since all are evaluated at every step.
    """
    rest: Index = np.arange(len(regressors))
    products = regressors.transpose(0, 2, 1) @ regressors
    removed = []
    while len(rest) > count:
        information = products[rest].sum(axis=0)
        now, after = float(criterion.value(information)), criterion.value(information - products[rest])
        change = np.abs(after - now)
        position = int(np.argmax(change <= change.min() + TIE * abs(now)))
        if not np.isfinite(after[position]) or (
            len(rest) <= FEW and not full_rank(regressors[np.delete(rest, position)])
        ):
            break
        removed.append(rest[position])
        rest = np.delete(rest, position)
        done(len(rest))
    return rest, np.array(removed, dtype=np.int64)


STEPS = 300
HALVINGS = 2  # halvings of the p-norm that smooths extreme eigenvalues, p = 8
INSIDE = 1e-7  # distance from every edge, so that rounding of the solver cannot leave the space


def refine(case: Case, model: Model, scaling: Array, criterion: PoseCriterion, poses: Array) -> tuple[Array, str]:
    """Poses refined by IPOPT, or the start where nothing better was found, and the solver's status.

    K and N are optimised by a smooth p-norm of the eigenvalues and rated by their exact values.

    Args:
        scaling: scaling of the columns, shape (u,).
        poses: valid, of full rank, shape (n, 6) [m, rad].
    """
    space = space_of(case)
    count = len(poses)
    shares = ca.MX.sym("shares", space.size, count)
    information, limits = _pose_functions(model, scaling, space, poses.shape[1])
    like = ca.DM(poses).T
    triangle = ca.sum2(information.map(count)(shares, like)) / count
    margins = ca.vec(limits.map(count)(shares, like))
    objective = _objective(criterion.letter, len(scaling))  # it must live as long as the solver
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
    before, after = (_value(model, scaling, criterion, p) for p in (poses, refined))
    if not (after > before and valid_poses(case, refined).all()):
        return poses, f"{status}; nothing better found"
    return refined, status


def _value(model: Model, scaling: Array, criterion: PoseCriterion, poses: Array) -> float:
    if not np.isfinite(poses).all():
        return -np.inf
    return float(criterion.value(total_information(pose_regressors(model, poses) * scaling)))


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
