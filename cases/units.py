"""The constants that turn file units into SI and back, in one place.

`value_SI = value_in_file * CONSTANT`.
"""

import math
import re
from collections.abc import Iterable
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

_OWN = {"mm": MM, "um": UM, "deg": DEG, "ms": MS}
_ENDING = re.compile(r"_(mm|um|deg|ms)(_s\d?)?$")


def own_units(keys: Iterable[str]) -> Array:
    """SI values of the units that keys and columns end in, shape (keys,); 1 where they are SI, or have none."""
    return np.array([_OWN[match[1]] if (match := _ENDING.search(key)) else 1.0 for key in keys])


def as_html(value: object) -> str:
    """The `_repr_html_` of values: their `repr` as it stands."""
    return f"<pre>{escape(repr(value))}</pre>"
