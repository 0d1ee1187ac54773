"""A plan folder read again by the commands that use it, without the planner that has made it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cases.basis import Artefact, plan_basis
from cases.errors import FileProblem
from cases.files import read_json
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
        case: loaded anew.
        case_file: name or file of the case.
        motion: the excitation.
        data: all of plan.json.
        stale: what has changed in the case since, where the user went on; written into what is made of the plan.
    """

    folder: Path
    case: Case
    case_file: str
    motion: Trajectory
    data: dict[str, Any]
    stale: tuple[str, ...] = ()


def load_plan(folder: Path, case: Case | None = None, stale: bool = False) -> SavedPlan:
    """Reads a plan folder; its figures are computed anew from its motion.

    Args:
        folder: where it is.
        case: for which the motion is taken, instead of the plan's own.
        stale: read it although what it was computed from has changed in its case.

    Raises:
        FileProblem: no plan there, damaged, changed by hand, or its case has changed since.
        CaseError: its case is gone or no longer valid.
    """
    file = folder / "plan.json"
    data = read_json(file, "hexcite plan")
    try:
        case_file, _ = str(data["case_file"]), str(data["case_hash"])
        motion = motion_of_entries(data)
        for key in ("family", "model"):
            if key not in data:
                raise KeyError(key)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise FileProblem(f"{file}: entry {error} is missing or damaged; plan again") from error
    if not motion.duration <= (LONGEST_OF_POSES if data["family"] == "poses" else LONGEST):
        raise FileProblem(f"{file}: a motion of {motion.duration:g} s is no excitation; plan again")
    named = Artefact(file, data, "plan again")
    own = named.case() if case is None else case
    payload = data.get("payload", 0)
    now = plan_basis(own, payload if isinstance(payload, int) else 0, data["family"] == "poses")
    remarks = named.require_unchanged(now, own, stale) if case is None else ()
    if not named.changes(now, own.hash) and (problem := problem_of(data, motion, own)):
        raise FileProblem(f"{file}: {problem}; plan again")
    return SavedPlan(folder, own, case_file, motion, data, remarks)
