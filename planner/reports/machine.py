"""The hexapod along a motion, as data for the page's 3-D picture."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from cases.units import MM
from identification.motion import Trajectory, sample
from planner.reports.outlines import box_outlines, room, tool_outlines
from planner.reports.page import MachineItem

Array = NDArray[np.float64]

FRAMES_A_SECOND = 50.0
MOST_FRAMES = 3000
SECONDS_A_POSE = 0.5  # of a pose set, when played


def moving_machine(case: Case, trajectory: Trajectory, note: str) -> MachineItem:
    """The machine of a case along a trajectory.

    Args:
        note: caption.
    """
    rate = min(FRAMES_A_SECOND, MOST_FRAMES / max(trajectory.duration, 1e-9))
    motion = sample(trajectory, rate)
    return MachineItem(_scene(case, motion.t, motion.pose, steps=False), note)


def posing_machine(case: Case, poses: Array, note: str) -> MachineItem:
    """The machine of a case in one pose after the other.

    Args:
        poses: shape (n, 6) [m, rad].
        note: caption.
    """
    return MachineItem(_scene(case, SECONDS_A_POSE * np.arange(float(len(poses))), poses, steps=True), note)


def _scene(case: Case, t: Array, poses: Array, steps: bool) -> dict[str, Any]:
    """Lengths in mm, angles in rad; points of platform, sensors and tools in {P}, of base and boxes in {B}."""
    machine, workspace, _ = case.need_machine("the picture of the machine")
    bars = case.sensor_frame.bars
    base, platform = machine.base.points / MM, machine.platform.points / MM
    unit = np.r_[np.full(3, 1 / MM), np.ones(3)]
    reach = float(np.linalg.norm(platform, axis=1).max())
    tall = 0.0 if bars is None else float(np.linalg.norm(bars.upper.points, axis=1).max()) / MM
    tools = tool_outlines(workspace.tool)
    tall = max([tall, *(float(np.linalg.norm(line, axis=1).max()) for line in tools)])
    centres = poses[:, :3] / MM
    low = np.minimum(base.min(axis=0), centres.min(axis=0) - np.array([reach, reach, 0.0]))
    high = np.maximum(base.max(axis=0), centres.max(axis=0) + np.array([reach, reach, tall]))
    low, high = room(low, high, workspace.keep_out)
    return {
        "steps": steps,
        "t": t.astype(np.float32),
        "poses": (poses * unit).astype(np.float32),
        "base": np.round(base, 3).tolist(),
        "platform": np.round(platform, 3).tolist(),
        "lower": [] if bars is None else np.round(bars.lower.points / MM, 3).tolist(),
        "upper": [] if bars is None else np.round(bars.upper.points / MM, 3).tolist(),
        "tools": [np.round(line, 2).tolist() for line in tools],
        "boxes": [np.round(line, 2).tolist() for line in box_outlines(workspace.keep_out, low, high)],
        "range": np.column_stack([low, high]).round(1).tolist(),
    }
