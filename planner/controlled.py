"""The controller that a plan is made for: which limits count with its own time law in point-to-point moves."""

from dataclasses import replace
from typing import NamedTuple

from cases.schema import Case
from identification.limits import PROOF_RATE, LimitReport, Status
from planner.request import Request
from postprocessors.dialects import dialect
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
