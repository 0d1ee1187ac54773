"""The report page: one HTML file that needs no network, put together from tiles, tables, notes and figures.

Values are typed here and drawn by the template, which escapes every text; plotly, compressed, the figures' data and the
script are part of the file. Words of the field are explained where they stand. Text from outside that goes into a
figure passes `plain`, for plotly reads some HTML in labels.
"""

import base64
import gzip
import html
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from numpy.typing import NDArray

from cases.files import write_text
from identification.motion import Array

if TYPE_CHECKING:
    from identification.outcome import Result
    from planner.comparison.advising import Comparison
    from planner.comparison.validation import Validation
    from planner.plans import Plan

    Shown = Plan | Result | Comparison | Validation

MOST_POINTS = 2000  # a drawn line has; the eye sees no more, and the page stays small

TERMS = {
    "std (28)": "standard deviation if the residuals are white noise, equation (28) of Friedrich & Ihlenfeldt 2021",
    "std robust": "standard deviation that allows for residuals alike from one sample or pose to the next",
    "s0": "scatter of the residuals: what a force sample deviates from the model",
    "D-efficiency": "share of the information that no motion inside the limits can exceed, from 0 to 1",
    "reference scaling": "parameters scaled by their effect on the sensors in the motion box, so that motions compare",
    "log det": "logarithm of the determinant of the information matrix: what criterion D maximises",
    "{P}": "frame of the moving platform",
    "{B}": "frame of the base",
    "f_q0": "offset of a sensor",
    "k0": "elastic deformation: force for each metre of displacement",
    "k1": "elastic deformation: moment for each metre of displacement",
    "k2": "elastic deformation: force for each radian of tilt",
    "k3": "elastic deformation: moment for each radian of tilt",
    "regressor": "the matrix that turns parameters into forces",
    "condition": "largest over smallest singular value: 1 is best, large where parameters are hard to tell apart",
    "rms": "root of the mean square",
}
"""Words that a page explains where they stand."""
_TERM = re.compile("|".join(rf"(?<![\w-]){re.escape(term)}(?!\w)" for term in sorted(TERMS, key=len, reverse=True)))


class Chart:
    """An interactive figure, traces and layout; keyword arguments are attributes of plotly's reference.

    Plotly's Python classes check each value anew, which took longer than all else on a page; tests let them check it.
    """

    def __init__(self, x: str | None = None, y: str | None = None) -> None:
        self.data: list[dict[str, Any]] = []
        self.layout: dict[str, Any] = {"xaxis": {}, "yaxis": {}, "shapes": []}
        self.update_xaxes(x)
        self.update_yaxes(y)

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


@dataclass(frozen=True, slots=True)
class Tiles:
    """The figures that matter, side by side: each a value with its unit, and what it means in a line."""

    tiles: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Note:
    """A paragraph."""

    text: str


@dataclass(frozen=True, slots=True)
class Answers:
    """Claims that figures bear out or not, one below the other: whether each holds, the claim and the figures."""

    answers: tuple[tuple[bool, str, str], ...]


@dataclass(frozen=True, slots=True)
class Table:
    """A table; the first `left` columns hold words, the others numbers."""

    columns: tuple[str, ...]
    rows: Sequence[Sequence[str]]
    left: int = 1


@dataclass(frozen=True, slots=True)
class Plot:
    """An interactive figure."""

    name: str  # unique on the page, also the name of the file it is saved to from the browser
    figure: Chart  # drawn in the colours of the page, so it sets none for text, grid and background
    note: str  # caption, which says what to see; also what a screen reader says of the figure
    half: bool = False  # may stand beside another one where the window is wide


@dataclass(frozen=True, slots=True)
class MachineItem:
    """The hexapod moving in 3-D, with buttons to play and a slider to scrub."""

    scene: dict[str, Any]  # what `planner.reports.machine` makes of a motion
    note: str = ""  # caption


Item = Tiles | Note | Answers | Table | Plot | MachineItem


@dataclass(frozen=True, slots=True)
class Section:
    """A heading and what stands below it."""

    title: str
    items: tuple[Item, ...]


@dataclass(frozen=True, slots=True)
class Page:
    """A report."""

    title: str  # heading
    lead: str  # what was done, in a sentence or two
    inputs: tuple[tuple[str, str], ...]  # what it was done with, versions too: names and values
    warnings: tuple[str, ...]  # stand first
    sections: tuple[Section, ...]


def render(page: Page) -> str:
    """The page as HTML."""
    environment = Environment(
        loader=PackageLoader("planner.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"explained": explained, "script": script_json}
    return environment.get_template("page.html.j2").render(page=page, plotly=_plotly())


@cache
def _plotly() -> str:
    """Plotly's script, compressed: a third of its size, and a browser reads it after the page's text."""
    script = (resources.files("plotly") / "package_data" / "plotly.min.js").read_bytes()
    return base64.b64encode(gzip.compress(script, 6, mtime=0)).decode("ascii")


def explained(text: str) -> Markup:
    """A text with its words of the field explained, as a tooltip that a keyboard and a screen reader reach too."""
    parts, end = [], 0
    for match in _TERM.finditer(text):
        parts.append(escape(text[end : match.start()]))
        parts.append(Markup('<abbr title="{}" tabindex="0">{}</abbr>').format(TERMS[match[0]], match[0]))
        end = match.end()
    return Markup("").join([*parts, escape(text[end:])])


# What only one kind of value needs is imported for that: SciPy takes a second.


def report(value: "Shown", file: Path | str) -> None:
    """Writes the page of a value, one HTML file that needs no network.

    Args:
        value: a plan, a result, a comparison, a validation.
        file: file to write.
    """
    write_text(Path(file), render(page(value)))


def page(value: Any) -> Page:
    """The page of a value."""
    match type(value).__name__:  # to import the types of all takes a second
        case "Plan":
            from planner.reports.plan import plan_page, poses_page

            return poses_page(value) if len(value.poses) else plan_page(value)
        case "Result":
            from planner.reports.identify import identify_page

            return identify_page(value)
        case "Comparison":
            from planner.reports.compare import compare_page

            return compare_page(value)
        case _:
            from planner.reports.validation import validation_page

            return validation_page(value)
