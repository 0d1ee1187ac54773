"""Starts of point-to-point motions by simulated annealing over walks of equal moves.

Optimised moves come out nearly equal: each lasts as long as the limits of velocity, acceleration and jerk just allow
together, and in each of them every coordinate goes a full step up, a full step down, or stands. This
choice is combinatorial: derivatives do not show it. So walks of such moves are annealed first (Metropolis, criterion
D); a solver then moves waypoints and times.

Proposals are made and rated many at a time. log det is concave: log det(F + dF) <= log det F + trace(F^-1 dF) rules
most of them out before anything else is computed.
"""

from collections.abc import Callable
from itertools import pairwise

import casadi as ca
import numpy as np

from cases.base.units import Array, Flags, Indices
from cases.schema import Case
from identification.machines.casadi_batch import over_samples
from identification.model.model import Model
from planner.families.ptp import PointToPointFamily, law_times, state_of_move
from planner.search.problem import near_limits

HOT, COLD = 0.05, 0.003  # temperatures in units of log det F: above walks forget, below nothing moves any more
EXCESS = 2.0  # loss of log det F for each whole limit of a rate or acceleration by which a move exceeds it
RIDGE = 1e-9  # on the diagonal of F in reference scaling: a walk that stands still has a value too
TEMPERATURES = 40
PROPOSALS = 0.75  # number of proposals for each three moves: few moves leave less to choose
FEWEST, MOST = 16, 256  # proposals at a time
KINDS = (0.6, 0.2, 0.2)  # shares of proposals: runs are shifted, one waypoint is chosen anew, an excursion moved
FAR = 0.1  # share of shifts of any number of waypoints; the others shift few
FEW = 0.35  # parameter of the geometric distribution of that few
SHIFTS = np.array([-2.0, -1.0, 1.0, 2.0])  # steps by which waypoints are shifted
LOOSE = 0.15  # share of shifts by no whole number of steps
WIDE = 0.3  # [half widths] largest length of these shifts
TWO = 0.4  # share of shifts of two coordinates
STILL = 0.1  # share of coordinates that stand in a move chosen anew
INWARD = 0.9  # share of its steps out of the box that go the other way instead
SLACK = 1e-9  # [half widths] for rounding
POSE_REACHED = 0.995  # share of a limit of poses that walks may use


def _rows(model: Model, scaling: Array, ends: list[ca.SX], times: ca.SX) -> ca.SX:
    """Regressors at the middle of acceleration and deceleration, so that the mean square of accelerations is exact."""
    duration = 4 * times[0] + 2 * times[1] + times[2]
    square = (4 / 3 * times[0] + 2 * times[1]) / duration  # mean of the squared acceleration
    rows = []
    for phase in (1, 5):
        pose, rates, accelerations = state_of_move(ends[0], ends[1], times, (phase, 0.5))
        rows.append(model.coordinate_regressor(pose, rates, ca.sqrt(square) * accelerations))
    return ca.densify(ca.vertcat(*rows) @ ca.diag(ca.DM(scaling)) / np.sqrt(2))


# A jerk-limited move uses most of an acceleration where a phase of constant acceleration begins or ends.
# Both ends count: the first waypoint of a walk is the end of no move.
_PLACES = (((0, 0.0), (3, 0.5), (6, 1.0)), ((3, 0.5),), ((1, 0.5), (5, 0.5)))  # by the order of `Limits`


def _excess(case: Case, ends: list[ca.SX], times: ca.SX) -> ca.SX:
    excess, pose = ca.SX(0), ca.SX(0)
    for _, order, kernel in near_limits(case):
        for place in _PLACES[order]:
            state = ca.vertcat(*state_of_move(ends[0], ends[1], times, place), 0)
            share = ca.mmax(ca.fabs(ca.substitute(kernel.expression, kernel.variables, state)))
            if order == 0:
                pose = ca.fmax(pose, share)
            else:
                excess = ca.fmax(excess, share - 1)
    return ca.vertcat(excess, pose)


Proposals = tuple[Array, Indices, Flags]
"""Walks that are proposed: their waypoints in half widths, shape (P, moves + 1, n); which of the present waypoints each
was, and which are at a new place, shapes (P, moves + 1)."""


class Walk:
    """A walk of equal moves, as many as a family has, that is being annealed.

    All moves last the family's mean duration; of the times that they share those give the longest steps.

    Args:
        scaling: reference scaling, shape (u,).
        draw: random generator.
        points: waypoints in half widths to begin with, shape (moves + 1, n), moved into the limits of poses.
        known: information of earlier results, in units of the mean information, shape (u, u).
    """

    def __init__(
        self,
        case: Case,
        model: Model,
        scaling: Array,
        family: PointToPointFamily,
        draw: np.random.Generator,
        points: Array,
        known: Array | None = None,
    ) -> None:
        self.beside = RIDGE * np.eye(len(scaling)) + (0.0 if known is None else known)  # information of no move
        self.size, self.count, self.draw = len(scaling), family.moves, draw
        # three times of each move [s]; largest way of each coordinate in them, in half widths of the box, shape (n,)
        self.times, self.steps = family.longest_steps()
        move = ca.SX.sym("move", 2 * len(self.steps))
        ends = [ca.DM(family.middle) + ca.DM(family.half) * place for place in ca.vertsplit(move, len(self.steps))]
        # start and end in half widths, shape (2 n,), -> matrix R, shape (12, u), of which R^T R is the mean H A^T A H
        # of the move; and by how much it exceeds limits of rates and accelerations, and its largest share of one of
        # poses
        times = law_times(ends[1] - ends[0], family.limits, family.unit) if family.own_law else ca.SX(self.times)
        self.rows_of = ca.Function("rows", [move], [_rows(model, scaling, ends, times)], {"cse": True})
        self.excess_of = ca.Function("excess", [move], [_excess(case, ends, times)], {"cse": True})
        self.points = self._inside(points)
        starts, ends_of_moves = self.points[:-1], self.points[1:]
        self.rows = _in_blocks(self.rows_of, starts, ends_of_moves)  # R of each move, shape (n, 12, u)
        self.passed = _in_blocks(self.excess_of, starts, ends_of_moves)[:, 0]
        self.batch = FEWEST
        self._take()
        self.best, self.best_points = self.value, self.points

    def _inside(self, points: Array) -> Array:
        """Waypoints at most a step apart, moved together until all of them satisfy the limits of poses."""
        points = points.copy()
        for before, point in pairwise(points):
            np.clip(point, before - self.steps, before + self.steps, out=point)
        while np.abs(points).max() > 1e-3 and _in_blocks(self.excess_of, points, points)[:, 1].max() > POSE_REACHED:
            points = points * 0.95
        return points

    def _take(self) -> None:
        """Computes the information and its factors from the present moves."""
        size = self.size
        flat = self.rows.reshape(-1, size)
        self.total = flat.T @ flat / self.count + self.beside
        factor = np.linalg.cholesky(self.total)
        self.logdet = 2.0 * float(np.log(np.diag(factor)).sum())
        self.root = np.linalg.inv(factor).T  # rows @ root: their squares add up to trace(F^-1 R^T R)
        self.traces = ((flat @ self.root) ** 2).sum(axis=1).reshape(self.count, -1).sum(axis=1)
        self.value = self.logdet - EXCESS * float(self.passed.sum())

    def anneal(self, temperature: float, proposals: int) -> None:
        """Proposes changes at one temperature."""
        kinds = (self.shifted, self.with_new_waypoint, self.with_moved_excursion)
        while proposals > 0:
            kind = kinds[int(self.draw.choice(len(kinds), p=KINDS))]
            attempts, accepted = self._try(*kind(self.batch), temperature)
            proposals -= attempts
            self.batch = max(FEWEST, self.batch // 2) if accepted else min(MOST, self.batch * 2)

    def _try(self, points: Array, source: Indices, new: Flags, temperature: float) -> tuple[int, bool]:
        """Takes the first of `Proposals` that is accepted; returns how many were looked at, and whether one was."""
        count = len(points)
        valid = np.all(
            np.abs(np.diff(points, axis=1)) <= self.steps + SLACK, axis=(1, 2)
        )  # no move is longer than a step
        chances = self.value + temperature * np.log1p(-self.draw.random(count))
        present = ~(new[:, :-1] | new[:, 1:]) & (np.diff(source, axis=1) == 1)
        origin = np.where(present, source[:, :-1], 0)
        number, place = np.nonzero(~present & valid[:, None])
        starts, ends = points[number, place], points[number, place + 1]
        rows = _in_blocks(self.rows_of, starts, ends)
        size = self.size
        traces = ((rows.reshape(-1, size) @ self.root) ** 2).reshape(len(rows), rows.shape[1] * size).sum(axis=1)
        gains = np.bincount(number, traces, count) + np.where(present, self.traces[origin], 0.0).sum(axis=1)
        remainder = np.where(present, self.passed[origin], 0.0).sum(axis=1)
        bound = self.logdet + (gains - self.traces.sum()) / self.count - EXCESS * remainder
        for k in np.flatnonzero(valid & (bound >= chances)):
            of_move = number == k
            excess = _in_blocks(self.excess_of, starts[of_move], ends[of_move])
            if excess[:, 1].max(initial=0.0) > POSE_REACHED:
                continue
            all_rows = np.empty_like(self.rows)
            all_rows[present[k]], all_rows[place[of_move]] = self.rows[origin[k][present[k]]], rows[of_move]
            flat = all_rows.reshape(-1, size)
            sign, logdet = np.linalg.slogdet(flat.T @ flat / self.count + self.beside)
            value = logdet - EXCESS * (remainder[k] + excess[:, 0].sum())
            if sign > 0 and value >= chances[k]:
                violations = np.empty(self.count)
                violations[present[k]], violations[place[of_move]] = (
                    self.passed[origin[k][present[k]]],
                    excess[:, 0],
                )
                self.points, self.rows, self.passed = points[k], all_rows, violations
                self._take()
                if self.value > self.best:
                    self.best, self.best_points = self.value, self.points
                return int(k) + 1, True
        return count, False

    def shifted(self, count: int) -> Proposals:
        """Proposals with runs of waypoints shifted in one or two coordinates."""
        draw, places = self.draw, self.count + 1
        length = np.where(draw.random(count) < FAR, draw.integers(1, places, count), draw.geometric(FEW, count))
        length = np.minimum(length, places)
        begin = draw.integers(1 - length, places)
        at = np.arange(places)
        run = (at >= begin[:, None]) & (at < (begin + length)[:, None])
        points = np.repeat(self.points[None], count, axis=0)
        for chance in (1.0, TWO):
            k = draw.integers(len(self.steps), size=count)
            by = self.steps[k] * SHIFTS[draw.integers(len(SHIFTS), size=count)]
            by = np.where(draw.random(count) < LOOSE, draw.uniform(-WIDE, WIDE, count), by)
            by[draw.random(count) >= chance] = 0.0
            index = np.arange(count)
            column = points[index, :, k]
            points[index, :, k] = np.where(run, np.clip(column + by[:, None], -1.0, 1.0), column)
        return points, np.tile(at, (count, 1)), run

    def _next_to(self, places: Array) -> Array:
        """Places one move from others: most coordinates go a full step, into the box rather than out of it."""
        draw, steps = self.draw, self.steps
        sign = np.where(draw.random(places.shape) < 0.5, -1.0, 1.0)
        sign[draw.random(places.shape) < STILL] = 0.0
        outside = np.abs(places + sign * steps) > 1.0 + SLACK
        sign[outside & (draw.random(places.shape) < INWARD)] *= -1.0
        return np.clip(places + sign * steps, -1.0, 1.0)

    def with_new_waypoint(self, count: int) -> Proposals:
        """Proposals with one waypoint chosen anew."""
        index, at = np.arange(count), np.arange(self.count + 1)
        place = self.draw.integers(self.count + 1, size=count)
        points = np.repeat(self.points[None], count, axis=0)
        points[index, place] = self._next_to(self.points[np.where(place > 0, place - 1, 1)])
        return points, np.tile(at, (count, 1)), at == place[:, None]

    def with_moved_excursion(self, count: int) -> Proposals:
        """Proposals without two waypoints and with an excursion to a new place elsewhere."""
        index, at = np.arange(count), np.arange(self.count + 1)
        out = self.draw.integers(self.count, size=count)[:, None]
        place = self.draw.integers(self.count - 1, size=count)[:, None]
        offset = at - 2 * (at >= place + 2) - (at == place + 1)
        source = offset + 2 * (offset >= out)
        points = self.points[source]
        point = points[index, place[:, 0]]
        points[index, place[:, 0] + 1] = self._next_to(point)
        return points, source, at == place + 1


BLOCK = 8


def _in_blocks(function: ca.Function, starts: Array, ends: Array) -> Array:
    """Values for each move; their number is rounded up, since each number has a function of its own."""
    count = len(starts)
    table = np.zeros((-(-count // BLOCK) * BLOCK, 2 * starts.shape[1]))
    table[:count] = np.hstack([starts, ends])
    return over_samples(function, table)[0][:count]


def annealed_start(
    case: Case,
    model: Model,
    scaling: Array,
    family: PointToPointFamily,
    draw: np.random.Generator,
    watch: Callable[[float], bool],
    known: Array | None = None,
) -> Array:
    """Unknowns of an annealed walk; limits of rates and accelerations may still be exceeded a little.

    Args:
        watch: called with -log det F / u now and then; a true answer ends the annealing.
        known: as of `Walk`.
    """
    points = family.split(family.start(draw, lambda unknowns: 0.0))[0]
    walk = Walk(case, model, scaling, family, draw, points, known)
    proposals = round(PROPOSALS * family.moves**3)
    for temperature in np.geomspace(HOT, COLD, TEMPERATURES):
        walk.anneal(float(temperature), proposals // TEMPERATURES)
        if watch(-walk.best / walk.size):
            break
    return np.concatenate([walk.best_points.ravel(), np.tile(walk.times / family.unit, family.moves)])
