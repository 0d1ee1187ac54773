"""Random unknowns of any family; a search begins from such ones of series and splines, from annealed walks of moves."""

from collections.abc import Callable

import numpy as np

from identification.motion.moves import fastest_profile
from planner.families.family import Family
from planner.families.ptp import PointToPointFamily

WIDTH = 0.9  # waypoints lie within this share of the box
BISECTIONS = 30
TINY = 1e-12  # [m, rad] a coordinate that does not move has no limits


def random_start(family: Family, draw: np.random.Generator, worst: Callable[[np.ndarray], float]) -> np.ndarray:
    """Unknowns well inside the limits; of moves random waypoints, moved together until the fastest moves just fit."""
    if not isinstance(family, PointToPointFamily):
        return family.start(draw, worst)
    directions = draw.uniform(-WIDTH, WIDTH, (family.moves + 1, family.coordinates))
    small, large = 0.0, 1.0
    for _ in range(BISECTIONS):
        width = (small + large) / 2
        longer = float((_fastest_times(family, width * directions) @ [4.0, 2.0, 1.0]).sum()) > family.duration
        small, large = (small, width) if longer else (width, large)
    times = _fastest_times(family, small * directions)
    times *= family.duration / (times @ [4.0, 2.0, 1.0]).sum()
    return np.concatenate([(small * directions).ravel(), times.ravel() / family.unit])


def _fastest_times(family: PointToPointFamily, points: np.ndarray) -> np.ndarray:
    ways = np.abs(np.diff(points, axis=0)) * family.half
    limits = np.min(family.limits[:, None, :] / np.maximum(ways, TINY), axis=2)
    return np.array([fastest_profile(1.0, *limits[:, k])[1:] for k in range(family.moves)])
