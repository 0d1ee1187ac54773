"""Lines that show boxes that are kept out of, and the tools that must stay out of them; in mm."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cases.machine import KeepOut, Tool
from cases.units import MM

Array = NDArray[np.float64]

AROUND = 16  # corners of a ring around a tool
BESIDE = 0.25  # of the machine's size: boxes are shown that far beside it
_BOTTOM = ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))


def room(low: Array, high: Array, boxes: Iterable[KeepOut]) -> tuple[Array, Array]:
    """Corners, shape (3,) [mm], of a picture that shows boxes too, as far as they stand beside a machine."""
    beside = BESIDE * (high - low)
    first, last = low, high
    for box in boxes:
        least, most = box.corners / MM
        first, last = (
            np.minimum(first, np.maximum(least, low - beside)),
            np.maximum(last, np.minimum(most, high + beside)),
        )
    return first, last


def box_outlines(boxes: Iterable[KeepOut], low: Array, high: Array) -> list[Array]:
    """Edges of boxes in {B}, as far as they lie between two corners: lines of shape (k, 3) [mm]."""
    lines = []
    for box in boxes:
        ends = np.clip(box.corners / MM, low, high)
        if np.any(ends[0] >= ends[1]):
            continue  # beside the picture
        floor, ceiling = (np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i, j in _BOTTOM]) for k in (0, 1))
        lines += [floor, ceiling, *np.stack([floor[:4], ceiling[:4]], axis=1)]
    return lines


def tool_outlines(tools: Iterable[Tool]) -> list[Array]:
    """Axes of tools, or the rings at their ends and lines between these, in {P}: lines of shape (k, 3) [mm]."""
    lines: list[Array] = []
    for tool in tools:
        start, end = tool.axis / MM
        if tool.radius_mm == 0.0:
            lines.append(np.stack([start, end]))
            continue
        # Two directions across the axis; a ball, whose ends are one, is shown as a ring.
        way = end - start if np.any(end != start) else np.array([0.0, 0.0, 1.0])
        across = np.linalg.svd(way[None])[2][1:]
        angle = np.linspace(0.0, 2 * np.pi, AROUND + 1)
        ring = tool.radius_mm * (np.cos(angle)[:, None] * across[0] + np.sin(angle)[:, None] * across[1])
        lines += [start + ring, end + ring]
        lines += list(np.stack([start + ring, end + ring], axis=1)[:AROUND:4])
    return lines
