"""Fits the nominal sensor frame to column Q5M of Table 5 alone: the paper does not print its geometry.

Six bars between two rings, pairs centred at 0, 120, 240 degrees; free are radius, half-angle and height of both rings.
Everything else (the other columns) is left for comparison. Eight numbers do not determine six lengths and angles
sharply: whatever frame fits, serves. Run as a script, it prints the fit from several starts.
"""

import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from cases.machine import Ring
from cases.schema import Case, load_case
from identification.estimation.criteria import pose_regressors
from identification.model.blocks import OFFSETS
from identification.model.model import identification_model
from planner.poses.planned_poses import grid_candidates
from tests.bench.table_5 import PUBLISHED, group_deviations

Array = NDArray[np.float64]

LOW = np.array([80.0, 5.0, -60.0, 80.0, 5.0, 70.0])  # lower radius mm, half-angle deg, z mm; upper the same
HIGH = np.array([250.0, 58.0, 60.0, 250.0, 58.0, 250.0])
STARTS = (
    (150.0, 25.0, 0.0, 150.0, 45.0, 120.0),
    (120.0, 15.0, 20.0, 200.0, 50.0, 140.0),
    (180.0, 30.0, -20.0, 140.0, 40.0, 110.0),
)


def structure(frame: Array) -> Array:
    """J^-T of a frame of two rings, shape (6, 6)."""
    rings = [
        Ring(radius_mm=r, half_angle_deg=h, pair_centres_deg=(0.0, 120.0, 240.0), z_mm=z)
        for r, h, z in (map(float, frame[:3]), map(float, frame[3:]))
    ]
    lower, upper = (ring.points for ring in rings)
    direction = (upper - lower) / np.linalg.norm(upper - lower, axis=1)[:, None]
    return np.vstack([direction.T, np.cross(lower, direction).T])


@dataclass(frozen=True)
class FrameFit:
    """A fitted frame.

    Args:
        frame: radius mm, half-angle deg, z mm of the lower ring, then of the upper one.
        misfit: log of ours over published, Q5M, by group, shape (8,).
    """

    frame: Array
    misfit: Array


class Q5M:
    """Standard deviations of column Q5M as a function of the frame."""

    def __init__(self, case: Case) -> None:
        self.case = case
        model = identification_model(case, 5)
        cartesian = replace(model, structure=np.eye(6))  # forces and moments instead of sensor forces
        self.cartesian = pose_regressors(cartesian, grid_candidates(case))
        offsets = [p.name for p in OFFSETS.parameters]
        self.body = [k for k, name in enumerate(model.names) if name not in offsets]

    def regressors(self, frame: Array) -> Array:
        """Of model 5 with this frame, shape (480, 6, 14)."""
        result = self.cartesian.copy()
        result[:, :, self.body] = np.linalg.inv(structure(frame)) @ self.cartesian[:, :, self.body]
        return result

    def misfit(self, frame: Array) -> Array:
        """Log of ours over published, shape (8,)."""
        ours = group_deviations(self.regressors(frame), self.case, PUBLISHED["Q5M"])
        return np.asarray(np.log(ours / np.array(PUBLISHED["Q5M"].deviations)))

    def fit(self, start: tuple[float, ...]) -> FrameFit:
        """The frame whose worst group is nearly as good as can be: least sum of sixth powers, from a start."""

        def cubes(frame: Array) -> Array:
            return np.asarray((10.0 * self.misfit(frame)) ** 3)

        near = least_squares(self.misfit, start, bounds=(LOW, HIGH), x_scale=HIGH - LOW, diff_step=1e-4, max_nfev=40)
        found = least_squares(cubes, near.x, bounds=(LOW, HIGH), x_scale=HIGH - LOW, diff_step=1e-4, max_nfev=80)
        return FrameFit(found.x, self.misfit(found.x))


def main() -> None:
    """Prints fits from several starts."""
    column = Q5M(load_case("hexapod"))
    for start in STARTS:
        fit = column.fit(start)
        print(np.round(fit.frame, 1), "misfit %:", np.round(100 * np.expm1(fit.misfit), 1))


if __name__ == "__main__":
    main()
