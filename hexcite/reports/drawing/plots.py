"""Pictures in files: a machine at home."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from mpl_toolkits.mplot3d.axes3d import Axes3D

from cases.base.units import MM
from cases.machine import turned
from cases.schema import Case
from hexcite.reports.drawing.outline import SAME_PLACE, outline, together, where
from hexcite.reports.drawing.scene import box_outlines, room
from hexcite.reports.drawing.still import NotebookFigure


def case_figure(case: Case) -> Figure:
    """The machine at home as a drawing has it, to be compared with the drawing: in 3-D, from above and from the side.

    Joints and sensors are numbered or named; of a hexapod, radii and heights of its rings and the lengths of its struts
    at home, which a control displays too, stand beside it.
    """
    figure = NotebookFigure(figsize=(13, 8), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.25, 1.0))
    space: Axes3D = figure.add_subplot(grid[:, 0], projection="3d")
    above, side = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    lines, labels, boxes = outline(case)
    points = np.vstack([line for _, group in lines.values() for line in group])
    corners = room(points.min(axis=0), points.max(axis=0), boxes)
    lines["kept out"] = "tab:orange", box_outlines(boxes, *corners)
    for name, (colour, group) in lines.items():
        for k, line in enumerate(group):
            space.plot(*line.T, color=colour, label=None if k else name)
            above.plot(*line.T[[0, 1]], color=colour, linewidth=1.0)
            side.plot(*line.T[[0, 2]], color=colour, linewidth=1.0)
    for place, text in labels:
        space.text(*place, text)
    space.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]", title=f"{case.name} in {{B}}\n{where(case)}")
    space.set_aspect("equal", adjustable="datalim")
    space.legend(loc="upper left")
    above.set(xlabel="x [mm]", ylabel="y [mm]", title="from above")
    side.set(xlabel="x [mm]", ylabel="z [mm]", title="from the side, along y")
    size = float(np.ptp(points, axis=0).max())
    for axes, axes_of_view in ((above, [0, 1]), (side, [0, 2])):
        for (x, y), text in together([(place[axes_of_view], text) for place, text in labels], SAME_PLACE * size):
            axes.annotate(text, (x, y), xytext=(3, 3), textcoords="offset points", fontsize="small")
        axes.set_aspect("equal", adjustable="datalim")
        axes.grid(color="0.9")
    if case.chain is None:
        _dimensions(case, above, side, figure)
    return figure


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
