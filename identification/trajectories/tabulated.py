"""A motion given row by row with its derivatives, as a generator of setpoints hands it to the drives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from identification.motion import Motion

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Tabulated:
    """Rows of pose, rates and accelerations at equal steps, from rest to rest.

    Between rows the pose is the cubic that shares pose and rates with both; rates and accelerations, which a table
    states for themselves, go straight from row to row. Jerks are the slopes of accelerations.

    Args:
        times: shape (k,), equal steps from 0 [s].
        pose: coordinates, shape (k, n) [m or rad].
        rates: shape (k, n) [m/s or rad/s].
        accelerations: shape (k, n) [m/s^2 or rad/s^2].

    Raises:
        ValueError: fewer than two rows, or shapes that do not belong together.
    """

    times: Array
    pose: Array
    rates: Array
    accelerations: Array

    def __post_init__(self) -> None:
        shape = (len(self.times), *self.pose.shape[1:2])
        if len(self.times) < 2 or any(v.shape != shape for v in (self.pose, self.rates, self.accelerations)):
            raise ValueError("a table needs two rows or more, each with as many coordinates, rates and accelerations")

    @property
    def duration(self) -> float:
        """Time of the last row [s]."""
        return float(self.times[-1])

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        k = np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, len(self.times) - 2)
        step = (self.times[k + 1] - self.times[k])[:, None]
        p = (time - self.times[k])[:, None] / step
        start, end = self.pose[k], self.pose[k + 1]
        pose = start * (1 + 2 * p) * (1 - p) ** 2 + end * p**2 * (3 - 2 * p)
        pose += step * p * (1 - p) * (self.rates[k] * (1 - p) - self.rates[k + 1] * p)
        rates = self.rates[k] * (1 - p) + self.rates[k + 1] * p
        accelerations = self.accelerations[k] * (1 - p) + self.accelerations[k + 1] * p
        jerks = (self.accelerations[k + 1] - self.accelerations[k]) / step
        return Motion(time, pose, rates, accelerations, np.ascontiguousarray(jerks))
