"""What an executed motion really reached, as shares of the case's limits, approach and return included."""

import numpy as np
from numpy.typing import NDArray

from cases.machine import MotionLimits
from cases.schema import Case
from identification.hexapod import Kinematics
from identification.trajectories.executed import Execution

Array = NDArray[np.float64]

CHUNK = 20_000  # instants at once, bounds memory


def coordinate_rates(kinematics: Kinematics) -> tuple[Array, Array]:
    """First and second time derivatives of the six coordinates, each (n, 6), from twist and twist rate.

    omega = roll' e1 + pitch' e2 + yaw' ez with e2 = Rz ey and e1 = Rz Ry ex, which turn with the angles before them:
    (37), (38) solved for the coordinates.
    """
    pitch, yaw = kinematics.pose[:, 4], kinematics.pose[:, 5]
    zero, one = np.zeros_like(yaw), np.ones_like(yaw)
    e1 = np.column_stack([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)])
    e2 = np.column_stack([-np.sin(yaw), np.cos(yaw), zero])
    ez = np.column_stack([zero, zero, one])
    axes = np.stack([e1, e2, ez], axis=2)
    angular = np.linalg.solve(axes, kinematics.twist[:, 3:, None])[:, :, 0]
    about_z = angular[:, 2:] * ez
    e1_rate = np.cross(about_z + angular[:, 1:2] * e2, e1)
    e2_rate = np.cross(about_z, e2)
    drift = angular[:, :1] * e1_rate + angular[:, 1:2] * e2_rate
    second = np.linalg.solve(axes, (kinematics.twist_rate[:, 3:] - drift)[:, :, None])[:, :, 0]
    return np.hstack([kinematics.twist[:, :3], angular]), np.hstack([kinematics.twist_rate[:, :3], second])


def executed_peaks(execution: Execution, case: Case) -> dict[str, float]:
    """Largest share of each kinetic limit over the whole run, by the name of the limit.

    Evaluated at `execution.extremes`: there, between two cycles of a controller that interpolates by cubic splines, are
    the largest accelerations.

    Args:
        execution: what the controller did.
        case: its limits.

    Raises:
        CaseError: the case has no machine.
    """
    limits = case.need_motion("the rating of a run")[1]
    instants = execution.extremes
    worst: dict[str, float] = {}
    for first in range(0, len(instants), CHUNK):
        t = instants[first : first + CHUNK]
        drives = execution.struts(t, 1), execution.struts(t, 2)
        rates, accelerations = coordinate_rates(execution.kinematics(t)) if execution.machine.of_pose else drives
        velocity, acceleration = np.abs(rates) / limits.rate, np.abs(accelerations) / limits.acceleration
        found = {
            "velocity": velocity[:, ~limits.turns],
            "angular velocity": velocity[:, limits.turns],
            "acceleration": acceleration[:, ~limits.turns],
            "angular acceleration": acceleration[:, limits.turns],
        }
        if isinstance(limits, MotionLimits):  # the struts of a hexapod have limits of their own
            found["strut velocity"] = np.abs(drives[0]) / limits.strut_velocity_m_s
            found["strut acceleration"] = np.abs(drives[1]) / limits.strut_acceleration_m_s2
        for name, shares in found.items():
            if shares.size:
                worst[name] = max(worst.get(name, 0.0), float(shares.max()))
    return worst
