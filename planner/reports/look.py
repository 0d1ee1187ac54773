"""The page of a file of unknown format: its channels over time, those that belong together in one figure."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from cases.files import provenance
from cases.recording_format import CLOCK
from identification.formats.looked import CLOCKS, Column, Look
from identification.formats.naming import GROUPS
from planner.reports.charts import Chart, plain, thinned
from planner.reports.page import Note, Page, Plot, Section

Array = NDArray[np.float64]

_TITLES = (
    "struts", "strut velocities", "drive positions", "drive velocities", "pose", "rotation", "accelerometer", "forces",
    "forces and moments",
)  # fmt: skip


def look_page(found: Look) -> Page:
    """Every column of numbers over time, or over the rows where there is no clock."""
    t, label = _time(found)
    plots = []
    for k, (title, columns) in enumerate(_panels(found.columns)):
        figure = Chart()
        for column in columns:
            x, y = thinned(t, np.asarray(column.values, dtype=float))
            figure.add_scatter(x=x, y=y, name=plain(_legend(column)), line={"width": 1})
        units = {column.unit for column in columns if column.unit}
        figure.update_xaxes(title=label)
        figure.update_yaxes(title=f"[{plain(units.pop())}]" if len(units) == 1 else "")
        plots.append(Plot(f"panel-{k}", figure.update_layout(height=280, showlegend=True), f"{title.capitalize()}."))
    return Page(
        title=f"Look at {found.file.name}",
        lead=f"{found.rows} rows. What each column is taken for stands behind it; ? marks a guess by its values.",
        inputs=(("recording", str(found.file)), *provenance([])["versions"].items()),
        warnings=tuple(found.odd),
        sections=(Section("Channels", tuple(plots) or (Note("There are no columns of numbers."),)),),
    )


def _legend(column: Column) -> str:
    name = column.name if column.ours in (None, column.name) else f"{column.name} = {column.ours}"
    return name + (" ?" if column.guessed else "")


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
