"""Figure of a file of unknown format: its channels over time, those that belong together in one panel."""

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from cases.recording_format import CLOCK
from identification.formats.looked import CLOCKS, Column, Look
from identification.formats.naming import GROUPS

Array = NDArray[np.float64]

MOST = 4000  # points of a line; more cannot be seen
_TITLES = (
    "struts", "strut velocities", "drive positions", "drive velocities", "pose", "rotation", "accelerometer", "forces",
    "forces and moments",
)  # fmt: skip
_PANEL = 2.2  # inches


def look_figure(found: Look) -> Figure:
    """Every column of numbers over time, or over the rows where there is no clock."""
    panels = list(_panels(found.columns))
    figure = Figure(figsize=(11, _PANEL * len(panels) + 0.6), layout="constrained")
    t, label = _time(found)
    step = -(-found.rows // MOST)
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
        return (clock.values - clock.values[0]) * CLOCKS[clock.unit], "time from the first row [s]"
    period = report.settings.get("clock", {}).get("period_ms")
    if period is not None:
        return np.arange(report.rows) * period / 1e3, "time from the first row [s]"
    return np.arange(1.0, report.rows + 1.0), "row"


def _panels(columns: Sequence[Column]) -> Iterator[tuple[str, list[Column]]]:
    """Titles and columns of the panels: groups that are known, then single columns, then what means nothing."""
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
