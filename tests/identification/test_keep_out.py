"""Distances of struts from boxes: the definition sampled, a linear program, and a motion whose strut enters a box."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from cases.schema import Case
from identification.keep_out import distance_of_points, distance_of_segments
from identification.limits import prove
from identification.trajectories.profile import StraightMove
from planner.poses.validity import valid_poses
from tests.helpers import HOME
from tests.postprocessors.changed_case import changed

CORNERS = np.array([[-0.1, 0.2, 0.3], [0.2, 0.3, 0.7]])
numbers = st.floats(-1.0, 1.0)
points = st.tuples(numbers, numbers, numbers).map(np.array)


@given(start=points, end=points)
def test_the_least_distance_is_that_of_the_nearest_of_many_points(start: np.ndarray, end: np.ndarray):
    along = start + np.linspace(0.0, 1.0, 4001)[:, None] * (end - start)
    nearest = distance_of_points(along, CORNERS).min()
    found = distance_of_segments(start[None], (end - start)[None, None], CORNERS)[0, 0]
    assert found <= nearest + 1e-12
    assert found == pytest.approx(nearest, abs=np.abs(end - start).max() / 8000 + 1e-12)


@given(start=points, end=points)
def test_the_least_distance_solves_its_linear_program(start: np.ndarray, end: np.ndarray):
    """Minimise t over s in [0, 1] with low - p(s) <= t and p(s) - high <= t in each axis."""
    way = end - start
    rows = np.vstack([np.column_stack([-way, -np.ones(3)]), np.column_stack([way, -np.ones(3)])])
    right = np.concatenate([start - CORNERS[0], CORNERS[1] - start])
    solved = linprog([0.0, 1.0], A_ub=rows, b_ub=right, bounds=[(0.0, 1.0), (None, None)])
    found = distance_of_segments(start[None], way[None, None], CORNERS)[0, 0]
    assert found == pytest.approx(solved.fun, abs=1e-7)


def test_what_is_no_number_has_no_distance():
    assert np.isnan(distance_of_segments(np.zeros((1, 3)), np.full((1, 1, 3), np.nan), CORNERS)).all()


def beside_strut(case: Case, gap: float, size: float = 0.02) -> dict:
    """A cube beside the middle of strut 1 at home, `gap` away from it along x."""
    machine = case.machine
    middle = (machine.base.points[0] + HOME[:3] + machine.platform.points[0]) / 2 + np.array([gap + size, 0.0, 0.0])
    low, high = 1e3 * (middle - size), 1e3 * (middle + size)
    ranges = {f"{axis}_mm": [float(low[k]), float(high[k])] for k, axis in enumerate("xyz")}
    return {"name": "rack", **ranges}


def rate_limits(case: Case) -> list[np.ndarray]:
    return [0.5 * v for v in (case.limits.motion.rate, case.limits.motion.acceleration, case.limits.motion.jerk)]


def nearest_by_sampling(case: Case, move: StraightMove, corners: np.ndarray) -> float:
    """Least distance of strut 1, from rotations by SciPy and points along the strut."""
    poses = move.at(np.linspace(0.0, move.duration, 300)).pose
    turns = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()
    joint = poses[:, :3] + turns @ case.machine.platform.points[0]
    base = case.machine.base.points[0]
    along = base + np.linspace(0.0, 1.0, 500)[None, :, None] * (joint - base)[:, None]
    return float(distance_of_points(along, corners).min())


@pytest.mark.parametrize("far", [0.05, 0.2])
def test_a_strut_that_enters_a_box_while_the_platform_stays_away_is_named(far: float, hexapod_case: Case):
    guarded = changed(hexapod_case, workspace__keep_out=[beside_strut(hexapod_case, 0.05)])
    move = StraightMove.fastest(HOME, HOME + np.r_[far, 0.0, 0.0, 0.05, -0.1, 0.1], *rate_limits(guarded))
    report = prove(move, guarded, 1000.0)
    (check,) = [c for c in report.checks if c.name.startswith("distance from rack")]
    least = nearest_by_sampling(guarded, move, guarded.workspace.keep_out[0].corners)
    assert check.name == "distance from rack (strut 1)"
    assert check.worst == pytest.approx(1e3 * least, abs=0.5)
    assert report.kept == (least >= 0.0) == (far < 0.1)
    assert valid_poses(guarded, move.end[None])[0] == (far < 0.1)


def test_a_strut_has_the_radius_that_the_case_says(hexapod_case: Case):
    box = beside_strut(hexapod_case, 0.05)
    still = StraightMove.fastest(HOME, HOME + np.r_[0.0, 0.0, 1e-3, 0.0, 0.0, 0.0], *rate_limits(hexapod_case))
    for radius, kept in ((0.0, True), (30.0, True), (60.0, False)):
        thick = changed(hexapod_case, workspace__keep_out=[box], workspace__strut_radius_mm=radius)
        assert prove(still, thick, 1000.0).kept == kept
        assert valid_poses(thick, HOME[None])[0] == kept
