"""Six lines in space: whether forces along them hold a body in all six degrees of freedom."""

import numpy as np

from cases.parts import Array

# Beyond this condition number (moments divided by the size) errors are amplified a thousandfold.
WORST_CONDITION = 1e3


def condition_of_lines(points: Array, directions: Array) -> float:
    """Condition number of six lines, moments divided by the largest distance of a point from the origin.

    Args:
        points: one on each line, shape (6, 3) [m].
        directions: of any length but 0, shape (6, 3).
    """
    unit = directions / np.linalg.norm(directions, axis=1)[:, None]
    size = max(float(np.linalg.norm(points, axis=1).max()), 1e-9)
    return float(np.linalg.cond(np.hstack([unit, np.cross(points, unit) / size])))
