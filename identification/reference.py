"""The reference scaling H* of a case and model: column RMS of the regressor over uniform states of the motion box.

The paper's own scaling (26) depends on the motion at hand, so that criteria of two motions could not be compared.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.evaluate import over_samples
from identification.model import Model

Array = NDArray[np.float64]

STATES = 20_000
SEED = 0


class BoxStates(NamedTuple):
    """States of the motion box, one row each: coordinates, rates and accelerations, shapes (n, k)."""

    pose: Array
    rates: Array
    accelerations: Array


def uniform_states(case: Case, count: int, seed: int) -> BoxStates:
    """Independent uniform states of the motion box of a case.

    Raises:
        CaseError: the case has no machine or no limits.
    """
    home, box = case.need_motion("the reference scaling")
    shape = (count, len(home))
    draw = np.random.default_rng(seed)
    pose = home + draw.uniform(box.pose[0], box.pose[1], shape)
    rates = draw.uniform(-box.rate, box.rate, shape)
    return BoxStates(pose, rates, draw.uniform(-box.acceleration, box.acceleration, shape))


def reference_scaling(case: Case, model: Model) -> Array:
    """H*: one over the RMS of each regressor column, over 20 000 seeded uniform states of the box, shape (u,)."""
    states = uniform_states(case, STATES, SEED)
    matrices = over_samples(model.coordinate_regressor, *states)[0]
    return np.asarray(1.0 / np.sqrt(np.einsum("nij,nij->j", matrices, matrices) / STATES))


def information(model: Model, scaling: Array, states: BoxStates) -> Array:
    """Mean of H A^T A H over states (equal sensors, W = 1), shape (u, u)."""
    matrices = over_samples(model.coordinate_regressor, *states)[0].reshape(-1, len(scaling)) * scaling
    return np.asarray(matrices.T @ matrices / len(states.pose))
