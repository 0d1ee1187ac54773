"""Pictures in files: a machine at home, and channels of an unknown file."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.axes3d import Axes3D
from scipy.spatial.transform import Rotation

from cases.machine import KeepOut
from cases.recording_format import CLOCK, TICKS
from cases.schema import Case
from cases.units import MM
from identification.formats.looked import Column, Look
from identification.formats.naming import GROUPS
from identification.limited_chain import chain_frames
from identification.motion import Array, StandingPoses
from planner.reports.machine import box_outlines, room, tool_outlines

NARROWEST = 0.6  # of the longest side of a picture in 3-D: joints in one line make no room
BESIDE = 0.12  # distance of numbers from the ring, as a share of its radius


def case_figure(case: Case) -> Figure:
    """The machine at home in 3-D."""
    figure = Figure(figsize=(9, 8), layout="constrained")
    geometry: Axes3D = figure.add_subplot(projection="3d")
    if case.chain is None:
        _draw_machine(geometry, case)
    else:
        _draw_chain(geometry, case)
    return figure


def _draw_chain(axes: Axes3D, case: Case) -> None:
    """A chain at home, with its bodies, its tool and the keep-out boxes, in mm."""
    chain, _ = case.need_chain("the picture of the machine")
    at_home = StandingPoses(chain.home[None]).at([0.0])
    frames = [np.eye(4), *(place[0] for place, _, _ in chain_frames(at_home, chain))]
    origins = np.array([frame[:3, 3] for frame in frames]) / MM
    axes.plot(*origins.T, color="tab:gray", linewidth=2.0, marker="o", markersize=4, label="joints")
    for place in np.unique(origins[1 : len(chain.joints) + 1].round(3), axis=0):  # joints may lie at one place
        there = [j.name for k, j in enumerate(chain.joints, 1) if np.allclose(origins[k], place, atol=1e-2)]
        axes.text(*place, ", ".join(there), fontsize="small")
    axes.plot(*origins[-1:].T, color="tab:red", marker="s", linestyle="", label="sensor")
    links = list(zip(frames[1:], (joint.bodies for joint in chain.joints), strict=False))
    outlines = [origins]
    for owners, colour, label in (
        ([(frames[0], chain.base)], "0.3", "base"),
        ([(frames[-1], chain.tool)], "tab:purple", "tool"),
        (links, "tab:blue", "links"),
    ):
        lines = [
            line @ frame[:3, :3].T + frame[:3, 3] / MM for frame, bodies in owners for line in tool_outlines(bodies)
        ]
        _draw_lines(axes, lines, colour, label, 0.8)
        outlines += lines
    _finish(axes, case, outlines, chain.keep_out)
    axes.set(zlabel="z [mm]")


def _draw_machine(axes: Axes3D, case: Case) -> None:
    """Base, platform, struts and the bars of the sensors at home, in mm."""
    machine, workspace, _ = case.need_machine("the picture of the machine")
    home = machine.home.vector
    turn = Rotation.from_euler("xyz", home[3:]).as_matrix()
    base = machine.base.points / MM
    platform = (home[:3] + machine.platform.points @ turn.T) / MM
    for points, colour, label in ((base, "0.3", "base"), (platform, "tab:blue", "platform")):
        _draw_lines(axes, [np.vstack([points, points[:1]])], colour, label, 2.0)
        for k, (joint, beside) in enumerate(zip(points, points - points.mean(axis=0), strict=True), start=1):
            axes.text(*(joint + BESIDE * beside), f"{k}", color=colour, ha="center", va="center")
    _draw_lines(axes, np.stack([base, platform], axis=1), "tab:gray", "struts 1 to 6", 1.0)
    bars = case.sensor_frame.bars
    if bars is not None:
        low, high = ((home[:3] + ring.points @ turn.T) / MM for ring in (bars.lower, bars.upper))
        _draw_lines(axes, np.stack([low, high], axis=1), "tab:red", "sensors 1 to 6", 1.5)
        for k, end in enumerate(high, start=1):
            axes.text(*end, f"{k}", color="tab:red", fontsize="small", va="bottom")
    tools = [home[:3] / MM + line @ turn.T for line in tool_outlines(workspace.tool)]
    _draw_lines(axes, tools, "tab:purple", "tools", 1.0)
    _finish(axes, case, [base, platform, *tools], workspace.keep_out)
    axes.text2D(0.98, 0.92, "z [mm]", transform=axes.transAxes, ha="right")


def _draw_lines(axes: Axes3D, lines: Iterable[Array], colour: str, label: str, width: float) -> None:
    """Lines of points, shape (n, 3) [mm], with one entry in the legend."""
    for k, line in enumerate(lines):
        axes.plot(*line.T, color=colour, linewidth=width, label=None if k else label)


def _finish(axes: Axes3D, case: Case, drawn: Sequence[Array], boxes: Iterable[KeepOut]) -> None:
    """Adds keep-out boxes near the lines `drawn`, shapes (n, 3) [mm], titles, scale and legend."""
    every = np.vstack(drawn)
    corners = room(every.min(axis=0), every.max(axis=0), boxes)
    _draw_lines(axes, box_outlines(boxes, *corners), "tab:orange", "kept out", 1.0)
    axes.set(xlabel="x [mm]", ylabel="y [mm]", title=f"{case.name} at home, in {{B}}")
    limits = np.array([axes.get_xlim3d(), axes.get_ylim3d(), axes.get_zlim3d()])
    half = np.maximum(np.diff(limits)[:, 0], NARROWEST * np.diff(limits).max()) / 2.0
    low, high = limits.mean(axis=1) - half, limits.mean(axis=1) + half
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_aspect("equal")
    axes.legend(loc="upper left")


MOST_POINTS = 4000  # points of a line; more cannot be seen
_TITLES = (
    "struts", "strut velocities", "drive positions", "drive velocities", "pose", "rotation", "accelerometer", "forces",
    "forces and moments",
)  # fmt: skip
_PANEL = 2.2  # inches


def look_figure(report: Look) -> Figure:
    """Every column of numbers over time, or over the rows without a clock."""
    panels = list(_panels(report.columns))
    figure = Figure(figsize=(11, _PANEL * len(panels) + 0.6), layout="constrained")
    t, label = _time(report)
    step = -(-report.rows // MOST_POINTS)
    all_axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (title, columns) in zip(all_axes, panels, strict=True):
        for column in columns:
            axes.plot(t[::step], column.values[::step], linewidth=0.8, label=_legend(column))
        units = {column.unit for column in columns if column.unit}
        axes.set_ylabel(f"[{units.pop()}]" if len(units) == 1 else "")
        axes.set_title(title, loc="left", fontsize="small")
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="x-small", frameon=False)
        axes.grid(alpha=0.25)
    all_axes[-1].set_xlabel(label)
    return figure


def _legend(column: Column) -> str:
    name = column.name if column.ours in (None, column.name) else f"{column.name} = {column.ours}"
    return name.replace("$", r"\$") + (" ?" if column.guessed else "")


def _time(report: Look) -> tuple[Array, str]:
    clock = next((c for c in report.columns if c.ours == CLOCK), None)
    if clock is not None:
        return (clock.values - clock.values[0]) * TICKS[clock.unit], "time from the first row [s]"
    period = report.settings.get("clock", {}).get("period_ms")
    if period is not None:
        return np.arange(report.rows) * period / 1e3, "time from the first row [s]"
    return np.arange(1.0, report.rows + 1.0), "row"


def _panels(columns: Sequence[Column]) -> Iterator[tuple[str, list[Column]]]:
    """Titles and columns of the panels: known groups, then single columns, then columns without a known meaning."""
    numbers = [column for column in columns if len(column.values) and column.ours != CLOCK]
    grouped = {ours for group in GROUPS for ours in group}
    for title, group in zip(_TITLES, GROUPS, strict=True):
        members = [column for column in numbers if column.ours in group]
        if members:
            yield title, members
    for column in numbers:
        if column.ours is not None and column.ours not in grouped:
            yield column.ours.replace("_", " "), [column]
    unknown = [column for column in numbers if column.ours is None]
    if unknown:
        yield "without a meaning for hexcite", unknown
