"""Whether a request can be met at all, as far as that is known before any search: refused at once, not in minutes."""

import numpy as np

from cases.errors import HexciteError
from cases.manual import load_poses, load_sequence
from cases.schema import Case
from identification.model import identification_model
from planner.controlled import move_count, planned_for
from planner.families.manual import sequence_file
from planner.families.ptp import FEWEST, SHORTEST_PHASE
from planner.infeasible import require_rest
from planner.request import Request
from planner.search.choices import choices
from planner.target import parse_targets

HALF = 0.5  # of the limit of acceleration
ROUNDING = 1e-9  # of a duration


def require_plannable(request: Request, case: Case) -> None:
    """Refuses what no search can mend.

    Raises:
        CaseError: the case has no machine, limits, controller or payload of this number.
        HexciteError: an unknown model, targets that cannot be read, a duration too short for the machine.
        InfeasiblePlan: standing still in the middle of the motion box passes a limit.
        FileProblem: the sequence cannot be used.
    """
    case.need_machine("planning")
    identification_model(case, request.model)
    case.body(request.payload)
    parse_targets(request.targets, case, request.model)
    if request.family == "manual":
        file = request.sequence if request.sequence is not None else sequence_file(request.case_file)
        if file.suffix.lower() == ".csv":
            load_poses(file)
        else:
            load_sequence(file)
    elif request.family == "fourier":
        for choice in choices(request, case):
            _require_heard(choice, case)
    else:
        _require_long_moves(request, case)
    require_rest(case)


def _require_heard(request: Request, case: Case) -> None:
    """The highest harmonic must pass the filter of the evaluation, or the run would teach nothing."""
    cutoff = case.recording.filter_cutoff_Hz
    period = request.base_period
    highest = request.order / period
    if cutoff is not None and highest > cutoff / 2:
        shortest = request.order / (cutoff / 2)
        most = int(request.duration / shortest * (1.0 + ROUNDING))  # periods
        remedy = f"--period {request.duration / most if most else shortest:g}"
        if request.period is None and not most:
            remedy = f"--duration {shortest:g}"
        raise HexciteError(
            f"period {period:g} s is too short: order {request.order} reaches {highest:g} Hz, the evaluation hears up "
            f"to {cutoff / 2:g} Hz (half of recording.filter_cutoff_Hz); choose {remedy} or more"
        )


def _require_long_moves(request: Request, case: Case) -> None:
    """Every move has four phases of jerk, or two of acceleration where it steps, each three controller cycles at least.

    A move whose coordinates cannot reach half of their limits of acceleration hardly leaves its place: the search would
    take minutes to make few moves of many, and find less than with few.
    """
    cycle = case.need_controller("point-to-point moves in whole controller cycles").cycle
    if request.family != "ptp":
        return
    own = planned_for(request, case).case
    box, moves = own.need_machine("planning")[2].motion, move_count(request, own)
    count = 4 if box.limits_jerk else 2
    phases = count * SHORTEST_PHASE * cycle
    rise = 4 * HALF * float(np.min(box.acceleration / box.jerk))
    least = max(phases, rise)
    if not request.duration >= moves * least * (1.0 - ROUNDING):
        why = f"{count} phases of {SHORTEST_PHASE} controller cycles of {cycle * 1e3:g} ms take {least:g} s"
        if rise > phases:
            why = (
                f"at the limits of jerk it takes {least:g} s to reach half of a limit of acceleration and come to rest"
            )
        fewer = int(request.duration / least * (1.0 + ROUNDING))
        remedy = f", or --moves {fewer} or fewer" if fewer >= FEWEST else ""
        raise HexciteError(
            f"duration {request.duration:g} s is too short for {moves} moves: {why}; choose at least "
            f"{moves * least:g} s{remedy}"
        )
