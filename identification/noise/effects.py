"""How noise of the accelerations changes the regressor: exactly, for A is affine in them."""

import numpy as np
from numpy.typing import NDArray

from identification.evaluate import over_samples
from identification.hexapod import Hexapod, Kinematics
from identification.model import Model, regressors

Array = NDArray[np.float64]


def acceleration_effects(hexapod: Hexapod, model: Model, motion: Kinematics) -> list[Array]:
    """dA/dq''_s for each strut s, shape (n, 6, u) [per m/s^2]."""
    to_twist_rate = np.linalg.inv(over_samples(hexapod.inverse_jacobian, motion.pose)[1])
    return _effects(model, motion, to_twist_rate.astype(np.float64))


def twist_rate_effects(model: Model, motion: Kinematics) -> list[Array]:
    """The same for each component of the twist rate [per m/s^2, rad/s^2]."""
    return _effects(model, motion, np.tile(np.eye(6), (len(motion.pose), 1, 1)))


def _effects(model: Model, motion: Kinematics, directions: Array) -> list[Array]:
    """What a step of the twist rate along each column of `directions`, shape (n, 6, 6), changes A by."""
    here = regressors(model, motion)
    return [
        regressors(model, Kinematics(motion.pose, motion.twist, motion.twist_rate + directions[:, :, k])) - here
        for k in range(6)
    ]
