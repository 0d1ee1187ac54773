"""Figures of a case: what `hexcite case check` tells beyond "valid"."""

from typing import Any

import numpy as np

from cases.errors import CaseError
from cases.loading import find_case, load_case
from cases.schema import Case
from identification.hexapod import Hexapod
from identification.limit import LimitKind
from identification.limit_proof import prove
from identification.model import identification_model
from identification.motion import StandingPoses
from planner.motion_box import MotionBox, largest_box
from planner.precision import share_text
from planner.reach import Reach, reach
from planner.search.inside import remedy

GRID = (-1.0, 0.0, 1.0)
MOST_COORDINATES = 7  # whose corners and middles are all looked at
STATIC = (
    LimitKind.STRUT_LENGTH, LimitKind.BASE_JOINT_ANGLE, LimitKind.PLATFORM_JOINT_ANGLE, LimitKind.SINGULARITY,
    LimitKind.POSITION, LimitKind.ANGLE, LimitKind.DISTANCE_FROM_BOX,
)  # fmt: skip
OF_CHAINS = (
    LimitKind.DISTANCE_FROM_BOX, LimitKind.DISTANCE_BETWEEN_LINKS, LimitKind.JOINT_TORQUE, LimitKind.JOINT_FORCE,
)  # fmt: skip


def case_figures(name: str) -> dict[str, Any]:
    """Loads a case and computes its figures.

    Raises:
        CaseError: not valid, or home is out of the machine's reach.
    """
    case = load_case(name)
    frame = identification_model(case, 0).structure
    size = 1.0
    if case.sensor_frame.bars is not None:
        size = float(np.linalg.norm(case.sensor_frame.bars.lower.points, axis=1).max())
    elif case.sensor_frame.struts is not None and case.hexapod is not None:
        size = float(np.linalg.norm(case.hexapod.platform.points, axis=1).max())
    scaled = frame / np.r_[np.ones(3), np.full(3, size)][:, None]
    return {
        "name": case.name,
        "title": case.title,
        "setup": case.setup,
        "hash": case.hash,
        "frame_condition": float(np.linalg.cond(scaled)),
    } | _of_machine(case, str(find_case(name)))


def _of_machine(case: Case, file: str) -> dict[str, Any]:
    if case.chain is not None and case.limits is not None:
        return _joints_in_box(case, file)
    return _in_box(case, file) if has_motion_box(case) else {}


def _joints_in_box(case: Case, file: str) -> dict[str, Any]:
    """Clearances of a chain's bodies and torques at rest, at home and in the corners and middles of the motion box."""
    home, limits = case.need_motion("the check of its reach")
    count = len(home)
    if count <= MOST_COORDINATES:
        corners = np.stack(np.meshgrid(*([GRID] * count), indexing="ij"), axis=-1).reshape(-1, count)
    else:
        corners = np.random.default_rng(0).choice(GRID, (len(GRID) ** MOST_COORDINATES, count))
    middle, half = limits.pose.mean(axis=0), np.ptp(limits.pose, axis=0) / 2
    poses = np.vstack([home, home + middle + corners * half])
    at_home = prove(StandingPoses(poses[[0, 0]]), case, 1.0)
    if at_home.violations:
        problem = at_home.violations[0].sentence(timed=False)
        raise CaseError(file, "machine.chain.joints", f"home cannot be: {problem}; choose another home")
    checks = prove(StandingPoses(poses), case, 1.0).checks
    entries = {str(c.of): c.to_json() for c in checks if c.kind in OF_CHAINS}
    return {"poses": len(poses), "limits_in_box": entries} if entries else {}


def has_motion_box(case: Case) -> bool:
    """Whether the case describes a machine and the box in which it moves."""
    return case.hexapod is not None and case.limits is not None and case.workspace is not None


def reach_figures(name: str) -> Reach | None:
    """The reachable part of the motion box of a case; None where the case has no such box, or no limits."""
    case = load_case(name)
    if case.chain is not None and case.limits is not None:
        return reach(case)
    return reach(case) if has_motion_box(case) else None


def proposed_box(name: str) -> MotionBox:
    """The largest reachable motion box of a case.

    Raises:
        CaseError: the case has no machine or no box of motions; the message names its file.
    """
    case = load_case(name)
    try:
        return largest_box(case)
    except CaseError as error:
        raise CaseError(find_case(name), error.key, error.problem) from error


def _in_box(case: Case, file: str) -> dict[str, Any]:
    machine, _, limits = case.need_machine("the check of its reach")
    corners = np.stack(np.meshgrid(*([GRID] * 6), indexing="ij"), axis=-1).reshape(-1, 6)
    middle, half = limits.motion.pose.mean(axis=0), np.ptp(limits.motion.pose, axis=0) / 2
    poses = np.vstack([machine.home.vector, machine.home.vector + middle + corners * half])
    at_home = prove(StandingPoses(poses[[0, 0]]), case, 1.0)
    if at_home.violations:
        broken = at_home.violations[0]
        raise CaseError(
            file,
            "machine.home",
            f"is out of reach: {broken.sentence(timed=False)}; move home or {remedy(broken, case)}",
        )
    report = prove(StandingPoses(poses), case, 1.0)
    return {
        "home_struts_mm": (Hexapod.of(case).strut_lengths(poses[:1])[0] * 1e3).tolist(),
        "poses": len(poses),
        "limits_in_box": {str(c.of): c.to_json() for c in report.checks if c.kind in STATIC},
    }


COLUMNS = ("coordinate", "stated range", "reachable range", "limited by")


def percent(share: float) -> str:
    """A share in %, with three digits, and never 100 % where something is missing."""
    text = f"{100 * share:.3g}"
    return f"{100 * share:.6g} %" if text in ("100", "0") and share not in (0.0, 1.0) else f"{text} %"


def share_words(reach: Reach) -> str:
    """The reachable share of the box's volume; one of 0 or 1 as the bound that holds with a probability of 95 %."""
    if reach.whole:
        return "100 %"
    if reach.share == 1.0:
        return f"more than {100 * (1 - 3 / reach.poses):.2f} %"
    return f"less than {100 * 3 / reach.poses:.2g} %" if reach.share == 0.0 else percent(reach.share)


def share_sentences(reach: Reach) -> str:
    """How much of the box's volume is reachable, and which limits the rest exceeds, in a line."""
    worst = f"{share_text(reach.worst)} of the limit {reach.worst_limit}"
    poses = f"{reach.poses} random poses"
    if reach.whole:
        return f"The whole motion box is reachable: of {poses} and a search, the worst uses {worst}."
    start = f"Of the motion box's volume {share_words(reach)} is reachable"
    if reach.share == 1.0:
        return f"{start} (all of {poses}), but not every corner: the worst pose uses {worst}."
    exceeded = sorted(reach.exceeded.items(), key=lambda item: -item[1])
    kinds = ", ".join(f"{kind} in {percent(share)}" for kind, share in exceeded)
    return f"{start} (standard error {100 * reach.share_std:.2g} %, {poses}). Exceeded limits: {kinds} of the poses."


def coordinate_rows(reach: Reach) -> list[list[str]]:
    """Rows of `COLUMNS`: key of the case file, both ranges in its unit, what limits the lower and the upper end."""
    case_ranges, reachable = ((box / reach.units).T for box in (reach.stated, reach.reachable))
    rows = []
    for key, outer, inner, names in zip(reach.keys, case_ranges, reachable, reach.limited_by, strict=True):
        sides = [f"{side}: {name}" for side, name in zip(("below", "above"), names, strict=True) if name is not None]
        ranges = [f"[{low:.4g}, {high:.4g}]" for low, high in (outer, inner)]
        rows.append([key, *ranges, "; ".join(sides) or "the stated range"])
    return rows
