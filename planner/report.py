"""The page of a demo run: one HTML file, no network, plots that can be zoomed."""

from importlib.metadata import version
from typing import Any

import numpy as np
import plotly.graph_objects as go
import plotly.io
from jinja2 import Environment, PackageLoader, StrictUndefined
from numpy.typing import NDArray
from plotly.subplots import make_subplots

from cases.schema import Case
from cases.units import DEG, MM
from identification.motion import Trajectory, sample
from identification.path import instants
from identification.result import Estimate
from planner.plots import AXES
from planner.running import Outcome

Array = NDArray[np.float64]

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # Okabe and Ito: told apart by everybody
DRAWN_RATE = 100.0  # [1/s]: enough for the eye, keeps the page small
LAYOUT = {
    "template": "plotly_white",
    "margin": {"l": 60, "r": 20, "t": 40, "b": 40},
    "font": {"family": "system-ui, sans-serif", "size": 13},
    "legend": {"orientation": "h", "y": 1.08, "x": 1.0, "xanchor": "right"},
}


def demo_page(case: Case, answer: dict[str, Any], outcome: Outcome, estimate: Estimate) -> str:
    """The page of a demo.

    Args:
        case: what it ran on.
        answer: JSON answers of the steps: plan, post, check, run, identify, truth.
        outcome: the run.
        estimate: the result.
    """
    figures = {
        "trajectory": trajectory_figure(case, outcome.planned),
        "limits": limits_figure(answer["check"]["limits"]),
        "executed": executed_figure(outcome),
        "residuals": residuals_figure(estimate),
        "errors": errors_figure(answer["truth"]),
    }
    environment = Environment(
        loader=PackageLoader("planner"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    worst = max(abs(r["error"]) / r["std"] for r in answer["truth"])
    return environment.get_template("demo.html.j2").render(
        version=version("hexcite"),
        case=case,
        steps=answer,
        worst=worst,
        delay=estimate.delay,
        script=plotly.io.to_html(go.Figure(), include_plotlyjs="inline", full_html=False),
        plots={name: _html(name, figure) for name, figure in figures.items()},
    )


def _html(name: str, figure: go.Figure) -> str:
    figure.update_layout(**LAYOUT)
    config = {"displaylogo": False, "responsive": True}
    return str(plotly.io.to_html(figure, include_plotlyjs=False, full_html=False, div_id=f"plot-{name}", config=config))


def trajectory_figure(case: Case, planned: Trajectory) -> go.Figure:
    """Position, velocity and acceleration of the planned excitation with the limits of each."""
    machine, _, limits = case.need_machine("the report")
    box, motion = limits.motion, sample(planned, DRAWN_RATE)
    rows = (
        ("position", "mm", "deg", motion.pose - machine.home.vector, np.abs(box.pose).max(axis=0), 1 / MM, 1 / DEG),
        ("velocity", "mm/s", "deg/s", motion.rates, box.rate, 1 / MM, 1 / DEG),
        ("acceleration", "m/s²", "rad/s²", motion.accelerations, box.acceleration, 1.0, 1.0),
    )
    figure = make_subplots(rows=3, cols=2, shared_xaxes=True, vertical_spacing=0.05, horizontal_spacing=0.09)
    for row, (name, length_unit, angle_unit, values, limit, to_length, to_angle) in enumerate(rows, start=1):
        for column, (axes, unit, factor) in enumerate(
            ((range(3), length_unit, to_length), (range(3, 6), angle_unit, to_angle)), start=1
        ):
            for k in axes:
                line = {"color": COLOURS[k], "width": 1.6}
                trace = go.Scatter(
                    x=motion.t,
                    y=values[:, k] * factor,
                    name=AXES[k],
                    line=line,
                    legendgroup=AXES[k],
                    showlegend=row == 1,
                )
                figure.add_trace(trace, row, column)
            for value in np.unique(limit[list(axes)]) * factor:
                for side in (-value, value):
                    figure.add_hline(y=side, line={"color": "#888", "dash": "dash", "width": 1}, row=row, col=column)
            figure.update_yaxes(title_text=f"{name} [{unit}]", row=row, col=column)
    figure.update_xaxes(title_text="time [s]", row=3)
    return figure.update_layout(height=760)


def limits_figure(limits: dict[str, dict[str, Any]]) -> go.Figure:
    """Share of each proven limit that the program uses."""
    proven = {k: v for k, v in limits.items() if v["status"] == "proven"}
    names = [v["at"] for v in proven.values()][::-1]
    shares = [100 * v["ratio"] for v in proven.values()][::-1]
    words = [f"{v['worst']:.4g} of {v['limit']:.4g} {v['unit']}" for v in proven.values()][::-1]
    bars = go.Bar(
        x=shares, y=names, orientation="h", text=words, textposition="inside", insidetextanchor="start",
        marker_color=COLOURS[5], textfont_color="#102a43",
    )  # fmt: skip
    figure = go.Figure(bars)
    figure.add_vline(x=100, line={"color": COLOURS[1], "width": 2})
    figure.update_xaxes(title_text="share of the limit [%]", range=[0, 108])
    return figure.update_layout(height=110 + 30 * len(names))


def executed_figure(outcome: Outcome) -> go.Figure:
    """Accelerations along x, y, z that the controller really made, beside the planned ones."""
    t = instants(outcome.run.trigger, DRAWN_RATE * 2)
    executed = outcome.run.execution.kinematics(t)
    planned = sample(outcome.planned, DRAWN_RATE * 2)
    figure = go.Figure()
    for k in range(3):
        line = {"color": COLOURS[k], "width": 1}
        figure.add_trace(go.Scatter(x=t - t[0], y=executed.twist_rate[:, k], name=f"{AXES[k]} executed", line=line))
        dashed = {"color": COLOURS[k], "width": 2, "dash": "dot"}
        figure.add_trace(go.Scatter(x=planned.t, y=planned.accelerations[:, k], name=f"{AXES[k]} planned", line=dashed))
    figure.update_xaxes(title_text="time since the trigger [s]")
    figure.update_yaxes(title_text="acceleration [m/s²]")
    return figure.update_layout(height=380)


def residuals_figure(estimate: Estimate) -> go.Figure:
    """Force residuals over time (drawn thinned) and their distribution."""
    residuals = estimate.residuals
    stride = max(1, len(residuals) // 1500)
    figure = make_subplots(rows=1, cols=2, column_widths=[0.75, 0.25], shared_yaxes=True, horizontal_spacing=0.03)
    for k in range(6):
        line = {"color": COLOURS[k], "width": 0.8}
        y = residuals[::stride, k]
        x = np.arange(len(y)) * stride
        figure.add_trace(go.Scatter(x=x, y=y, name=f"f{k + 1}", line=line), 1, 1)
    counts, edges = np.histogram(residuals, bins=80)
    figure.add_trace(
        go.Bar(y=(edges[1:] + edges[:-1]) / 2, x=counts, orientation="h", marker_color="#9aa5b1", showlegend=False),
        1,
        2,
    )
    figure.update_xaxes(title_text="sample", col=1)
    figure.update_xaxes(title_text="count", col=2)
    figure.update_yaxes(title_text="residual [N]", col=1)
    return figure.update_layout(height=360)


def errors_figure(rows: list[dict[str, Any]]) -> go.Figure:
    """Estimate less truth in standard deviations, with the 95 % and the 4 sigma band."""
    names = [r["name"] for r in rows]
    errors = [r["error"] / r["std"] for r in rows]
    figure = go.Figure()
    for half, colour in ((4.0, "#eef3f8"), (1.96, "#d6e4f0")):
        figure.add_hrect(y0=-half, y1=half, fillcolor=colour, line_width=0, layer="below")
    bars = {"type": "constant", "value": 1.0, "color": "#102a43", "thickness": 1.2, "width": 5}
    figure.add_trace(
        go.Scatter(x=names, y=errors, mode="markers", marker={"color": COLOURS[0], "size": 9}, error_y=bars)
    )
    figure.add_hline(y=0, line={"color": "#102a43", "width": 1})
    figure.update_yaxes(title_text="(estimate - truth) / std", range=[-5, 5])
    return figure.update_layout(height=380, showlegend=False)
