"""Bounds of sensor forces: nothing that keeps the limits passes them, and something comes close."""

import numpy as np
import pytest

from cases.schema import load_case
from identification.motion import Motion, rotation_motion
from identification.overload import Loads
from identification.trajectories.moves import CircularMove, Plane, StraightMove, fastest_profile
from postprocessors.proving.forces import forces_along, forces_anywhere, forces_on
from tests.helpers import HOME, Harmonic
from tests.postprocessors.changed_case import changed

CASE = load_case("hexapod")
LOADS = Loads.of(CASE)
LIMITS = CASE.limits.motion
FAR = HOME + np.r_[0.15, -0.1, 0.05, 0.3, -0.2, 0.3]


def forces(pose, rates, accelerations) -> np.ndarray:
    """Newton and Euler for each body."""
    none = np.zeros_like(pose)
    motion = Motion(np.zeros(len(pose)), pose.copy(), rates.copy(), accelerations.copy(), none)
    return np.abs(LOADS.forces(motion, rotation_motion(motion), motion.accelerations[:, :3]))


def corners(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Rates and accelerations with every coordinate at one of its limits."""
    signs = rng.choice([-1.0, 1.0], (2, count, 6))
    return signs[0] * LIMITS.rate, signs[1] * LIMITS.acceleration


def test_no_motion_within_the_limits_passes_the_bound_of_any_pose():
    rng = np.random.default_rng(1)
    angles = np.column_stack([rng.uniform(-np.pi, np.pi, 50_000) for _ in range(3)])
    pose = np.hstack([np.zeros_like(angles), angles])
    found = forces(pose, *corners(rng, len(pose))).max()
    bound = forces_anywhere(LOADS)[0].worst
    assert 0.7 * bound < found <= bound


def test_no_motion_within_the_limits_passes_the_bound_on_a_path():
    path = Harmonic(seed=3)
    rng = np.random.default_rng(2)
    t = np.repeat(np.linspace(0.0, path.duration, 400), 64)
    found = forces(path.at(t).pose, *corners(rng, len(t))).max()
    (check,) = forces_on(LOADS, path)
    assert 0.9 * check.worst < found <= check.worst * 1.001
    assert check.worst < forces_anywhere(LOADS)[0].worst


MOVES = {
    "straight": StraightMove(HOME, FAR, fastest_profile(1.0, 1.0, 10.0)),
    "arc": CircularMove(
        HOME, FAR[3:], Plane.ZX, HOME[[2, 0]] + np.array([0.0, 0.08]), 2.0, fastest_profile(1.0, 1.0, 10.0)
    ),
}


@pytest.mark.parametrize("feed", [None, 0.1])
@pytest.mark.parametrize("name", MOVES)
def test_no_law_of_time_within_the_limits_passes_the_bound_along_a_move(name: str, feed: float | None):
    """Any speed and acceleration of the share of the way that keeps every coordinate's limits."""
    move = MOVES[name]
    rng = np.random.default_rng(3)
    shares, none = rng.uniform(0.0, 1.0, 20_000), np.zeros(20_000)
    way = move.along(shares, (shares, none + 1.0, none, none))
    speed = rng.uniform(0.0, 3.0, (20_000, 1)) if feed is None else rng.uniform(0.0, feed, (20_000, 1))
    change = rng.uniform(-20.0, 20.0, (20_000, 1))
    rates, accelerations = way.rates * speed, way.accelerations * speed**2 + way.rates * change
    kept = np.all(np.abs(rates) <= LIMITS.rate, axis=1) & np.all(np.abs(accelerations) <= LIMITS.acceleration, axis=1)
    assert kept.sum() > 500
    found = forces(way.pose[kept], rates[kept], accelerations[kept]).max()
    (check,) = forces_along(LOADS, move, feed)
    assert 0.75 * check.worst < found <= check.worst


def test_a_feed_and_a_known_way_lower_the_bound():
    slow = forces_along(LOADS, MOVES["arc"], 0.1)[0].worst
    assert slow <= forces_along(LOADS, MOVES["arc"], None)[0].worst < forces_anywhere(LOADS)[0].worst


def test_the_planned_law_is_below_the_bound_along_its_own_move():
    law = fastest_profile(1.0, 2.0, 10.0, 200.0)
    move = StraightMove(HOME, HOME + np.r_[0.1, 0.0, 0.0, 0.1, 0.0, 0.0], law)
    t = np.linspace(0.0, move.duration, 500)
    motion = move.at(t)
    assert forces(motion.pose, motion.rates, motion.accelerations).max() <= forces_along(LOADS, move, None)[0].worst


def test_without_a_range_there_is_no_bound():
    assert Loads.of(changed(CASE, sensors__range_N=None)) is None
