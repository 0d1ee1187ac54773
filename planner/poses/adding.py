"""Forward adding of poses until a criterion saturates, and exchange of chosen poses against better candidates."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner.poses.criteria import Index, PoseCriterion, total_information
from planner.poses.removal import TIE, full_rank

Array = NDArray[np.float64]

RIDGE = 1e-6  # of the mean information of all candidates: makes the first few poses comparable, and is taken out again
SATURATED = 0.01  # relative gain of the expected standard deviations by one more pose, below which no more are added
LEAST_IMPROVEMENT = 1e-9
SWEEPS = 30


@dataclass(frozen=True, slots=True)
class Addition:
    """What forward adding did.

    Args:
        chosen: indices of the poses in the order in which they were added.
        values: of the criterion after each addition; -inf while the rank is not full.
        saturated: whether it ended because one more pose would gain too little.
    """

    chosen: Index
    values: Array
    saturated: bool


def add_forward(
    regressors: Array,
    criterion: PoseCriterion,
    most: int,
    saturation: float = SATURATED,
    done: Callable[[int], None] = lambda _: None,
) -> Addition:
    """Adds, again and again, the pose with which the criterion is best.

    Saturation is measured by what any criterion is about: one more pose makes the geometric mean of the standard
    deviations smaller by less than `saturation` (0: add `most` poses whatever they gain).

    Args:
        regressors: scaled, of all candidates, shape (n, 6, u); together of full rank.
        criterion: what to make large.
        most: poses to choose at most.
        saturation: relative gain below which no more are added.
        done: called with the number of chosen poses after each addition.
    """
    size = regressors.shape[2]
    ridge = RIDGE * total_information(regressors) / len(regressors)
    chosen: list[int] = []
    values: list[float] = []
    information = ridge
    open_ = np.ones(len(regressors), dtype=bool)
    exact, before = False, -np.inf
    while len(chosen) < most:
        rows = np.flatnonzero(open_)
        after = criterion.after_addition(information, regressors[rows])
        best = rows[int(np.argmax(after >= after.max() - TIE * abs(after.max())))]
        grown = information + regressors[best].T @ regressors[best]
        logdet = float(np.linalg.slogdet(grown)[1]) / (2 * size)
        if exact and 1.0 - np.exp(before - logdet) < saturation:
            return Addition(np.array(chosen), np.array(values), True)
        chosen.append(int(best))
        open_[best] = False
        information, before = grown, logdet
        if not exact and full_rank(regressors[chosen]):
            exact, information = True, total_information(regressors[chosen])
            before = float(np.linalg.slogdet(information)[1]) / (2 * size)
        values.append(float(criterion.value(information)) if exact else -np.inf)
        done(len(chosen))
    return Addition(np.array(chosen), np.array(values), False)


def exchange(regressors: Array, criterion: PoseCriterion, chosen: Index) -> Index:
    """Replaces one chosen pose after the other by the best candidate in its place, until nothing improves.

    Args:
        regressors: scaled, of all candidates, shape (n, 6, u).
        criterion: what to make large.
        chosen: indices to start from; their regressors together of full rank, also without any one of them.

    Returns:
        Indices, ascending; never worse than `chosen`.
    """
    current = np.array(chosen)
    value = float(criterion.value(total_information(regressors[current])))
    for _ in range(SWEEPS):
        before = value
        for place in range(len(current)):
            others = np.delete(current, place)
            information = total_information(regressors[others])
            candidates = np.setdiff1d(np.arange(len(regressors)), others)
            after = criterion.after_addition(information, regressors[candidates])
            best = int(np.argmax(after))
            if after[best] > value + LEAST_IMPROVEMENT * abs(value):
                current[place] = candidates[best]
                value = float(criterion.value(total_information(regressors[current])))
        if value <= before + LEAST_IMPROVEMENT * abs(before):
            break
    return np.sort(current)
