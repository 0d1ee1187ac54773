"""How far an executed motion strayed from the planned one, and what information it still carries."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from identification.model import Model, regressors
from identification.motion import Trajectory, sample
from identification.signals import Filter
from identification.trajectories.executed import Execution

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
        windows: when it ran the excitation, shape (k, 2) [s].
    """
    positions = execution.machine.positions(sample(planned, PLAN_RATE).pose)
    # Where the machine stands or only turns, a query would look at thousands of places that are all as near.
    passed = positions[np.r_[True, np.any(np.diff(positions, axis=0) != 0.0, axis=1)]]
    tree = cKDTree(passed)
    executed = execution.kinematics(np.clip(instants(windows), 0.0, execution.duration)).pose[:, :3]
    return float(tree.query(executed)[0].max())


def executed_information(model: Model, scaling: Array, execution: Execution, windows: Array, cutoff: float) -> Array:
    """Time average of H A^T A H over the executed excitation, behind the filter of the evaluation, shape (u, u); W = 1.

    Controllers that run a path in short blocks add ripple above the limits; the evaluation filters it off, so that it
    must not count as information.

    Args:
        scaling: diagonal of H, shape (u,).
        windows: when it ran the excitation, shape (k, 2) [s].
        cutoff: cutoff of the low-pass [Hz].
    """
    low_pass = Filter(cutoff, 1.0 / RATE)
    t = np.arange(int(execution.duration * RATE) + 1) / RATE
    struts = execution.struts(t)
    inside = t[low_pass.margin : -low_pass.margin]
    rows = np.zeros(len(inside), dtype=bool)
    for start, end in windows:
        rows |= (inside >= start) & (inside < end)
    motion = [low_pass.apply(struts, order)[rows] for order in range(3)]
    matrices = regressors(model, execution.machine.kinematics(*motion)).reshape(-1, len(scaling)) * scaling
    return np.asarray(matrices.T @ matrices / rows.sum())
