"""Time laws from rest to rest computed by ruckig, independently of the closed forms that programs are made with."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from ruckig import InputParameter, Result, Ruckig, Trajectory

from cases.errors import ExecutionError
from identification.trajectories.profile import TimeLaw
from postprocessors.proving.guarantees import Law, limits_jerk

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RuckigLaw:
    """A way of 1 from rest to rest in segments of constant jerk."""

    ends: Array  # when each segment ends, shape (7,) [s]
    states: Array  # position, velocity, acceleration and jerk at the start of each segment, shape (4, 7)

    @classmethod
    def within(cls, velocity: float, acceleration: float, jerk: float) -> "RuckigLaw":
        """The fastest within limits above 0; the jerk may be infinite.

        Raises:
            ExecutionError: ruckig finds none.
        """
        wanted = InputParameter(1)
        wanted.current_position, wanted.target_position = [0.0], [1.0]
        wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = [velocity], [acceleration], [jerk]
        found = Trajectory(1)
        result = Ruckig(1).calculate(wanted, found)
        if result != Result.Working:  # offline, this is what success is called
            raise ExecutionError(f"ruckig cannot time a move ({result}); slow it down or make it longer")
        profile = found.profiles[0][0]
        values = (profile.p[:7], profile.v[:7], profile.a[:7], profile.j)
        return cls(np.cumsum(profile.t), np.array(values, dtype=float))

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return float(self.ends[-1])

    @property
    def peak_velocity(self) -> float:
        """Largest velocity [1/s]."""
        _, v, a, j = self.states
        lengths = np.diff(self.ends, prepend=0.0)
        to_the_top = np.clip(np.divide(-a, j, out=np.zeros(7), where=j != 0.0), 0.0, lengths)
        return float(np.max(v + to_the_top * (a + to_the_top * j / 2)))

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """Share of the way covered, and its derivatives, at times t, each of shape (n,)."""
        time = np.clip(np.asarray(t, dtype=float), 0.0, self.duration)
        k = np.minimum(np.searchsorted(self.ends, time, side="left"), 6)
        tau = time - np.r_[0.0, self.ends][k]
        p, v, a, j = self.states[:, k]
        return p + tau * (v + tau * (a / 2 + tau * j / 6)), v + tau * (a + tau * j / 2), a + tau * j, j

    def slowed(self, speed: float) -> "RuckigLaw":
        """The same way at a share of the speed."""
        return RuckigLaw(self.ends / speed, self.states * (speed ** np.arange(4.0))[:, None])


def by_ruckig(law: Law) -> Law:
    """A law of the same kind, with a jerk limit or without, computed by ruckig within the limits as they are given."""

    def timed(velocity: float, acceleration: float, jerk: float) -> TimeLaw:
        return RuckigLaw.within(velocity, acceleration, jerk if limits_jerk(law) else math.inf)

    return timed
