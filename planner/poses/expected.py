"""Poses at which a recording should stand: of a plan of poses, or what `hexcite run` wrote of its program."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cases.errors import FileProblem, HexciteError
from cases.schema import Case
from identification.motion import Joined, Measurement
from planner.runs.about import about_recording
from planner.saved_plan import load_plan

Array = NDArray[np.float64]


def poses_of_plan(folder: Path, case: Case) -> Array:
    """Poses of a plan in the order of visit, shape (n, 6) [m, rad].

    Args:
        folder: of the plan.
        case: of the recording.

    Raises:
        FileProblem: no plan there, or damaged.
        HexciteError: no plan of poses.
    """
    saved = load_plan(folder, case)
    parts = saved.motion.parts if isinstance(saved.motion, Joined) else ()
    poses = [part.pose for part in parts if isinstance(part, Measurement)]
    if not poses:
        raise HexciteError(
            f"{folder}: is a plan of family {saved.data['family']}, not of poses; name one of hexcite poses"
        )
    return np.array(poses)


def poses_of_recording(path: Path) -> Array | None:
    """Poses that the program of a recording folder measured, shape (n, 6); None where it measured a motion, or unknown.

    Raises:
        FileProblem: recording.json is damaged.
    """
    entry = about_recording(path).get("poses_m_rad")
    if not entry:
        return None
    try:
        poses = np.array(entry, dtype=float)
    except (TypeError, ValueError) as error:
        raise FileProblem(f"{path / 'recording.json'}: poses_m_rad: {error}; run the program again") from error
    if poses.ndim != 2 or poses.shape[1] != 6 or not np.isfinite(poses).all():
        raise FileProblem(f"{path / 'recording.json'}: poses_m_rad: are no poses of six numbers; run the program again")
    return poses
