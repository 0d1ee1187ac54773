"""A planned motion at the pace that a controller or its limits allow.

By ruckig, point-to-point moves get the jerk-limited law that a controller computes online, in whole cycles; other paths
are slowed as a whole, until they satisfy every limit. By toppra, any path is run as fast as rates, accelerations,
struts, torques and sensor forces allow everywhere along it, for controllers that do not limit jerk.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike

from cases.base.errors import Code, HexciteError, InfeasiblePlan, choice, option
from cases.base.options import default_of, documented
from cases.base.phrases import Phrase, phrase
from cases.schema import Case
from identification.limits.limit import UNUSED_SHARE, LimitKind
from identification.limits.proof import PROOF_RATE, prove
from identification.machines.path_timing import Shares, rounded
from identification.machines.path_timing import retime as timed_path
from identification.motion.curves import FourierMotion, PolynomialMotion
from identification.motion.motion import Array, Joined, Motion, Standstill, Trajectory
from identification.motion.moves import CircularMove, StraightMove, UntimedMotion, limits_along, ruckig_profile
from planner.controller_limits import with_steps
from planner.families.manual import fastest_within_limits
from planner.families.plan_settings import RetimedSettings
from planner.families.settings import require_plannable_without
from planner.options import Pace, PaceWithout
from planner.plans.plan import Plan
from planner.plans.prediction import Gain
from planner.plans.rating import PlannedMotion, rated_plan
from planner.request import LONGEST
from planner.search.problem import near_limits

_REMEDY = "no pace helps; plan again for this case"


class Method(StrEnum):
    """What times a path."""

    RUCKIG = "ruckig"
    TOPPRA = "toppra"

    @classmethod
    def _missing_(cls, value: object) -> NoReturn:
        """Refuses what is not one of them."""
        raise HexciteError(
            problem=f"{option('method', 'with')} {value!r} is unknown",
            remedy=choice(str(value), cls),
            code=Code.UNKNOWN,
        )


@documented()
def retime(plan: Plan, method: Pace = default_of(Pace), without: PaceWithout = default_of(PaceWithout)) -> Plan:
    """A plan of the same path at another pace.

    >>> plan = hx.Plan.load("plan")
    >>> faster = hx.retime(plan, "toppra", without="jerk")
    >>> f"{faster.duration:.1f} s in place of {plan.duration:.1f} s"
    '4.0 s in place of 4.4 s'

    Args:
        plan: plan of a motion.
        OPTIONS

    Raises:
        InfeasiblePlan: no pace satisfies every limit, or the motion lasts too long; the message says which.
        HexciteError: a plan of poses; limits of jerk that toppra cannot keep.
    """
    start, case, request = perf_counter(), plan.case, plan.of_motion[0]
    require_plannable_without(without)
    by, step_time, made_with = Method(method), 0.0, str(method)
    motion = plan.motion
    if by is Method.TOPPRA:
        motion, step_time = as_fast_as_possible(motion, case, plan.name, without)
    elif without is not None:
        raise HexciteError(
            problem=f"{option('without')} {without} goes with {option('method', 'with')} toppra",
            remedy="ruckig keeps jerk: leave it out",
            code=Code.CONTRADICTION,
        )
    elif isinstance(motion, Joined):
        motion = by_controller(motion, case, plan.name)
    elif isinstance(motion, FourierMotion | PolynomialMotion):
        motion, made_with = fastest_within_limits(case, motion.slowed, plan.name, _REMEDY), "one slower pace"
    if not motion.duration <= LONGEST:
        raise InfeasiblePlan(
            place=plan.name,
            problem=f"the motion takes {motion.duration:.0f} s, longer than {LONGEST:g} s",
            remedy="shorten it",
            code=Code.INFEASIBLE,
        )
    limits = with_steps(prove(motion, case), step_time)
    if violations := limits.violations:
        raise InfeasiblePlan(
            place=plan.name,
            problem=f"the re-timed motion is not a plan: {violations[0].sentence()}",
            remedy=_REMEDY,
            code=Code.NOT_PROVEN,
        )
    settings = RetimedSettings(
        retimed_with=made_with,
        retimed_from=str((plan.folder or Path(plan.name)).resolve()),
        duration_before_s=plan.duration,
        without=LimitKind.JERK if step_time else None,
    )
    rated = rated_plan(request, case, PlannedMotion(motion, settings, limits), perf_counter() - start)
    if plan.gain is not None and request.known is None:  # which a plan that was read from its folder has not
        worth = rated.of_motion[1]
        rated = replace(rated, worth=replace(worth, notes=(_not_known(plan.gain), *worth.notes)))
    return replace(rated, stale=plan.stale)


def _not_known(gain: Gain) -> Phrase:
    """What a plan does not count that was planned with earlier results."""
    words = "what was known by {named} is not counted: the plan was read from its folder, which does not hold it"
    return phrase("known_not_counted", words, named=", ".join(gain.results))


HURRY = 10.0  # times its own pace, at most: near its rests a path that rests by itself may be passed at any
WINDOW = 0.02  # [s] within which accelerations change from one extreme to the other, that is as good as step
PIECE = 0.01  # [s] of a polynomial through the motion
STEP = 1.0 / PROOF_RATE  # [s] between samples of the proof, by which jerks are what they are


def as_fast_as_possible(
    motion: Trajectory, case: Case, place: str, without: str | None = None
) -> tuple[PolynomialMotion, float]:
    """The path of a motion, timed by toppra; moves and arcs one by one, pauses as they are.

    Args:
        place: name of the motion, for messages.
        without: jerk where it may be left out.

    Returns:
        Polynomials along it, inside every limit but jerk, rounded by some hundredths of a millimetre; and the time
        behind the jerks of its proof, 0 where the case limits none [s].

    Raises:
        HexciteError: the case limits jerk, which is not left out.
        InfeasiblePlan: no pace satisfies the limits.
    """
    limited = case.need_motion("re-timing")[1].limits_jerk
    if limited and without is None:
        raise HexciteError(
            place=f"case {case.name}, limits.motion",
            problem="states jerk, which toppra cannot limit",
            remedy=f"re-time with {option('without')} jerk if the machine bears steps of acceleration, or with "
            f"{option('method', 'with')} ruckig",
            code=Code.NOT_SUPPORTED,
        )
    without_jerk = case.without_jerk()
    forces = force_shares(without_jerk)
    timed: list[Trajectory] = []
    for number, part in enumerate(motion.parts if isinstance(motion, Joined) else (motion,), start=1):
        if isinstance(part, Standstill):
            timed.append(part)
            continue
        path = Way(part) if isinstance(part, StraightMove | CircularMove) else part
        try:
            timed.append(timed_path(path, without_jerk, HURRY, forces))
        except UntimedMotion as error:
            where = f"{place}, move {number}" if isinstance(motion, Joined) else place
            raise InfeasiblePlan(place=where, problem=error, remedy=_REMEDY, code=Code.INFEASIBLE) from error
    whole = PolynomialMotion.of_pieces(rounded(Joined(tuple(timed)), WINDOW, PIECE))
    slowed = fastest_within_limits(
        without_jerk, whole.slowed, place, _REMEDY
    )  # what is between gridpoints, and sensors at rest
    assert isinstance(slowed, PolynomialMotion)
    return slowed, STEP if limited else 0.0


@dataclass(frozen=True, slots=True)
class Way:
    """The way of a move at an even pace, whatever its own time law: the pace alone brings it from rest to rest."""

    move: StraightMove | CircularMove

    @property
    def duration(self) -> float:
        """Duration of the move [s]."""
        return self.move.duration

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        none = np.zeros(len(time))
        share = np.clip(time / self.duration, 0.0, 1.0)
        return self.move.along(time, (share, np.full(len(time), 1.0 / self.duration), none, none))


def force_shares(case: Case) -> Shares | None:
    """Shares of the limits of torques and sensor forces that come close in the motion box; None without any."""
    kinds = LimitKind.JOINT_TORQUE, LimitKind.JOINT_FORCE, LimitKind.SENSOR_FORCE, LimitKind.SENSOR_MOMENT
    kernels = [kernel for kind, _, kernel in near_limits(case) if kind in kinds]
    if not kernels:
        return None

    def shares(pose: Array, rates: Array, accelerations: Array) -> Array:
        states = np.hstack([pose, rates, accelerations, np.zeros((len(pose), 1))])
        return np.hstack([kernel.values(states) for kernel in kernels])

    return shares


def by_controller(motion: Joined, case: Case, place: str) -> Joined:
    """Every move under the law of a jerk-limited controller with the motion limits of the case, in whole cycles.

    Straight moves become as fast as the limits of their coordinates allow, less the margin of every plan; arcs as fast
    as the peaks of their planned law; either slower where struts, torques or sensors need it. Pauses are rounded up.

    Args:
        place: name of the motion, for messages.

    Raises:
        InfeasiblePlan: a move exceeds a limit at any pace.
    """
    cycle = case.need_controller("re-timing in whole controller cycles").cycle

    def parts() -> Iterator[Trajectory]:
        for number, part in enumerate(motion.parts, start=1):
            if isinstance(part, StraightMove | CircularMove):
                timed = partial(_timed, part, case, cycle)
                yield fastest_within_limits(case, timed, f"{place}, move {number}", _REMEDY)
            else:
                yield Standstill(part.at([0.0]).coordinates[0], float(np.ceil(part.duration / cycle - 1e-9)) * cycle)

    return Joined(tuple(parts()))


def _timed(part: StraightMove | CircularMove, case: Case, cycle: float, pace: float) -> StraightMove | CircularMove:
    """A move under a controller's own law, with its limits at a share of their pace."""
    v, a, j = pace, pace**2, pace**3
    if isinstance(part, StraightMove):
        box, share = case.need_motion("re-timing")[1], 1.0 - UNUSED_SHARE
        limits = box.rate * share * v, box.acceleration * share * a, box.jerk * share * j
        velocity, peak, change = limits_along(np.abs(part.end - part.start), *limits)
        return replace(part, profile=ruckig_profile(velocity, peak, change, cycle))
    planned = part.profile
    law = ruckig_profile(planned.peak_velocity * v, planned.acceleration * a, planned.jerk * j, cycle)
    return replace(part, profile=law)
