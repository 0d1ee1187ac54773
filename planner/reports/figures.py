"""Interactive figures of a report, drawn with plotly: functions take data and return a figure without colours of text.

Okabe and Ito's colours (everybody can distinguish them) come from the page; what is set here reads on light and dark.
"""

from collections.abc import Sequence

import numpy as np

from cases.schema import Case
from cases.units import DEG, MM
from identification.limit import LimitReport, Status
from identification.motion import Motion
from identification.precision import bounds_text
from planner.reports.page import COLOURS, GREY, Chart, colour

MOST_SHARE = 120.0  # [%] largest share of a limit that a chart shows


def motion_blocks(case: Case, motion: Motion) -> tuple[Chart, ...]:
    """Position, velocity and acceleration over time, each axis with its own limits."""
    home, box = case.need_motion("the report")
    rows = (
        ("position from home", "mm", "deg", motion.pose - home, box.pose, 1 / MM, 1 / DEG),
        ("velocity", "mm/s", "deg/s", motion.rates, np.outer((-1, 1), box.rate), 1 / MM, 1 / DEG),
        ("acceleration", "m/s²", "rad/s²", motion.accelerations, np.outer((-1, 1), box.acceleration), 1.0, 1.0),
    )
    charts = []
    for name, length_unit, angle_unit, values, limit, to_length, to_angle in rows:
        for kind, own, unit, factor in (
            ("translation", ~box.turns, length_unit, to_length),
            ("rotation", box.turns, angle_unit, to_angle),
        ):
            if not own.any():
                continue
            caption = (
                f"{name[0].upper()}{name[1:]} of each {kind} over time; dashed: the limits of the axis in its colour."
            )
            key = f"{name.split()[0]}-{kind}"
            labels = [label for label, its in zip(box.labels, own, strict=True) if its]
            figure = Chart(key, caption, "time [s]", f"{name} [{unit}]", half=not own.all(), height=280)
            figure.add_lines(motion.t, values[:, own] * factor, labels, 1.6)
            for row in limit[:, own] * factor:
                for k, value in enumerate(row):
                    figure.add_line({"y": float(value)}, colour(k))
            charts.append(figure)
    return tuple(charts)


FILLS = {Status.PROVEN: COLOURS[5], Status.ENFORCED: COLOURS[2]}  # of all others COLOURS[1]


def limits_chart(report: LimitReport) -> Chart:
    """Share of each limit that is used, coloured by who guarantees it: the proof, the controller, or nobody."""
    caption = "Largest use of each limit; 100 % is the limit. Blue: proven; green: enforced by the controller."
    if nobody := [c.name for c in report.checks if c.status not in FILLS]:
        caption += (
            f" Orange: nobody enforces {', '.join(nobody)}; the machine must bear what is shown (cut off at "
            f"{MOST_SHARE:g} %)."
        )
    checks = report.checks[::-1]
    figure = Chart("limits", caption, "share of the limit [%]", height=130 + 30 * len(checks))
    figure.add(
        "bar",
        x=[min(100 * c.ratio, MOST_SHARE) for c in checks],
        y=[c.name for c in checks],
        orientation="h",
        text=[f"{c.worst:.4g} of {bounds_text(c)} {c.unit}" for c in checks],
        textposition="inside",
        insidetextanchor="start",
        marker={"color": [FILLS.get(c.status, COLOURS[1]) for c in checks]},
        textfont={"color": ["#102a43" if c.status is Status.PROVEN else "#ffffff" for c in checks]},
    )
    figure.add_line({"x": 100}, GREY, 2, "solid")
    figure.axes({"range": [0, MOST_SHARE]})
    return figure


def unit_of(channels: Sequence[str]) -> str:
    """The units in which the names of the channels end, such as `fx_N`, `mz_Nm`."""
    return ", ".join(dict.fromkeys(name.rsplit("_", 1)[-1].replace("Nm", "N m") for name in channels))
