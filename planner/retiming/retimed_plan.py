"""A re-timed motion as a plan of its own: a folder for `hexcite post`, `run`, `identify` and `compare`."""

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from cases.errors import FileProblem, HexciteError, InfeasiblePlan
from cases.recording_format import POSE
from cases.schema import Case
from cases.units import DEG, MM
from identification.model import identification_model
from identification.motion import TimedPoints, Trajectory
from planner.found import Found
from planner.planning import rated
from planner.plans import Plan
from planner.request import LONGEST, Request
from planner.retiming.retimed import Retimed, RetimingMethod, fitting_method, retimed


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


def method_of(name: str | None, motion: Trajectory, fastest: bool) -> RetimingMethod:
    """The method of a name, or what fits a motion.

    Raises:
        HexciteError: unknown, or ruckig with `fastest`.
    """
    if name is not None and name not in list(RetimingMethod):
        raise HexciteError(f"method {name!r} is unknown; choose {', '.join(RetimingMethod)}")
    chosen = RetimingMethod(name) if name is not None else fitting_method(motion)
    if fastest and chosen is RetimingMethod.RUCKIG:
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
    if found.method is RetimingMethod.TOPPRA:
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


MOST_POINTS = 1_000_000


def read_motion(file: Path) -> TimedPoints:
    """A motion from a table with `t_s` and the six pose columns, as `motion.csv` has them; other columns do not count.

    Raises:
        FileProblem: unreadable, a column is missing, a value is no number, or times do not increase.
    """
    try:
        with file.open(newline="", encoding="utf-8") as stream:
            rows = csv.reader(stream)
            header = [name.strip() for name in next(rows, [])]
            missing = [name for name in ("t_s", *POSE) if name not in header]
            if missing:
                raise FileProblem(
                    f"{file}, line 1", f"column {missing[0]} is missing", "head the columns as motion.csv does"
                )
            places = [header.index(name) for name in ("t_s", *POSE)]
            values = [_numbers(file, line, row, places, header) for line, row in enumerate(rows, start=2) if row]
    except FileProblem:
        raise
    except OSError as error:
        raise FileProblem(file, f"cannot be read ({error.strerror or error})", "give a plan folder or a CSV") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise FileProblem(file, f"is no table in UTF-8 ({error})", "give a plan folder or a CSV") from error
    if not 4 <= len(values) <= MOST_POINTS:
        raise FileProblem(file, f"holds {len(values)} poses", f"a motion has 4 to {MOST_POINTS}")
    table = np.array(values)
    steps = np.diff(table[:, 0])
    if not np.all(steps > 0.0):
        line = int(np.argmax(steps <= 0.0)) + 3
        raise FileProblem(
            f"{file}, pose of line {line}", "t_s does not increase", "sort the rows and drop repeated times"
        )
    return TimedPoints.through(table[:, 0] - table[0, 0], table[:, 1:] * np.repeat([MM, DEG], 3))


def _numbers(file: Path, line: int, row: list[str], places: list[int], header: list[str]) -> list[float]:
    values = []
    for place in places:
        text = row[place] if place < len(row) else ""
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not np.isfinite(value):
            raise FileProblem(f"{file}, line {line}", f"{header[place]} is {text!r}, not a number", "correct it")
        values.append(value)
    return values
