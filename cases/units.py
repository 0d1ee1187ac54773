"""The constants that turn file units into SI and back, in one place, and values in words.

`value_SI = value_in_file * CONSTANT`.
"""

import math
from collections.abc import Iterable
from html import escape

MM = 1e-3  # [m]
UM = 1e-6  # [m]
DEG = math.pi / 180.0  # [rad]
MS = 1e-3  # [s]
MINUTE = 60.0  # [s]


def pose_words(pose: Iterable[float]) -> str:
    """A pose, six coordinates [m, rad], in words."""
    x, y, z, a, b, c = (value / unit for value, unit in zip(pose, (MM, MM, MM, DEG, DEG, DEG), strict=True))
    return f"x {x:.1f} y {y:.1f} z {z:.1f} mm, a {a:.2f} b {b:.2f} c {c:.2f} deg"


def coordinate_words(coordinates: Iterable[float], labels: Iterable[str], turns: Iterable[bool]) -> str:
    """Coordinates of a machine [m or rad] in words."""
    return ", ".join(
        f"{label} {value / (DEG if turning else MM):.{2 if turning else 1}f} {'deg' if turning else 'mm'}"
        for value, label, turning in zip(coordinates, labels, turns, strict=True)
    )


def payload_words(count: int) -> str:
    """How many payloads are mounted, in words."""
    return f"{count} payload{'' if count == 1 else 's'}"


def as_html(text: str) -> str:
    """Text as it stands, for `_repr_html_`."""
    return f"<pre>{escape(text)}</pre>"
