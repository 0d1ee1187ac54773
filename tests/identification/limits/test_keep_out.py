"""Distances of struts and tools from boxes: the definition sampled, a linear program, motions that enter a box."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from cases.schema import Case, load_case
from identification.limits.hexapod import distance_of_points, distance_of_segments, distances, guarded
from identification.limits.limit import LimitReport
from identification.limits.proof import prove
from identification.machines.clearance import ROUNDING
from identification.machines.hexapod import CLEARANCE
from identification.machines.machine import VICINITY
from identification.motion.motion import Standstill
from identification.motion.moves import StraightMove
from planner.poses.space import valid_poses
from planner.search.problem import state_limits
from tests.helpers import HOME, examples
from tests.postprocessors.changed_case import changed

CASE = load_case("hexapod")
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
    poses = move.at(np.linspace(0.0, move.duration, 300)).coordinates
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


def test_boxes_that_are_told_apart_in_brackets_are_limits_of_their_own(hexapod_case: Case):
    names = [f"vice ({side})" for side in ("left", "right, behind")]
    boxes = [{**beside_strut(hexapod_case, 0.05), "name": name} for name in names]
    report = prove(Standstill(HOME, 0.01), changed(hexapod_case, workspace__keep_out=boxes), 100.0)
    data = report.to_json()
    assert {f"distance from {name}" for name in names} <= set(data)
    assert LimitReport.of_json(data) == report


def test_a_strut_has_the_radius_that_the_case_says(hexapod_case: Case):
    box = beside_strut(hexapod_case, 0.05)
    still = StraightMove.fastest(HOME, HOME + np.r_[0.0, 0.0, 1e-3, 0.0, 0.0, 0.0], *rate_limits(hexapod_case))
    for radius, kept in ((0.0, True), (30.0, True), (60.0, False)):
        thick = changed(hexapod_case, workspace__keep_out=[box], workspace__strut_radius_mm=radius)
        assert prove(still, thick, 1000.0).kept == kept
        assert valid_poses(thick, HOME[None])[0] == kept


SPINDLE = {"name": "spindle", "from_mm": [30.0, 0.0, 0.0], "to_mm": [30.0, -20.0, 250.0], "radius_mm": 40.0}


def above_the_tool(gap: float) -> dict:
    """A plate over the whole machine; at home, level, it is `gap` above the ball at the end of the spindle."""
    low = 1e3 * HOME[2] + 250.0 + 40.0 + gap
    return {"name": "plate", "x_mm": [-900.0, 900.0], "y_mm": [-900.0, 900.0], "z_mm": [low, low + 50.0]}


@pytest.mark.parametrize("rise", [0.01, 0.03])
def test_a_tool_that_enters_a_box_is_named(rise: float, hexapod_case: Case):
    """Twenty millimetres above the tool, far above everything else."""
    case = changed(hexapod_case, workspace__keep_out=[above_the_tool(20.0)], workspace__tool=[SPINDLE])
    move = StraightMove.fastest(HOME, HOME + np.r_[0.0, 0.0, rise, 0.0, 0.0, 0.3], *rate_limits(case))
    (check,) = [c for c in prove(move, case, 1000.0).checks if c.name.startswith("distance from plate")]
    assert check.name == "distance from plate (spindle)"
    assert check.worst == pytest.approx(20.0 - 1e3 * rise, abs=1e-6)
    assert check.kept == (rise < 0.02)
    assert valid_poses(case, move.end[None])[0] == (rise < 0.02)


@given(seed=st.integers(0, 2**32 - 1))
def test_a_tool_is_as_far_as_the_nearest_point_of_its_axis_less_its_radius(seed: int):
    """Poses by SciPy, points along the axis; the box stands anywhere near the tool."""
    draw = np.random.default_rng(seed)
    corner = HOME[:3] + draw.uniform(-0.4, 0.4, 3)
    ranges = {f"{axis}_mm": [1e3 * corner[k], 1e3 * corner[k] + 150.0] for k, axis in enumerate("xyz")}
    case = changed(CASE, workspace__keep_out=[{"name": "post", **ranges}], workspace__tool=[SPINDLE])
    poses = HOME + draw.uniform(-1.0, 1.0, (5, 6)) * np.r_[0.2, 0.2, 0.1, 0.3, 0.3, 0.3]
    turns = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()
    axis = np.linspace([0.03, 0.0, 0.0], [0.03, -0.02, 0.25], 2001)
    box, workspace = case.workspace.keep_out[0], case.workspace
    joints = poses[:, None, :3] + case.machine.platform.points @ turns.transpose(0, 2, 1)
    found = distances(box, workspace, poses[:, :3], turns, case.machine.base.points, joints - case.machine.base.points)
    nearest = distance_of_points(poses[:, None, :3] + axis @ turns.transpose(0, 2, 1), box.corners).min(axis=1) - 0.04
    assert found[:, -1] == pytest.approx(nearest, abs=2e-4)
    assert len(guarded(workspace)) == found.shape[1] == 14


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=examples(8))
def test_what_the_optimiser_takes_for_outside_is_outside(seed: int):
    """At origin, joints and the ends of tools: its smooth distance is never more than the true one."""
    draw = np.random.default_rng(seed)
    corner = HOME[:3] + draw.uniform(0.2, 0.5, 3)  # away from home, so that the clearance is whole
    ranges = {f"{axis}_mm": [1e3 * corner[k], 1e3 * corner[k] + 150.0] for k, axis in enumerate("xyz")}
    case = changed(CASE, workspace__keep_out=[{"name": "post", **ranges}], workspace__tool=[SPINDLE])
    pose = HOME + draw.uniform(-1.0, 1.0, 6) * np.r_[0.4, 0.4, 0.3, 0.3, 0.3, 0.3]
    (distance,) = (kernel for kind, _, kernel in state_limits(case) if kind == "distance from")
    shares = distance.values(np.r_[pose, np.zeros(13)][None])[0]
    turn = Rotation.from_euler("xyz", pose[3:]).as_matrix()
    ends = np.array([[0.03, 0.0, 0.0], [0.03, -0.02, 0.25]]) @ turn.T
    places = pose[:3] + np.vstack([np.zeros(3), case.machine.platform.points @ turn.T, ends])
    gaps = distance_of_points(places, case.workspace.keep_out[0].corners) - np.r_[np.zeros(7), 0.04, 0.04]
    bounds = np.exp(-gaps / VICINITY)
    of_these = np.r_[0:7, 25, 27]
    assert len(shares) == 28
    assert np.all(shares[of_these] >= bounds * (1.0 - 1e-12))
    assert np.all(shares[of_these] <= bounds * np.exp((CLEARANCE + ROUNDING * np.log(3.0)) / VICINITY) * (1.0 + 1e-12))
