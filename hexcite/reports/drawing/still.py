"""A figure as a picture that stands still: what is printed, and what is seen before, or without, a page's script.

Matplotlib draws it, as wide as a sheet of paper, so that words on it have their size in print.
"""

import io
import re
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from mpl_toolkits.mplot3d.axes3d import Axes3D

from cases.base.errors import legible
from hexcite.reports.drawing.chart import COLOURS, Axis, Box, Chart, Heat, Line, Points, thinned
from hexcite.reports.drawing.scene import Scene

WIDE, HALF = 7.2, 3.55  # widths that A4 and Letter have room for [inch]
PIXELS = 110.0  # of a figure's height on the page for an inch of its picture
DASHES = {"solid": "-", "dash": "--", "dot": ":"}
STYLE: dict[Any, Any] = {
    "font.size": 8, "font.family": ["DejaVu Sans", "sans-serif"],
    "axes.edgecolor": "#bbbbbb", "axes.grid": True, "grid.color": "#dddddd", "grid.linewidth": 0.6,
    "axes.linewidth": 0.6, "xtick.color": "#333333", "ytick.color": "#333333", "axes.axisbelow": True,
    "text.usetex": False, "svg.hashsalt": "hexcite", "svg.fonttype": "none",
    "legend.frameon": False, "path.simplify_threshold": 0.5,
}  # fmt: skip
MOST_POINTS = 700  # of a line, which is printed some 1000 dots wide
MOST_PICTURES = 6  # of a machine in some of its poses
SIDE, ALONE = 2.3, 4.4  # width and height of each of these, and of a single one [inch]


class NotebookFigure(Figure):
    """A figure that a notebook shows, also where nothing has set matplotlib up for it."""

    def _repr_png_(self) -> bytes:
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=PIXELS)
        return picture.getvalue()


def drawn(charts: Sequence[Chart]) -> Figure:
    """Figures below each other, two halves side by side, as one by matplotlib."""
    rows: list[list[Chart]] = []
    for chart in charts:
        if chart.half and rows and len(rows[-1]) == 1 and rows[-1][0].half:
            rows[-1].append(chart)
        else:
            rows.append([chart])
    heights = [max(chart.height for chart in row) / PIXELS for row in rows]
    width = HALF if all(len(row) == 1 and row[0].half for row in rows) else WIDE
    with mpl.rc_context(STYLE):
        figure = NotebookFigure(figsize=(width, sum(heights)), layout="constrained")
        stack = figure.subfigures(len(rows), 1, height_ratios=heights, squeeze=False)[:, 0]
        for row, below in zip(rows, stack, strict=True):
            for chart, part in zip(row, below.subfigures(1, len(row), squeeze=False)[0], strict=True):
                _draw(part.add_subplot(), chart)
                if chart.legend:
                    part.legend(loc="outside upper left", ncols=3 if chart.half else 6)
    return figure


def picture(chart: Chart) -> str:
    """The picture of a figure as SVG."""
    return _svg(drawn([chart]))


def _svg(figure: Figure) -> str:
    text = io.StringIO()
    canvas: Any = FigureCanvasSVG(figure)  # its functions state no types
    with mpl.rc_context(STYLE):  # savefig would draw everything twice, to lay it out first: drawing does so by itself
        canvas.print_svg(text, metadata={"Date": None})
    return legible(_PATH.sub(lambda path: _DIGITS.sub(r"\1", path[0]), text.getvalue()))


_PATH = re.compile(r' d="[^"]*"')
_DIGITS = re.compile(r"(\.\d\d)\d+")  # a hundredth of a point is finer than any printer's dot


def _plain(text: str) -> str:
    """Text of which matplotlib, which reads formulas between dollars, shows every character as it is."""
    return text.replace("$", r"\$")


def _draw(axes: Axes, chart: Chart) -> None:
    for band in chart.bands:
        axes.axhspan(-band.half, band.half, color=band.colour, alpha=band.opacity, linewidth=0)
    boxes = [series for series in chart.series if isinstance(series, Box)]
    for series in chart.series:
        label = _plain(series.name) if isinstance(series, Line | Points) and series in chart.legend else None
        match series:
            case Line():
                marks: dict[str, Any] = {"marker": "o", "markersize": 2.5} if series.dots else {}
                width, dash = 0.75 * series.width, DASHES[series.dash]
                points = thinned(series.x, series.y, MOST_POINTS)
                axes.plot(*points, label=label, color=series.colour, linewidth=width, linestyle=dash, **marks)
            case Points():
                dot: dict[str, Any] = {"markersize": 5, "markerfacecolor": "none" if series.hollow else series.colour}
                bars: dict[str, Any] = (
                    {"yerr": series.bar, "capsize": 2, "elinewidth": 0.8} if np.any(series.bar) else {}
                )
                axes.errorbar(series.x, series.y, fmt="o", color=series.colour, label=label, **dot, **bars)
            case Heat():
                image = axes.imshow(series.values, vmin=0.0, vmax=1.0, cmap="Blues", aspect="auto")
                axes.figure.colorbar(image, ax=axes, fraction=0.03, pad=0.01)
                axes.grid(visible=False)
            case Box():
                pass  # all of them together, below
    if boxes:
        axes.boxplot([list(box.values) for box in boxes], tick_labels=[_plain(box.name) for box in boxes])
    for rule in chart.rules:
        across = axes.axvline if rule.axis == "x" else axes.axhline
        across(rule.value, color=rule.colour, linestyle=DASHES[rule.dash], linewidth=0.8)
    for letter, axis in (("x", chart.x), ("y", chart.y)):
        _set_axis(axes, letter, axis, any(isinstance(series, Heat) for series in chart.series))


DECADES = 100.0  # ratio of the ends of a logarithmic axis, beyond which powers of ten are marks enough
MOST_TICKS = 6  # intervals along an axis, whose numbers stand side by side in half the width of a page
DOT = 0.03  # share of the width that is left for a dot at an end


def _set_axis(axes: Axes, letter: str, axis: Axis, heat: bool) -> None:
    this_axis = axes.xaxis if letter == "x" else axes.yaxis
    this_axis.set_label_text(_plain(axis.title))
    if axis.logarithmic:
        (axes.set_xscale if letter == "x" else axes.set_yscale)("log")
        low, high = axes.get_xlim() if letter == "x" else axes.get_ylim()
        steps = (1.0,) if high > DECADES * low else (1.0, 2.0, 5.0)
        this_axis.set_major_locator(LogLocator(subs=steps))
        this_axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        this_axis.set_minor_formatter(NullFormatter())
    elif letter == "x" and not axis.names and not heat:
        this_axis.set_major_locator(MaxNLocator(MOST_TICKS))
    if axis.names:
        this_axis.set_ticks(list(range(len(axis.names))), labels=[_plain(name) for name in axis.names])
        this_axis.set_tick_params(labelrotation=axis.tilt, labelsize=7)
        this_axis.grid(visible=False)
    if axis.ends is not None:
        (axes.set_xlim if letter == "x" else axes.set_ylim)(*axis.ends)
    elif letter == "x" and not axis.names and axes.lines and not heat:
        dotted = any(line.get_marker() not in ("None", "", None) for line in axes.lines)
        axes.margins(x=DOT if dotted else 0.0)


def machine_picture(scene: Scene) -> str:
    """The picture of a machine as SVG."""
    return _svg(machine_figure(scene))


def machine_figure(scene: Scene) -> Figure:
    """A machine at the start of its path, with the path; in some of its poses, where it has such."""
    count = min(MOST_PICTURES, len(scene.t)) if scene.steps else 1
    frames = np.unique(np.linspace(0, len(scene.t) - 1, count).round().astype(int)) if scene.steps else np.zeros(1, int)
    columns = min(3, len(frames))
    side = SIDE if len(frames) > 1 else ALONE
    with mpl.rc_context(STYLE):
        figure = NotebookFigure(figsize=(columns * side, -(-len(frames) // columns) * side), layout="constrained")
        for place, k in enumerate(frames, 1):
            axes: Axes3D = figure.add_subplot(-(-len(frames) // columns), columns, place, projection="3d")
            _draw_machine(axes, scene, int(k), small=len(frames) > 1)
        handles, names = figure.axes[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside upper left", ncols=_beside(names, columns * side))
    return figure


LETTER, HANDLE = 0.075, 0.5  # widths in a legend: of a letter, and of a line with the room beside it [inch]


def _beside(names: Sequence[str], width: float) -> int:
    """How many names of a legend stand beside each other in a width [inch]; columns are as wide as their names."""
    for count in range(min(6, len(names)), 1, -1):
        columns = np.array_split([len(name) for name in names], count)
        if sum(HANDLE + LETTER * max(column) for column in columns) <= width:
            return count
    return 1


def _draw_machine(axes: Axes3D, scene: Scene, k: int, small: bool) -> None:
    for part in scene.parts:
        for number, line in enumerate(part.placed(scene, k)):
            label = _plain(part.name) if number == 0 and part.in_legend else None
            marks: dict[str, Any] = {"marker": "o", "markersize": 3} if len(line) == 1 else {}
            axes.plot(*line.T, color=part.colour, linewidth=0.25 * part.width, label=label, **marks)
    if not scene.steps:
        axes.plot(*scene.path.T, color=COLOURS[2], linewidth=0.8, label="path")
    axes.set(xlim=scene.ends[0], ylim=scene.ends[1], zlim=scene.ends[2])
    axes.set_box_aspect(np.ptp(scene.ends, axis=1))
    axes.view_init(elev=20.0, azim=-50.0)
    axes.tick_params(labelsize=5 if small else 7, pad=-2)
    if small:
        axes.set_title(f"pose {k + 1}", fontsize=8, y=0.95)
    else:
        axes.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
