"""The report page: one HTML file that needs no network, put together from tiles, tables, notes and figures.

Every function here returns HTML in which texts are escaped; plotly, compressed, the figures' data and the script are
part of the file. Each figure is there twice: as a picture, for print and until the script has drawn it, and as data.
Words of the field are explained where they stand. Elements that hold a text of ours and nothing else are marked by
`data-said`, with the code and values of the text where it has some: `translated` makes another language of them.
"""

import base64
import gzip
import html
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime
from functools import cache
from importlib import resources
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from cases.base.errors import legible
from cases.base.phrases import phrase
from hexcite.reports.drawing.chart import Chart, Line, Points
from hexcite.reports.drawing.interactive import plotly_figure
from hexcite.reports.drawing.marks import has_code, mark
from hexcite.reports.drawing.scene import Scene

TERMS = {
    "std (28)": "standard deviation if the residuals are white noise, equation (28) of Friedrich & Ihlenfeldt 2021",
    "std robust": "standard deviation that allows for residuals alike from one sample or pose to the next",
    "s0": "standard deviation of the recorded forces from the model, equation (27)",
    "white noise": "noise of a force without memory, as the residuals behind the evaluation's filter show it",
    "D-efficiency": "share of the information that no motion inside the limits can exceed, from 0 to 1",
    "reference scaling": "parameters scaled by their effect on the sensors in the motion box, so that motions compare",
    "regressor": "the matrix that turns parameters into forces",
    "condition": "largest over smallest singular value: 1 is best, large where parameters are hard to separate",
    "rms": "root of the mean square",
}
"""Terms that a page explains where they stand."""


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


Block = Markup | Chart | Scene
"""Block of a page: HTML, a figure, or a machine in 3-D."""


def _html(block: Block) -> Markup:
    match block:
        case Chart():
            return _figure(block)
        case Scene():
            return _player(block)
        case _:
            return block


def _figure(chart: Chart) -> Markup:
    """A figure as it stands on a page: its picture, which the script replaces by one that answers."""
    from hexcite.reports.drawing.still import picture  # matplotlib, which pages without figures do not need

    kind = Markup(' class="half"') if chart.half else ""
    plot = _plot(f"plot-{chart.name}", chart.caption, chart.height, picture(chart))
    script = Markup('<script type="application/json" data-plot="{}">{}</script>')
    data = script.format(chart.name, script_json(plain(plotly_figure(chart))))
    caption = Markup("<figcaption{}>{}</figcaption>").format(mark(chart.caption), explained(chart.caption))
    texts = Markup(' data-phrases="{}"').format(json.dumps(phrases)) if (phrases := _phrases(chart)) else ""
    return Markup("<figure{}{}>\n{}\n{}\n{}\n</figure>").format(kind, texts, plot, data, caption)


def _phrases(chart: Chart) -> dict[str, Any]:
    """Texts of a figure that have a code, each with the entries of its phrase."""
    series = (each.name for each in chart.series if isinstance(each, Line | Points))
    texts = (chart.caption, chart.x.title, chart.y.title, *chart.x.names, *chart.y.names, *series)
    return {str(text): text.to_json() for text in texts if has_code(text)}


def _plot(name: str, words: str, height: int, still: str) -> Markup:
    text = (
        '<img class="still" alt="{}" src="data:image/svg+xml;base64,{}">\n'
        '<div class="plot" id="{}" role="img" aria-label="{}" style="min-height: {}px"></div>'
    )
    return Markup(text).format(words, base64.b64encode(still.encode()).decode("ascii"), name, words, height)


def _joined(parts: Iterable[Block]) -> Markup:
    return Markup("\n").join(map(_html, parts))


def tiles(*figures: tuple[str, str]) -> Markup:
    """The figures that matter, side by side: each a value with its unit, and what it means in a line."""
    tile = Markup("<div><b>{}</b><span{}>{}</span></div>")
    each = (tile.format(value, mark(text), explained(text)) for value, text in figures)
    return Markup('<div class="tiles">\n{}\n</div>').format(_joined(each))


def note(text: str) -> Markup:
    """A paragraph."""
    return Markup('<p class="note"{}>{}</p>').format(mark(text), explained(text))


def table(columns: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> Markup:
    """A table; the first `left` columns hold words, the others numbers."""

    def row(texts: Sequence[str], cell: str, shown: Callable[[str], str]) -> Markup:
        kinds = (Markup(' class="word"') if k < left else "" for k in range(len(texts)))
        marks = (mark(text) if _LETTERS.search(text) else "" for text in texts)
        cells = (Markup(cell).format(*each, shown(text)) for *each, text in zip(kinds, marks, texts, strict=True))
        return Markup("<tr>{}</tr>").format(Markup("").join(cells))

    head = row(columns, '<th scope="col"{}{}>{}</th>', explained)
    body = (row(each, "<td{}{}>{}</td>", _unit) for each in rows)
    text = """<div class="scroll" tabindex="0" role="region" aria-label="table: {}"><table>
<thead>{}</thead>
<tbody>
{}
</tbody>
</table></div>"""
    return Markup(text).format(", ".join(filter(None, columns)), head, _joined(body))


_LETTERS = re.compile(r"[A-Za-z]{2}")


def _unit(cell: str) -> str:
    """A cell whose unit stays in one line."""
    return cell.replace("kg m^2", "kg m²").replace("N m", "N\N{NO-BREAK SPACE}m")


def _player(scene: Scene) -> Markup:
    """A machine moving in 3-D, with buttons to play and a slider to scrub."""
    text = """<figure>
{}
<div class="player">
<button id="play" type="button" data-said="">Play</button>
<input id="scrub" type="range" min="0" max="1" step="1" value="0" aria-label="time">
<output id="instant"></output>
<div id="used" class="used"></div>
</div>
<script type="application/json" id="scene">{}</script>
<figcaption><span data-said="">{}</span>
<span class="screen" data-said="">Drag to turn, wheel to zoom.</span></figcaption>
</figure>"""
    from hexcite.reports.drawing.still import machine_picture

    words = "The machine in some of its poses." if scene.steps else "The machine where its path begins, and the path."
    plot = _plot("machine", "the machine in 3-D along its path", 560, machine_picture(scene))
    return Markup(text).format(plot, script_json(scene.to_json()), words)


def section(title: str, *blocks: Block) -> Markup:
    """A heading and what stands below it."""
    text = '<section>\n<h2{}>{}</h2>\n<div class="items">\n{}\n</div>\n</section>'
    return Markup(text).format(mark(title), title, _joined(blocks))


SOUND = phrase("sound_run", "Nothing speaks against this run")
"""Verdict on a run without a warning."""


class Head(NamedTuple):
    """What every page begins with."""

    verdict: str  # in a sentence
    good: bool  # whether nothing speaks against it
    machine: str
    facts: tuple[tuple[str, str], ...] = ()  # program, recording and the like: names and values


def page(
    title: str, head: Head, lead: str, inputs: Iterable[tuple[str, str]], warnings: Sequence[str], *sections: Markup
) -> str:
    """A page as HTML.

    Args:
        lead: what was done, in a sentence or two.
        inputs: what it was done with, versions too: names and values.
        warnings: stand first.
    """
    items = [Markup("<li{}>{}</li>").format(mark(warning), explained(warning)) for warning in warnings]
    listed = Markup('<ul class="warnings" aria-label="warnings">\n{}\n</ul>').format(_joined(items)) if items else ""
    last = section("Inputs and versions", table(("input", "value"), inputs, left=2))
    files = resources.files("hexcite.reports") / "templates"
    parts = {name: Markup((files / f"page.{name}").read_text(encoding="utf-8")) for name in ("css", "js", "html")}
    facts = (("machine", head.machine), *head.facts, ("page made", f"{datetime.now().astimezone():%Y-%m-%d %H:%M %Z}"))
    fact = Markup("<div><dt{}>{}</dt><dd{}>{}</dd></div>")
    whole = parts.pop("html").format(
        **parts,
        title=title,
        of_title=mark(title),
        mood="good" if head.good else "doubt",
        verdict=explained(head.verdict),
        of_verdict=mark(head.verdict),
        facts=_joined(fact.format(mark(name), name, mark(value), value) for name, value in facts),
        lead=explained(lead),
        of_lead=mark(lead),
        warnings=listed,
        sections=_joined((*sections, last)),
        plotly=_plotly(),
    )
    return legible(whole)


@cache
def space_page() -> str:
    """A page of nothing but a machine in 3-D, for a frame: it draws each scene that the page around it sends.

    Messages to it are `{scene, words}`: `Scene.to_json`, with `pick` where its labels are to be clicked; words for
    play, pause, pose and of. Its own are `{ready}`, `{failed}` and `{picked}`, the text of a label.
    """
    text = """<!doctype html>
<html lang="en">
<head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark"><title>3-D</title><style>{css}</style></head>
<body class="space"><figure><div class="plot" id="machine" role="img" aria-label="3-D"></div>
<div class="player"><button id="play" type="button">Play</button>
<input id="scrub" type="range" min="0" max="1" step="1" value="0" aria-label="time"><output id="instant"></output>
<div id="used" class="used"></div></div></figure>
<script type="application/octet-stream" id="plotly">{plotly}</script><script>{js}</script></body></html>"""
    files = resources.files("hexcite.reports") / "templates"
    parts = {name: (files / f"page.{name}").read_text(encoding="utf-8") for name in ("css", "js")}
    return text.format(plotly=_plotly(), **parts)


@cache
def _plotly() -> str:
    """Plotly's script, compressed: a third of its size, and a browser reads it after the page's text."""
    script = (resources.files("plotly") / "package_data" / "plotly.min.js").read_bytes()
    return base64.b64encode(gzip.compress(script, 6, mtime=0)).decode("ascii")


def explained(text: str) -> Markup:
    """A text whose terms are explained by a tooltip, which a keyboard and a screen reader reach too."""
    return with_tooltips(escape(text), TERMS)


def with_tooltips(text: Markup, terms: Mapping[str, str]) -> Markup:
    """A text, its terms explained by tooltips."""

    def tooltip(term: re.Match[str]) -> str:
        return Markup('<abbr title="{}" tabindex="0">{}</abbr>').format(terms[term[0]], term[0])

    ordered = sorted(terms, key=len, reverse=True)
    return Markup(re.sub("|".join(rf"(?<![\w-]){re.escape(term)}(?!\w)" for term in ordered), tooltip, text))
