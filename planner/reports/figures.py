"""Interactive figures of a report, drawn with plotly: functions take data and return a figure without colours of text.

Okabe and Ito's colours (everybody can distinguish them) come from the page; what is set here reads on light and dark.
"""

from collections.abc import Sequence

import numpy as np

from cases.schema import Case
from cases.units import DEG, MM
from identification.criteria import Identifiability
from identification.limit import LimitReport, Status
from identification.motion import Motion
from planner.precision import bounds_text
from planner.reports.page import COLOURS, GREY, Block, Chart, colour, note, table

MOST_SHARE = 120.0  # [%] largest share of a limit that a chart shows
MAGNITUDE = ((0.0, "rgba(0,114,178,0)"), (1.0, "rgba(0,114,178,1)"))


def motion_blocks(case: Case, motion: Motion) -> tuple[Block, ...]:
    """Position, velocity, acceleration and jerk over time, each axis with its own limits."""
    home, box = case.need_motion("the report")
    rows = (
        ("position from home", "mm", "deg", motion.pose - home, box.pose, 1 / MM, 1 / DEG),
        ("velocity", "mm/s", "deg/s", motion.rates, np.outer((-1, 1), box.rate), 1 / MM, 1 / DEG),
        ("acceleration", "m/s²", "rad/s²", motion.accelerations, np.outer((-1, 1), box.acceleration), 1.0, 1.0),
        ("jerk", "m/s³", "rad/s³", motion.jerks, np.outer((-1, 1), box.jerk), 1.0, 1.0),
    )
    charts: list[Block] = []
    for name, length_unit, angle_unit, values, limit, to_length, to_angle in rows:
        for kind, own, unit, factor in (
            ("translation", ~box.turns, length_unit, to_length),
            ("rotation", box.turns, angle_unit, to_angle),
        ):
            axes = [int(k) for k in np.flatnonzero(own)]
            if not axes:
                continue
            caption = f"{name[0].upper()}{name[1:]} of each {kind} over time; dashed: its limits."
            if name == "jerk" and not np.any(values) and np.any(motion.accelerations):
                caption = (
                    "Accelerations step, and the jerk between the steps is zero: limits of jerk do not count here."
                )
            key, half = f"{name.split()[0]}-{kind}", not own.all()
            figure = Chart(key, caption, "time [s]", f"{name} [{unit}]", half=half, height=280)
            figure.add_lines(motion.t, values[:, axes] * factor, [box.labels[k] for k in axes], 1.6)
            for row in limit[:, axes] * factor:  # grey where all axes share it
                shared = bool(np.ptp(row) <= 1e-9 * np.abs(row).max())
                for k, value in enumerate(row[:1] if shared else row):
                    figure.add_line({"y": float(value)}, GREY if shared else colour(k))
            charts.append(figure)
    return (*charts, note("Dashed: the limit of the axis in its colour, grey where axes share it."))


_ENFORCED = {Status.PROVEN: "proven", Status.ENFORCED: "enforced by the controller"}
_NOBODY = "enforced by nobody"


def limits_chart(report: LimitReport) -> Chart:
    """Share of each limit that is used, coloured by who guarantees it: the proof, the controller, or nobody."""
    caption = "Largest use of each limit; 100 % is the limit."
    if nobody := [c.name for c in report.checks if c.status not in _ENFORCED]:
        caption += (
            f" Nobody enforces {', '.join(nobody)}: the machine must bear what is shown (cut off at {MOST_SHARE:g} %)."
        )
    names = [c.name for c in reversed(report.checks)]
    height = 130 + 30 * len(names)
    figure = Chart("limits", caption, "share of the limit [%]", height=height, showlegend=True, barmode="overlay")
    for label, fill in zip((*_ENFORCED.values(), _NOBODY), (COLOURS[5], COLOURS[2], COLOURS[1]), strict=True):
        checks = [c for c in reversed(report.checks) if _ENFORCED.get(c.status, _NOBODY) == label]
        if not checks:
            continue
        figure.add(
            "bar",
            x=[min(100 * c.ratio, MOST_SHARE) for c in checks],
            y=[c.name for c in checks],
            name=label,
            orientation="h",
            text=[f"{c.worst:.4g} of {bounds_text(c)} {c.unit}" for c in checks],
            textposition="inside",
            insidetextanchor="start",
            marker={"color": fill},
            textfont={"color": "#102a43" if label == "proven" else "#ffffff"},
        )
    figure.add_line({"x": 100}, GREY, 2, "solid")
    figure.axes({"range": [0, MOST_SHARE]}, {"categoryorder": "array", "categoryarray": names})
    return figure


def unit_of(channels: Sequence[str]) -> str:
    """The units in which the names of the channels end, such as `fx_N`, `mz_Nm`."""
    return ", ".join(dict.fromkeys(name.rsplit("_", 1)[-1].replace("Nm", "N m") for name in channels))


def identifiability_blocks(found: Identifiability) -> tuple[Block, ...]:
    """Chart 3 of the paper, magnitudes of correlations and of R of the scaled regressor, and the strongest pairs."""
    panels = (
        ("correlation", np.abs(found.correlation), "Magnitude of the correlation of the regressor's columns."),
        ("qr", np.abs(found.r), "Magnitude of R of the scaled regressor: what stands right of the diagonal is shared."),
    )
    charts = []
    for name, values, caption in panels:
        bar = {"thickness": 12, "outlinewidth": 0}
        figure = Chart(name, caption, half=True, height=460)
        both = {"x": found.names, "y": found.names}
        figure.add("heatmap", z=values.astype(np.float32), zmin=0, zmax=1, colorscale=MAGNITUDE, colorbar=bar, **both)
        small = {"tickfont": {"size": 10}}
        figure.axes({**small, "tickangle": -90}, {**small, "autorange": "reversed"})
        charts.append(figure)
    rows = ((f"{a} ~ {b}", f"{value:+.3f}") for a, b, value in found.strongest())
    return (*charts, table(("strongest correlations", "value"), rows))
