"""Starts of point-to-point motions by simulated annealing over walks of equal moves.

Optimised moves come out nearly equal: each lasts as long as the limits of velocity, acceleration and jerk just allow
together, and in each of them every coordinate goes a full step up, a full step down, or stands. Which of the three is a
combinatorial choice that derivatives do not see. So walks of such moves are annealed first (Metropolis, D criterion);
a solver then moves waypoints and times. Information is taken at the middle of three phases of a move, weighted so
that the mean square of the acceleration is exact: enough for a choice, rated properly afterwards.
"""

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.model import Model
from identification.trajectories.profile import fastest_profile
from planner.families.ptp import PointToPointFamily, states_of_move
from planner.search.information import sample_information
from planner.search.state_limits import state_limits

Array = NDArray[np.float64]

PHASES = (1, 3, 5)  # constant acceleration, velocity, deceleration
HOT, COLD = 0.03, 0.002  # temperatures in units of log det F: above walks forget, below nothing moves any more
EXCESS = 2.0  # of log det F for each whole limit that a move passes
RIDGE = 1e-9  # on the diagonal of F in reference scaling: a walk that stands still has a value too
BLOCK = 1000  # proposals between two words to the watch
FAR = 0.1  # share of proposals that shift any number of waypoints; the others shift few
FEW = 0.35  # parameter of the geometric distribution of that few
SHIFTS = (-2, -1, 1, 2)  # steps by which waypoints are shifted
LOOSE = 0.15  # share of proposals that shift by no whole number of steps
WIDE = 0.3  # [half widths] of these, at most
TWO = 0.4  # share of proposals that shift two coordinates
SLACK = 1e-9  # [half widths] for rounding


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
        rated: start and end in half widths, (6,) each -> lower triangle of the mean H A^T A H of the move, and by how
            much it passes non-linear limits.
    """

    times: Array
    steps: Array
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
        return cls(times, steps, _rated(case, model, scaling, family, times))


def _rated(case: Case, model: Model, scaling: Array, family: PointToPointFamily, times: Array) -> ca.Function:
    square = (4 / 3 * times[0] + 2 * times[1]) / (times @ [4.0, 2.0, 1.0])  # mean of the squared acceleration
    weights = (square / 2, 1 - square, square / 2)
    start, end = ca.SX.sym("start", 6), ca.SX.sym("end", 6)
    ends = (ca.DM(family.middle) + ca.DM(family.half) * place for place in (start, end))
    states = states_of_move(tuple((phase, 0.5) for phase in PHASES)).call([*ends, ca.DM(times)], True, False)
    information, shares = sample_information(model, scaling), state_limits(case).shares
    triangle, largest = ca.SX(0), ca.SX(0)
    for k, weight in enumerate(weights):
        state = [matrix[:, k] for matrix in states]
        triangle += weight * information.call(state, True, False)[0]
        largest = ca.fmax(largest, ca.mmax(ca.fabs(shares.call(state, True, False)[0])))
    return ca.Function("move", [start, end], [ca.vertcat(triangle, ca.fmax(0, largest - 1))], {"cse": True})


class _Rater:
    """Rates several moves in one call, through buffers: CasADi's own conversion takes longer than the evaluation."""

    def __init__(self, rated: ca.Function, most: int) -> None:
        self.prepared = [self._prepare(rated, count) for count in range(1, most + 1)]

    @staticmethod
    def _prepare(rated: ca.Function, count: int) -> tuple[Array, Array, Array, Callable[[], None], object]:
        buffer, evaluate = rated.map(count).buffer()
        starts, ends, results = np.zeros((count, 6)), np.zeros((count, 6)), np.zeros((count, rated.size1_out(0)))
        buffer.set_arg(0, starts.ravel().data)
        buffer.set_arg(1, ends.ravel().data)
        buffer.set_res(0, results.ravel().data)
        return starts, ends, results, evaluate, buffer

    def __call__(self, starts: Array, ends: Array) -> Array:
        """Rows of `EqualMoves.rated`, shape (moves, ..)."""
        own_starts, own_ends, results, evaluate, _ = self.prepared[len(starts) - 1]
        own_starts[:], own_ends[:] = starts, ends
        evaluate()
        return results.copy()


class Walk:
    """A closed walk of equal moves that is being annealed.

    Args:
        moves: what each move may be.
        count: number of moves.
        size: number of parameters.
        draw: the source of chance.
    """

    def __init__(self, moves: EqualMoves, count: int, size: int, draw: np.random.Generator) -> None:
        self.moves, self.count, self.draw = moves, count, draw
        self.rate = _Rater(moves.rated, count)
        self.row, self.column = (np.array(k) for k in ca.Sparsity.lower(size).get_triplet())
        self.matrix = np.zeros((size, size))
        self.points = np.tile(draw.uniform(-0.5, 0.5, 6), (count, 1))
        self.parts = self.rate(self.points, np.roll(self.points, -1, axis=0))
        self.total = self.parts.mean(axis=0)
        self.value = self.worth(self.total)
        self.best, self.best_points = self.value, self.points

    def worth(self, total: Array) -> float:
        """Log det F of the whole walk, less what it passes limits by."""
        self.matrix[self.row, self.column] = total[:-1]
        np.fill_diagonal(self.matrix, np.diag(self.matrix) + RIDGE)
        try:
            lower = np.linalg.cholesky(self.matrix)
        except np.linalg.LinAlgError:
            return -np.inf
        return float(2.0 * np.log(np.diag(lower)).sum() - EXCESS * self.count * total[-1])

    def anneal(self, temperature: float, proposals: int) -> None:
        """Proposes shifts of runs of waypoints, one or two coordinates each, at one temperature."""
        draw, count, steps = self.draw, self.count, self.moves.steps
        lengths = np.minimum(draw.geometric(FEW, proposals), count - 1)
        far = draw.random(proposals) < FAR
        lengths[far] = draw.integers(1, count, far.sum())
        begins = draw.integers(0, count, proposals)
        coordinates = draw.integers(0, 6, (proposals, 2))
        shifts = steps[coordinates] * draw.choice(SHIFTS, (proposals, 2))
        loose = draw.random(proposals) < LOOSE
        shifts[loose] = draw.uniform(-WIDE, WIDE, (loose.sum(), 2))
        shifts[draw.random(proposals) >= TWO, 1] = 0.0
        luck = temperature * np.log1p(-draw.random(proposals))
        ways = steps + SLACK
        for begin, length, pair, shift, chance in zip(begins, lengths, coordinates, shifts, luck, strict=True):
            trial = self.points.copy()
            run = np.arange(begin, begin + length) % count
            for coordinate, by in zip(pair, shift, strict=True):
                trial[run, coordinate] = np.clip(trial[run, coordinate] + by, -1.0, 1.0)
            touched = np.arange(begin - 1, begin + length) % count
            starts, ends = trial[touched], trial[(touched + 1) % count]
            if (np.abs(ends - starts) > ways).any():
                continue
            parts = self.rate(starts, ends)
            total = self.total + (parts.sum(axis=0) - self.parts[touched].sum(axis=0)) / count
            value = self.worth(total)
            if value - self.value >= chance:
                self.points, self.total, self.value = trial, total, value
                self.parts[touched] = parts
                if value > self.best:
                    self.best, self.best_points = value, trial


def annealed_start(
    case: Case,
    model: Model,
    scaling: Array,
    family: PointToPointFamily,
    draw: np.random.Generator,
    proposals: int,
    watch: Callable[[float], bool],
) -> Array:
    """Unknowns of an annealed walk; limits may still be passed a little.

    Args:
        case: machine and limits.
        model: gives A.
        scaling: reference scaling, shape (u,).
        family: number of moves and duration.
        draw: the source of chance.
        proposals: how many; the temperature falls geometrically meanwhile.
        watch: is told -log det F / u now and then; true ends the annealing.
    """
    moves = EqualMoves.of(case, model, scaling, family)
    walk = Walk(moves, family.moves, len(scaling), draw)
    blocks = max(2, proposals // BLOCK)
    for temperature in np.geomspace(HOT, COLD, blocks):
        walk.anneal(float(temperature), BLOCK)
        if watch(-walk.best / len(scaling)):
            break
    return np.concatenate([walk.best_points.ravel(), np.tile(moves.times / family.unit, family.moves)])
