"""Poses at which a recording should stand: of a plan of poses, or what `hexcite run` wrote of its program."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.errors import FileProblem, HexciteError
from cases.schema import Case
from planner.plan_folder import load_plan

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
    plan = load_plan(folder, case)
    if not len(plan.poses):
        raise HexciteError(f"{folder}: is a plan of family {plan.family}, not of poses; name one of hexcite poses")
    return plan.poses


def poses_of_record(record: Mapping[str, Any]) -> Array | None:
    """Poses that a program measured, shape (n, 6); None where it measured a motion, or unknown.

    Args:
        record: what `recording.json` says.

    Raises:
        FileProblem: the entry is damaged.
    """
    entry = record.get("poses_m_rad")
    if not entry:
        return None
    try:
        poses = np.array(entry, dtype=float)
    except (TypeError, ValueError) as error:
        raise FileProblem(f"recording.json: poses_m_rad: {error}; run the program again") from error
    if poses.ndim != 2 or poses.shape[1] != 6 or not np.isfinite(poses).all():
        raise FileProblem("recording.json: poses_m_rad: are no poses of six numbers; run the program again")
    return poses
