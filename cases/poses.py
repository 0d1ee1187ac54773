"""Poses of a case: the table `[poses]` of quasi-static measurement, with the grid of candidate poses of a hexapod."""

import math
from functools import cached_property
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from cases.base.units import Array
from cases.tables import Grid, Part, Positive, Range, frozen, own_units, si

GRID = ("x_mm", "y_mm", "z_mm", "tilt_deg", "azimuth_deg", "torsion_deg")


class Poses(Part):
    """How long poses are measured, and of a hexapod the grid of candidates; a chain's lie in `[limits.motion]`.

    Tilt-and-torsion angles, R = Rz(azimuth) Ry(tilt) Rz(torsion - azimuth); positions relative to home.
    """

    settle_s: Positive
    """Waited at each pose before averaging begins."""
    average_s: Positive
    """Averaged at each pose."""
    x_mm: Grid | None = None
    """Grid of positions relative to home: [first, last, step]; a hexapod needs it, and all below."""
    y_mm: Grid | None = None
    z_mm: Grid | None = None
    radius_mm: Range | None = None
    """Distance from home in the XY plane: grid points outside are left out."""
    tilt_deg: Grid | None = None
    """Grid of tilts: [first, last, step]."""
    azimuth_deg: Grid | None = None
    """Grid of the tilts' directions: [first, last, step]."""
    torsion_deg: Grid | None = None
    """Grid of turns about the tilted z axis: [first, last, step]."""
    singularity_distance: Annotated[float, Field(strict=True, gt=0, lt=1)] | None = None
    """Smallest determinant of the machine's inverse Jacobian, as a share of that at home."""

    radius: ClassVar = si("radius_mm")  # smallest and largest distance from home in the XY plane, shape (2,) [m]

    @cached_property
    def axes(self) -> tuple[Array, ...]:
        """Grid values of x, y and z relative to home [m], and of tilt, azimuth and torsion [rad]."""
        return tuple(
            frozen((getattr(self, key)[0] + getattr(self, key)[2] * np.arange(self._count(key))) * own_units([key]))
            for key in GRID
        )

    @property
    def grid_size(self) -> int:
        """Points of the grid before any is left out."""
        return math.prod(map(self._count, GRID))

    def _count(self, key: str) -> int:
        first, last, step = getattr(self, key)
        return int(np.floor((last - first) / step + 1e-9)) + 1
