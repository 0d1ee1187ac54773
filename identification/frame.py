"""The sensor frame's structure matrix J^-T, (2): six sensor forces -> force and moment on the platform, in {P}."""

import numpy as np
from numpy.typing import NDArray

from cases.sensors import SensorFrame

Array = NDArray[np.float64]


def structure_matrix(frame: SensorFrame) -> Array:
    """J^-T of (2), shape (6, 6): columns (n_k; h_k x n_k) for bars [-, m].

    Bar k runs from its lower point h_k to its upper point along n_k. A force/torque sensor that reads the support's
    push has J^-T = 1, one that reads the load's pull J^-T = -1.
    """
    if frame.bars is not None:
        lower, upper = frame.bars.lower.points, frame.bars.upper.points
        direction = (upper - lower) / np.linalg.norm(upper - lower, axis=1)[:, None]
        return np.vstack([direction.T, np.cross(lower, direction).T])
    if frame.transducer is None:
        raise ValueError("the structure matrix of sensors in struts depends on the pose: `strut_sensors.structure`")
    return np.eye(6) * {"load_on_sensor": -1.0, "sensor_on_load": 1.0}[frame.transducer.sense]
