"""Smooth coordinates of the pose space: position, tilt as a vector, torsion; no angle in them is ever undefined.

R = Q Rz(torsion) with Q the turn by the tilt about the horizontal axis (-sin azimuth, cos azimuth, 0). The tilt enters
by its Gibbs vector tan(tilt/2) (-sin azimuth, cos azimuth), so that R is a rational function of it. Each coordinate is
a share of its largest value.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.schema import Case

Array = NDArray[np.float64]

SIZE = 5  # x, y, two of tilt, torsion; z stays where it is, for no static model depends on it


@dataclass(frozen=True, slots=True)
class PoseSpace:
    """The poses among which refinement searches: a disc, all tilts up to the largest, a range of torsion.

    Args:
        home: position of {P} at home, shape (3,) [m].
        radius: of the disc [m].
        low: lower end of the XY range relative to home, shape (2,) [m].
        high: upper end, shape (2,) [m].
        tilt: tangent of half the largest tilt.
        torsion: smallest and largest, shape (2,) [rad].
    """

    home: Array
    radius: float
    low: Array
    high: Array
    tilt: float
    torsion: Array

    @classmethod
    def of(cls, case: Case) -> "PoseSpace":
        """The space that the case's grid spans; raises CaseError where the case lacks machine or poses."""
        home = case.need_machine("pose candidates")[0].home.vector[:3]
        grid = case.need_poses("pose candidates")
        x, y, _ = grid.lengths
        torsion = grid.angles[2][[0, -1]]
        low, high = np.array([x[0], y[0]]), np.array([x[-1], y[-1]])
        return cls(home, float(grid.radius[1]), low, high, float(np.tan(grid.angles[0][-1] / 2)), torsion)

    @property
    def _torsion_middle(self) -> tuple[float, float]:
        half = float(np.ptp(self.torsion)) / 2
        return float(self.torsion.mean()), half if half > 0.0 else 1.0

    def bounds(self) -> Array:
        """Lower and upper bound of each coordinate, shape (2, 5)."""
        middle, half = self._torsion_middle
        ends = np.column_stack([self.low / self.radius, self.high / self.radius]).T
        ends = np.clip(ends, -1.0, 1.0)
        torsion = (self.torsion - middle) / half
        return np.column_stack([ends, [[-1.0, -1.0], [1.0, 1.0]], torsion])

    def shares(self, poses: Array) -> Array:
        """Coordinates of poses, shape (n, 5)."""
        turn = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()
        normal = turn[:, :, 2]
        tilt = np.column_stack([-normal[:, 1], normal[:, 0]]) / (1.0 + normal[:, 2])[:, None]
        tilted = Rotation.from_quat(np.column_stack([tilt, np.zeros(len(poses)), np.ones(len(poses))])).as_matrix()
        left = tilted.transpose(0, 2, 1) @ turn
        middle, half = self._torsion_middle
        torsion = (np.arctan2(left[:, 1, 0], left[:, 0, 0]) - middle) / half
        return np.column_stack([(poses[:, :2] - self.home[:2]) / self.radius, tilt / self.tilt, torsion])

    def project(self, shares: Array) -> Array:
        """The nearest shares that lie in the space, shape (n, 5): ranges first, then disc and largest tilt."""
        low, high = self.bounds()
        inside = np.clip(shares, low, high)
        for part in (slice(0, 2), slice(2, 4)):
            inside[:, part] /= np.maximum(np.linalg.norm(inside[:, part], axis=1, keepdims=True), 1.0)
        return inside

    def poses(self, shares: Array, z: Array) -> Array:
        """Poses of coordinates, shape (n, 6) [m, rad].

        Args:
            shares: shape (n, 5).
            z: absolute, shape (n,) [m].
        """
        middle, half = self._torsion_middle
        one, none = np.ones(len(shares)), np.zeros(len(shares))
        tilted = Rotation.from_quat(np.column_stack([shares[:, 2:4] * self.tilt, none, one]))
        turn = tilted * Rotation.from_rotvec(np.column_stack([none, none, middle + half * shares[:, 4]]))
        return np.column_stack([self.home[:2] + self.radius * shares[:, :2], z, turn.as_euler("xyz")])

    def expression(self, share: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Position (z at home) and R of one pose, shapes (3,) and (3, 3)."""
        middle, half = self._torsion_middle
        a, b = self.tilt * share[2], self.tilt * share[3]
        norm = 1 + a * a + b * b
        tilted = (
            ca.vertcat(
                ca.horzcat(1 + a * a - b * b, 2 * a * b, 2 * b),
                ca.horzcat(2 * a * b, 1 - a * a + b * b, -2 * a),
                ca.horzcat(-2 * b, 2 * a, 1 - a * a - b * b),
            )
            / norm
        )
        c, s = ca.cos(middle + half * share[4]), ca.sin(middle + half * share[4])
        about_z = ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))
        position = ca.vertcat(ca.DM(self.home[:2]) + self.radius * share[:2], float(self.home[2]))
        return position, tilted @ about_z
