"""Quintic run-in: from rest at one pose to a state of pose, rate and acceleration, and its mirror image, the run-out.

A series of one harmonic never rests: its rate and acceleration have no common zero. It is led in and out of, and so
carries nothing but its own harmonic while it runs.
"""

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Over the share s of the time, from rest: to a way, a rate, an acceleration of 1 at s = 1, each alone.
_TO_WAY = Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
_TO_RATE = Polynomial([0.0, 0.0, 0.0, -4.0, 7.0, -3.0])
_TO_ACCELERATION = Polynomial([0.0, 0.0, 0.0, 0.5, -1.0, 0.5])


def run_in(time: Array, duration: float) -> tuple[Array, Array, Array, Array]:
    """Matrices from the state reached (way, rate, acceleration) to value, rate, acceleration and jerk on the way there.

    Args:
        time: after the start out of rest, shape (n,) [s], from 0 to duration.
        duration: [s].

    Returns:
        Four matrices of shape (n, 3).
    """
    share = time / duration
    shapes = ((_TO_WAY, 1.0), (_TO_RATE, duration), (_TO_ACCELERATION, duration**2))
    value, rate, acceleration, jerk = (
        np.column_stack([p.deriv(order)(share) * unit if order else p(share) * unit for p, unit in shapes])
        / duration**order
        for order in range(4)
    )
    return value, rate, acceleration, jerk


def run_out(time: Array, duration: float) -> tuple[Array, Array, Array, Array]:
    """The same from the state back to rest, `time` after leaving it: a run-in with time reversed."""
    mirror = np.array([1.0, -1.0, 1.0])
    value, rate, acceleration, jerk = (
        matrix * mirror * (-1.0) ** order for order, matrix in enumerate(run_in(duration - time, duration))
    )
    return value, rate, acceleration, jerk
