"""What controllers guarantee beyond a program's text: limits that they enforce, time law, accuracy."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property, partial

import numpy as np

from cases.chain import Box
from cases.controller import ControllerName
from cases.schema import Case
from identification.limits.limit import TOLERANCE, Limit, LimitCheck, LimitKind, OwnMove, Status
from identification.limits.proof import limited_machine
from identification.limits.sensor_loads import Loads
from identification.motion.motion import Array
from identification.motion.moves import Profile, StraightMove, fastest_profile, limits_along

Law = Callable[[float, float, float], Profile]
"""Time law of a controller in a straight way from rest to rest.

Limits of velocity, acceleration and jerk on the share of the way [1/s, 1/s^2, 1/s^3] -> time law of that share, 0 to 1.
"""
ALONG, ACROSS = math.sqrt(0.75), 0.5  # shares of the acceleration limit that an arc is assumed to use


class WayToFirst(Enum):
    """Polynomials of a way to a first point: peaks of rate and of what follows, over 1 in the time 1.

    What steps has no peak.
    """

    SMOOTH = (15 / 8, 10 / math.sqrt(3.0), 60.0)  # of degree five
    ACCELERATIONS_STEP = (1.5, 6.0)  # of degree three, where accelerations of the joints are not known
    RATES_STEP = (1.0,)  # at one speed, where rates are not known either


NO_SLOWER = 1e-9  # share of a duration
HALVINGS = 80  # halvings of the interval of a speed, down to its last bit


def speed_lasting(law: Callable[[float], Profile], velocity: float, duration: float) -> float:
    """The largest velocity on the way that a move can reach which lasts at least a time, or the whole of `velocity`.

    Args:
        law: velocity on the way [1/s] -> time law of the move.
        velocity: limit of that velocity [1/s].
        duration: time that the move is to last [s].
    """
    low, high = min(velocity, 1.0 / duration), velocity  # below the mean speed it takes longer for certain
    if law(high).duration * (1.0 + NO_SLOWER) >= duration:
        low = high = law(high).peak_velocity  # the fastest move is a flat optimum, which bisection does not find
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if law(middle).duration > duration else (low, middle)
    return high


def limits_jerk(law: Law) -> bool:
    """Whether a controller's law has a limit of jerk; without one its accelerations step."""
    return law(1.0, 1.0, 1.0).jerk_time > 0.0


@dataclass(frozen=True, eq=False)
class Guarantees:
    """A controller as set up for one case and one program: the basis on which its limits are judged."""

    case: Case
    controller: str  # name of the controller, for messages
    shortest_block: float  # a timed block must not be shorter: the controller's cycle [s]
    longest_block: float  # a timed block must not be longer: beyond it the time law is unknown [s]
    law: Law  # its time law in straight moves that it times itself, under the limits of the case
    enforced: frozenset[LimitKind] = frozenset()  # families of limits that it enforces, whatever the program states
    # whether it has been seen to keep this law, within all that it enforces: then what moves as fast as the law says
    # is as sure as that
    known_law: bool = False
    without: frozenset[LimitKind] = frozenset()  # families of limits that the plan of the program leaves out
    jerk_time: float = 0.0  # time within which accelerations step where its law has no jerk limit; 0 where it has [s]
    # whether it passes timed points at their times along the assumed curve between them; then all limits of such paths
    # are proven from the text, else only their geometry and rates are
    follows_paths: bool = False
    # whether it covers each timed block in a straight line at one feed, in whole cycles: then rates are proven also
    # where it does not follow the assumed curve
    even_blocks: bool = False
    # what to do about a timed block of another duration
    timing_remedy: str = "write such blocks (controller.block_ms), or a move at a feed (G94) with an exact stop"
    # to which it rounds the ends of moves, and by which a coordinate moves at least [mm, deg]; LinuxCNC does not round,
    # and where it follows points it moves by as little as they say: 0
    resolution: float = 1e-4
    rounds: bool = True
    headroom: float = 1.0  # multiple of the case's limits of acceleration that its law uses
    # limit of jerk along the way that the feed counts, beside those of the coordinates: where lengths are counted
    # [m/s^3], and where only angles are [rad/s^3]
    path_jerk: tuple[float, float] = (math.inf, math.inf)
    arc_across: float = ACROSS  # share of its acceleration limit that it uses across an arc at most
    # share of it along the arc; None: what is left, root of sum of squares, at the largest speed across
    arc_along: float | None = ALONG
    # name by which moves are planned for it; None where it follows any path
    plan_for: ControllerName | None = None
    # how an operator's feed override is kept at 100 % at most, for people; empty where it goes no further
    override_remedy: str = ""
    # how it goes from where it stands to a first point of a table, from rest to rest
    to_first: WayToFirst = WayToFirst.SMOOTH
    # what it does by settings of its own, one sentence each, for people
    own_rules: tuple[str, ...] = ()
    # allowed deviation of its polynomials from a motion that is none, beside rounding, shape (6,) or (1,) [m, rad]
    tolerance: Array = field(default_factory=lambda: np.zeros(1))

    def arc_law(self, feed: float, velocity: float, acceleration: float, jerk: float, angle: float) -> Profile:
        """Time law in an arc of some angle [rad], else as `law`: turning needs a part of the acceleration."""
        most = self.headroom * acceleration
        share = min(self.arc_across, velocity**2 * angle / most)  # v^2 / r over the length r angle
        turning = math.sqrt(share * most / angle)
        along = math.sqrt(1.0 - share**2) if self.arc_along is None else self.arc_along
        return self.law(min(feed, turning), along * acceleration, along * jerk)

    def lasting(self, move: StraightMove) -> StraightMove:
        """A move as it makes it within the limits of the case and in the same time: as hard as these allow at first."""
        limits = self.limits
        way = np.abs(move.end - move.start)
        velocity, acceleration, jerk = limits_along(way, limits.rate, limits.acceleration, limits.jerk)

        def law(speed: float) -> Profile:
            return self.law(speed, acceleration, jerk)

        return replace(move, profile=law(speed_lasting(law, velocity, move.duration)))

    @property
    def cycle(self) -> float:
        """The time in which its set points change, at least [s]."""
        return self.jerk_time or self.case.need_controller("the check of a program").cycle

    @property
    def crawl(self) -> Array:
        """Speeds of the coordinates that may step within a cycle and reverse in the next, shape (k,) [m/s, rad/s]."""
        limits, cycle = self.limits, self.cycle
        return np.minimum(limits.rate, np.minimum(limits.acceleration * cycle, limits.jerk * cycle**2 / 2))

    @cached_property
    def loads(self) -> Loads | None:
        """What the sensors carry; None where the case has no range or body."""
        return Loads.of(self.case)

    @property
    def limits(self) -> Box:
        """Limits of excitations."""
        return self.case.need_motion("the check of a program")[1]

    def status_of(self, kind: LimitKind) -> Status:
        """Whether the controller enforces a limit in a motion that it times, or the plan leaves it out."""
        if kind.family in self.enforced:
            return Status.ENFORCED
        return Status.LEFT_OUT if kind.family in self.without else Status.NOT_ENFORCED

    def lawful(self, check: LimitCheck) -> Status:
        """How a limit is ensured that a move satisfies, or does not, at the velocities and accelerations of the law."""
        status = self.status_of(check.kind)
        if status is Status.NOT_ENFORCED and self.known_law and check.ratio <= 1.0 + TOLERANCE:
            return Status.FOLLOWS
        return status

    def prediction(
        self, check: LimitCheck, move: OwnMove = OwnMove.UNTIMED, status: Status | None = None
    ) -> LimitCheck:
        """The check of a limit in a move that the controller times: a prediction, not a property of the text."""
        verdict = self.status_of(check.kind) if status is None else status
        return replace(check, of=check.of._replace(move=move), status=verdict, binding=False)

    def force_bounds(self, stated: tuple[Array, Array] | None = None) -> tuple[LimitCheck, ...]:
        """Largest sensor force and moment in any pose within the limits of motion; none for sensors in struts.

        Forces are f = b (p'' - g) + d alpha + omega Q omega, with b, d and Q constant in the axes of the platform. No
        controller limits them: they are proven where rates and accelerations are enforced, or the text states them.

        Args:
            stated: rates and accelerations of the coordinates that the text states, shapes (k,) [SI]; None: those of
                the limits.
        """
        loads = self.loads
        if loads is None or self.case.sensor_frame.struts is not None:
            return ()
        linear, angular, spin = np.split(loads.coefficients, (3, 6), axis=1)
        rates, accelerations = stated or (self.limits.rate, self.limits.acceleration)
        omega, alpha, pull = limited_machine(self.case).fastest(rates, accelerations)
        pull += float(np.linalg.norm(self.case.gravity))
        most = np.linalg.norm(linear, axis=1) * pull + np.linalg.norm(angular, axis=1) * alpha
        products = spin.reshape(-1, 3, 3)
        most += np.abs(np.linalg.eigvalsh(products + products.transpose(0, 2, 1))).max(axis=1) / 2 * omega**2
        bounded, checks = stated is not None or {LimitKind.VELOCITY, LimitKind.ACCELERATION} <= self.enforced, []
        for channels, kind in ((~loads.moments, LimitKind.SENSOR_FORCE), (loads.moments, LimitKind.SENSOR_MOMENT)):
            if channels.any():
                shares = np.where(channels, most / loads.limit, 0.0)
                k = int(np.argmax(shares))
                worst, limit, ratio = float(most[k]), float(loads.limit[k]), float(shares[k])
                proven = bounded and ratio <= 1.0
                place = f"{loads.labels[k]}, at {'most' if proven or stated else 'the limits'}"
                status = Status.PROVEN if proven else Status.NOT_ENFORCED
                checks.append(LimitCheck(Limit(kind), place, worst, limit, kind.unit, ratio, 0.0, status))
        return tuple(checks)

    def sensed(
        self, check: LimitCheck, move: OwnMove | None = None, status: Status = Status.NOT_ENFORCED
    ) -> LimitCheck:
        """The bound of a sensor force or moment where it is proven, else its prediction, which nobody enforces."""
        judged = replace(check, status=status, binding=move is None)
        bounds = (b for b in self.force_bounds() if b.kind is check.kind and b.status is Status.PROVEN)
        answer = next(bounds, judged)
        return replace(answer, of=answer.of._replace(move=move))


LONGEST_POINTS = 0.25  # largest distance of points of a path [s]: the curve between them may leave the assumed one
SEVEN_SEGMENTS: Law = partial(fastest_profile, 1.0)
"""The law of a controller that limits the jerk."""


def trapezoid(velocity: float, acceleration: float, jerk: float, headroom: float = 1.0) -> Profile:
    """The law of a controller that has no limit of jerk."""
    return fastest_profile(1.0, velocity, headroom * acceleration)
