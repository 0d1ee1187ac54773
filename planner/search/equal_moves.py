"""Moves that share their times: what walks are chosen from before a solver moves waypoints and times.

Optimised moves come out nearly equal: each lasts as long as the limits of velocity, acceleration and jerk just allow
together, and in each of them every coordinate goes a full step up, a full step down, or stands.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.model import Model
from identification.trajectories.profile import fastest_profile
from planner.families.ptp import PointToPointFamily, states_of_move
from planner.search.state_limits import state_limits

Array = NDArray[np.float64]

PHASES = (1, 5)  # constant acceleration, deceleration


def _largest_way(limits: Array, duration: float) -> float:
    """The way that one coordinate can go from rest to rest within a duration, by bisection."""
    small, large = 0.0, float(limits[0] * duration)
    for _ in range(50):
        way = (small + large) / 2
        small, large = (way, large) if fastest_profile(way, *limits).duration <= duration else (small, way)
    return small


@dataclass(frozen=True)
class EqualMoves:
    """Moves that share their times.

    Args:
        times: of a segment with jerk, of constant acceleration, of constant velocity [s].
        steps: largest way of each coordinate in these times, in half widths of the box, shape (6,).
        size: number of parameters u.
        rated: start and end in half widths, (6,) each -> rows R, shape (u, 12), of which R R^T is the mean H A^T A H of
            the move, and by how much it passes non-linear limits.
    """

    times: Array
    steps: Array
    size: int
    rated: ca.Function

    @classmethod
    def of(cls, case: Case, model: Model, scaling: Array, family: PointToPointFamily) -> "EqualMoves":
        """The moves of a family, each of its mean duration; times are those that give the longest steps."""
        choices = []
        for limits in family.limits.T:
            way = _largest_way(limits, family.unit)
            times = np.array(fastest_profile(way, *limits)[1:])
            velocity = 1.0 / (times @ [2.0, 1.0, 1.0])
            acceleration = velocity / (times @ [1.0, 1.0, 0.0])
            peaks = np.array([velocity, acceleration, acceleration / times[0]])
            steps = np.min(family.limits / peaks[:, None], axis=0) / family.half
            choices.append((float(np.prod(np.minimum(steps, 2.0))), times, steps))
        _, times, steps = max(choices, key=lambda choice: choice[0])
        return cls(times, steps, len(scaling), _rated(case, model, scaling, family, times))


def _rated(case: Case, model: Model, scaling: Array, family: PointToPointFamily, times: Array) -> ca.Function:
    """Information at the middle of two phases of a move, the accelerations so that their mean square is exact."""
    square = (4 / 3 * times[0] + 2 * times[1]) / (times @ [4.0, 2.0, 1.0])  # mean of the squared acceleration
    start, end = ca.SX.sym("start", 6), ca.SX.sym("end", 6)
    ends = (ca.DM(family.middle) + ca.DM(family.half) * place for place in (start, end))
    states = states_of_move(tuple((phase, 0.5) for phase in PHASES)).call([*ends, ca.DM(times)], True, False)
    weight, shares = ca.diag(ca.DM(scaling)) / np.sqrt(len(PHASES)), state_limits(case).shares
    rows, largest = [], ca.SX(0)
    for k in range(len(PHASES)):
        pose, rates, accelerations = (matrix[:, k] for matrix in states)
        rows.append(ca.densify(model.coordinate_regressor(pose, rates, np.sqrt(square) * accelerations) @ weight))
        largest = ca.fmax(largest, ca.mmax(ca.fabs(shares(pose, rates, accelerations))))
    return ca.Function("move", [start, end], [ca.vertcat(*rows).T, ca.fmax(0, largest - 1)], {"cse": True})


class Rater:
    """Rates moves in one call, through buffers: CasADi's own conversion takes longer than the evaluation."""

    def __init__(self, moves: EqualMoves) -> None:
        self.moves = moves
        self._prepared: dict[int, _Prepared] = {}

    def _of(self, count: int) -> "_Prepared":
        if count not in self._prepared:
            rated = self.moves.rated
            buffer, evaluate = rated.map(count).buffer()
            starts, ends, passed = np.zeros((count, 6)), np.zeros((count, 6)), np.zeros(count)
            rows = np.zeros((count, rated.size2_out(0), self.moves.size))
            for k, argument in enumerate((starts, ends)):
                buffer.set_arg(k, argument.ravel().data)
            for k, result in enumerate((rows, passed)):
                buffer.set_res(k, result.ravel().data)
            self._prepared[count] = _Prepared(starts, ends, rows, passed, evaluate, buffer)
        return self._prepared[count]

    def __call__(self, starts: Array, ends: Array) -> Array:
        """Mean information of each move, u u elements, and by how much it passes limits, shape (moves, u u + 1)."""
        prepared = self._of(len(starts))
        prepared.starts[:], prepared.ends[:] = starts, ends
        prepared.evaluate()
        results = np.empty((len(starts), self.moves.size**2 + 1))
        results[:, :-1] = (prepared.rows.transpose(0, 2, 1) @ prepared.rows).reshape(len(starts), -1)
        results[:, -1] = prepared.passed
        return results


class _Prepared(NamedTuple):
    """Buffers of a number of moves, what fills them, and the owner of what is called."""

    starts: Array
    ends: Array
    rows: Array
    passed: Array
    evaluate: Callable[[], None]
    owner: object
