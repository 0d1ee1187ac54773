"""Charts: interactive figures as data for plotly's JavaScript, by plotly's own names.

Plotly's Python classes check each value anew, which took longer than all else on a page; tests let them check pages.
"""

import base64
import html
import json
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from identification.motion import Array

CLOSE, FAR = [1, 1.1, 1.2, 1.5, 2, 3, 4], [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]  # labels, for the largest ratio
SPREAD = 0.7  # of the distance between two parameters, over which the markers of one stand side by side


AXES = ("x", "y", "z", "a", "b", "c")


class Chart:
    """An interactive figure, traces and layout; keyword arguments are attributes of plotly's reference."""

    def __init__(self) -> None:
        self.data: list[dict[str, Any]] = []
        self.layout: dict[str, Any] = {"xaxis": {}, "yaxis": {}, "shapes": []}

    def add(self, kind: str, **attributes: Any) -> None:
        """Adds a trace of a type: scatter, bar, heatmap, box."""
        self.data.append({"type": kind, **attributes})

    def add_scatter(self, **attributes: Any) -> None:
        """Adds lines or points."""
        self.add("scatter", **attributes)

    def add_hline(self, y: float, **attributes: Any) -> None:
        """Adds a line at `y` across the whole figure."""
        self._add_shape("line", {"xref": "x domain", "x0": 0, "x1": 1, "y0": y, "y1": y}, attributes)

    def add_vline(self, x: float, **attributes: Any) -> None:
        """Adds a line at `x` over the whole height."""
        self._add_shape("line", {"yref": "y domain", "y0": 0, "y1": 1, "x0": x, "x1": x}, attributes)

    def add_hrect(self, y0: float, y1: float, **attributes: Any) -> None:
        """Adds a band from `y0` to `y1` across the whole figure."""
        self._add_shape("rect", {"xref": "x domain", "x0": 0, "x1": 1, "y0": y0, "y1": y1}, attributes)

    def _add_shape(self, kind: str, place: dict[str, Any], attributes: dict[str, Any]) -> None:
        self.layout["shapes"].append({"type": kind, "xref": "x", "yref": "y"} | place | attributes)

    def update_traces(self, **attributes: Any) -> None:
        """Sets attributes of all traces."""
        for trace in self.data:
            trace.update(attributes)

    def update_xaxes(self, title: str | None = None, **attributes: Any) -> None:
        """Sets the title and attributes of the x axis."""
        self.layout["xaxis"].update(attributes if title is None else {"title": {"text": title}, **attributes})

    def update_yaxes(self, title: str | None = None, **attributes: Any) -> None:
        """Sets the title and attributes of the y axis."""
        self.layout["yaxis"].update(attributes if title is None else {"title": {"text": title}, **attributes})

    def update_layout(self, **attributes: Any) -> "Chart":
        """Sets attributes of the layout; returns the chart."""
        self.layout.update(attributes)
        return self


def script_json(value: Any) -> Markup:
    """JSON that is safe inside a script element; arrays are packed as plotly packs them, NaN and infinity are null."""
    try:
        text = json.dumps(value, default=packed, allow_nan=False)
    except ValueError:
        text = json.dumps(json.loads(json.dumps(value, default=packed), parse_constant=lambda _: None))
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e"))


def packed(values: NDArray[Any]) -> Any:
    """An array of numbers as plotly packs it, a third of the size of decimal digits; other arrays as lists."""
    if values.ndim == 0 or values.dtype.kind != "f":
        return values.tolist()
    little = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    coded = {"dtype": f"f{values.itemsize}", "bdata": base64.b64encode(little.tobytes()).decode("ascii")}
    return coded if values.ndim == 1 else {**coded, "shape": ", ".join(map(str, values.shape))}


MOST_POINTS = 2000  # a drawn line has; the eye sees no more, and the page stays small


def plain(text: str) -> str:
    """A text that plotly shows as it is: what looks like HTML in it stays text."""
    return html.escape(text, quote=False)


def thinned(x: Array, y: Array) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """A line of at most `MOST_POINTS` points that looks the same: of each stretch its lowest and highest sample."""
    if len(x) <= MOST_POINTS:
        return x.astype(np.float32), y.astype(np.float32)
    size = -(-len(x) // (MOST_POINTS // 2))
    stretches = np.pad(y, (0, -len(y) % size), mode="edge").reshape(-1, size)
    both = np.stack([stretches.argmin(axis=1), stretches.argmax(axis=1)], axis=1)
    indices = np.unique(np.minimum(np.arange(len(stretches))[:, None] * size + both, len(x) - 1))
    return x[indices].astype(np.float32), y[indices].astype(np.float32)


class Series(NamedTuple):
    """Standard deviations of one method."""

    name: str  # name in the legend
    deviations: Mapping[str, float]  # deviations by parameter; parameters that it does not tell are missing
    colour: str  # colour of its markers
    symbol: str = "circle"  # plotly's name of the marker


def ratio_figure(series: Sequence[Series]) -> Chart:
    """Standard deviations over the smallest of each parameter, on a logarithmic axis; 0 (a given value) is left out."""
    names = list(dict.fromkeys(n for s in series for n in s.deviations))
    deviations = {n: [s.deviations[n] for s in series if s.deviations.get(n, 0.0) > 0.0] for n in names}
    best = {n: min(values) for n, values in deviations.items() if values}
    figure = Chart()
    for k, one in enumerate(series):
        parameters = [n for n in one.deviations if n in best and one.deviations[n] > 0.0]
        aside = SPREAD * ((k + 0.5) / len(series) - 0.5)
        figure.add_scatter(
            x=[names.index(n) + aside for n in parameters],
            y=[one.deviations[n] / best[n] for n in parameters],
            name=plain(one.name),
            mode="markers",
            marker={"size": 8, "color": one.colour, "symbol": one.symbol},
            text=[f"{plain(n)}: {one.deviations[n]:.3g}" for n in parameters],
            hovertemplate="%{text} (SI), %{y:.3g} times the smallest",
        )
    figure.update_xaxes(
        range=[-0.6, len(names) - 0.4], showgrid=False, zeroline=False, tickvals=list(range(len(names))),
        ticktext=[plain(n) for n in names], tickangle=-90,
    )  # fmt: skip
    largest = max((one.deviations[n] / best[n] for one in series for n in one.deviations if n in best), default=1.0)
    figure.update_yaxes(title="times the smallest", type="log", tickvals=CLOSE if largest < CLOSE[-1] else FAR)
    return figure
