"""Plans from Python: what notebooks and the command line call."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Unpack

from threadpoolctl import threadpool_limits

from cases.base.options import documented
from cases.base.seldom import seldom
from cases.base.units import Array
from cases.schema import Case
from identification.model.model import full_model, static_model
from planner.families.manual import load_poses
from planner.families.settings import Best, FamilySettings
from planner.known import Known
from planner.options import DURATION, LONGEST_WANTED, Duration, PlanOptions, PoseOptions
from planner.plans.making import make_until_ctrl_c, require_plannable
from planner.plans.plan import Plan
from planner.plans.progress import Follower, Standing
from planner.poses.given import given_poses
from planner.request import PoseRequest, Request
from planner.search.parallel import silent
from planner.shortest import require_more, shortest


@documented(PlanOptions)
def plan(
    case: Case,
    family: FamilySettings | None = None,
    duration: Duration = None,
    *,
    progress: Callable[[str], None] | None = None,
    **settings: Unpack[PlanOptions],
) -> Plan:
    """The most informative motion inside the machine's limits, proven.

    Ctrl-C ends the search and keeps the best motion found so far; a second one gives up. So does the end of `seconds`;
    proof and figures come after. The search runs in `workers`
    processes, which do not run the caller's script.

    >>> by_hand = hx.plan(hx.load_case("hexapod"), hx.Manual())
    >>> by_hand.limits.kept
    True

    Args:
        case: machine and limits.
        family: family of motions; unless given the one of which the best motion is found, of moves, splines and series.
        progress: shows a line, at most once a second.
        OPTIONS

    Raises:
        HexciteError: what was asked for cannot be met; the message says what to change.
    """
    request = request_of(case, family, duration, **settings)
    return planned(request, case, None if progress is None else seldom(lambda standing: progress(standing.line)))


def request_of(
    case: Case, family: FamilySettings | None, duration: float | None, **settings: Unpack[PlanOptions]
) -> Request:
    """What arguments of `plan` ask for: the model, the duration and what is known follow from the case."""
    options: dict[str, Any] = dict(settings)
    results = settings.get("known")
    known = Known.of(results, case, settings.get("payload", 0), standing=False) if results else None
    options["known"] = known
    if options.get("model") is None:
        options["model"] = full_model(case) if known is None else known.model
    if duration is None:
        duration = LONGEST_WANTED if settings.get("target") else DURATION
    return Request(family or Best(), duration, **options)


def planned(
    request: Request,
    case: Case,
    progress: Callable[[Standing], None] | None = None,
    began: float | None = None,
) -> Plan:
    """`plan` for settings that are one value.

    Args:
        began: from when the seconds of the search count, by `time.monotonic` [s]; None for now.
    """
    require_plannable(request, case)
    follower = silent if progress is None else Follower(case, progress)
    with threadpool_limits(limits=1, user_api="blas"):  # matrices are small: threads of BLAS would wait for each other
        if request.target:
            require_more(request, case)
            return shortest(request, case, lambda shorter: make_until_ctrl_c(shorter, case, follower))
        return make_until_ctrl_c(request, case, follower, began)


@documented(PoseOptions)
def plan_poses(
    case: Case,
    at: Path | Array | None = None,
    *,
    progress: Callable[[int], None] | None = None,
    **settings: Unpack[PoseOptions],
) -> Plan:
    """The most informative poses to stand at, in a short order, proven.

    >>> plan = hx.plan_poses(hx.load_case("hexapod"), count=8, candidates=64, model=0)
    >>> plan.poses.shape, plan.limits.kept
    ((8, 6), True)
    >>> f"{plan.predicted_std['m']:.4f} kg"
    '0.0036 kg'

    Args:
        at: poses of one's own instead, to see what they are worth beside chosen ones: a CSV file, or coordinates of the
            machine, shape (n, k) [m or rad].
        case: machine, limits and poses.
        progress: called with the number of poses as the choice goes on, at most once a second.
        OPTIONS

    Raises:
        HexciteError: what was asked for cannot be met; the message says what to change.
    """
    from planner.poses.planned_poses import poses_planned  # SciPy, which motions do without

    options: dict[str, Any] = dict(settings)
    results = settings.get("known")
    known = Known.of(results, case, 0, standing=True) if results else None
    options["known"] = known
    if options.get("model") is None:
        options["model"] = static_model(case) if known is None else known.model
    if at is not None:
        options["method"] = "given"
    request = PoseRequest(**options)
    poses: Array | None = None
    if isinstance(at, Path | str):
        poses = load_poses(Path(at), case.need_motion("a plan of poses")[1].columns)
    elif at is not None:
        poses = given_poses(at, case, "plan_poses, at")
    with threadpool_limits(limits=1, user_api="blas"):
        return poses_planned(request, case, seldom(progress or (lambda _: None)), poses)
