"""A motion at a share of its speed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from identification.motion import Motion, Trajectory


@dataclass(frozen=True, slots=True)
class Slowed:
    """A motion at a share of its speed: the same path, everything else slower.

    Args:
        speed: share of it, above 0.
    """

    motion: Trajectory
    speed: float

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return self.motion.duration / self.speed

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        fast = self.motion.at(np.clip(time * self.speed, 0.0, self.motion.duration))
        s = self.speed
        return Motion(time, fast.pose, fast.rates * s, fast.accelerations * s**2, fast.jerks * s**3)
