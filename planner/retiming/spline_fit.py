"""The cubic spline nearest to a motion: what controllers take as polynomials, and plans keep as pieces."""

import numpy as np
from numpy.typing import NDArray

from identification.motion import Trajectory
from identification.trajectories.polynomial import Piece, PolynomialMotion

Array = NDArray[np.float64]

SAMPLES = 8  # of each interval, by whose poses the spline is fitted


def fitted_spline(motion: Trajectory, step: float) -> PolynomialMotion:
    """The cubic spline over equal intervals that is nearest to a motion in the mean square of its poses.

    It begins and ends at the motion's ends, with rates and accelerations zero there. Its jerk is constant in each
    interval.

    Args:
        motion: from rest to rest.
        step: of the intervals, at most [s].
    """
    from scipy.interpolate import BSpline
    from scipy.sparse.linalg import spsolve

    count = max(8, int(np.ceil(motion.duration / step - 1e-9)))
    length = motion.duration / count
    begins = np.arange(count) * length
    knots = np.concatenate([np.zeros(3), begins, np.full(4, motion.duration)])
    t = np.linspace(0.0, motion.duration, SAMPLES * count + 1)
    poses = motion.at(t).pose
    basis = BSpline.design_matrix(t, knots, 3).tocsc()
    fixed = np.repeat(poses[[0, -1]], 3, axis=0)  # three equal coefficients at an end: no rate, no acceleration
    inner, outer = basis[:, 3:-3], basis[:, [0, 1, 2, -3, -2, -1]]
    free = spsolve((inner.T @ inner).tocsc(), inner.T @ (poses - outer @ fixed))
    spline = BSpline(knots, np.concatenate([fixed[:3], free, fixed[3:]]), 3)
    # Taylor's coefficients at the start of each interval; the third derivative is constant and jumps there.
    taylor = [spline(begins, nu=order) / (1.0, 1.0, 2.0)[order] for order in range(3)]
    taylor.append(spline(begins + length / 2, nu=3) / 6.0)
    return PolynomialMotion(tuple(Piece(np.array([c[k] for c in taylor]), length) for k in range(count)))
