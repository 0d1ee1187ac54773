"""Whether a request can be met at all, as far as that is known before any search: refused at once, not in minutes."""

from cases.schema import Case
from identification.model import identification_model
from planner.infeasible import require_rest
from planner.request import Request
from planner.target import parse_targets


def require_plannable(request: Request, case: Case) -> None:
    """Refuses what no search can mend.

    Raises:
        CaseError: the case has no machine, limits, controller or payload of this number.
        HexciteError: an unknown model, targets that cannot be read, a duration too short for the machine.
        InfeasiblePlan: standing still in the middle of the motion box passes a limit.
        FileProblem: the sequence cannot be used.
    """
    case.need_motion("planning")
    identification_model(case, request.model)
    case.body(request.payload)
    parse_targets(request.targets, case, request.model)
    request.family.require_plannable(case, request.duration)
    require_rest(case)
