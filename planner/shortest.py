"""The shortest motion whose predicted standard deviations meet given targets."""

from collections.abc import Callable

import numpy as np

from cases.errors import InfeasiblePlan
from cases.schema import Case
from planner.interruption import Interrupted
from planner.plan import Plan
from planner.request import LONGEST, Request
from planner.target import UNITS, Target, parse_targets

ROUNDS = 4  # of shortening: each lands within a few percent of what the information rate promises
RESERVE = 1.03  # shorter motions carry a little less information a second: turning round at the ends takes its time
WORTHWHILE = 0.97  # share of the duration below which another plan is worth its time
SHORTEST = 2.0  # [s]


def shortest_plan(request: Request, case: Case, make: Callable[[Request], Plan]) -> Plan:
    """Plans at the request's duration, the longest allowed, then shorter ones as long as the targets are met.

    Every plan is optimal by the request's criterion for its duration; the shortest of these that meets the targets need
    not be the shortest of all motions. Ctrl-C keeps the shortest found until then.

    Raises:
        HexciteError: a target that cannot be read.
        InfeasiblePlan: a target is not met; the message says what is reached, and about how long would do.
        Interrupted: Ctrl-C before a plan met the targets.
    """
    targets = parse_targets(request.targets, case, request.model)

    def hardest(plan: Plan) -> Target:
        """The target of which a plan needs the largest share."""
        return max(targets, key=lambda target: target.share(plan.predicted_std))

    def use(plan: Plan) -> float:
        return hardest(plan).share(plan.predicted_std)

    best = make(request)
    if use(best) > 1.0:
        raise _missed(request, best, hardest(best))
    too_short = SHORTEST / 2
    for _ in range(ROUNDS):
        duration = max(best.motion.duration * use(best) ** 2 * RESERVE, SHORTEST)
        if duration <= too_short:
            duration = (too_short + best.motion.duration) / 2
        duration = request.family.allowed_duration(duration)
        if duration > WORTHWHILE * best.motion.duration or best.interrupted:
            break
        try:
            trial = make(request.lasting(duration))
        except InfeasiblePlan:  # so short that no start led anywhere
            too_short = duration
            continue
        except Interrupted:
            return best.ended_early()
        if use(trial) <= 1.0:
            best = trial
        elif trial.interrupted:
            return best.ended_early()
        else:
            too_short = duration
    return best


def _missed(request: Request, best: Plan, target: Target) -> BaseException:
    """What to say of the longest motion that is allowed where it does not meet a target."""
    reached = f"{best.predicted_std[target.name] / UNITS[target.unit][1]:.3g} {target.unit}"
    if best.interrupted:
        return Interrupted(f"the best found until then has {reached}, not {target.text}: nothing was written")
    needed = request.duration * target.share(best.predicted_std) ** 2 * RESERVE
    longer = request.family.allowed_duration(float(np.ceil(needed)))
    remedy = f"allow --duration {longer:g}{request.family.options_for(longer)} or a wider target"
    if longer > LONGEST:
        remedy = f"even the longest motion, {LONGEST:g} s, would not do: set a wider target"
    return InfeasiblePlan(
        f"target {target.text} is out of reach in {request.duration:g} s: the best found has {reached}; {remedy}"
    )
