"""Charts: interactive figures as data for plotly's JavaScript, by plotly's own names.

Plotly's Python classes check each value anew, which took longer than all else on a page; tests let them check pages.
"""

import base64
import json
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

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
