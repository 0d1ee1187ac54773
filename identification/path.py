"""How far an executed motion strayed from the planned one, and what information it still carries."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from identification.executed import Execution
from identification.model import Model
from identification.motion import Trajectory, sample
from identification.simulate import regressors

Array = NDArray[np.float64]

PLAN_RATE = 10_000.0  # [1/s]: at 0.6 m/s neighbours are 0.06 mm apart, so the error is exact to some micrometres
RATE = 1000.0


def instants(windows: Array, rate: float = RATE) -> Array:
    """Instants inside windows, shape (n,) [s], evenly spaced and off their edges."""
    return np.concatenate(
        [start + (np.arange(max(1, round((end - start) * rate))) + 0.5) / rate for start, end in windows]
    )


def path_error(planned: Trajectory, execution: Execution, windows: Array) -> float:
    """Largest distance of the executed position from the planned path, whatever the timing [m].

    Args:
        planned: the excitation.
        execution: what the controller did.
        windows: when it ran the excitation, shape (k, 2) [s].
    """
    tree = cKDTree(sample(planned, PLAN_RATE).pose[:, :3])
    executed = execution.kinematics(np.clip(instants(windows), 0.0, execution.duration)).pose[:, :3]
    return float(tree.query(executed)[0].max())


def executed_information(model: Model, scaling: Array, execution: Execution, windows: Array) -> Array:
    """Time average of H A^T A H over the executed excitation, shape (u, u); W = 1."""
    t = np.clip(instants(windows), 0.0, execution.duration)
    rows = regressors(model, execution.kinematics(t)).reshape(-1, len(scaling)) * scaling
    return np.asarray(rows.T @ rows / len(t))
