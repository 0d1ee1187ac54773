"""The machine along a motion, or in one pose after the other: its picture in 3-D."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from markupsafe import Markup

from cases.machine import KeepOut, Tool
from cases.schema import Case
from cases.units import MM
from identification.motion import Array, Trajectory, sample
from planner.reports.page import player, section

BESIDE = 0.25  # share of the machine's size: boxes are shown up to this distance
_BOTTOM = ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))
NO_POSES: Array = np.zeros((0, 6))
FRAMES_A_SECOND = 50.0
MOST_FRAMES = 3000
SECONDS_A_POSE = 0.5  # time of each pose when a pose set is played


def pictured(case: Case, motion: Trajectory, poses: Array = NO_POSES) -> tuple[Markup, ...]:
    """Picture of the machine along a motion, or in the poses of a set, shape (n, 6) [m, rad]; empty for a chain."""
    if case.hexapod is None:
        return ()
    picture = posing_machine(case, poses) if len(poses) else moving_machine(case, motion)
    return (section("The machine along the plan", picture),)


def moving_machine(case: Case, trajectory: Trajectory) -> Markup:
    """The machine of a case along a trajectory."""
    motion = sample(trajectory, min(FRAMES_A_SECOND, MOST_FRAMES / max(trajectory.duration, 1e-9)))
    return player(_scene(case, motion.t, motion.pose, steps=False))


def posing_machine(case: Case, poses: Array) -> Markup:
    """The machine of a case in one pose after the other, shape (n, 6) [m, rad]."""
    return player(_scene(case, SECONDS_A_POSE * np.arange(float(len(poses))), poses, steps=True))


def _scene(case: Case, t: Array, poses: Array, steps: bool) -> dict[str, Any]:
    """Lengths in mm, angles in rad; points of platform, sensors and tools in {P}, of base and boxes in {B}."""
    machine, workspace, _ = case.need_machine("the picture of the machine")
    bars = case.sensor_frame.bars
    base, platform, tools = machine.base.points / MM, machine.platform.points / MM, tool_outlines(workspace.tool)
    ends = [] if bars is None else [bars.lower.points / MM, bars.upper.points / MM]
    reach = np.linalg.norm(platform, axis=1).max()
    tall = max((np.linalg.norm(line, axis=1).max() for line in (*ends, *tools)), default=0.0)
    centres = poses[:, :3] / MM
    low = np.minimum(base.min(axis=0), centres.min(axis=0) - np.array([reach, reach, 0.0]))
    high = np.maximum(base.max(axis=0), centres.max(axis=0) + np.array([reach, reach, tall]))
    low, high = room(low, high, workspace.keep_out)
    lower, upper = [np.round(points, 3).tolist() for points in ends] or ([], [])
    return {
        "steps": steps,
        "t": t.astype(np.float32),
        "poses": (poses / np.repeat([MM, 1.0], 3)).astype(np.float32),
        "base": np.round(base, 3).tolist(),
        "platform": np.round(platform, 3).tolist(),
        "lower": lower,
        "upper": upper,
        "tools": [np.round(line, 2).tolist() for line in tools],
        "boxes": [np.round(line, 2).tolist() for line in box_outlines(workspace.keep_out, low, high)],
        "range": np.column_stack([low, high]).round(1).tolist(),
    }


def room(low: Array, high: Array, boxes: Iterable[KeepOut]) -> tuple[Array, Array]:
    """Corners, shape (3,) [mm], of a picture that shows boxes too, as far as they stand beside a machine."""
    beside, corners = BESIDE * (high - low), [box.corners / MM for box in boxes]
    first = np.min([low, *(np.clip(least, low - beside, low) for least, _ in corners)], axis=0)
    last = np.max([high, *(np.clip(most, high, high + beside) for _, most in corners)], axis=0)
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
    """Axes of tools in {P}: lines of shape (2, 3) [mm]."""
    return [tool.axis / MM for tool in tools]
