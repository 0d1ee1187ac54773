"""Drawings that the server makes for the page: the machine from above and from the side, and the curve of a search."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup

from cases.base.errors import Code, HexciteError
from cases.chain import Chain
from cases.machine import KeepOut
from cases.schema import Case
from hexcite.reports.drawing.outline import SAME_PLACE, Labels, Lines, chain_outline, outline, together
from hexcite.reports.drawing.scene import box_outlines, room
from identification.motion.motion import Array

WIDTH, HEIGHT, EDGE = 340.0, 270.0, 30.0  # of a drawing, and free at its sides
ROWS = 4  # of texts above or below a point, where nearer ones are taken
LETTER, LINE = 7.7, 13.0  # of its texts: width of a letter, roughly, and height
_CLASSES = {
    "base": "base",
    "platform": "platform",
    "struts 1 to 6": "strut",
    "sensors 1 to 6": "sensor",
    "tools": "tool",
}


class Views(NamedTuple):
    """A machine at home."""

    above: Markup
    side: Markup
    lengths: tuple[float, ...]  # of its struts [mm]; empty of a machine without


def views(case: Case) -> Views:
    """The machine at home from above and from the side; raises HexciteError where the case does not describe one."""
    if case.chain is not None:
        return chain_views(case.chain)
    lines, labels, boxes = outline(case)
    lengths = tuple(float(np.linalg.norm(line[1] - line[0])) for line in lines.get("struts 1 to 6", ("", ()))[1])
    return _views(lines, labels, boxes, lengths)


def chain_views(chain: Chain) -> Views:
    """A chain at home, or at 0, from above and from the side."""
    return _views(*chain_outline(chain), ())


def _views(lines: Lines, labels: Labels, boxes: Sequence[KeepOut], lengths: tuple[float, ...]) -> Views:
    groups = {name: list(group) for name, (_, group) in lines.items()}
    points = np.vstack([line for group in groups.values() for line in group])
    if not np.isfinite(points).all() or float(np.abs(points).max()) > 1e9:
        raise HexciteError(problem="its points are not finite", code=Code.OUT_OF_RANGE)
    groups["kept out"] = box_outlines(boxes, *room(points.min(axis=0), points.max(axis=0), boxes))
    near = SAME_PLACE * float(np.ptp(points, axis=0).max())
    drawn = [_drawn(groups, labels, near, axes) for axes in ((0, 1), (0, 2))]
    return Views(drawn[0], drawn[1], lengths)


def _drawn(groups: Mapping[str, Sequence[Array]], labels: Labels, near: float, axes: tuple[int, int]) -> Markup:
    """Lines and names in two axes as SVG, in the colours of the style sheet."""
    vertices = np.vstack([line[:, axes] for group in groups.values() for line in group])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    scale = float(min((np.array([WIDTH, HEIGHT]) - 2.0 * EDGE) / np.maximum(high - low, 1.0)))
    middle = (low + high) / 2.0

    def at(points: Array) -> Array:
        return np.asarray((points - middle) * scale * np.array([1.0, -1.0]) + np.array([WIDTH, HEIGHT]) / 2.0)

    shapes = [
        Markup('<polyline class="{}" points="{}"/>').format(
            _CLASSES.get(name, "other"), " ".join(f"{x:.1f},{y:.1f}" for x, y in at(line[:, axes]))
        )
        for name, group in groups.items()
        for line in group
    ]
    named = together([(place[list(axes)], text) for place, text in labels], near)
    texts = [
        Markup('<text x="{}" y="{}">{}</text>').format(f"{x:.1f}", f"{y:.1f}", text)
        for (x, y), text in _beside([(at(place), text) for place, text in named])
    ]
    length = _round(120.0 / scale)
    bar = Markup('<path class="bar" d="M10 {0} h{1}"/><text x="10" y="{2}">{3} mm</text>').format(
        f"{HEIGHT - 8:.0f}", f"{length * scale:.1f}", f"{HEIGHT - 13:.0f}", f"{length:g}"
    )
    names = ("x", "y", "z")
    words = Markup('<text class="axes" x="{}" y="{}">{} →, {} ↑</text>').format(
        f"{WIDTH - 84:.0f}", f"{HEIGHT - 10:.0f}", names[axes[0]], names[axes[1]]
    )
    return _svg(WIDTH, HEIGHT, "machine", Markup("").join([*shapes, *texts, bar, words]))


def _beside(labels: Labels) -> Labels:
    """The labels where their texts begin: each as near to its point as there is room beside earlier ones."""
    labels_at: Labels = []
    for (x, y), text in labels:
        wide = LETTER * len(text)
        heights = [up for far in range(ROWS) for up in (-4.0 - LINE * far, 13.0 + LINE * far)]
        sides = [np.array([x + across, y + up]) for up in heights for across in (4.0, -4.0 - wide)]
        free = (
            side
            for side in sides
            if 0.0 < side[0] < WIDTH - wide
            and LINE < side[1] < HEIGHT - 2.0 * LINE  # below them stands the scale
            and not any(
                -LETTER * len(other) < there[0] - side[0] < wide and abs(there[1] - side[1]) < LINE
                for there, other in labels_at
            )
        )
        inside = next((side for side in sides if 0.0 < side[0] < WIDTH - wide), sides[0])
        labels_at.append((next(free, inside), text))
    return labels_at


def _round(length: float) -> float:
    """The next lower of 1, 2, 5, 10, 20, .."""
    power = 10.0 ** np.floor(np.log10(max(length, 1e-6)))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * 1.0001))


def _svg(width: float, height: float, kind: str, inner: Markup) -> Markup:
    text = '<svg viewBox="0 0 {} {}" class="{}" aria-hidden="true" preserveAspectRatio="xMidYMid meet">{}</svg>'
    return Markup(text).format(f"{width:.0f}", f"{height:.0f}", kind, inner)


def curve(progress: Sequence[Mapping[str, Any]], seconds: float, words: str) -> Markup:
    """The best motion of a search over time, as steps; empty where there is none yet.

    Args:
        progress: where the search stood, each with `best` and `at` [s].
        seconds: since the search began.
        words: what is drawn, for the label.
    """
    points = [(float(p["at"]), float(p["best"])) for p in progress if p.get("best") is not None]
    if not points:
        return Markup("")
    low, high = min(b for _, b in points), max(b for _, b in points)
    low, high = (min(low, 0.0), max(high, 1e-9)) if low > 0.0 else (low, high + 1e-9)
    until = max(seconds, points[-1][0], 1e-3)

    def place(at: float, best: float) -> str:
        return f"{8 + 424 * at / until:.1f},{112 - 96 * (best - low) / (high - low):.1f}"

    corners, last = list[str](), points[0][1]
    for at, best in points:
        corners += [place(at, last), place(at, best)]
        last = best
    line = Markup('<polyline class="curve" points="{}"/>').format(" ".join([*corners, place(until, last)]))
    label = Markup('<text x="10" y="12">{}</text><text x="432" y="{}" text-anchor="end">{}</text>').format(
        words, f"{float(place(until, last).split(',')[1]) - 5:.1f}", f"{last:.3g}"
    )
    axis = Markup('<path class="bar" d="M8 112 H432"/><text x="432" y="124" text-anchor="end">{} s</text>').format(
        f"{until:.0f}"
    )
    return _svg(440, 128, "search", Markup("").join([axis, line, label]))
