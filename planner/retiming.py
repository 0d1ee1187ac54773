"""A planned motion at the pace that controllers or limits allow: criteria and limits before and after.

Point-to-point moves get the jerk-limited law that a controller computes online, in whole cycles (ruckig). Other paths
keep the limits of rates and accelerations of coordinates and struts at another pace (toppra); that has no jerk limit.
"""

import csv
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cases.errors import FileProblem, InfeasiblePlan
from cases.schema import Case
from cases.units import DEG, MM
from identification.circle import CircularMove
from identification.criteria import CRITERIA, singular_values
from identification.limits import LimitReport, prove
from identification.model import Model
from identification.motion import Joined, Standstill, TimedPoints, Trajectory
from identification.online_profile import UntimedMove, online_move, online_profile
from identification.path_timing import UntimedPath, retime
from identification.profile import Profile, StraightMove
from identification.reference import reference_scaling
from planner.bound import Bound, box_bound
from planner.problem import mean_information

Array = NDArray[np.float64]

POSE_COLUMNS = ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")
MOST_POINTS = 1_000_000


class Method(StrEnum):
    """How a motion is re-timed."""

    RUCKIG = "ruckig"
    TOPPRA = "toppra"


@dataclass(frozen=True, slots=True)
class Rating:
    """What a motion is worth and whether it keeps the limits.

    Args:
        duration: [s].
        criteria: A, D, K, N in reference scaling, better the larger they are.
        d_efficiency: against the box bound; may be above 1 for a motion that leaves the box.
        limits: proof at 10 kHz.
    """

    duration: float
    criteria: dict[str, float]
    d_efficiency: float
    limits: LimitReport


@dataclass(frozen=True, slots=True)
class Retimed:
    """A motion before and after.

    Args:
        method: what re-timed it.
        motion: the motion after.
        before: of the motion as it was.
        after: of the motion after.
    """

    method: Method
    motion: Trajectory
    before: Rating
    after: Rating


def fitting_method(motion: Trajectory) -> Method:
    """Ruckig for sequences of moves and pauses, toppra for everything else."""
    moves = isinstance(motion, Joined) and all(
        isinstance(part, StraightMove | CircularMove | Standstill) for part in motion.parts
    )
    return Method.RUCKIG if moves else Method.TOPPRA


def retimed(motion: Trajectory, case: Case, model: Model, method: Method, fastest: bool) -> Retimed:
    """Re-times a motion and rates both.

    Args:
        motion: from rest to rest.
        case: limits and controller.
        model: whose parameters count.
        method: how.
        fastest: for toppra: as fast as the limits allow, instead of never faster than planned.

    Raises:
        InfeasiblePlan: the motion cannot be re-timed that way; the message says why.
        IdentificationError: it does not excite all parameters of the model.
        CaseError: the case has no machine, limits or controller.
    """
    try:
        after = by_controller(motion, case) if method is Method.RUCKIG else retime(motion, case, fastest)
    except (UntimedMove, UntimedPath) as error:
        raise InfeasiblePlan(f"cannot be re-timed with {method}: {error}") from error
    bound = box_bound(case, model)
    return Retimed(method, after, _rating(motion, case, model, bound), _rating(after, case, model, bound))


def _rating(motion: Trajectory, case: Case, model: Model, bound: Bound) -> Rating:
    information = mean_information(model, reference_scaling(case, model), motion)
    mu = singular_values(information, model.names)
    criteria = {letter: criterion.of(mu) for letter, criterion in CRITERIA.items()}
    return Rating(motion.duration, criteria, bound.efficiency(criteria["D"]), prove(motion, case))


def by_controller(motion: Trajectory, case: Case) -> Joined:
    """Every move under the law of a jerk-limited controller with the motion limits of the case, in whole cycles.

    Straight moves become as fast as the limits of their coordinates allow; arcs as fast as the peaks of their planned
    law; pauses are rounded up.

    Raises:
        UntimedMove: the motion is no sequence of moves and pauses.
        CaseError: the case has no machine, limits or controller.
    """
    box = case.need_machine("re-timing")[2].motion
    cycle = case.need_controller("re-timing in whole controller cycles").cycle
    if not isinstance(motion, Joined):
        raise UntimedMove("it is one continuous path, no sequence of moves; use toppra")
    parts: list[Trajectory] = []
    for part in motion.parts:
        if isinstance(part, Standstill):
            parts.append(Standstill(part.pose, float(np.ceil(part.duration / cycle - 1e-9)) * cycle))
        elif isinstance(part, StraightMove):
            parts.append(online_move(part.start, part.end, box.rate, box.acceleration, box.jerk, cycle))
        elif isinstance(part, CircularMove) and isinstance(part.profile, Profile):
            law = part.profile
            profile = online_profile(law.peak_velocity, law.jerk * law.jerk_time, law.jerk, cycle)
            parts.append(replace(part, profile=profile))
        else:
            raise UntimedMove("it contains a continuous path; use toppra")
    return Joined(tuple(parts))


def read_motion(file: Path) -> TimedPoints:
    """A motion from a table with `t_s` and the six pose columns, as `motion.csv` has them; other columns do not count.

    Raises:
        FileProblem: unreadable, a column is missing, a value is no number, or times do not increase.
    """
    try:
        with file.open(newline="", encoding="utf-8") as stream:
            rows = csv.reader(stream)
            header = [name.strip() for name in next(rows, [])]
            missing = [name for name in ("t_s", *POSE_COLUMNS) if name not in header]
            if missing:
                raise FileProblem(
                    f"{file}, line 1: column {missing[0]} is missing; head the columns as motion.csv does"
                )
            places = [header.index(name) for name in ("t_s", *POSE_COLUMNS)]
            values = [_numbers(file, line, row, places, header) for line, row in enumerate(rows, start=2) if row]
    except FileProblem:
        raise
    except OSError as error:
        raise FileProblem(f"{file}: cannot be read ({error.strerror or error}); give a plan folder or a CSV") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise FileProblem(f"{file}: is no table in UTF-8 ({error}); give a plan folder or a CSV") from error
    if not 4 <= len(values) <= MOST_POINTS:
        raise FileProblem(f"{file}: holds {len(values)} poses; a motion has 4 to {MOST_POINTS}")
    table = np.array(values)
    steps = np.diff(table[:, 0])
    if not np.all(steps > 0.0):
        line = int(np.argmax(steps <= 0.0)) + 3
        raise FileProblem(f"{file}, pose of line {line}: t_s does not increase; sort the rows and drop repeated times")
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
            raise FileProblem(f"{file}, line {line}: {header[place]} is {text!r}, not a number; correct it")
        values.append(value)
    return values
