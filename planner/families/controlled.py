"""The limits that count for a plan: the box of the case, and what a controller makes of point-to-point moves."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cases.schema import Case
from cases.units import Array
from identification.limit import LimitKind, LimitReport, Status
from identification.limit_proof import PROOF_RATE
from postprocessors.dialects import dialect
from postprocessors.proving.guarantees import limits_jerk
from postprocessors.reading import Reading


class Controlled(NamedTuple):
    """A case as a controller executes point-to-point moves."""

    case: Case  # case with the limits that count: those of jerk do not where the controller knows none
    controller: str | None = None  # its name; None where the plan is made for none, and all limits of the case count
    step_time: float = 0.0  # within which its accelerations step; 0 where it limits the jerk [s]

    def reported(self, report: LimitReport) -> LimitReport:
        """The proof by all limits of a case, with jerks that the controller does not limit as the steps they are."""
        if not self.step_time:
            return report
        share = 1.0 / (PROOF_RATE * self.step_time)
        return LimitReport(
            tuple(
                replace(c, worst=c.worst * share, ratio=c.ratio * share, status=Status.STEPS, binding=False)
                if c.kind.family is LimitKind.JERK
                else c
                for c in report.checks
            )
        )


def controlled(case: Case, controller: str | None) -> Controlled:
    """The case as a controller executes point-to-point moves.

    Args:
        controller: name of a dialect, or virtual; None for none.

    Raises:
        CaseError: the case has no limits, or no settings of this controller.
    """
    if controller is None or controller == "virtual":  # the virtual one has the law of the program's own controller
        return Controlled(case, controller)
    guarantees = dialect(controller).load().guarantees(Reading(controller, (), 0), case)
    if limits_jerk(guarantees.law):
        return Controlled(case, controller)
    return Controlled(case.without_jerk(), controller, guarantees.jerk_time)


def box_middle(case: Case) -> tuple[Array, Array]:
    """Middle of the box of coordinates and half of its width, shapes (n,) [m or rad]."""
    home, limits = case.need_motion("planning")
    low, high = limits.pose
    return home + (low + high) / 2, np.asarray((high - low) / 2)
