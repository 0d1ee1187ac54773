"""Pictures in files: a machine at home."""

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from mpl_toolkits.mplot3d.axes3d import Axes3D

from cases.machine import KeepOut, turned
from cases.schema import Case
from cases.units import MM
from identification.limited_chain import chain_frames
from identification.motion import Array, StandingPoses
from planner.reports.scene import box_outlines, room, tool_outlines
from planner.reports.still import Shown

Lines = dict[str, tuple[str, Iterable[Array]]]
"""Entry of the legend -> colour, and lines of points, shapes (n, 3) [mm]."""
Labels = list[tuple[Array, str]]
"""Places, shape (3,) or (2,) [mm], and what is written there."""
SAME_PLACE = 0.01  # of the machine's size, within which labels are written as one


def case_figure(case: Case) -> Figure:
    """The machine at home as a drawing has it, to be compared with the drawing: in 3-D, from above and from the side.

    Joints and sensors are numbered or named; of a hexapod, radii and heights of its rings and the lengths of its struts
    at home, which a control displays too, stand beside it.
    """
    figure = Shown(figsize=(13, 8), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.25, 1.0))
    space: Axes3D = figure.add_subplot(grid[:, 0], projection="3d")
    above, beside = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    lines, labels, boxes = _hexapod(case) if case.chain is None else _chain(case)
    points = np.vstack([line for _, group in lines.values() for line in group])
    corners = room(points.min(axis=0), points.max(axis=0), boxes)
    lines["kept out"] = "tab:orange", box_outlines(boxes, *corners)
    for name, (colour, group) in lines.items():
        for k, line in enumerate(group):
            space.plot(*line.T, color=colour, label=None if k else name)
            above.plot(*line.T[[0, 1]], color=colour, linewidth=1.0)
            beside.plot(*line.T[[0, 2]], color=colour, linewidth=1.0)
    for place, text in labels:
        space.text(*place, text)
    space.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]", title=f"{case.name} at home, in {{B}}")
    space.set_aspect("equal", adjustable="datalim")
    space.legend(loc="upper left")
    above.set(xlabel="x [mm]", ylabel="y [mm]", title="from above")
    beside.set(xlabel="x [mm]", ylabel="z [mm]", title="from the side, along y")
    size = float(np.ptp(points, axis=0).max())
    for axes, seen in ((above, [0, 1]), (beside, [0, 2])):
        for (x, y), text in _together([(place[seen], text) for place, text in labels], SAME_PLACE * size):
            axes.annotate(text, (x, y), xytext=(3, 3), textcoords="offset points", fontsize="small")
        axes.set_aspect("equal", adjustable="datalim")
        axes.grid(color="0.9")
    if case.chain is None:
        _dimensions(case, above, beside, figure)
    return figure


def _together(labels: Labels, near: float) -> Labels:
    """The labels, those of one place as one."""
    merged: Labels = []
    for place, text in labels:
        same = next((k for k, (other, _) in enumerate(merged) if np.linalg.norm(other - place) <= near), None)
        if same is None:
            merged.append((place, text))
        else:
            merged[same] = merged[same][0], f"{merged[same][1]}, {text}"
    return merged


def _dimensions(case: Case, above: Axes, beside: Axes, figure: Figure) -> None:
    """Radii and heights of the rings, and lengths of the struts at home."""
    machine = case.need_machine("the picture of the machine")[0]
    base, home = machine.base.points / MM, machine.home.vector
    platform = machine.platform.points / MM @ turned(home[3:]).T + home[:3] / MM
    for name, points, side in (("base", base, 1.0), ("platform", platform, -1.0)):  # words above and below
        centre = points.mean(axis=0)
        radii, heights = np.linalg.norm((points - centre)[:, :2], axis=1), points[:, 2]
        if np.ptp(radii) < 1.0:  # one circle
            above.add_patch(Circle(tuple(centre[:2]), radii.mean(), fill=False, color="0.7", linestyle=":"))
            x, y = centre[:2] + radii.mean() * np.array([1.0, side]) * np.sqrt(0.5)
            above.annotate(f"{name}: radius {radii.mean():.4g}", (x, y), fontsize="small", color="0.3")
        if np.ptp(heights) < 1.0:
            beside.axhline(heights.mean(), color="0.7", linestyle=":", linewidth=0.8)
            words = f"{name}: z = {heights.mean():.4g}"
            beside.annotate(
                words, (1.0, heights.mean()), xycoords=("axes fraction", "data"), fontsize="small", color="0.3"
            )
    lengths = np.linalg.norm(platform - base, axis=1)
    words = ", ".join(f"{k}: {length:.4g}" for k, length in enumerate(lengths, 1))
    figure.supxlabel(f"strut lengths at home [mm]: {words}", fontsize="medium")


def _hexapod(case: Case) -> tuple[Lines, Labels, tuple[KeepOut, ...]]:
    machine, workspace, _ = case.need_machine("the picture of the machine")
    origin, turn = machine.home.vector[:3] / MM, turned(machine.home.vector[3:])

    def placed(points: Array) -> Array:
        return np.asarray(origin + points @ turn.T)

    base, platform = machine.base.points / MM, placed(machine.platform.points / MM)
    lines: Lines = {
        "base": ("0.3", [np.vstack([base, base[:1]])]),
        "platform": ("tab:blue", [np.vstack([platform, platform[:1]])]),
        "struts 1 to 6": ("tab:gray", np.stack([base, platform], axis=1)),
        "tools": ("tab:purple", [placed(line) for line in tool_outlines(workspace.tool)]),
    }
    ends = [base, platform]
    if (bars := case.sensor_frame.bars) is not None:
        sensors = [placed(ring.points / MM) for ring in (bars.lower, bars.upper)]
        lines["sensors 1 to 6"] = "tab:red", np.stack(sensors, axis=1)
        ends.append(sensors[1])
    labels = [(place, f"{k}") for joints in ends for k, place in enumerate(joints, start=1)]
    return lines, labels, workspace.keep_out


def _chain(case: Case) -> tuple[Lines, Labels, tuple[KeepOut, ...]]:
    chain, _ = case.need_chain("the picture of the machine")
    at_home = StandingPoses(chain.home[None]).at([0.0])
    frames = [np.eye(4), *(place[0] for place, _, _ in chain_frames(at_home, chain))]
    origins = np.array([frame[:3, 3] for frame in frames]) / MM
    lines: Lines = {"joints and sensor": ("tab:gray", [origins])}
    for name, colour, owners in (
        ("base", "0.3", [(frames[0], chain.base)]),
        ("tool", "tab:purple", [(frames[-1], chain.tool)]),
        ("links", "tab:blue", zip(frames[1:], (joint.bodies for joint in chain.joints), strict=False)),
    ):
        outlines = [(frame, line) for frame, bodies in owners for line in tool_outlines(bodies)]
        lines[name] = colour, [line @ frame[:3, :3].T + frame[:3, 3] / MM for frame, line in outlines]
    return lines, list(zip(origins[1:], (*chain.names, "sensor"), strict=False)), chain.keep_out
