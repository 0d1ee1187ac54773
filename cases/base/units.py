"""The constants that turn file units into SI and back: `value_SI = value_in_file * CONSTANT`."""

import math
from html import escape

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Floats of any shape."""
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]

MM = 1e-3  # [m]
UM = 1e-6  # [m]
DEG = math.pi / 180.0  # [rad]
MS = 1e-3  # [s]
MINUTE = 60.0  # [s]


def as_html(value: object) -> str:
    """The `_repr_html_` of values: their text as it is printed."""
    return f"<pre>{escape(str(value))}</pre>"
