"""Pictures of a file of unknown format: its channels in panels of a kind, as many pages as that needs."""

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from cases.base.atomic import atomic_file
from cases.base.errors import legible, printable
from cases.base.output_places import check_file
from cases.base.units import Array
from cases.recording_format import CLOCK, ROLE_OF
from identification.looks.look import Column, Look
from identification.recording.formats.names.families import words_of

MOST_POINTS = 4000  # points of a line; more cannot be seen
MOST_LINES = 12  # lines of a panel that can be told from each other
MOST_PANELS = 6  # panels of a page
_WIDTH, _PANEL = 11.0, 2.2  # of a page, and the height of a panel [inches]
_LONGEST = 44  # characters of a name in a legend; longer ones would leave no room for the lines
_LARGEST = 1e100  # beyond, numbers are not measurements, and cannot be drawn


@dataclass(frozen=True)
class Panel:
    """Channels that are drawn over each other."""

    title: str
    columns: Sequence[Column]


def panels_of(report: Look) -> list[Panel]:
    """The channels of a file in panels: those with a meaning by their kind, others by the words of their names."""
    groups: dict[tuple[str, ...], list[Column]] = {}
    for column in report.columns:
        if column.ours != CLOCK and len(column.values):
            groups.setdefault(_group(column), []).append(column)
    ordered = sorted(groups.items(), key=lambda group: group[0][0] == _UNUSED)
    alone = [group[0] for key, group in ordered if key[0] == _UNUSED and len(group) == 1]  # share panels
    shared = [(key, group) for key, group in ordered if key[0] != _UNUSED or len(group) > 1]
    panels = [(_title(key, group), group) for key, group in shared] + ([("not used", alone)] if alone else [])
    return [
        Panel(title, group[first : first + MOST_LINES])
        for title, group in panels
        for first in range(0, len(group), MOST_LINES)
    ]


_UNUSED = "not used"


def _group(column: Column) -> tuple[str, ...]:
    """What channels of one panel have in common."""
    if column.ours is not None:
        return str(ROLE_OF.get(column.ours, column.ours)), column.unit
    words = (word.rstrip("xyz") or "axis" for word in words_of(column.name) if not word.isdecimal())
    return _UNUSED, *words


def _title(key: tuple[str, ...], group: Sequence[Column]) -> str:
    """The label of a panel's axis."""
    if key[0] == _UNUSED:
        return _UNUSED
    unit = f" [{group[0].unit}]" if group[0].unit else ""
    return f"{key[0]}{unit}"


def look_pages(report: Look) -> Iterator[Figure]:
    """The pages of a look: every channel of numbers over its clock, or over the rows."""
    panels = panels_of(report)
    clock = next((column for column in report.columns if column.ours == CLOCK and len(column.values)), None)
    axis = "row" if clock is None else f"{_short(clock.name)} [{clock.unit}]"
    rows = np.arange(1.0, report.rows + 1.0) if clock is None else clock.values
    count = -(-len(panels) // MOST_PANELS)
    for page in range(count):
        panels_of_page = panels[page * MOST_PANELS : (page + 1) * MOST_PANELS]
        figure = Figure(figsize=(_WIDTH, _PANEL * len(panels_of_page) + 0.8), layout="constrained")
        title = f"{report.file.name}, page {page + 1} of {count}" if count > 1 else report.file.name
        figure.suptitle(_escaped(title), fontsize="medium")
        own_clocks = any(column.t is not None for panel in panels_of_page for column in panel.columns)
        every = figure.subplots(len(panels_of_page), 1, sharex=True, squeeze=False)[:, 0]
        for axes, panel in zip(every, panels_of_page, strict=True):
            for column in panel.columns:
                axes.plot(*_line(rows if column.t is None else column.t, column.values), lw=0.8, label=_label(column))
            axes.set_ylabel(_escaped(panel.title))
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small", frameon=False)
        every[-1].set_xlabel("t [s]" if own_clocks else _escaped(axis))
        yield figure


def _line(x: Array, y: Array) -> tuple[Array, Array]:
    """Points of a line, few enough to be drawn; what cannot be drawn is left out."""
    if len(x) != len(y):  # of another clock there are more or fewer over the same time
        x = np.linspace(x[0], x[-1], len(y))
    step = -(-len(y) // MOST_POINTS)
    x, y = x[::step], y[::step]
    drawn = (np.abs(y) < _LARGEST) & (np.abs(x) < _LARGEST)  # false where one of them is NaN
    return np.where(drawn, x, np.nan), np.where(drawn, y, np.nan)


def _label(column: Column) -> str:
    name = _short(column.name)
    return _escaped(name if column.ours in (None, column.name) else f"{name} = {column.ours}")


def _short(name: str) -> str:
    """A name that fits into a legend: its beginning and its end."""
    half = (_LONGEST - 2) // 2
    plain = printable(" ".join(name.split()))
    return plain if len(plain) <= _LONGEST else f"{plain[:half]}..{plain[-half:]}"


def _escaped(text: str) -> str:
    """Text that matplotlib does not take for mathematics; a label that begins with _ would not be in the legend."""
    return ("\N{ZERO WIDTH SPACE}" if text.startswith("_") else "") + legible(text).replace("$", r"\$")


def save_pages(pages: Iterator[Figure], file: Path, overwrite: bool) -> list[Path]:
    """Writes pages, each into a file of its own, of PDF all into one; returns the files.

    Raises FileProblem where one of them stands there already, and `overwrite` is not set, or cannot be written.
    """
    kind = file.suffix[1:].lower()
    # text as text: it can be searched, and said in another language
    with (
        warnings.catch_warnings(),
        rc_context({"svg.fonttype": "none"}),
    ):  # a letter that the font does not have is drawn as a box
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        if kind == "pdf":
            with atomic_file(file) as part, PdfPages(part) as pdf:
                for page in pages:
                    pdf.savefig(page)
            return [file]
        written: list[Path] = []
        for number, page in enumerate(pages, 1):
            place = file if number == 1 else file.with_name(f"{file.stem}-page{number}{file.suffix}")
            check_file(place, (file.suffix.lower(),), (), overwrite)
            with atomic_file(place) as part:
                page.savefig(part, format=kind)
            written.append(place)
        return written
