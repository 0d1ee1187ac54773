"""Which limits a controller leaves in force for moves whose time law is its own, by what it promises."""

from dataclasses import replace

from cases.controller import ControllerName
from cases.schema import Case
from identification.limits.limit import LimitKind, LimitReport, Status
from identification.limits.proof import PROOF_RATE
from postprocessors.program import dialect
from postprocessors.proof.guarantees import limits_jerk
from postprocessors.reading import Reading


def steps_of(case: Case, controller: str | None) -> float:
    """The time within which accelerations step where a controller executes moves; 0 where it limits the jerk [s].

    Args:
        controller: name of a dialect, or virtual; None for none.
    """
    if controller in (None, ControllerName.VIRTUAL):  # which has the law of the program's own controller
        return 0.0
    guarantees = dialect(controller).guarantees(Reading(controller, (), 0), case)
    return 0.0 if limits_jerk(guarantees.law) else guarantees.jerk_time


def controlled(case: Case, controller: str | None) -> tuple[Case, float]:
    """A case as a controller executes point-to-point moves.

    Args:
        controller: name of a dialect, or virtual; None for none, when all limits of the case count.

    Returns:
        The case with the limits that count: those of jerk do not where the controller knows none; and the time within
        which its accelerations step, 0 where it limits the jerk [s].
    """
    steps = steps_of(case, controller)
    return (case.without_jerk(), steps) if steps else (case, 0.0)


def with_steps(report: LimitReport, step_time: float) -> LimitReport:
    """The proof by all limits of a case, with jerks as the steps that they are where accelerations step [s]."""
    if not step_time:
        return report
    share = 1.0 / (PROOF_RATE * step_time)
    return LimitReport(
        tuple(
            replace(c, worst=c.worst * share, ratio=c.ratio * share, status=Status.LEFT_OUT, binding=False)
            if c.kind.family is LimitKind.JERK
            else c
            for c in report.checks
        )
    )
