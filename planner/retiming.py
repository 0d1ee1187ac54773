"""A planned motion at the pace that a controller or its limits allow.

Point-to-point moves get the jerk-limited law that a controller computes online, in whole cycles (ruckig). Other paths
are slowed as a whole, until they satisfy every limit.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

from cases.errors import InfeasiblePlan
from cases.schema import Case
from identification.limit_proof import prove
from identification.motion import Joined, Standstill, Trajectory
from identification.trajectories.curves import FourierMotion, PolynomialMotion
from identification.trajectories.moves import CircularMove, StraightMove, limits_along, ruckig_profile
from planner.families import Settings
from planner.families.manual import fastest_within_limits
from planner.plans import Plan
from planner.rating import PlannedMotion, rated_plan
from planner.request import LONGEST
from planner.search.feasibility import MARGIN

_REMEDY = "no pace helps; plan again for this case"


def retime(plan: Plan) -> Plan:
    """A plan of the same path at another pace: moves as a controller times them, other paths inside every limit.

    Raises:
        InfeasiblePlan: no pace satisfies every limit, or the motion lasts too long; the message says which.
        HexciteError: a plan of poses.
    """
    start, case, request = perf_counter(), plan.case, plan.of_motion[0]
    motion, method = plan.motion, "ruckig"
    if isinstance(motion, Joined):
        motion = by_controller(motion, case, plan.name)
    elif isinstance(motion, FourierMotion | PolynomialMotion):
        motion, method = fastest_within_limits(case, motion.slowed, plan.name, _REMEDY), "one slower pace"
    if not motion.duration <= LONGEST:
        raise InfeasiblePlan(f"the motion takes {motion.duration:.0f} s, longer than {LONGEST:g} s; shorten it")
    limits = prove(motion, case)
    if violations := limits.violations:
        raise InfeasiblePlan(f"the re-timed motion is not a plan: {violations[0].sentence()}")
    settings: Settings = {
        "retimed_with": method,
        "retimed_from": str((plan.folder or Path(plan.name)).resolve()),
        "duration_before_s": plan.duration,
    }
    rated = rated_plan(request, case, PlannedMotion(motion, settings, limits), perf_counter() - start)
    return replace(rated, stale=plan.stale)


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
                yield Standstill(part.at([0.0]).pose[0], float(np.ceil(part.duration / cycle - 1e-9)) * cycle)

    return Joined(tuple(parts()))


def _timed(part: StraightMove | CircularMove, case: Case, cycle: float, pace: float) -> StraightMove | CircularMove:
    """A move under a controller's own law, with its limits at a share of their pace."""
    v, a, j = pace, pace**2, pace**3
    if isinstance(part, StraightMove):
        box, share = case.need_motion("re-timing")[1], 1.0 - MARGIN
        limits = box.rate * share * v, box.acceleration * share * a, box.jerk * share * j
        velocity, peak, change = limits_along(np.abs(part.end - part.start), *limits)
        return replace(part, profile=ruckig_profile(velocity, peak, change, cycle))
    planned = part.profile
    law = ruckig_profile(planned.peak_velocity * v, planned.acceleration * a, planned.jerk * j, cycle)
    return replace(part, profile=law)
