"""The machine along a motion: its picture in 3-D, its struts, the forces of its sensors, the information gathered."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from cases.machine import KeepOut, Tool
from cases.schema import Case
from cases.sensors import payload_words
from cases.units import MM
from identification.criteria import analyse, reference_scaling
from identification.limit_proof import limited_machine, load_shares
from identification.model import Model, identification_model
from identification.motion import Array, Motion, Trajectory, sample
from identification.overload import SHARE
from identification.parameters import RIGID, nominal_parameters
from identification.symbolic import over_samples
from planner.reports.figures import identifiability_blocks, unit_of
from planner.reports.page import COLOURS, GREY, Block, Chart, note, player, section, table

AROUND = 16  # corners of a ring around a tool
BESIDE = 0.25  # share of the machine's size: boxes are shown up to this distance
_BOTTOM = ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))


FRAMES_A_SECOND = 50.0
MOST_FRAMES = 3000
SECONDS_A_POSE = 0.5  # time of each pose when a pose set is played
INFORMATION_RATE = 100.0  # [1/s] rate of the figures of information, enough for its mean


def pictured(case: Case, motion: Trajectory) -> tuple[Markup, ...]:
    """Picture of the machine along a motion; empty for a chain."""
    if case.hexapod is None:
        return ()
    return (section("The machine along the plan", moving_machine(case, motion, "Drag to turn, wheel to zoom.")),)


def moving_machine(case: Case, trajectory: Trajectory, caption: str) -> Markup:
    """The machine of a case along a trajectory."""
    rate = min(FRAMES_A_SECOND, MOST_FRAMES / max(trajectory.duration, 1e-9))
    motion = sample(trajectory, rate)
    return player(_scene(case, motion.t, motion.pose, steps=False), caption)


def posing_machine(case: Case, poses: Array, caption: str) -> Markup:
    """The machine of a case in one pose after the other.

    Args:
        poses: shape (n, 6) [m, rad].
    """
    return player(_scene(case, SECONDS_A_POSE * np.arange(float(len(poses))), poses, steps=True), caption)


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


def strut_charts(case: Case, motion: Motion) -> tuple[Chart, ...]:
    """Lengths, velocities and accelerations of struts, with their limits."""
    _, workspace, box = case.need_machine("the page of a plan")
    length, velocity, acceleration = limited_machine(case).drives(motion)
    low = max(box.strut_length[0], workspace.strut_length[0]) / MM
    high = min(box.strut_length[1], workspace.strut_length[1]) / MM
    v, a = box.strut_velocity_m_s, box.strut_acceleration_m_s2
    names = [f"strut {k}" for k in range(1, 7)]
    panels = (
        ("strut-lengths", length / MM, "length [mm]", (low, high)),
        ("strut-velocities", velocity, "velocity [m/s]", (-v, v)),
        ("strut-accelerations", acceleration, "acceleration [m/s²]", (-a, a)),
    )
    figures = []
    for name, values, unit, ends in panels:
        figure = Chart(
            name, f"Strut {unit.split(' [')[0]} over time; dashed: its limits.", "time [s]", unit, height=280
        )
        _add_lines(figure, motion.t, values, names, ends)
        figures.append(figure)
    return tuple(figures)


def force_blocks(case: Case, motion: Motion, payload: int) -> tuple[Block, ...]:
    """Forces with the mounted payloads, and the share of the range that each number of payloads would use."""
    model = identification_model(case, RIGID)
    matrices = over_samples(model.coordinate_regressor, motion.pose, motion.rates, motion.accelerations)[0]
    forces = matrices @ nominal_parameters(model, case.body(payload))
    of = case.sensors.range_N
    limits = () if of is None or np.abs(forces).max() < SHARE * of / 4 else (-SHARE * of, SHARE * of)
    columns = case.sensor_frame.channels
    caption = f"With {payload_words(payload)}, offsets and compensation apart."
    figure = Chart("sensor-forces", caption, "time [s]", f"force [{unit_of(columns)}]", height=340)
    _add_lines(figure, motion.t, forces, columns, limits)
    shares = load_shares(motion, case)
    if of is None or not len(shares):
        return (figure, note("The case names no range of its sensors: nothing limits these forces."))
    rows = ((str(k), f"{100 * share:.1f} %") for k, share in enumerate(shares))
    ends = f"{of:g} N" if (moments := case.sensors.range_Nm) is None else f"{of:g} N and {moments:g} N m"
    return (figure, table(("payloads mounted", f"used of {100 * SHARE:.0f} % of the range of {ends}"), rows, left=0))


def _add_lines(figure: Chart, x: Array, values: Array, names: Sequence[str], limits: tuple[float, ...]) -> None:
    """Adds six lines over time, with the limits that they share."""
    figure.add_lines(x, values, names, 1.3)
    for limit in limits:
        figure.add_line({"y": limit}, GREY)


def information_blocks(case: Case, motion: Trajectory, model: Model) -> tuple[Block, ...]:
    """Deviation of each parameter, with all others known and estimated, and which parameters are determined."""
    count = max(200, int(motion.duration * INFORMATION_RATE))
    states = motion.at((np.arange(count) + 0.5) * motion.duration / count)
    regressors = over_samples(model.coordinate_regressor, states.pose, states.rates, states.accelerations)[0]
    matrices = np.asarray(regressors * reference_scaling(case, model))
    stacked = matrices.reshape(-1, matrices.shape[2])
    information = stacked.T @ stacked / len(matrices)
    alone = 1.0 / np.sqrt(np.diag(information))
    together = np.sqrt(np.diag(np.linalg.inv(information)))
    caption = "In reference scaling, for a noise of 1. The gap is what it costs that the others are unknown too."
    figure = Chart("information", caption, y="std of one sample, scaled", height=360, barmode="group")
    figure.add("bar", x=model.names, y=together, name="with all others unknown", marker={"color": COLOURS[0]})
    figure.add("bar", x=model.names, y=alone, name="if all others were known", marker={"color": COLOURS[5]})
    figure.axes({"tickangle": -60})
    return (figure, *identifiability_blocks(analyse(matrices, model.names)))
