"""The report page: one HTML file that needs no network, put together from tiles, tables, notes and figures.

Every function here returns HTML in which texts are escaped; plotly, compressed, the figures' data and the script are
part of the file. Words of the field are explained where they stand.
"""

import base64
import gzip
import html
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from cases.units import Array

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
GREY = "#8593a1"
MOST_POINTS = 2000  # points of a line: more cannot be seen, and the page stays small
TERMS = {
    "std (28)": "standard deviation if the residuals are white noise, equation (28) of Friedrich & Ihlenfeldt 2021",
    "std robust": "standard deviation that allows for residuals alike from one sample or pose to the next",
    "s0": "scatter of the residuals: what a force sample deviates from the model",
    "D-efficiency": "share of the information that no motion inside the limits can exceed, from 0 to 1",
    "reference scaling": "parameters scaled by their effect on the sensors in the motion box, so that motions compare",
    "regressor": "the matrix that turns parameters into forces",
    "condition": "largest over smallest singular value: 1 is best, large where parameters are hard to separate",
    "rms": "root of the mean square",
}
"""Terms that a page explains where they stand."""
_TERM = re.compile("|".join(rf"(?<![\w-]){re.escape(term)}(?!\w)" for term in sorted(TERMS, key=len, reverse=True)))


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


def plain(value: Any) -> Any:
    """A value of which plotly, which reads some HTML in labels, shows every text as it is."""
    if isinstance(value, str):
        return html.escape(value, quote=False)
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return {key: plain(each) for key, each in value.items()} if isinstance(value, dict) else value


def colour(k: int) -> str:
    """Colour of a line or an entry by its number, from 0; the seventh is grey."""
    return (*COLOURS, GREY)[k % 7]


def thinned(x: Array, y: Array) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """A line of at most `MOST_POINTS` points that looks the same: of each stretch its lowest and highest sample."""
    if len(x) <= MOST_POINTS:
        return x.astype(np.float32), y.astype(np.float32)
    size = -(-len(x) // (MOST_POINTS // 2))
    stretches = np.pad(y, (0, -len(y) % size), mode="edge").reshape(-1, size)
    both = np.stack([stretches.argmin(axis=1), stretches.argmax(axis=1)], axis=1)
    indices = np.unique(np.minimum(np.arange(len(stretches))[:, None] * size + both, len(x) - 1))
    return x[indices].astype(np.float32), y[indices].astype(np.float32)


class Chart:
    """An interactive figure, traces and layout; keyword arguments are attributes of plotly's reference.

    Plotly's Python classes check each value anew, which took longer than all else on a page; tests let them check it.

    Args:
        name: unique on the page, also the name of the file to which a browser saves the figure.
        caption: describes the figure, also for a screen reader.
        half: whether it may stand beside another one where the window is wide.
        layout: attributes of the layout; colours of text, grid and background are the page's.
    """

    def __init__(self, name: str, caption: str, x: str = "", y: str = "", *, half: bool = False, **layout: Any) -> None:
        self.name, self.caption, self.half = name, caption, half
        self.data: list[dict[str, Any]] = []
        titles = {f"{axis}axis": {"title": {"text": text}} if text else {} for axis, text in (("x", x), ("y", y))}
        self.layout: dict[str, Any] = {**titles, "shapes": [], **layout}

    def add(self, kind: str, **attributes: Any) -> None:
        """Adds a trace of a type: scatter, bar, heatmap, box."""
        self.data.append({"type": kind, **attributes})

    def add_lines(self, x: Array, y: Array, names: Sequence[str], width: float, dash: str = "solid") -> None:
        """Adds a line for each column of `y`, shape (n, k), each in its colour; dashed ones need no legend."""
        for k, name in enumerate(names):
            line = {"color": colour(k), "width": width, "dash": dash}
            few_x, few_y = thinned(x, y[:, k])
            self.add("scatter", x=few_x, y=few_y, name=name, line=line, legendgroup=name, showlegend=dash == "solid")

    def add_line(self, at: dict[str, float], colour: str, width: float = 1, dash: str = "dash") -> None:
        """Adds a straight line across the whole figure, at `{"x": 3.0}` or `{"y": 3.0}`."""
        ((axis, value),) = at.items()
        along = "y" if axis == "x" else "x"
        place = {f"{along}ref": f"{along} domain", f"{axis}ref": axis, f"{along}0": 0, f"{along}1": 1}
        ends = {f"{axis}0": value, f"{axis}1": value}
        line = {"color": colour, "dash": dash, "width": width}
        self.layout["shapes"].append({"type": "line", **place, **ends, "line": line})

    def add_band(self, half: float, colour: str, opacity: float) -> None:
        """Adds a band across the whole figure, from -half to half of the y axis."""
        place = {"xref": "x domain", "yref": "y", "x0": 0, "x1": 1, "y0": -half, "y1": half}
        look = {"fillcolor": colour, "opacity": opacity, "line": {"width": 0}, "layer": "below"}
        self.layout["shapes"].append({"type": "rect", **place, **look})

    def axes(self, x: Mapping[str, Any] = {}, y: Mapping[str, Any] = {}) -> None:
        """Sets attributes of the axes."""
        self.layout["xaxis"].update(x)
        self.layout["yaxis"].update(y)

    def __html__(self) -> Markup:
        """The figure as it stands on a page."""
        kind = Markup(' class="half"') if self.half else ""
        plot = _plot(f"plot-{self.name}", self.caption, self.layout.get("height", 300))
        script = Markup('<script type="application/json" data-plot="{}">{}</script>')
        data = script.format(self.name, script_json(plain({"data": self.data, "layout": self.layout})))
        caption = Markup("<figcaption>{}</figcaption>").format(explained(self.caption))
        return Markup("<figure{}>\n{}\n{}\n{}\n</figure>").format(kind, plot, data, caption)


def _plot(name: str, words: str, height: int) -> Markup:
    text = '<div class="plot" id="{}" role="img" aria-label="{}" style="min-height: {}px"></div>'
    return Markup(text).format(name, words, height)


Block = Markup | Chart
"""Block of a page: HTML, or an object with `__html__`."""


def _joined(parts: Iterable[Block]) -> Markup:
    return Markup("\n").join(parts)


def tiles(*figures: tuple[str, str]) -> Markup:
    """The figures that matter, side by side: each a value with its unit, and what it means in a line."""
    each = (Markup("<div><b>{}</b><span>{}</span></div>").format(value, explained(text)) for value, text in figures)
    return Markup('<div class="tiles">\n{}\n</div>').format(_joined(each))


def note(text: str) -> Markup:
    """A paragraph."""
    return Markup('<p class="note">{}</p>').format(explained(text))


def table(columns: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> Markup:
    """A table; the first `left` columns hold words, the others numbers."""

    def row(texts: Sequence[str | Markup], cell: str) -> Markup:
        kinds = (Markup(' class="word"') if k < left else "" for k in range(len(texts)))
        cells = (Markup(cell).format(kind, text) for kind, text in zip(kinds, texts, strict=True))
        return Markup("<tr>{}</tr>").format(Markup("").join(cells))

    head = row([explained(column) for column in columns], '<th scope="col"{}>{}</th>')
    body = (row([cell.replace("kg m^2", "kg m²") for cell in each], "<td{}>{}</td>") for each in rows)
    text = '<div class="scroll" tabindex="0" role="region" aria-label="table: {}"><table>\n{}\n</table></div>'
    return Markup(text).format(", ".join(filter(None, columns)), _joined((head, *body)))


def player(scene: dict[str, Any]) -> Markup:
    """The hexapod moving in 3-D, with buttons to play and a slider to scrub; a scene of `planner.reports.machine`."""
    text = """<figure>
{}
<div class="player">
<button id="play" type="button">Play</button>
<input id="scrub" type="range" min="0" max="1" step="1" value="0" aria-label="time">
<output id="instant"></output>
</div>
<script type="application/json" id="scene">{}</script>
<figcaption>Drag to turn, wheel to zoom.</figcaption>
</figure>"""
    return Markup(text).format(_plot("machine", "the machine in 3-D along its path", 560), script_json(scene))


def section(title: str, *blocks: Block) -> Markup:
    """A heading and what stands below it."""
    text = '<section>\n<h2>{}</h2>\n<div class="items">\n{}\n</div>\n</section>'
    return Markup(text).format(title, _joined(blocks))


def page(title: str, lead: str, inputs: Iterable[tuple[str, str]], warnings: Sequence[str], *sections: Markup) -> str:
    """A page as HTML.

    Args:
        lead: what was done, in a sentence or two.
        inputs: what it was done with, versions too: names and values.
        warnings: stand first.
    """
    given = [Markup("<li>{}</li>").format(explained(warning)) for warning in warnings]
    listed = Markup('<ul class="warnings" aria-label="warnings">\n{}\n</ul>').format(_joined(given)) if given else ""
    last = section("Inputs and versions", table(("input", "value"), inputs, left=2))
    files = resources.files("planner.reports") / "templates"
    parts = {name: Markup((files / f"page.{name}").read_text(encoding="utf-8")) for name in ("css", "js", "html")}
    return parts.pop("html").format(
        **parts,
        title=title,
        lead=explained(lead),
        warnings=listed,
        sections=_joined((*sections, last)),
        plotly=_plotly(),
    )


@cache
def _plotly() -> str:
    """Plotly's script, compressed: a third of its size, and a browser reads it after the page's text."""
    script = (resources.files("plotly") / "package_data" / "plotly.min.js").read_bytes()
    return base64.b64encode(gzip.compress(script, 6, mtime=0)).decode("ascii")


def explained(text: str) -> Markup:
    """A text whose terms are explained by a tooltip, which a keyboard and a screen reader reach too."""
    return Markup(_TERM.sub(_tooltip, escape(text)))


def _tooltip(term: re.Match[str]) -> str:
    return Markup('<abbr title="{}" tabindex="0">{}</abbr>').format(TERMS[term[0]], term[0])
