"""Starts of point-to-point motions by simulated annealing over walks of equal moves.

In which of its moves a coordinate goes a full step up, a full step down, or stands is a combinatorial choice that
derivatives do not see. So walks of such moves are annealed first (Metropolis, D criterion); a solver then moves
waypoints and times. Good walks visit few places and go back and forth between them, so that besides shifts of
waypoints whole excursions, there and back, are proposed.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.model import Model
from planner.families.ptp import PointToPointFamily
from planner.search.equal_moves import EqualMoves, Rater

Array = NDArray[np.float64]

HOT, COLD = 0.04, 0.002  # temperatures in units of log det F: above walks forget, below nothing moves any more
EXCESS = 2.0  # of log det F for each whole limit that a move passes
RIDGE = 1e-9  # on the diagonal of F in reference scaling: a walk that stands still has a value too
BLOCK = 1000  # proposals between two words to the watch
KINDS = (0.6, 0.2, 0.2)  # shares of proposals: runs are shifted, one waypoint is chosen anew, an excursion moved
FAR = 0.1  # share of shifts of any number of waypoints; the others shift few
FEW = 0.35  # parameter of the geometric distribution of that few
SHIFTS = (-2, -1, 1, 2)  # steps by which waypoints are shifted
LOOSE = 0.15  # share of shifts by no whole number of steps
WIDE = 0.3  # [half widths] of these, at most
TWO = 0.4  # share of shifts of two coordinates
STILL = 0.1  # share of coordinates that stand in a move chosen anew
INWARD = 0.9  # share of its steps out of the box that go the other way instead
SLACK = 1e-9  # [half widths] for rounding


NEW = -1


class Proposal(NamedTuple):
    """A walk, and for each of its moves which one of the present walk that is; `NEW` where none."""

    points: Array
    origins: NDArray[np.intp]


class Walk:
    """A walk of equal moves that is being annealed.

    Args:
        moves: what each move may be.
        points: waypoints, in half widths, shape (moves + 1, 6).
        draw: the source of chance.
    """

    def __init__(self, moves: EqualMoves, points: Array, draw: np.random.Generator) -> None:
        from scipy.linalg.lapack import dpotrf  # here: what plans no moves does without SciPy

        self.moves, self.count, self.draw, self.factorised = moves, len(points) - 1, draw, dpotrf
        self.ways = moves.steps + SLACK
        self.own = np.arange(self.count)
        self.rate = Rater(moves)
        self.ridge = RIDGE * np.eye(moves.size)
        self.points = points
        self.parts = self.rate(points[:-1], points[1:])
        self.total = self.parts.mean(axis=0)
        self.value = self.worth(self.total)
        self.best, self.best_points = self.value, self.points

    def worth(self, total: Array) -> float:
        """Log det F of the whole walk, less what it passes limits by."""
        size = self.moves.size
        factor, fault = self.factorised(total[:-1].reshape(size, size) + self.ridge, clean=0)
        if fault:
            return -np.inf
        return float(2.0 * np.log(factor.diagonal()).sum() - EXCESS * self.count * total[-1])

    def anneal(self, temperature: float, proposals: int) -> None:
        """Proposes changes at one temperature."""
        kinds = (self._shifted, self._with_new_waypoint, self._with_moved_excursion)
        luck = temperature * np.log1p(-self.draw.random(proposals))
        for kind, chance in zip(self.draw.choice(len(kinds), proposals, p=KINDS), luck, strict=True):
            proposal = kinds[kind]()
            if proposal is None:
                continue
            points, origins = proposal
            new = np.flatnonzero(origins == NEW)
            left_out = np.ones(self.count, dtype=bool)
            left_out[origins[origins != NEW]] = False
            parts = self.rate(points[new], points[new + 1])
            total = self.total + (parts.sum(axis=0) - self.parts[left_out].sum(axis=0)) / self.count
            value = self.worth(total)
            if value - self.value >= chance:
                self.points, self.total, self.value = points, total, value
                self.parts = self.parts[origins]
                self.parts[new] = parts
                if value > self.best:
                    self.best, self.best_points = value, points

    def _origins(self, first: int, after: int) -> NDArray[np.intp]:
        """Of a walk whose moves from `first` up to but not including `after` are new."""
        origins = self.own.copy()
        origins[first:after] = NEW
        return origins

    def _too_long(self, ways: Array) -> bool:
        return bool((np.abs(ways) > self.ways).any())

    def _shifted(self) -> Proposal | None:
        """A run of waypoints shifted in one or two coordinates; None where a move becomes too long."""
        draw, last, points = self.draw, self.count, self.points
        length = int(draw.integers(1, last + 1)) if draw.random() < FAR else min(int(draw.geometric(FEW)), last)
        begin = int(draw.integers(1 - length, last + 1))
        begin, end = max(begin, 0), min(begin + length, last + 1)
        trial = points.copy()
        for _ in range(2 if draw.random() < TWO else 1):
            k = int(draw.integers(6))
            loose = draw.random() < LOOSE
            by = draw.uniform(-WIDE, WIDE) if loose else float(self.moves.steps[k]) * SHIFTS[draw.integers(len(SHIFTS))]
            run = np.clip(trial[begin:end, k] + by, -1.0, 1.0)
            # Most shifts make the move into the run or that out of it too long.
            if begin > 0 and abs(run[0] - trial[begin - 1, k]) > self.ways[k]:
                return None
            if end <= last and abs(run[-1] - trial[end, k]) > self.ways[k]:
                return None
            trial[begin:end, k] = run
        first, after = max(begin - 1, 0), min(end, last)
        if self._too_long(np.diff(trial[first : after + 1], axis=0)):
            return None
        return Proposal(trial, self._origins(first, after))

    def _next_to(self, place: Array) -> Array:
        """A place a move away: most coordinates go a full step, into the box rather than out of it."""
        draw, steps = self.draw, self.moves.steps
        sign = np.where(draw.random(6) < 0.5, -1.0, 1.0)
        sign[draw.random(6) < STILL] = 0.0
        outside = np.abs(place + sign * steps) > 1.0 + SLACK
        sign[outside & (draw.random(6) < INWARD)] *= -1.0
        return np.clip(place + sign * steps, -1.0, 1.0)

    def _with_new_waypoint(self) -> Proposal | None:
        """One waypoint chosen anew; None where the move out of it becomes too long."""
        place, last = int(self.draw.integers(self.count + 1)), self.count
        new = self._next_to(self.points[place - 1 if place else 1])
        if 0 < place < last and self._too_long(self.points[place + 1] - new):
            return None
        trial = self.points.copy()
        trial[place] = new
        return Proposal(trial, self._origins(max(place - 1, 0), min(place + 1, last)))

    def _with_moved_excursion(self) -> Proposal | None:
        """Two waypoints left out and, elsewhere, a new place visited and left again; None where a gap is too wide."""
        points, draw = self.points, self.draw
        out = int(draw.integers(self.count))
        if 0 < out < self.count - 1 and self._too_long(points[out + 2] - points[out - 1]):
            return None
        kept = np.concatenate([points[:out], points[out + 2 :]])
        if out == 0:
            origins = self.own[2:]
        elif out == self.count - 1:
            origins = self.own[:-2]
        else:
            origins = np.concatenate([self.own[: out - 1], [NEW], self.own[out + 2 :]])
        place = int(draw.integers(len(kept)))
        here = kept[place]
        trial = np.concatenate([kept[: place + 1], [self._next_to(here), here], kept[place + 1 :]])
        return Proposal(trial, np.concatenate([origins[:place], [NEW, NEW], origins[place:]]))


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
    walk = Walk(moves, np.tile(draw.uniform(-0.5, 0.5, 6), (family.moves + 1, 1)), draw)
    for temperature in np.geomspace(HOT, COLD, max(2, proposals // BLOCK)):
        walk.anneal(float(temperature), BLOCK)
        if watch(-walk.best / len(scaling)):
            break
    return np.concatenate([walk.best_points.ravel(), np.tile(moves.times / family.unit, family.moves)])
