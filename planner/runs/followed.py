"""What a recorded run should have done: the plan or the program that it followed."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from cases.errors import ExecutionError, HexciteError, ProgramError
from cases.schema import Case
from identification.motion import Joined, Standstill, Trajectory
from planner.plan_folder import load_plan
from postprocessors.files import Program, read_program
from postprocessors.proving.measured import measures_at_poses
from postprocessors.proving.predicted import predicted
from postprocessors.proving.stretches import Timed, Untimed, stretches


class Followed(NamedTuple):
    """A motion that was asked for.

    Args:
        name: of the plan or program, for messages.
        motion: while the trigger is on.
    """

    name: str
    motion: Trajectory


def followed_plan(path: Path, case: Case) -> Followed:
    """The excitation of a plan folder or of a program.

    Raises:
        HexciteError: neither, damaged, or of poses instead of a motion.
    """
    if path.is_dir():
        saved = load_plan(path, case)
        if len(saved.poses):
            raise HexciteError(f"{path}: is a plan of poses, which has no feed to compare; name it with --poses")
        return Followed(str(path), saved.motion)
    read = read_program(path, case)
    if measures_at_poses(stretches(read.reading)):
        raise HexciteError(f"{path}: measures at poses, which has no feed to compare; leave --plan out")
    return Followed(str(path), planned_excitation(read, case))


def followed_by_record(record: Mapping[str, Any], case: Case) -> Followed | None:
    """The excitation of the program that `recording.json` names; None where it is gone, changed, or of poses."""
    program = Path(str(record.get("program", "")))
    if record.get("poses_m_rad") or not program.is_file():
        return None
    try:
        read = read_program(program, case)
        if hashlib.sha256(read.content).hexdigest()[:16] != record.get("program_hash"):
            return None
        return Followed(program.name, planned_excitation(read, case))
    except (ProgramError, OSError):  # another program stands there now
        return None


def planned_excitation(read: Program, case: Case) -> Trajectory:
    """The motion that the program asks for while its trigger is on.

    Raises:
        ExecutionError: nothing moves then.
    """
    limits = case.need_machine("a run")[2].motion
    excited: list[Trajectory] = []
    for part in stretches(read.reading):
        if not part.trigger:
            continue
        if isinstance(part, Timed):
            excited.append(part.points)
        elif isinstance(part, Untimed):
            motion = predicted(part, limits, read.guarantees)
            excited += [] if motion is None else [motion]
        elif excited and part.duration > 0.0:  # a pause between moves
            excited.append(Standstill(excited[-1].at([excited[-1].duration]).pose[0], part.duration))
    while excited and isinstance(excited[-1], Standstill):
        excited.pop()
    if not excited:
        raise ExecutionError(f"{read.path}: nothing moves with the trigger on; write it with hexcite post")
    return excited[0] if len(excited) == 1 else Joined(tuple(excited))
