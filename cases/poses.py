"""Quasi-static measurement: the grid of candidate poses, what counts as a valid pose, and how long it is measured.

A chain has no grid: its poses are searched for in the box of `[limits.motion]`.
"""

from functools import cached_property
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field

from cases.parts import Array, Number, Part, Positive, Range, frozen
from cases.units import DEG, MM


def _climbing(value: tuple[float, float, float]) -> tuple[float, float, float]:
    first, last, step = value
    if not (first <= last and step > 0.0):
        raise ValueError(
            f"[{first:g}, {last:g}, {step:g}] is not a range [first, last, step]; step up from first to last"
        )
    return value


Steps = Annotated[tuple[Number, Number, Number], AfterValidator(_climbing)]
"""First value, last value, step."""


class JointPoses(Part):
    """How long a chain is measured at each pose; which poses are possible, `[limits.motion]` and its bodies say."""

    settle_s: Positive
    """Waited at each pose before averaging begins."""
    average_s: Positive
    """Averaged at each pose."""


class Poses(JointPoses):
    """Poses in tilt-and-torsion angles, R = Rz(azimuth) Ry(tilt) Rz(torsion - azimuth); positions relative to home."""

    x_mm: Steps
    """Grid of positions relative to home: [first, last, step]."""
    y_mm: Steps
    """As `x_mm`."""
    z_mm: Steps
    """As `x_mm`."""
    radius_mm: Range
    """Distance from home in the XY plane: grid points outside are left out."""
    tilt_deg: Steps
    """Grid of tilts: [first, last, step]."""
    azimuth_deg: Steps
    """Grid of the tilts' directions: [first, last, step]."""
    torsion_deg: Steps
    """Grid of turns about the tilted z axis: [first, last, step]."""
    singularity_distance: Annotated[float, Field(strict=True, gt=0, lt=1)]
    """Smallest determinant of the machine's inverse Jacobian, as a share of that at home."""

    @cached_property
    def lengths(self) -> tuple[Array, Array, Array]:
        """Grid values of x, y and z relative to home [m]."""
        return tuple(_values(s, MM) for s in (self.x_mm, self.y_mm, self.z_mm))  # type: ignore[return-value]

    @cached_property
    def angles(self) -> tuple[Array, Array, Array]:
        """Grid values of tilt, azimuth and torsion [rad]."""
        return tuple(_values(s, DEG) for s in (self.tilt_deg, self.azimuth_deg, self.torsion_deg))  # type: ignore[return-value]

    @cached_property
    def radius(self) -> Array:
        """Smallest and largest distance from home in the XY plane, shape (2,) [m]."""
        return frozen(np.array(self.radius_mm) * MM)

    @property
    def grid_size(self) -> int:
        """Points of the grid before any is left out."""
        return int(np.prod([_count(s) for s in (self.x_mm, self.y_mm, self.z_mm)], dtype=float)) * int(
            np.prod([_count(s) for s in (self.tilt_deg, self.azimuth_deg, self.torsion_deg)], dtype=float)
        )


def _count(steps: tuple[float, float, float]) -> int:
    first, last, step = steps
    return int(np.floor((last - first) / step + 1e-9)) + 1


def _values(steps: tuple[float, float, float], unit: float) -> Array:
    return frozen((steps[0] + steps[2] * np.arange(_count(steps))) * unit)
