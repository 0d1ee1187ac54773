"""Interactive figures of a report, drawn with plotly: functions take data and return a figure without colours of text.

Okabe and Ito's colours (told apart by everybody) come from the page; what is set here reads on light and dark.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cases.schema import Case
from cases.units import DEG, MM
from identification.criteria import Identifiability
from identification.limit import LimitReport, Status
from identification.motion import Array, Motion
from planner.precision import bounds_text, std_text, value_text
from planner.reports.page import Block, Chart, note, plain, table, thinned

if TYPE_CHECKING:
    from identification.result import Residuals

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
GREY = "#8593a1"
MOST_SHARE = 120.0  # [%] of a limit that a chart shows
MAGNITUDE = ((0.0, "rgba(0,114,178,0)"), (1.0, "rgba(0,114,178,1)"))


def motion_blocks(case: Case, motion: Motion) -> tuple[Block, ...]:
    """Position, velocity, acceleration and jerk over time, each axis with its own limits."""
    home, box = case.need_motion("the report")
    rows = (
        ("position from home", "mm", "deg", motion.pose - home, box.pose, 1 / MM, 1 / DEG),
        ("velocity", "mm/s", "deg/s", motion.rates, _both(box.rate), 1 / MM, 1 / DEG),
        ("acceleration", "m/s²", "rad/s²", motion.accelerations, _both(box.acceleration), 1.0, 1.0),
        ("jerk", "m/s³", "rad/s³", motion.jerks, _both(box.jerk), 1.0, 1.0),
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
            for k in axes:
                x, y = thinned(motion.t, values[:, k] * factor)
                figure.add("scatter", x=x, y=y, name=plain(box.labels[k]), line={"color": colour(k), "width": 1.6})
            for row in limit[:, axes] * factor:  # grey where all axes share it
                shared = bool(np.ptp(row) <= 1e-9 * np.abs(row).max())
                own_colours = zip(row, map(colour, axes), strict=True)
                for value, c in [(row[0], GREY)] if shared else list(own_colours):
                    figure.add_line({"y": float(value)}, c)
            charts.append(figure)
    return (*charts, note("Dashed: the limit of the axis in its colour, grey where axes share it."))


def colour(k: int) -> str:
    """Of a line by its number, from 0."""
    return COLOURS[k % len(COLOURS)]


def colour_or_grey(k: int) -> str:
    """Of one of up to seven things that are compared, by its number, from 0."""
    return (*COLOURS, GREY)[k % 7]


def _both(limit: Array) -> Array:
    return np.array([-limit, limit])


_KEEPERS = {Status.PROVEN: "proven", Status.ENFORCED: "kept by the controller"}
_NOBODY = "kept by nobody"


def limits_chart(report: LimitReport) -> Chart:
    """Share of each limit that is used, in a colour for who answers for it: the proof, the controller, or nobody."""
    caption = "Largest use of each limit; 100 % is the limit."
    if nobody := [c.name for c in report.checks if c.status not in _KEEPERS]:
        caption += (
            f" No one keeps {', '.join(nobody)}: the machine must bear what is shown (cut off at {MOST_SHARE:g} %)."
        )
    names = [plain(c.name) for c in reversed(report.checks)]
    height = 130 + 30 * len(names)
    figure = Chart("limits", caption, "share of the limit [%]", height=height, showlegend=True, barmode="overlay")
    for label, colour in zip((*_KEEPERS.values(), _NOBODY), (COLOURS[5], COLOURS[2], COLOURS[1]), strict=True):
        checks = [c for c in reversed(report.checks) if _KEEPERS.get(c.status, _NOBODY) == label]
        if not checks:
            continue
        figure.add(
            "bar",
            x=[min(100 * c.ratio, MOST_SHARE) for c in checks],
            y=[plain(c.name) for c in checks],
            name=label,
            orientation="h",
            text=[f"{c.worst:.4g} of {bounds_text(c)} {c.unit}" for c in checks],
            textposition="inside",
            insidetextanchor="start",
            marker={"color": colour},
            textfont={"color": "#102a43" if label == "proven" else "#ffffff"},
        )
    figure.add_line({"x": 100}, GREY, 2, "solid")
    figure.x_axis(range=[0, MOST_SHARE])
    figure.y_axis(categoryorder="array", categoryarray=names)
    return figure


def forces_chart(residuals: "Residuals", channels: Sequence[str]) -> Chart:
    """Forces as the estimator saw them (lines) and the model's (dotted)."""
    source = "recorded" if residuals.filtered is None else "recorded, behind the evaluation's low-pass"
    caption = f"Lines: {source}. Dotted: the identified model."
    figure = Chart("forces", caption, y=f"force [{unit_of(channels)}]", height=340)
    for k, name in enumerate(channels):
        x, y = thinned(residuals.t, residuals.seen[:, k])
        figure.add("scatter", x=x, y=y, name=plain(name), line={"color": COLOURS[k], "width": 1}, legendgroup=str(k))
        x, y = thinned(residuals.t, residuals.predicted[:, k])
        dotted = {"color": COLOURS[k], "width": 2, "dash": "dot"}
        figure.add("scatter", x=x, y=y, name="model", line=dotted, legendgroup=str(k), showlegend=False)
    return _over_samples(figure, residuals)


def residuals_chart(residuals: "Residuals", channels: Sequence[str]) -> Chart:
    """Residuals of each channel over time; a long run is drawn by its extremes."""
    caption = "What the model leaves of each channel. Noise without a pattern is good; waves and steps have a cause."
    figure = Chart("residuals", caption, y=f"recorded - model [{unit_of(channels)}]", height=320)
    for k, name in enumerate(channels):
        x, y = thinned(residuals.t, residuals.left[:, k])
        figure.add("scatter", x=x, y=y, name=plain(name), line={"color": COLOURS[k], "width": 0.8})
    return _over_samples(figure, residuals)


def distribution_chart(residuals: "Residuals") -> Chart:
    """Residuals over the rms of their channel, with the density of the normal distribution."""
    values = residuals.left
    scaled = (values / np.maximum(np.sqrt(np.mean(values**2, axis=0)), 1e-300)).ravel()
    density, edges = np.histogram(scaled, bins=81, range=(-5, 5), density=True)
    x = (edges[1:] + edges[:-1]) / 2
    caption = "Residuals in units of their rms: bars that follow the line are normal noise; wide feet are gross errors."
    titles = "residual / rms of its channel", "density"
    figure = Chart("distribution", caption, *titles, half=True, height=320, bargap=0.0)
    figure.add("bar", x=x, y=density, marker={"color": GREY}, name="residuals")
    normal = np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi)
    figure.add("scatter", x=x, y=normal, name="normal distribution", line={"color": COLOURS[1]})
    return figure


def spectrum_chart(residuals: "Residuals", channels: Sequence[str], cutoff: float | None) -> Chart:
    """Amplitude spectral density of the residuals; what stands above the cut-off the evaluation does not see."""
    frequency, density = residuals.spectrum()
    caption = "Of the forces as recorded."
    if cutoff is not None:
        caption += (
            f" Dashed: the evaluation's low-pass at {cutoff:g} Hz; what lies above it, as ripple of a controller, the "
            "estimate does not see."
        )
    titles = "frequency [Hz]", f"residual [{unit_of(channels)}/√Hz]"
    figure = Chart("spectrum", caption, *titles, half=True, height=320)
    for k, name in enumerate(channels):
        line = {"color": COLOURS[k], "width": 1.2}
        figure.add(
            "scatter",
            x=frequency[1:].astype(np.float32),
            y=density[1:, k].astype(np.float32),
            name=plain(name),
            line=line,
        )
    if cutoff is not None:
        figure.add_line({"x": cutoff}, GREY)
    figure.x_axis(type="log")
    figure.y_axis(type="log")
    return figure


def _over_samples(figure: Chart, residuals: "Residuals") -> Chart:
    """The figure with its x axis: time, or standstills, each a marker."""
    if residuals.step is None:
        for trace in figure.data:
            trace.update(mode="lines+markers", marker={"size": 4})
    figure.x_axis(title={"text": "standstill" if residuals.step is None else "time [s]"})
    return figure


def unit_of(channels: Sequence[str]) -> str:
    """`fx_N`, `mz_Nm`: the units that the names of the channels end in."""
    return ", ".join(dict.fromkeys(name.rsplit("_", 1)[-1].replace("Nm", "N m") for name in channels))


def identifiability_blocks(found: Identifiability) -> tuple[Block, ...]:
    """Chart 3 of the paper, magnitudes of correlations and of R of the scaled regressor, and the strongest pairs."""
    panels = (
        ("correlation", np.abs(found.correlation), "Magnitude of the correlation of the regressor's columns."),
        ("qr", np.abs(found.r), "Magnitude of R of the scaled regressor: what stands right of the diagonal is shared."),
    )
    names = [plain(name) for name in found.names]
    charts = []
    for name, values, caption in panels:
        bar = {"thickness": 12, "outlinewidth": 0}
        figure = Chart(name, caption, half=True, height=460)
        figure.add(
            "heatmap", z=values.astype(np.float32), x=names, y=names, zmin=0, zmax=1, colorscale=MAGNITUDE, colorbar=bar
        )
        figure.y_axis(autorange="reversed", tickfont={"size": 10})
        figure.x_axis(tickfont={"size": 10}, tickangle=-90)
        charts.append(figure)
    rows = ((f"{a} ~ {b}", f"{value:+.3f}") for a, b, value in found.strongest())
    return (*charts, table(("strongest correlations", "value"), rows))


def errors_chart(rows: Sequence[dict[str, Any]]) -> Chart:
    """Estimate less truth in standard deviations, with the 95 % and the 4 sigma band."""
    names = [plain(r["name"]) for r in rows]
    errors = [r["error"] / r["std"] for r in rows]
    caption = (
        "Points: estimate less truth in reported standard deviations, one standard deviation as the bar; bands: 95 % "
        "and 4 standard deviations."
    )
    figure = Chart("errors", caption, y="(estimate - truth) / std", height=380)
    for half, opacity in ((4.0, 0.10), (1.96, 0.16)):
        figure.add_band(half, COLOURS[0], opacity)
    bars = {"type": "constant", "value": 1.0, "thickness": 1.2, "width": 5}
    figure.add(
        "scatter",
        x=names,
        y=errors,
        mode="markers",
        marker={"color": COLOURS[0], "size": 9},
        error_y=bars,
        showlegend=False,
    )
    reach = max(5.0, 1.15 * max(abs(e) for e in errors))
    figure.x_axis(tickangle=-45)
    figure.y_axis(range=[-reach, reach])
    return figure


def parameters_chart(parameters: dict[str, dict[str, Any]]) -> Chart:
    """Each parameter with its 95 % interval, as a share of the largest parameter of its unit."""
    names = list(parameters)
    largest: dict[str, float] = {}
    for p in parameters.values():
        largest[p["unit"]] = max(largest.get(p["unit"], 0.0), abs(p["value"]), 1e-300)
    caption = "Error bars of all parameters on one scale: as a share of the largest parameter of the same unit."
    figure = Chart("parameters", caption, y="half width of the 95 % interval [%]", height=360)
    for key, label, colour in (("std_robust", "robust", COLOURS[1]), ("std", "(28)", COLOURS[0])):
        width = [1.96 * parameters[n][key] / largest[parameters[n]["unit"]] * 100 for n in names]
        text = [
            f"{value_text(parameters[n]['value'], parameters[n][key])} ± {std_text(1.96 * parameters[n][key])} "
            f"{parameters[n]['unit']}"
            for n in names
        ]
        figure.add(
"scatter",
            x=[plain(n) for n in names], y=width, name=label, mode="markers", marker={"size": 9, "color": colour},
            hovertext=text, hoverinfo="text+name",
        )  # fmt: skip
    figure.x_axis(tickangle=-45)
    figure.y_axis(type="log", dtick="D2")
    return figure
