"""A re-timed motion as a plan of its own: a folder for `hexcite post`, `run`, `identify` and `compare`."""

from pathlib import Path

from cases.errors import InfeasiblePlan
from cases.schema import Case
from cases.units import DEG, MM
from planner.plan import Plan
from planner.planning import Found, rated
from planner.request import LONGEST, Request
from planner.retiming.retimed import Method, Retimed


def retimed_plan(
    found: Retimed,
    request: Request,
    case: Case,
    case_file: str,
    source: Path,
    seconds: float,
    stale: tuple[str, ...] = (),
) -> Plan:
    """The plan of a motion after re-timing.

    Args:
        found: the motion before and after.
        request: family, criterion, model and payload of the plan that it comes from.
        case: machine and limits.
        case_file: name or file that finds the case again from any folder.
        source: plan or table before.
        seconds: spent on re-timing [s].
        stale: what has changed in the case since the plan before, where the user went on.

    Raises:
        InfeasiblePlan: it passes a limit, or has no limited jerk; the message names the limit and the remedy.
        IdentificationError: the motion does not excite all parameters of the model.
    """
    if found.method is Method.TOPPRA:
        raise InfeasiblePlan(
            "what toppra re-times has steps in its accelerations, without limit of jerk, and is no plan; use --method "
            "ipopt, or name a table (-o after.csv)"
        )
    if violations := found.after.limits.violations:
        raise InfeasiblePlan(
            f"the re-timed motion is no plan: {violations[0].sentence()}; name a table (-o after.csv) to look at it"
        )
    if not found.motion.duration <= LONGEST:
        raise InfeasiblePlan(f"the motion takes {found.motion.duration:.0f} s, longer than {LONGEST:g} s; shorten it")
    settings = {
        "retimed_with": str(found.method),
        "retimed_from": str(source.resolve()),
        "duration_before_s": found.before.duration,
        "off_path_mm": found.off_path[0] / MM,
        "off_path_deg": found.off_path[1] / DEG,
        **({"stale": list(stale)} if stale else {}),
    }
    result = Found(found.motion, request.family, settings, found.after.limits, (), (), False)
    return rated(request, case, case_file, result, seconds)
