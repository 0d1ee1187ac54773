"""The constants that turn file units into SI and back, in one place.

`value_SI = value_in_file * CONSTANT`.
"""

import math

MM = 1e-3  # [m]
UM = 1e-6  # [m]
DEG = math.pi / 180.0  # [rad]
MS = 1e-3  # [s]
MINUTE = 60.0  # [s]
