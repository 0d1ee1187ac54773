"""Which limits a controller leaves in force for moves whose time law is its own, by what it promises."""

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np

from cases.base.errors import CaseError
from cases.controller import ControllerName
from cases.readiness import languages_of
from cases.schema import Case
from identification.limits.limit import LimitKind, LimitReport, Status
from identification.limits.proof import PROOF_RATE
from postprocessors.program import dialect
from postprocessors.proof.guarantees import Guarantees, limits_jerk
from postprocessors.reading import Reading


def _guarantees(case: Case, controller: str | None) -> Guarantees | None:
    """What a controller guarantees of moves; None of none and of the virtual one, which has the program's own law."""
    if controller in (None, ControllerName.VIRTUAL):
        return None
    return dialect(controller).guarantees(Reading(controller, (), 0), case)


def steps_of(case: Case, controller: str | None) -> float:
    """The time within which accelerations step where a controller executes moves; 0 where it limits the jerk [s].

    Args:
        controller: name of a dialect, or virtual; None for none.
    """
    guarantees = _guarantees(case, controller)
    return 0.0 if guarantees is None or limits_jerk(guarantees.law) else guarantees.jerk_time


def times_itself(case: Case, controller: str | None) -> bool:
    """Whether moves are timed by the law of a controller, which accelerates as hard as its set-up allows.

    Not that of a robot whose program states speeds and accelerations.

    Args:
        controller: name of a dialect, or virtual; None where any that the case is set up for may execute them, if it
            limits the jerk.
    """
    if controller is not None:
        guarantees = _guarantees(case, controller)
        return guarantees is not None and LimitKind.ACCELERATION in guarantees.enforced
    for name in languages_of(case):
        with suppress(CaseError):
            guarantees = _guarantees(case, name)
            if guarantees is not None and LimitKind.JERK in guarantees.enforced:
                return True
    return False


def controlled(case: Case, controller: str | None) -> tuple[Case, float]:
    """A case as a controller executes point-to-point moves.

    Args:
        controller: name of a dialect, or virtual; None for none, when all limits of the case count.

    Returns:
        The case with the limits that count: those of jerk do not where the controller knows none, and are smaller where
        it limits the jerk along the path, so that this never binds before one of them; and the time within which its
        accelerations step, 0 where it limits the jerk [s].
    """
    if steps := steps_of(case, controller):
        return case.without_jerk(), steps
    guarantees = _guarantees(case, controller)
    if guarantees is None or not math.isfinite(max(guarantees.path_jerk)):
        return case, 0.0
    box = case.need_motion("planning")[1]
    linear, angular = guarantees.path_jerk
    slides = ~box.turns
    most = linear / math.sqrt(slides.sum()) if slides.any() else angular / math.sqrt(box.turns.sum())
    jerk = np.where(slides if slides.any() else box.turns, np.minimum(box.jerk, most), box.jerk)
    return (case.with_jerk(jerk) if np.any(jerk < box.jerk) else case), 0.0


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
