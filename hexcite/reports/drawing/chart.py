"""What a figure shows: its series, axes and lines, once for the page that moves and for the picture that is printed."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cases.base.units import Array

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
GREY = "#8593a1"
MOST_POINTS = 1500  # points of a line: more cannot be seen, and the page stays small

Dash = Literal["solid", "dash", "dot"]


def colour(k: int) -> str:
    """Colour of a line or an entry by its number, from 0; the seventh is grey."""
    return (*COLOURS, GREY)[k % 7]


def thinned(x: Array, y: Array, most: int = MOST_POINTS) -> tuple[Array, Array]:
    """A line of at most so many points that looks the same: of each stretch its lowest and highest sample."""
    if len(x) <= most:
        return x, y
    size = -(-len(x) // (most // 2))
    stretches = np.pad(y, (0, -len(y) % size), mode="edge").reshape(-1, size)
    both = np.stack([stretches.argmin(axis=1), stretches.argmax(axis=1)], axis=1)
    indices = np.unique(np.minimum(np.arange(len(stretches))[:, None] * size + both, len(x) - 1))
    return x[indices], y[indices]


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A line through points."""

    x: Array  # shape (n,)
    y: Array  # shape (n,)
    name: str
    colour: str
    width: float = 1.5
    dash: Dash = "solid"
    dots: bool = False  # whether its points are marked
    in_legend: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Points without a line."""

    x: Array  # shape (n,)
    y: Array  # shape (n,)
    name: str
    colour: str
    words: tuple[str, ...] = ()  # what is shown at each where the pointer is
    hollow: bool = False
    bar: Array | float = 0.0  # half the length of a bar at each, or at all, in units of y; 0: none
    in_legend: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Heat:
    """A square of values from 0 to 1, each a field of a strength."""

    values: Array  # shape (n, n)


@dataclass(frozen=True, slots=True)
class Box:
    """Quartiles of some values, which are shown beside as points, under a name."""

    values: tuple[float, ...]
    name: str


Series = Line | Points | Heat | Box


@dataclass(frozen=True, slots=True)
class Rule:
    """A straight line across the whole figure."""

    axis: Literal["x", "y"]  # that on which its value is
    value: float
    colour: str = GREY
    dash: Dash = "dash"


@dataclass(frozen=True, slots=True)
class Band:
    """A band across the whole figure, from -half to half of the y axis."""

    half: float
    colour: str
    opacity: float


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis; its unit is in the title."""

    title: str = ""
    logarithmic: bool = False
    ends: tuple[float, float] | None = None  # by default those of the series
    names: tuple[str, ...] = ()  # written at 0, 1, 2, .. in place of numbers
    tilt: float = 0.0  # of these names [deg]
    downwards: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """A figure.

    Args:
        name: unique on the page, also the name of the file to which a browser saves the figure.
        caption: describes the figure, also for a screen reader.
        series: what it shows, in the order of the legend.
        x: horizontal axis.
        y: vertical axis.
        rules: straight lines across it.
        bands: behind all else.
        height: on the page [pixels].
        half: whether it may stand beside another one where the window is wide.
    """

    name: str
    caption: str
    series: tuple[Series, ...]
    x: Axis = Axis()
    y: Axis = Axis()
    rules: tuple[Rule, ...] = ()
    bands: tuple[Band, ...] = ()
    height: int = 300
    half: bool = False

    @property
    def legend(self) -> tuple[Line | Points, ...]:
        """The entries of the legend; none where one name says nothing."""
        named = tuple(s for s in self.series if isinstance(s, Line | Points) and s.in_legend and s.name)
        return named if len(named) > 1 else ()


def lines(
    x: Array,
    y: Array,
    names: Sequence[str],
    width: float = 1.5,
    dash: Dash = "solid",
    dots: bool = False,
    most: int = MOST_POINTS,
) -> tuple[Line, ...]:
    """A line for each column of `y`, shape (n, k), each in its colour; dashed ones go without the legend."""
    drawn = (thinned(x, column, most) for column in y.T)
    return tuple(
        Line(*points, name, colour(k), width, dash, dots, in_legend=dash == "solid")
        for k, (points, name) in enumerate(zip(drawn, names, strict=True))
    )
