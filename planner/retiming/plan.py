"""A re-timed motion as a plan of its own: a folder for `hexcite post`, `run`, `identify` and `compare`."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter

from cases.errors import HexciteError, InfeasiblePlan
from cases.schema import Case
from cases.units import DEG, MM
from identification.model import identification_model
from identification.motion import Trajectory
from planner.found import Found
from planner.plan import Plan
from planner.planning import rated
from planner.request import LONGEST, Request
from planner.retiming.retimed import Method, Retimed, fitting_method, retimed


def retime(
    plan: Plan,
    method: str | None = None,
    fastest: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> Plan:
    """A plan of the same path at another pace.

    Args:
        plan: of a motion.
        method: ruckig: moves as a jerk-limited controller times them; ipopt: paths under every limit; by default what
            fits.
        fastest: for ipopt: as fast as the limits allow, not only as slow as needed.
        progress: shows a line now and then.

    Raises:
        InfeasiblePlan: the motion cannot be re-timed that way.
        HexciteError: a plan of poses, an unknown method, or a method that does not fit.
    """
    began = perf_counter()
    request = replace(plan.of_motion[0], targets=())
    model = identification_model(plan.case, plan.model)
    found = retimed(plan.motion, plan.case, model, method_of(method, plan.motion, fastest), fastest, progress)
    source = Path(plan.name) if plan.saved is None else plan.saved.folder
    return retimed_plan(found, request, plan.case, source, perf_counter() - began, plan.stale)


def method_of(name: str | None, motion: Trajectory, fastest: bool) -> Method:
    """The method of a name, or what fits a motion.

    Raises:
        HexciteError: unknown, or ruckig with `fastest`.
    """
    if name is not None and name not in list(Method):
        raise HexciteError(f"method {name!r} is unknown; choose {', '.join(Method)}")
    chosen = Method(name) if name is not None else fitting_method(motion)
    if fastest and chosen is Method.RUCKIG:
        raise HexciteError(
            "--fastest belongs to --method ipopt or toppra; a controller's moves are as fast as its limits allow"
        )
    return chosen


def retimed_plan(
    found: Retimed,
    request: Request,
    case: Case,
    source: Path,
    seconds: float,
    stale: tuple[str, ...] = (),
) -> Plan:
    """The plan of a motion after re-timing.

    Args:
        found: the motion before and after.
        request: family, criterion, model and payload of the plan that it comes from.
        case: machine and limits.
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
    result = Found(found.motion, settings, found.after.limits)
    return rated(request, case, result, seconds)
