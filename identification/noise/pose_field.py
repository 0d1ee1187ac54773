"""Errors that depend on the pose, as a random field over the struts' lengths.

Encoders, joints, frame and geometry err in the same way wherever a motion comes back to a place. As in kriging (Cressie
1993, Statistics for Spatial Data), the error of a channel is a random function of the place: its correlation is of
Matern's form with smoothness 3/2 (Stein 1999, Interpolation of Spatial Data), and channels are independent of each
other. Struts are one unit for places and turns.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.sensors import Sensors
from cases.units import MM

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PoseField:
    """A field of errors."""

    size: float  # standard deviation of a channel's error [N]
    length: float  # distance in the space of the six strut lengths at which errors are half alike [m]

    @classmethod
    def of(cls, sensors: Sensors) -> "PoseField | None":
        """The field that a case states; None where it states none."""
        if sensors.pose_error_N is None or sensors.pose_error_length_mm is None:
            return None
        return cls(sensors.pose_error_N, sensors.pose_error_length_mm * MM)

    @property
    def keys(self) -> dict[str, float]:
        """As `[sensors]` of a case states it."""
        return {"pose_error_N": float(f"{self.size:.3g}"), "pose_error_length_mm": float(f"{self.length / MM:.3g}")}

    @property
    def words(self) -> str:
        """For people."""
        return f"{self.size:.3g} N over {self.length / MM:.3g} mm of strut lengths"

    def covariance(self, struts: Array) -> Array:
        """Covariance of a channel's errors between places, shape (n, n) [N^2]; struts: shape (n, 6) [m]."""
        return self.size**2 * matern(np.sqrt(squared_distances(struts, struts)) / self.length)[0]


def squared_distances(places: Array, others: Array) -> Array:
    """Between places, shapes (n, d) and (m, d), shape (n, m)."""
    middle = others.mean(axis=0)
    first, second = places - middle, others - middle
    total = np.sum(first**2, axis=1)[:, None] + np.sum(second**2, axis=1)
    return np.asarray(np.maximum(total - 2.0 * first @ second.T, 0.0))


def matern(distance: Array) -> tuple[Array, Array]:
    """Matern's correlation of smoothness 3/2, and its derivative by the logarithm of the length.

    Args:
        distance: distance in lengths.
    """
    scaled = np.sqrt(3.0) * distance
    fading = np.exp(-scaled)
    return (1.0 + scaled) * fading, scaled**2 * fading
