"""A rigid body made of a few point masses, and what it takes to move it: no code in common with the model."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from cases.sensors import Bars
from identification.motion.motion import Trajectory

Array = np.ndarray

# Second derivative by sixth-order central differences; at 5 ms the error is some 1e-9 of the acceleration.
STEP = 5e-3
STENCIL = np.array([1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90]) / STEP**2


@dataclass(frozen=True)
class PointMasses:
    """Masses (k,) [kg] at points of {P}, (k, 3) [m]."""

    masses: Array
    points: Array

    @classmethod
    def drawn(cls, seed: int, count: int = 6) -> "PointMasses":
        draw = np.random.default_rng(seed)
        return cls(draw.uniform(1.0, 8.0, count), draw.uniform(-0.3, 0.3, (count, 3)))

    @property
    def parameters(self) -> dict[str, float]:
        """The rigid-body part of u, (17), by its definition as sums over the masses."""
        first = self.masses @ self.points
        inertia = np.diag(self.masses @ self.points**2 @ (1 - np.eye(3))) - np.einsum(
            "k,ki,kj->ij", self.masses, self.points, self.points
        ) * (1 - np.eye(3))
        named = {f"I{i + 1}{j + 1}": inertia[i, j] for i in range(3) for j in range(i, 3)}
        return {"m": self.masses.sum(), "mxC": first[0], "myC": first[1], "mzC": first[2]} | named

    def wrench(self, trajectory: Trajectory, t: float, gravity: Array) -> Array:
        """Force and moment about the origin of {P}, in {P}, that keep the masses on their way (Newton for each)."""
        moments = t + STEP * np.arange(-3, 4)
        pose = trajectory.at(moments).coordinates
        turns = Rotation.from_euler("xyz", pose[:, 3:]).as_matrix()
        ways = pose[:, None, :3] + np.einsum("nij,kj->nki", turns, self.points)
        forces = self.masses[:, None] * (np.einsum("n,nki->ki", STENCIL, ways) - gravity)
        arms = ways[3] - pose[3, :3]
        return np.concatenate([forces.sum(axis=0) @ turns[3], np.cross(arms, forces).sum(axis=0) @ turns[3]])


def wrench_of_bars(bars: Bars, forces: Array) -> Array:
    """Force and moment about the origin of {P} that six bars with given forces exert, shape (6,)."""
    lower, upper = bars.lower.points, bars.upper.points
    pulls = forces[:, None] * (upper - lower) / np.linalg.norm(upper - lower, axis=1, keepdims=True)
    return np.concatenate([pulls.sum(axis=0), np.cross(lower, pulls).sum(axis=0)])
