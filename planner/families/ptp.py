"""Point-to-point excitation: straight moves in the coordinates, each from rest to rest under seven segments.

Unknowns are the waypoints and three times of each move: of a segment with jerk, of constant acceleration, of constant
velocity. With D the way of a coordinate and tj, th, tc these times its largest velocity is D / (2 tj + th + tc), its
largest acceleration that over (tj + th), its largest jerk that over tj: limits hold for all t and are 3 n rows a move
for n coordinates. For a controller that does not limit jerk tj is 0, moves are trapezoids with 2 n rows each.
The last move need not end where the first begins: a way back would cost moves with little information.

A controller that times moves itself knows no such times: it is given the duration of a move (by its feed), accelerates
as hard as its set-up allows, and cruises more slowly instead. Of a family with this law (`own_law`) one coordinate of
each move reaches its limit of acceleration, and one that of jerk: otherwise struts and sensors would bear less in the
plan than in the program.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar

import casadi as ca
import numpy as np

from cases.base.units import Array, Flags, Indices
from cases.chain import Box
from cases.schema import Case
from identification.estimation.criteria import box_middle
from identification.limits.limit import UNUSED_SHARE
from identification.machines.casadi_batch import over_samples
from identification.motion.motion import Joined, Standstill
from identification.motion.moves import StraightMove, fastest_profile, unit_profile
from planner.families.family import Family, Layout
from planner.families.plan_settings import MoveSettings
from planner.families.rows import LinearRows, StateRows
from planner.families.states import Kernel, KernelStates, LinearStates, state_size

FEWEST, MOST = 8, 64  # moves
SHORTEST_CYCLES, SHORTEST_TIME = 3, 2e-3  # of a phase: controller cycles, and [s]; a shorter one is absent
LONGEST_PHASE = 4.0  # mean durations of a move
LAW = 1.0 - UNUSED_SHARE - 5e-4  # share of accelerations and jerks with which moves by a controller's law are planned
NOWHERE = 1e-12  # [m or rad] a shorter way has no law
ROUNDING = 1e-6  # share of a move's duration by which the fastest law may last longer
GAUSS = 0.5 - 0.5 / np.sqrt(3.0)  # two points integrate what is cubic in time exactly: jerk phases squared


MOVES_A_SECOND = 10.0 / 3.0  # at most where jerk is limited


def shortest_phase(cycle: float) -> float:
    """Shortest duration of a phase for a controller of some cycle [s]."""
    return max(SHORTEST_CYCLES * cycle, SHORTEST_TIME)


def moves_in(box: Box, duration: float) -> float:
    """Number of moves for which a duration has room.

    A good move just reaches its limit of velocity, or crosses the box before that: where accelerations step in all
    coordinates; where jerk is limited in the quickest, and in 0.3 s at least.

    Args:
        box: limits that count, see `controlled`.
    """
    width = box.coordinates[1] - box.coordinates[0]
    each = 2 * np.minimum(box.rate / box.acceleration, np.sqrt(width / box.acceleration))
    if box.limits_jerk:
        return duration * min(MOVES_A_SECOND, 1.0 / float(np.min(each)))
    return duration / float(np.max(each))


def _profile_state(share: float, times: ca.SX, phase: int) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Share of the way, velocity and acceleration of a unit move at a share of a phase (0 to 6), which may last 0."""
    tj, th, tc = times[0], times[1], times[2]
    peak = 1 / ((tj + th) * (2 * tj + th + tc))
    s, v, a = ca.SX(0), ca.SX(0), ca.SX(0)
    for k, (length, sign) in enumerate(zip(_phases(times)[: phase + 1], (1, 0, -1, 0, -1, 0, 1), strict=False)):
        part = share if k == phase else 1.0
        tau, step = part * length, sign * part * peak
        s, v, a = s + v * tau + a * tau**2 / 2 + step * tau**2 / 6, v + a * tau + step * tau / 2, a + step
    return s, v, a


def state_of_move(start: ca.SX, end: ca.SX, times: ca.SX, point: tuple[int, float]) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Coordinates, rates and accelerations of a move at a phase (0 to 6) and a share of it."""
    s, v, a = _profile_state(point[1], times, point[0])
    way = end - start
    return start + s * way, v * way, a * way


def _phases(times: ca.SX) -> tuple[ca.SX, ...]:
    """Lengths of the seven phases."""
    tj, th, tc = times[0], times[1], times[2]
    return (tj, th, tj, tc, tj, th, tj)


def law_times(way: ca.SX, limits: Array, duration: ca.SX | float) -> ca.SX:
    """Three times of a move as a controller makes it that is given its duration, not below the shortest, shape (3,).

    Args:
        way: of each coordinate, shape (n,) [m or rad].
        limits: of rates, accelerations and jerks, shape (3, n), or without the jerks, shape (2, n).
        duration: [s].
    """
    acceleration, *jerks = (ca.mmin(ca.DM(limit) / (ca.fabs(way) + NOWHERE)) for limit in limits[1:])
    jerk_time = acceleration / jerks[0] if jerks else ca.SX(0)
    # The acceleration stays at its limit for a while: v^2 / a - (T - tj) v + 1 = 0.
    left = duration - jerk_time
    velocity = acceleration * (left - ca.sqrt(ca.fmax(left**2 - 4 / acceleration, 0))) / 2
    holding = ca.vertcat(jerk_time, velocity / acceleration - jerk_time)
    if jerks:  # or it does not reach it: j tj^2 (T - 2 tj) = 1, of which this is the root between 0 and T / 3
        angle = (2 * ca.asin(ca.fmin(ca.sqrt(27 / (jerks[0] * duration**3)), 1)) - 2 * np.pi) / 3
        rising = duration / 6 * (1 + 2 * ca.cos(angle))
        holding = ca.if_else(rising <= jerk_time, ca.vertcat(rising, 0), holding)
    return ca.vertcat(holding, duration - 4 * holding[0] - 2 * holding[1])


@lru_cache(maxsize=8)
def _law(limits: tuple[tuple[float, ...], ...]) -> ca.Function:
    """Way and duration of a move, shape (n + 1,) -> its three times, see `law_times`."""
    of_move = ca.SX.sym("move", len(limits[0]) + 1)
    times = law_times(of_move[:-1], np.array(limits), of_move[-1])
    return ca.Function("law", [of_move], [ca.densify(times)], {"cse": True})


# Where accelerations do not change one point does, unless all of the move is so.
INFORMATION_POINTS = tuple((k, share) for k in range(7) for share in ((0.5,) if k % 2 else (GAUSS, 1 - GAUSS)))
TRAPEZOID_POINTS = ((1, GAUSS), (1, 1 - GAUSS), (3, 0.5), (5, GAUSS), (5, 1 - GAUSS))
# Where velocities and accelerations have their peaks: both ends of each phase of constant acceleration, mid-cruise.
_HOLDS = ((0, 1.0), (1, 1.0), (5, 0.0), (5, 1.0))
CRITICAL_POINTS = (*_HOLDS[:2], (2, 0.5), (3, 0.5), (4, 0.5), *_HOLDS[2:], (6, 1.0))
_PEAKS = tuple([p in points for p in CRITICAL_POINTS] for points in (((3, 0.5), (6, 1.0)), ((3, 0.5),), _HOLDS))


@dataclass(frozen=True, slots=True)
class PointToPointFamily(Family):
    """Sequences of rest-to-rest moves."""

    moves: int  # 8 to 64
    duration: float  # duration of all moves together [s]
    cycle: float  # cycle of the controller [s]
    middle: Array  # middle of the box of coordinates, shape (n,) [m or rad]
    half: Array  # half of its width, shape (n,) [m or rad]
    # limits of rates, accelerations and jerks, shape (3, n); without those of jerks, for a controller that knows none,
    # shape (2, n)
    limits: Array
    # phases of constant acceleration and of constant velocity that are omitted, shape (moves, 2); others last as long
    # as the shortest phase at least. None while that is open
    absent: Flags | None = None
    # whether a controller times the moves by its own law: motions are its own as soon as a choice below is made
    own_law: bool = False
    # the coordinate that has to reach its limit of acceleration in each move, and of jerk, shape (moves, 2); below 0
    # where none has to. None where moves may be slower than the law
    leading: Indices | None = None

    @classmethod
    def of(cls, case: Case, moves: int, duration: float, own_law: bool = False) -> "PointToPointFamily":
        """The family of a case."""
        middle, half = box_middle(case)
        box = case.need_motion("planning")[1]
        cycle = case.need_controller("point-to-point moves in whole controller cycles").cycle
        limits = [box.rate, box.acceleration, *([box.jerk] if box.limits_jerk else [])]
        return cls(moves, duration, cycle, middle, half, np.array(limits), own_law=own_law)

    name: ClassVar[str] = "ptp"
    iterations: ClassVar[int] = 20  # which show what walks are worth: of those of a robot the walk alone does not
    refining: ClassVar[int] = 60  # a solver that has not converged by then may wander for hundreds
    mending: ClassVar[int] = 50  # with 10, a wider box gave 1.5 % less; with 25 some had not converged

    @property
    def settings(self) -> MoveSettings:
        """Number of moves and duration."""
        return MoveSettings(moves=self.moves, duration_s=self.duration)

    @property
    def steps(self) -> bool:
        """Whether accelerations step: no limit of jerk counts."""
        return len(self.limits) == 2

    @property
    def coordinates(self) -> int:
        """Number of coordinates n."""
        return len(self.middle)

    @property
    def unit(self) -> float:
        """Mean duration of a move, in which times are counted [s]."""
        return self.duration / self.moves

    def split(self, unknowns: Array) -> tuple[Array, Array]:
        """Waypoints in half widths, shape (moves + 1, n), and times in units of a mean move, shape (moves, 3)."""
        places = self.coordinates * (self.moves + 1)
        return unknowns[:places].reshape(-1, self.coordinates), unknowns[places:].reshape(-1, 3)

    def layout(self, case: Case, margin: float) -> Layout:
        """The motion as functions of the unknowns."""
        from scipy.sparse import csr_array

        count, n = self.moves, self.coordinates
        places = n * (count + 1)
        move = np.arange(count)[:, None]
        index = np.hstack([n * move + np.arange(2 * n), places + 3 * move + np.arange(3)])
        own_unknowns = ca.SX.sym("move", 2 * n + 3)
        start, end = (
            ca.DM(self.middle) + ca.DM(self.half) * place for place in (own_unknowns[:n], own_unknowns[n : 2 * n])
        )

        def states(points: tuple[tuple[int, float], ...]) -> KernelStates:
            times = own_unknowns[2 * n :] * self.unit
            columns = []
            for point in points:
                alike = sum(phase == point[0] for phase, _ in points)
                share = _phases(times)[point[0]] / alike / self.duration
                columns += [*state_of_move(start, end, times, point), share]
            return KernelStates(index, Kernel(own_unknowns, ca.vertcat(*columns)), state_size(n))

        tj, th, tc = ca.vertsplit(own_unknowns[2 * n :])
        velocity = (own_unknowns[n : 2 * n] - own_unknowns[:n]) / (2 * tj + th + tc)
        acceleration = velocity / (tj + th)
        maxima = (velocity, acceleration) if self.steps else (velocity, acceleration, acceleration / tj)
        peaks = [
            ca.DM(self.half / limit / self.unit**order) * peak
            for order, (peak, limit) in enumerate(zip(maxima, self.limits, strict=True), start=1)
        ]
        kernel = Kernel(own_unknowns, ca.vertcat(*peaks))  # of the unknowns of each move themselves
        width = 2 * n + 3
        own_states = LinearStates(index, np.zeros((count, 1, width)), np.tile(np.eye(width), (count, 1, 1, 1)))
        led = []
        if (leads := self._leads) is not None:
            reached = Kernel(own_unknowns, ca.fabs(ca.vertcat(*peaks[1:])))
            led.append(StateRows(own_states, reached, leads[:, None], 1.0 - margin, equal=1.0 - margin))
        total = np.r_[np.zeros(places), np.tile([4.0, 2.0, 1.0], count)] / count
        edge = np.full(places, 1.0 - margin)
        lower, upper = self._time_bounds()
        return Layout(
            states=states(TRAPEZOID_POINTS if self.steps else INFORMATION_POINTS),
            critical=states(CRITICAL_POINTS),
            peaks=tuple(np.tile(points, (count, 1)) for points in _PEAKS),
            rows=(
                LinearRows(csr_array(total[None, :]), np.zeros(1, int), np.ones(1, bool), np.ones(1), equal=1.0),
                StateRows(own_states, kernel, np.ones((count, 1, kernel.size), dtype=bool), 1.0 - margin),
                *led,
            ),
            lower=np.r_[-edge, lower.ravel()],
            upper=np.r_[edge, upper.ravel()],
            standing=self._first_waypoint(),
        )

    @property
    def _leads(self) -> Flags | None:
        """Which accelerations, and behind them which jerks, reach their limits, shape (moves, n or 2 n)."""
        if self.leading is None:
            return None
        orders = self.leading[:, : len(self.limits) - 1]
        return np.asarray((orders[:, :, None] == np.arange(self.coordinates)).reshape(self.moves, -1))

    def lawful(self, unknowns: Array) -> Array:
        """Unknowns of the same moves, in the same times, by the controller's law."""
        points, times = self.split(unknowns)
        return np.concatenate([points.ravel(), self._lawful(points, times).ravel()])

    def led_by(self, unknowns: Array) -> "PointToPointFamily":
        """The family whose leading coordinates are those of a motion by the law."""
        points, times = self.split(unknowns)
        return replace(self, leading=self._leading(points, times[:, 1] * self.unit >= shortest_phase(self.cycle) / 2))

    def _leading(self, points: Array, holds: Flags) -> Indices:
        """The coordinate with the largest share of its acceleration, of moves that hold it, and of its jerk."""
        ways = np.abs(np.diff(points, axis=0)) * self.half
        leading = np.argmax(ways[:, None] / self.limits[[1, -1]], axis=2)
        leading[~holds, 0] = -1
        leading[~ways.any(axis=1)] = -1
        return np.asarray(leading)

    def _lawful(self, points: Array, times: Array) -> Array:
        """Times of moves by the controller's law, shape (moves, 3); their own where they are too short for it."""
        durations = times @ [4.0, 2.0, 1.0]
        ways = np.diff(points, axis=0) * self.half
        limits = self.limits * np.r_[1.0, np.full(len(self.limits) - 1, LAW)][:, None]
        law = over_samples(_law(tuple(map(tuple, limits))), np.hstack([ways, durations[:, None] * self.unit]))[0]
        law = np.maximum(law / self.unit, 0.0)
        longer = law @ [4.0, 2.0, 1.0] / durations
        return np.where((np.abs(longer - 1.0) <= ROUNDING)[:, None], law / longer[:, None], times)

    def _first_waypoint(self) -> LinearStates:
        """State at the first waypoint: it ends no move, so that no critical state is there."""
        n = self.coordinates
        offset, slope = np.zeros((1, 1, state_size(n))), np.zeros((1, 1, state_size(n), n))
        offset[0, 0, :n] = self.middle
        slope[0, 0, :n] = np.diag(self.half)
        return LinearStates(np.arange(n)[None], offset, slope)

    def _time_bounds(self) -> tuple[Array, Array]:
        shortest = shortest_phase(self.cycle) / self.unit
        lower, upper = np.zeros((self.moves, 3)), np.full((self.moves, 3), LONGEST_PHASE)
        lower[:, 1 if self.steps else 0] = shortest
        if self.steps:
            upper[:, 0] = 0.0
        if self.absent is not None:
            lower[:, 1:] = np.where(self.absent, 0.0, shortest)
            upper[:, 1:] = np.where(self.absent, 0.0, LONGEST_PHASE)
        return lower, upper

    def longest_steps(self) -> tuple[Array, Array]:
        """Three times [s] of moves of mean duration, and how far each coordinate goes in them, in half widths, (n,).

        Of the times that let one coordinate go as far as it can, those that give the largest product of all steps.
        """
        choices = []
        for limits in self.limits.T:
            times = np.array(fastest_profile(_largest_way(limits, self.unit), *limits)[1:])
            velocity = 1.0 / (times @ [2.0, 1.0, 1.0])
            acceleration = velocity / (times @ [1.0, 1.0, 0.0])
            peaks = np.array([velocity, acceleration, *([] if self.steps else [acceleration / times[0]])])
            steps = np.minimum(np.min(self.limits / peaks[:, None], axis=0) / self.half, 2.0)
            choices.append((float(np.prod(steps)), times, steps))
        _, times, steps = max(choices, key=lambda choice: choice[0])
        return times, steps

    def start(self, draw: np.random.Generator, worst: Callable[[Array], float]) -> Array:
        """A standstill anywhere, from which walks are annealed."""
        place, times = draw.uniform(-0.5, 0.5, self.coordinates), self.longest_steps()[0]
        return np.concatenate([np.tile(place, self.moves + 1), np.tile(times / self.unit, self.moves)])

    def motion(self, unknowns: Array) -> Joined:
        """The motion of unknowns of shape ((n + 3) moves + n,); a move between equal waypoints is a pause."""
        points, times = self.split(unknowns)
        if self.own_law and not (self.absent is None and self.leading is None):
            times = self._lawful(points, times)
        poses = self.middle + points * self.half
        moves: list[StraightMove | Standstill] = []
        for start, end, (tj, th, tc) in zip(poses[:-1], poses[1:], times * self.unit, strict=True):
            law = unit_profile(float(tj), float(th), float(tc))
            moves.append(StraightMove(start, end, law) if (start != end).any() else Standstill(start, law.duration))
        return Joined(tuple(moves))

    def shrunk(self, unknowns: Array, share: float) -> Array:
        """Unknowns with waypoints nearer to the middle, at times that a controller executes and that add up.

        Those of a search that was stopped, or that only explored, need not.
        """
        points, times = self.split(unknowns)
        family = self if self.absent is not None else self.refined(unknowns)
        least, most = family._time_bounds()
        spare = np.clip(times, least, most) - least
        weights = np.array([4.0, 2.0, 1.0])  # how often a move has each of its three times
        longer = (spare @ weights).sum() / (self.moves - (least @ weights).sum())
        return np.concatenate([share * points.ravel(), (least + spare / longer).ravel()])

    def refined(self, unknowns: Array) -> "PointToPointFamily":
        """The family in which phases that are too short for the controller are omitted, or last as long as it needs."""
        points, times = self.split(unknowns)
        absent = times[:, 1:] * self.unit < shortest_phase(self.cycle) / 2
        if self.steps:
            absent[:, 0] = False  # without it nothing accelerates
        leading = None if self.leading is None else self._leading(points, ~absent[:, 0])
        return replace(self, absent=absent, leading=leading)


def _largest_way(limits: Array, duration: float) -> float:
    """The largest distance that a coordinate can go from rest to rest within a duration, by bisection."""
    small, large = 0.0, float(limits[0] * duration)
    for _ in range(50):
        way = (small + large) / 2
        small, large = (way, large) if fastest_profile(way, *limits).duration <= duration else (small, way)
    return small
