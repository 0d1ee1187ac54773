"""A motion as a controller executed it: continuous in time, with struts and platform kinematics at any instant.

Drives that ripple and a platform that vibrates are executed motions too.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from cases.base.renamed import renamed
from cases.base.units import Array
from cases.sensors import Disturbances
from identification.machines.casadi_batch import over_samples
from identification.machines.machine import Kinematics, Machine
from identification.machines.rotations import pose_rates, twist_rate
from identification.motion.motion import Motion, Trajectory, sample

if TYPE_CHECKING:
    from scipy.interpolate import BSpline


@renamed(struts="drives")
@dataclass(frozen=True, slots=True)
class Execution:
    """What the machine did, from time 0 to `duration`, under a controller that interpolates drives as LinuxCNC does.

    Its interpolator makes a uniform cubic B-spline of the inverse kinematics, and logs positions on it; accelerations
    are straight lines between those of the cycles, and known exactly.
    """

    machine: Machine
    spline: "BSpline"  # drives over time [m or rad]

    @classmethod
    def of_log(cls, machine: Machine, period: float, drives: Array) -> "Execution":
        """Through logged drives, shape (n, k) [m or rad], one each `period` [s]."""
        from scipy.interpolate import make_interp_spline

        return cls(machine, make_interp_spline(np.arange(len(drives)) * period, drives, k=3))

    @classmethod
    def of_set_points(cls, machine: Machine, period: float, drives: Array) -> "Execution":
        """The uniform B-spline whose control points are set points, shape (n, k) [m or rad], one each `period` [s].

        It begins and ends standing still, and accelerates no more than the set points do from cycle to cycle.
        """
        points = np.vstack([drives[:1], drives, drives[-1:]])
        return cls.of_log(machine, period, (points[:-2] + 4.0 * points[1:-1] + points[2:]) / 6.0)

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return float(self.spline.t[-1])

    @property
    def extremes(self) -> Array:
        """The spline's knots, shape (n,) [s]: accelerations of the drives are straight lines between them."""
        return np.unique(self.spline.t)

    def drives(self, t: ArrayLike, order: int = 0) -> Array:
        """Drives at times t, or their first or second derivatives, shape (n, k)."""
        return np.asarray(self.spline(t, nu=order))

    def kinematics(self, t: ArrayLike) -> Kinematics:
        """Motion of the platform at times t, shape (n,) [s]."""
        return self.machine.kinematics(self.spline(t), self.spline(t, nu=1), self.spline(t, nu=2))


@lru_cache(maxsize=1)
def coordinate_rates() -> ca.Function:
    """(pose, twist, twist rate) -> first and second time derivatives of the pose: (37), (38) solved for them."""
    pose, moving, changing = (ca.SX.sym(n, 6) for n in ("pose", "twist", "twist_rate"))
    rates = pose_rates(pose, moving)
    accelerations = pose_rates(pose, changing - twist_rate(pose, rates, ca.SX.zeros(6)))
    return ca.Function("coordinate_rates", [pose, moving, changing], [rates, accelerations])


def executed_motion(execution: Execution, t: Array) -> Motion:
    """Coordinates with two derivatives at times t, shape (n,) [s]; jerks, which no log shows, are 0."""
    if execution.machine.of_pose:
        moving = execution.kinematics(t)
        pose = moving.pose
        rates, accelerations = over_samples(coordinate_rates(), pose, moving.twist, moving.twist_rate)
    else:
        pose, rates, accelerations = (execution.drives(t, order) for order in range(3))
    return Motion(t, pose, rates, accelerations, np.zeros_like(pose))


PLAN_RATE = 10_000.0  # [1/s]: at 10 m/s^2 the path leaves the lines between such points by 13 nm
RATE = 1000.0


def instants(windows: Array, rate: float = RATE) -> Array:
    """Instants inside windows, shape (n,) [s], evenly spaced and off their edges."""
    return np.concatenate(
        [start + (np.arange(max(1, round((end - start) * rate))) + 0.5) / rate for start, end in windows]
    )


def path_error(planned: Trajectory, execution: Execution, windows: Array) -> float:
    """Largest distance of the executed position from the planned path in windows, shape (k, 2) [s], at any pace [m]."""
    path = execution.machine.positions(sample(planned, PLAN_RATE).coordinates)
    executed = execution.kinematics(np.clip(instants(windows), 0.0, execution.duration)).pose[:, :3]
    return largest_distance(executed, path)


NEIGHBOURS = 16  # points of a path whose lines are tried before all are: a motion may pass a place many times


def largest_distance(points: Array, path: Array) -> float:
    """Largest distance of points, shape (n, 3), from the lines that join the points of a path, shape (m, 3)."""
    from scipy.spatial import cKDTree  # loads slowly, and plans that look at a mode do without

    # Where the machine stands or only turns, a query would look at thousands of places that are all as near; splines
    # leave ways there that are not zero, but whose squares are.
    path = path[np.r_[True, np.square(np.diff(path, axis=0)).sum(axis=1) > 0.0]]
    if len(path) == 1:
        return float(np.linalg.norm(points - path, axis=1).max())
    starts, ways = path[:-1], np.diff(path, axis=0)
    nearest = cKDTree(path).query(points, min(NEIGHBOURS, len(path)))[1].reshape(len(points), -1)
    lines = np.clip(np.stack([nearest - 1, nearest]), 0, len(ways) - 1)  # that end and begin there
    bounds = _from_lines(points[:, None], starts[lines], ways[lines]).min(axis=(0, 2))
    largest = 0.0
    for k in np.argsort(-bounds):
        if bounds[k] <= largest:
            break
        largest = max(largest, float(_from_lines(points[k], starts, ways).min()))
    return largest


def _from_lines(points: Array, starts: Array, ways: Array) -> Array:
    """Distances of points from lines of some length above 0, from their starts along their ways, shape (n,)."""
    shares = np.einsum("...k,...k", points - starts, ways) / np.einsum("...k,...k", ways, ways)
    return np.asarray(np.linalg.norm(points - starts - np.clip(shares, 0.0, 1.0)[..., None] * ways, axis=-1))


RIPPLE_STEP = 1e-3  # [s] between the samples of the ripple


def rippled(execution: Execution, disturbances: Disturbances, seed: int) -> Execution:
    """The execution with a ripple of the struts on top, which encoders and sensors both see.

    It grows with the speed, as errors of screws and gears make it.
    """
    if disturbances.ripple == 0.0:
        return execution
    from scipy.signal import butter, sosfiltfilt

    t = np.arange(0.0, execution.duration + 2 * RIPPLE_STEP, RIPPLE_STEP)
    inside = np.clip(t, 0.0, execution.duration)
    lengths, speeds = execution.drives(inside), execution.drives(inside, 1)
    draw = np.random.default_rng([seed, 1])
    band = (0.05 * disturbances.strut_velocity_band_Hz, disturbances.strut_velocity_band_Hz)
    sections = butter(3, band, btype="bandpass", fs=1.0 / RIPPLE_STEP, output="sos")
    velocity = sosfiltfilt(sections, draw.normal(size=lengths.shape), axis=0)
    velocity *= disturbances.ripple * speeds / np.sqrt(np.mean(velocity**2, axis=0))
    return Execution.of_log(execution.machine, RIPPLE_STEP, lengths + np.cumsum(velocity, axis=0) * RIPPLE_STEP)


def mode_frequency(disturbances: Disturbances, mass: float, load: float) -> float:
    """Frequency of the structural mode [Hz]: of the structure's stiffness, and the masses of platform and load [kg]."""
    return float(disturbances.mode_Hz * np.sqrt(mass / (mass + load)))


def vibrating(accelerations: Array, step: float, frequency: float, damping: float) -> Array:
    """Accelerations of a platform behind spring and damper, driven by those of drives from rest, shape (n, k).

    Transfer function (2 d w s + w^2) / (s^2 + 2 d w s + w^2), w of the undamped mode [Hz], d the share of the critical
    damping; exact for accelerations that are linear between samples, a step [s] apart.
    """
    from scipy.signal import cont2discrete, lfilter

    w = 2.0 * np.pi * frequency
    numerator, denominator = np.array([2.0 * damping * w, w**2]), np.array([1.0, 2.0 * damping * w, w**2])
    discrete = cont2discrete((numerator, denominator), step, method="foh")
    return np.asarray(lfilter(np.ravel(discrete[0]), discrete[1], accelerations, axis=0))
