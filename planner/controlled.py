"""The controller that a plan is made for: which limits count with its own time law in point-to-point moves."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cases.errors import HexciteError
from cases.scaffold import readiness
from cases.schema import Case
from identification.limit import LimitKind, LimitReport, Status
from identification.limit_proof import PROOF_RATE
from identification.limited_quantities import Box
from identification.motion import Trajectory
from identification.trajectories.moves import has_steps
from postprocessors.dialects import DIALECTS, dialect
from postprocessors.proving.guarantees import limits_jerk
from postprocessors.reading import Reading

CONTROLLERS = ("linuxcnc", "virtual", "sinumerik", "twincat", "setpoints", "urscript", "ros2")
USUAL = ("linuxcnc", "sinumerik", "twincat", "urscript", "setpoints", "ros2")  # languages, the first that a case can
USUAL_OF_PATHS = ("setpoints", "ros2")


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
        controller: a name of `CONTROLLERS`; None for none.

    Raises:
        CaseError: the case has no limits, or no settings of this controller.
    """
    if controller is None or controller == "virtual":  # the virtual one has the law of the program's own controller
        return Controlled(case, controller)
    guarantees = dialect(controller).load().guarantees(Reading(controller, (), 0), case)
    if limits_jerk(guarantees.law):
        return Controlled(case, controller)
    return Controlled(case.without_jerk(), controller, guarantees.jerk_time)


MOVES_A_SECOND = 10.0 / 3.0  # at most where jerk is limited


def moves_in(box: Box, duration: float) -> float:
    """How many moves a duration has room for.

    A good move just reaches its limit of velocity, or crosses the box before that: where accelerations step in all
    coordinates; where jerk is limited in the quickest, and in 0.3 s at least.

    Args:
        box: limits that count, see `Controlled`.
    """
    width = box.pose[1] - box.pose[0]
    each = 2 * np.minimum(box.rate / box.acceleration, np.sqrt(width / box.acceleration))
    if box.limits_jerk:
        return duration * min(MOVES_A_SECOND, 1.0 / float(np.min(each)))
    return duration / float(np.max(each))


def usual_dialect(case: Case, settings: Mapping[str, Any] | None = None, path: bool = False) -> str:
    """The language of the controller that a plan was made for, else the first that the case has what it takes for.

    Args:
        path: whether the motion is one path, of which controllers of a chain know tables of points alone.
    """
    made_for = (settings or {}).get("made_for")
    if made_for in DIALECTS:
        return str(made_for)
    ready = {command for command, missing in readiness(case).items() if not missing}
    names = USUAL_OF_PATHS if path and case.chain is not None else USUAL
    return next((name for name in names if f"post --dialect {name}" in ready), "linuxcnc")


def fits_law(plan: str, made_for: str | None, motion: Trajectory, dialect_name: str, case: Case) -> tuple[str, ...]:
    """What to know about moves that the controller of a dialect times by another law than they were planned with.

    Raises:
        HexciteError: the moves have steps of acceleration, and the controller limits jerk: none would last as planned.
        CaseError: the case has no settings of this controller.
    """
    steps = bool(controlled(case, dialect_name).step_time)
    if has_steps(motion) and not steps:
        raise HexciteError(
            f"{plan}: was made for {made_for or 'a controller'}, which does not limit jerk; moves for {dialect_name} "
            f"keep the limits of jerk and last longer: plan with --for {dialect_name}, or re-time the moves with "
            f"hexcite retime {plan} -o NEW"
        )
    if steps and not has_steps(motion):
        return (
            f"planned with limited jerk; {dialect_name} does not limit it and makes trapezoids of the moves: a plan "
            f"made with --for {dialect_name} carries more information there",
        )
    if made_for not in (None, "", "virtual", dialect_name):
        return (f"made for {made_for}; {dialect_name} times moves by the same law",)
    return ()
