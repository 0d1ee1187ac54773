"""The controller that a plan is made for: which limits count with its own time law in point-to-point moves."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cases.errors import HexciteError
from cases.schema import Case
from identification.limits import PROOF_RATE, LimitReport, Status
from identification.motion import Trajectory
from identification.trajectories.profile import has_steps
from planner.families.ptp import FEWEST, MOST
from planner.request import Request
from postprocessors.dialects import DIALECTS, dialect
from postprocessors.proving.guarantees import family, limits_jerk
from postprocessors.reading.words import Reading


class Controlled(NamedTuple):
    """A case as a controller executes point-to-point moves.

    Args:
        case: with the limits that count: those of jerk do not where the controller knows none.
        controller: its name; None where the plan is made for none, and all limits of the case count.
        step_time: within which its accelerations step; 0 where it limits the jerk [s].
    """

    case: Case
    controller: str | None = None
    step_time: float = 0.0

    def reported(self, report: LimitReport) -> LimitReport:
        """The proof by all limits of a case, with jerks that the controller does not limit as the steps they are."""
        if not self.step_time:
            return report
        share = 1.0 / (PROOF_RATE * self.step_time)
        return LimitReport(
            tuple(
                replace(c, worst=c.worst * share, ratio=c.ratio * share, status=Status.STEPS, binding=False)
                if family(c.name) == "jerk"
                else c
                for c in report.checks
            )
        )


def planned_for(request: Request, case: Case) -> Controlled:
    """The case as the controller executes it that a request names, else the case; errors as `controlled`."""
    controller = request.controller
    if controller is None and case.controller is not None:
        controller = case.controller.plan_for
    return controlled(case, controller) if request.family == "ptp" else Controlled(case)


def controlled(case: Case, controller: str | None) -> Controlled:
    """The case as a controller executes point-to-point moves.

    Args:
        case: whose limits of jerk count unless the controller's time law knows none.
        controller: a name of `planner.request.CONTROLLERS`; None for none.

    Raises:
        CaseError: the case has no limits, or no settings of this controller.
    """
    if controller is None or controller == "virtual":  # the virtual one has the law of the program's own controller
        return Controlled(case, controller)
    guarantees = dialect(controller).load().guarantees(Reading(controller, (), 0), case)
    if limits_jerk(guarantees.law):
        return Controlled(case, controller)
    limits = case.need_machine("planning")[2]
    freed = limits.model_copy(update={"motion": limits.motion.without_jerk()})
    return Controlled(case.model_copy(update={"limits": freed}), controller, guarantees.jerk_time)


def usual_dialect(plan: Mapping[str, Any]) -> str:
    """The language of the controller that a saved plan was made for, else LinuxCNC's."""
    made_for = _made_for(plan)
    return made_for if made_for in DIALECTS else "linuxcnc"


def _made_for(plan: Mapping[str, Any]) -> str:
    """The controller that a saved plan was made for; nothing where it says none."""
    settings = plan.get("settings")
    return str(settings.get("made_for", "")) if isinstance(settings, Mapping) else ""


def move_count(request: Request, case: Case) -> int:
    """Number of point-to-point moves of a request; where it is not stated, what its limits suggest.

    Without a limit of jerk a good move is one that just reaches its limit of velocity, or crosses the box before that.

    Args:
        request: family ptp.
        case: with the limits that count, see `Controlled`.
    """
    box = case.need_machine("planning")[2].motion
    if request.moves is not None or box.limits_jerk:
        return request.move_count
    width = box.pose[1] - box.pose[0]
    duration = float(np.max(2 * np.minimum(box.rate / box.acceleration, np.sqrt(width / box.acceleration))))
    return int(np.clip(round(request.duration / duration), FEWEST, MOST))


def fits_law(
    folder: Path, plan: Mapping[str, Any], motion: Trajectory, dialect_name: str, case: Case
) -> tuple[str, ...]:
    """What to know about moves that the controller of a dialect times by another law than they were planned with.

    Args:
        folder: of the plan.
        plan: all of plan.json.
        motion: its motion.
        dialect_name: of the program.
        case: settings of its controller.

    Raises:
        HexciteError: the moves have steps of acceleration, and the controller limits jerk: none would last as planned.
        CaseError: the case has no settings of this controller.
    """
    if plan["family"] != "ptp":
        return ()
    made_for, steps = _made_for(plan), bool(controlled(case, dialect_name).step_time)
    if has_steps(motion) and not steps:
        raise HexciteError(
            f"{folder}: was made for {made_for or 'a controller'}, which does not limit jerk; moves for {dialect_name} "
            f"keep the limits of jerk and last longer: plan with --for {dialect_name}, or re-time the moves with "
            f"hexcite retime {folder} -o NEW"
        )
    if steps and not has_steps(motion):
        return (
            f"planned with limited jerk; {dialect_name} does not limit it and makes trapezoids of the moves: a plan "
            f"made with --for {dialect_name} carries more information there",
        )
    if made_for not in ("", "virtual", dialect_name):
        return (f"made for {made_for}; {dialect_name} times moves by the same law",)
    return ()
