"""A planned motion at the pace that a controller or its limits allow, rated before and after.

Point-to-point moves get the jerk-limited law that a controller computes online, in whole cycles (ruckig). Other paths
are slowed as a whole, until they satisfy every limit.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np

from cases.errors import InfeasiblePlan
from cases.schema import Case
from identification.criteria import CRITERIA, Criterion, reference_scaling, singular_values
from identification.limit import LimitReport
from identification.limit_proof import prove
from identification.model import Model, identification_model
from identification.motion import Joined, Standstill, Trajectory
from identification.trajectories.curves import FourierMotion, PolynomialMotion
from identification.trajectories.moves import CircularMove, StraightMove, limits_along, ruckig_profile
from planner.bounds.information_limit import information_limit
from planner.families import Settings
from planner.families.manual import fastest_within_limits
from planner.noise import mean_information
from planner.plans import Plan
from planner.rating import PlannedMotion, rated_plan
from planner.request import LONGEST
from planner.search.feasibility import MARGIN


@dataclass(frozen=True, slots=True)
class PaceRating:
    """Criteria of a motion, and the proof of its limits."""

    duration: float  # [s]
    criteria: dict[str, float]  # A, D, K, N in reference scaling; larger is better
    d_efficiency: float  # against the box bound; may be above 1 for a motion that leaves the box
    limits: LimitReport  # proof at 10 kHz

    @classmethod
    def of(cls, motion: Trajectory, case: Case, model: Model) -> "PaceRating":
        """The rating of a motion; raises IdentificationError where it does not excite all parameters of the model."""
        information = mean_information(model, reference_scaling(case, model), motion)
        mu = singular_values(information, model.names)
        criteria = {letter: criterion(mu) for letter, criterion in CRITERIA.items()}
        efficiency = information_limit(case, model).efficiency(criteria[Criterion.D])
        return cls(motion.duration, criteria, efficiency, prove(motion, case))


@dataclass(frozen=True, slots=True)
class Retimed:
    """A planned motion before and after re-timing."""

    plan: Plan  # the plan that it comes from
    model: Model  # the model by which it is rated
    method: str  # ruckig, or slowed as a whole
    motion: Trajectory
    before: PaceRating
    after: PaceRating
    seconds: float  # computing time [s]

    def as_plan(self) -> Plan:
        """The plan of the motion after re-timing.

        Raises:
            InfeasiblePlan: the motion exceeds a limit, or lasts too long.
        """
        if violations := self.after.limits.violations:
            raise InfeasiblePlan(f"the re-timed motion is not a plan: {violations[0].sentence()}")
        before, after = self.before.duration, self.after.duration
        if not after <= LONGEST:
            raise InfeasiblePlan(f"the motion takes {after:.0f} s, longer than {LONGEST:g} s; shorten it")
        plan = self.plan
        settings: Settings = {
            "retimed_with": self.method,
            "retimed_from": str((plan.folder or Path(plan.name)).resolve()),
            "duration_before_s": before,
            **({"stale": list(plan.stale)} if plan.stale else {}),
        }
        remark = f"re-timed with {self.method}: {after:.2f} s instead of {before:.2f} s"
        planned = PlannedMotion(self.motion, settings, self.after.limits, remark=remark)
        request = replace(plan.of_motion[0], model=self.model.number, targets=())
        return rated_plan(request, plan.case, planned, self.seconds)


def retimed(plan: Plan, model: int | None = None) -> Retimed:
    """A planned motion at another pace, rated beside the planned one; arguments and errors as of `retime`."""
    start, case, number = perf_counter(), plan.case, plan.of_motion[0].model
    own = identification_model(case, number if model is None else model)
    if isinstance(plan.motion, Joined):
        motion, method = by_controller(plan.motion, case, plan.name), "ruckig"
    else:
        motion, method = slowed(plan.motion, case, plan.name), "one slower pace"
    before, after = (PaceRating.of(m, case, own) for m in (plan.motion, motion))
    return Retimed(plan, own, method, motion, before, after, perf_counter() - start)


def retime(plan: Plan, model: int | None = None) -> Plan:
    """A plan of the same path at another pace: moves as a controller times them, other paths inside every limit.

    Args:
        plan: plan of a motion.
        model: number in Table 2, by which it is rated; the plan's own unless given.

    Raises:
        InfeasiblePlan: no pace satisfies every limit; the message names the limit.
        IdentificationError: the motion does not excite all parameters of the model.
        HexciteError: a plan of poses.
    """
    return retimed(plan, model).as_plan()


_REMEDY = "no pace helps; plan again for this case"


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


def slowed(motion: FourierMotion | PolynomialMotion, case: Case, place: str) -> Trajectory:
    """The same path, slower by as much as every limit needs; never faster. Arguments and errors as `by_controller`."""
    return fastest_within_limits(case, motion.slowed, place, _REMEDY)
