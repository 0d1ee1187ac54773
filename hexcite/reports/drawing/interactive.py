"""A figure as plotly draws it: its traces and layout; colours of text, grid and background are the page's."""

from typing import Any, assert_never

import numpy as np

from hexcite.reports.drawing.chart import Axis, Box, Chart, Heat, Line, Points, Rule, Series

STRENGTH = ((0.0, "rgba(0,114,178,0)"), (1.0, "rgba(0,114,178,1)"))  # colours of a `Heat`


def plotly_figure(chart: Chart) -> dict[str, Any]:
    """Data and layout of a figure by attributes of plotly's reference.

    Plotly's Python classes check each value anew, which takes longer than all else on a page; tests let them check it.
    """
    shapes = [_across(rule) for rule in chart.rules]
    for band in chart.bands:
        place = {"xref": "x domain", "yref": "y", "x0": 0, "x1": 1, "y0": -band.half, "y1": band.half}
        look = {"fillcolor": band.colour, "opacity": band.opacity, "line": {"width": 0}, "layer": "below"}
        shapes.append({"type": "rect", **place, **look})
    layout = {
        "height": chart.height,
        "xaxis": _axis(chart.x),
        "yaxis": _axis(chart.y),
        "shapes": shapes,
        "showlegend": bool(chart.legend),
    }
    return {"data": [_trace(series, chart) for series in chart.series], "layout": layout}


def _axis(axis: Axis) -> dict[str, Any]:
    entries: dict[str, Any] = {"title": {"text": axis.title}} if axis.title else {}
    if axis.logarithmic:
        entries |= {"type": "log"}
    if axis.ends is not None:
        entries |= {"range": list(axis.ends[::-1] if axis.downwards else axis.ends)}
    elif axis.downwards:
        entries |= {"autorange": "reversed"}
    if axis.names:
        ticks = {"tickvals": list(range(len(axis.names))), "ticktext": list(axis.names), "tickangle": -axis.tilt}
        entries |= {**ticks, "showgrid": False, "zeroline": False}
    return entries


def _trace(series: Series, chart: Chart) -> dict[str, Any]:
    match series:
        case Line():
            line = {"color": series.colour, "width": series.width, "dash": series.dash}
            legend = {"name": series.name, "legendgroup": series.name, "showlegend": series.in_legend}
            marks = {"mode": "lines+markers", "marker": {"size": 4}} if series.dots else {"mode": "lines"}
            points = {"x": series.x.astype(np.float32), "y": series.y.astype(np.float32)}
            return {"type": "scatter", **points, **legend, "line": line, **marks}
        case Points():
            symbol = "circle-open" if series.hollow else "circle"
            marker = {"size": 8, "color": series.colour, "symbol": symbol}
            trace: dict[str, Any] = {"type": "scatter", "x": series.x, "y": series.y, "mode": "markers"}
            trace |= {"name": series.name, "showlegend": series.in_legend, "marker": marker}
            if np.any(series.bar):
                bars = np.broadcast_to(series.bar, series.y.shape).tolist()
                trace["error_y"] = {"type": "data", "array": bars, "thickness": 1.2, "width": 5}
            if series.words:
                trace |= {"text": list(series.words), "hovertemplate": "%{text}<extra></extra>"}
            return trace
        case Heat():
            bar = {"thickness": 12, "outlinewidth": 0}
            values = {"z": series.values.astype(np.float32), "zmin": 0, "zmax": 1}
            names = {"x": list(chart.x.names), "y": list(chart.y.names)}
            return {"type": "heatmap", **names, **values, "colorscale": STRENGTH, "colorbar": bar}
        case Box():
            return {
                "type": "box",
                "y": list(series.values),
                "name": series.name,
                "boxpoints": "all",
                "showlegend": False,
            }
        case _:
            assert_never(series)


def _across(rule: Rule) -> dict[str, Any]:
    along = "y" if rule.axis == "x" else "x"
    place = {f"{along}ref": f"{along} domain", f"{rule.axis}ref": rule.axis, f"{along}0": 0, f"{along}1": 1}
    ends = {f"{rule.axis}0": rule.value, f"{rule.axis}1": rule.value}
    return {"type": "line", **place, **ends, "line": {"color": rule.colour, "dash": rule.dash, "width": 1}}
