"""A body of known mass on the hexapod's six bars, moved smoothly: struts, poses and forces from Newton and Euler alone.

Shares no code with the product but the points of the case.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.schema import Case, load_case

Array = NDArray[np.float64]
CASE = load_case("hexapod")
MASS = 21.4
CENTRE = np.array([4.0, -11.0, 95.0]) * 1e-3
INERTIA = np.array([[0.82, 0.01, -0.02], [0.01, 0.77, 0.015], [-0.02, 0.015, 0.61]])
OFFSETS = np.array([12.0, -7.0, 33.0, -18.0, 5.0, 21.0])
NOISE = 0.5


@dataclass(frozen=True)
class Run:
    """Samples of a run."""

    t: Array  # [s]
    position: Array  # of the platform, shape (n, 3) [m]
    turn: Rotation  # of the platform
    struts: Array  # [m]
    forces: Array  # [N]

    def angles(self, order: str) -> Array:
        """Angles of a convention as SciPy names it, shape (n, 3) [deg]."""
        return self.turn.as_euler(order, degrees=True)


def run(t: Array, case: Case = CASE, seed: int = 0) -> Run:
    """The machine at instants of one motion, which depends on no recorder: several may sample it."""
    draw = np.random.default_rng(12)
    order = 2.0 * np.pi * np.array([0.5, 0.75, 1.25, 1.5])
    size = draw.normal(size=(4, 6)) * ([0.03] * 3 + [0.06] * 3)
    phase = draw.uniform(0.0, 2.0 * np.pi, (4, 6))

    def coordinates(at: Array) -> Array:
        moved = (size * np.sin(order[:, None] * at[:, None, None] + phase)).sum(axis=1)
        start = (size * np.sin(phase)).sum(axis=0)
        return (moved - start) * np.sin(np.pi * np.clip(at / 4.0, 0.0, 1.0))[:, None] ** 4

    def pose(at: Array) -> tuple[Array, Rotation]:
        q = coordinates(at)
        return q[:, :3] + [0.0, 0.0, 0.9], Rotation.from_rotvec(q[:, 3:])

    step = 1e-4  # central differences
    (before, turned_before), (here, turned), (after, turned_after) = (pose(t + k * step) for k in (-1, 0, 1))
    acceleration = (after - 2.0 * here + before) / step**2
    forward = (turned_after * turned.inv()).as_rotvec() / step
    backward = (turned * turned_before.inv()).as_rotvec() / step
    spin, spin_rate = (forward + backward) / 2.0, (forward - backward) / step
    # all in the axes of the platform
    own = turned.inv()
    spin, spin_rate = own.apply(spin), own.apply(spin_rate)
    specific = own.apply(acceleration - np.array(case.gravity))
    at_centre = specific + np.cross(spin_rate, CENTRE) + np.cross(spin, np.cross(spin, CENTRE))
    force = MASS * at_centre
    moment = spin_rate @ INERTIA + np.cross(spin, spin @ INERTIA) + np.cross(CENTRE, force)
    bars = case.sensor_frame.bars
    lower, upper = bars.lower.points, bars.upper.points
    direction = (upper - lower) / np.linalg.norm(upper - lower, axis=1)[:, None]
    frame = np.vstack([direction.T, np.cross(lower, direction).T])
    forces = np.linalg.solve(frame, np.hstack([force, moment]).T).T + OFFSETS
    forces += NOISE * np.random.default_rng(seed).normal(size=forces.shape)
    hexapod = case.hexapod
    ends = here[:, None] + np.einsum("nij,kj->nki", turned.as_matrix(), hexapod.platform.points)
    return Run(t, here, turned, np.linalg.norm(ends - hexapod.base.points, axis=2), forces)
