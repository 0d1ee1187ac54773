"""Chooses poses by the method that was asked for."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.errors import HexciteError, InfeasiblePlan
from cases.schema import Case
from identification.model import Model
from planner.poses.pose_criteria import POSE_CRITERIA, pose_regressors, total_information
from planner.poses.pose_request import METHODS, PoseMethod, PoseRequest
from planner.poses.refinement import refine
from planner.poses.removal import MOST_EXHAUSTIVE, reduce_best, reduce_smallest_change

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Choice:
    """Chosen poses.

    Args:
        poses: shape (n, 6) [m, rad].
        remark: how the choice ended, one phrase.
    """

    poses: Array
    remark: str


def choose(
    request: PoseRequest,
    case: Case,
    model: Model,
    candidates: Array,
    regressors: Array,
    scaling: Array,
    done: Callable[[int], None],
) -> Choice:
    """Chooses poses.

    Args:
        request: method, criterion and count.
        case: gives the space of refinement.
        model: static.
        candidates: valid poses, shape (n, 6) [m, rad].
        regressors: theirs, scaled, shape (n, 6, u); together of full rank.
        scaling: scaling of the columns, shape (u,).
        done: called with the number of poses after each step.

    Raises:
        HexciteError: more or fewer poses are asked for than is possible.
        InfeasiblePlan: so few poses do not determine the model.
    """
    count = request.wanted(len(candidates), regressors.shape[2])
    criterion = POSE_CRITERIA[request.criterion]
    if request.method in (PoseMethod.ALL, PoseMethod.GIVEN):
        return Choice(candidates, METHODS[PoseMethod(request.method)])
    if request.method == PoseMethod.BACKWARD_CHANGE:
        if len(candidates) > MOST_EXHAUSTIVE:
            raise HexciteError(
                f"method backward-change evaluates every removal and is meant for {MOST_EXHAUSTIVE} candidates at "
                f"most, here are {len(candidates)}; choose backward"
            )
        kept = reduce_smallest_change(regressors, criterion, count, done).kept
    else:
        kept = reduce_best(regressors, criterion, count, done).kept
    if len(kept) > count:
        raise InfeasiblePlan(
            f"{count} poses do not determine model {request.model}: Algorithm 1 ends at {len(kept)}, every further "
            f"removal loses rank; ask for {len(kept)} or more"
        )
    if request.method in (PoseMethod.BACKWARD, PoseMethod.BACKWARD_CHANGE):
        return Choice(candidates[kept], "as many as asked for")
    refined = refine(case, model, scaling, criterion, candidates[kept])
    return Choice(refined.poses, f"refined: {refined.status}")


def smallest_set(model: Model, scaling: Array, poses: Array, letter: str) -> int:
    """Poses that Algorithm 1 keeps of a set, shape (n, 6), before the regressor loses rank (Table 5, "Min. poses")."""
    return len(reduce_best(pose_regressors(model, poses) * scaling, POSE_CRITERIA[letter], 1).kept)


def criterion_value(model: Model, scaling: Array, poses: Array, letter: str) -> float:
    """Value of a criterion of Table 4, to be maximised, of the mean information of poses, shape (n, 6), as scaled."""
    regressors = pose_regressors(model, poses) * scaling
    return float(POSE_CRITERIA[letter].value(total_information(regressors) / len(poses)))
