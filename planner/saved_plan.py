"""A plan folder read again by the commands that use it, without the planner that has made it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cases.errors import FileProblem
from cases.files import read_json
from cases.loading import load_case
from cases.schema import Case
from identification.motion import Trajectory
from planner.families.saved import motion_of_entries
from planner.request import LONGEST
from planner.verifying import problem_of

LONGEST_OF_POSES = 4 * 3600.0  # [s] of a measurement at poses: the paper's took 21 min


@dataclass(frozen=True, slots=True)
class SavedPlan:
    """What other commands need of a plan folder.

    Args:
        folder: where it is.
        case: loaded anew and unchanged since.
        case_file: name or file of the case.
        motion: the excitation.
        data: all of plan.json.
    """

    folder: Path
    case: Case
    case_file: str
    motion: Trajectory
    data: dict[str, Any]


def load_plan(folder: Path) -> SavedPlan:
    """Reads a plan folder; its figures are computed anew from its motion.

    Raises:
        FileProblem: no plan there, damaged, changed by hand, or its case has changed since.
        CaseError: its case is gone or no longer valid.
    """
    file = folder / "plan.json"
    data = read_json(file, "hexcite plan")
    try:
        case_file, case_hash = str(data["case_file"]), str(data["case_hash"])
        motion = motion_of_entries(data)
        for key in ("family", "model"):
            if key not in data:
                raise KeyError(key)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise FileProblem(f"{file}: entry {error} is missing or damaged; plan again") from error
    if not motion.duration <= (LONGEST_OF_POSES if data["family"] == "poses" else LONGEST):
        raise FileProblem(f"{file}: a motion of {motion.duration:g} s is no excitation; plan again")
    case = load_case(case_file)
    if case.hash != case_hash:
        what = _what_changed(case, data)
        raise FileProblem(
            f"{file}: case {case_file} has changed since{what} (hash {case.hash}, was {case_hash}); plan again"
        )
    if problem := problem_of(data, motion, case):
        raise FileProblem(f"{file}: {problem}; plan again")
    return SavedPlan(folder, case, case_file, motion, data)


def _what_changed(case: Case, data: dict[str, Any]) -> str:
    """In which tables, where the plan says what they were."""
    then = data.get("case_tables")
    names = case.changes_since(then) if isinstance(then, dict) else ()
    return f" in {', '.join(names)}" if names else ""
