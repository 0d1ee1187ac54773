"""Paths inside every limit at another pace: proven, near the path, never slower than what already keeps the limits."""

from itertools import pairwise

import numpy as np
import pytest

from cases.errors import InfeasiblePlan
from cases.schema import load_case
from identification.limit_proof import kinetic_shares, prove
from identification.motion import Joined, TimedPoints
from identification.trajectories.moves import StraightMove
from identification.trajectories.path_timing import retime
from planner.retiming import path_pace as module
from planner.retiming.path_pace import retimed_path

CASE = load_case("hexapod")
HOME = CASE.machine.home.vector
BOX = CASE.limits.motion


def way(hurry: float, reach: float = 1.0) -> Joined:
    """Three moves there and back, `hurry` times as fast as the coordinates may."""
    ways = np.array([np.zeros(6), [0.1, 0.05, -0.02, 0.1, -0.1, 0.05], [-0.1, 0.1, 0.04, -0.1, 0.1, 0.1], np.zeros(6)])
    limits = (BOX.rate * hurry, BOX.acceleration * hurry**2, BOX.jerk * hurry**3)
    return Joined(tuple(StraightMove.fastest(HOME + reach * a, HOME + reach * b, *limits) for a, b in pairwise(ways)))


def points(path: Joined) -> TimedPoints:
    t = np.linspace(0.0, path.duration, 200)
    return TimedPoints.through(t, path.at(t).pose)


def test_a_hasty_path_is_slowed_down_inside_every_limit_and_stays_the_path():
    path = points(way(1.5))
    motion, off_path, _ = retimed_path(path, CASE, fastest=False)
    assert prove(path, CASE).worst_ratio > 2.0
    report = prove(motion, CASE)
    assert report.worst_ratio <= 0.99901
    assert motion.duration > path.duration
    assert off_path[0] < 5e-4
    # the distances told are those to the nearest pose of the path, or more
    fine = path.at(np.linspace(0.0, path.duration, 20_000)).pose
    t = np.linspace(0.0, motion.duration, 60)
    nearest = [np.linalg.norm(fine[:, :3] - p, axis=1).min() for p in motion.at(t).pose[:, :3]]
    assert max(nearest) <= off_path[0] + 1e-5


def test_a_path_that_keeps_the_limits_is_left_alone():
    path = way(0.7)
    motion, off_path, _ = retimed_path(path, CASE, fastest=False)
    assert motion is path
    assert off_path == (0.0, 0.0)


def test_as_fast_as_the_limits_allow_is_faster_than_planned_and_slower_than_without_a_limit_of_jerk():
    path = way(0.6)
    motion, *_ = retimed_path(path, CASE, fastest=True)
    assert prove(motion, CASE).kept
    without = retime(way(6.0), CASE)  # never faster than this: as fast as the limits allow
    assert without.duration * (1.0 - 2e-3) < motion.duration < 0.8 * path.duration
    jerk = kinetic_shares(without, CASE, np.linspace(0.0, without.duration, 4000))[2]
    assert jerk.max() > 2.0  # what toppra's answer would have passed


def test_what_is_as_fast_as_possible_is_not_made_slower(monkeypatch: pytest.MonkeyPatch):
    path = way(0.99)  # seven segments at their limits are the fastest law of a straight way
    monkeypatch.setattr(module, "ROUNDS", 2)
    assert retimed_path(path, CASE, fastest=True)[0] is path


@pytest.mark.parametrize(
    ("path", "words"),
    [
        (points(way(1.0, reach=2.6)), "no pace keeps this path inside all limits: position"),
        (points(way(0.008)), "longer than the 120 s"),
    ],
)
def test_what_no_pace_can_mend_is_refused(path: TimedPoints, words: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(module, "ROUNDS", 1)
    with pytest.raises(InfeasiblePlan, match=words):
        retimed_path(path, CASE, fastest=False)


def test_a_path_that_moves_at_its_end_is_refused():
    class Broken:
        duration = 1.0

        def at(self, t):
            return way(1.0).at(np.asarray(t, dtype=float) * 0.1)

    with pytest.raises(InfeasiblePlan, match="the path ends at"):
        retimed_path(Broken(), CASE, fastest=False)
