"""The hexapod along a motion, as data for the page's 3-D picture."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.machine import KeepOut, Tool
from cases.schema import Case
from cases.units import MM
from identification.motion import Trajectory, sample
from planner.reports.page import MachineItem

Array = NDArray[np.float64]

AROUND = 16  # corners of a ring around a tool
BESIDE = 0.25  # of the machine's size: boxes are shown that far beside it
_BOTTOM = ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))


FRAMES_A_SECOND = 50.0
MOST_FRAMES = 3000
SECONDS_A_POSE = 0.5  # of a pose set, when played


def moving_machine(case: Case, trajectory: Trajectory, note: str) -> MachineItem:
    """The machine of a case along a trajectory."""
    rate = min(FRAMES_A_SECOND, MOST_FRAMES / max(trajectory.duration, 1e-9))
    motion = sample(trajectory, rate)
    return MachineItem(_scene(case, motion.t, motion.pose, steps=False), note)


def posing_machine(case: Case, poses: Array, note: str) -> MachineItem:
    """The machine of a case in one pose after the other.

    Args:
        poses: shape (n, 6) [m, rad].
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


def room(low: Array, high: Array, boxes: Iterable[KeepOut]) -> tuple[Array, Array]:
    """Corners, shape (3,) [mm], of a picture that shows boxes too, as far as they stand beside a machine."""
    beside = BESIDE * (high - low)
    first, last = low, high
    for box in boxes:
        least, most = box.corners / MM
        first, last = (
            np.minimum(first, np.maximum(least, low - beside)),
            np.maximum(last, np.minimum(most, high + beside)),
        )
    return first, last


def box_outlines(boxes: Iterable[KeepOut], low: Array, high: Array) -> list[Array]:
    """Edges of boxes in {B}, as far as they lie between two corners: lines of shape (k, 3) [mm]."""
    lines = []
    for box in boxes:
        ends = np.clip(box.corners / MM, low, high)
        if np.any(ends[0] >= ends[1]):
            continue  # beside the picture
        floor, ceiling = (np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i, j in _BOTTOM]) for k in (0, 1))
        lines += [floor, ceiling, *np.stack([floor[:4], ceiling[:4]], axis=1)]
    return lines


def tool_outlines(tools: Iterable[Tool]) -> list[Array]:
    """Axes of tools, or the rings at their ends and lines between these, in {P}: lines of shape (k, 3) [mm]."""
    lines: list[Array] = []
    for tool in tools:
        start, end = tool.axis / MM
        if tool.radius_mm == 0.0:
            lines.append(np.stack([start, end]))
            continue
        # Two directions across the axis; a ball, whose ends are one, is shown as a ring.
        way = end - start if np.any(end != start) else np.array([0.0, 0.0, 1.0])
        across = np.linalg.svd(way[None])[2][1:]
        angle = np.linspace(0.0, 2 * np.pi, AROUND + 1)
        ring = tool.radius_mm * (np.cos(angle)[:, None] * across[0] + np.sin(angle)[:, None] * across[1])
        lines += [start + ring, end + ring]
        lines += list(np.stack([start + ring, end + ring], axis=1)[:AROUND:4])
    return lines
