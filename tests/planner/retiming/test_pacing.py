"""The fastest pace under every limit: never faster than theory allows, hardly slower, and truly a motion."""

import numpy as np
import pytest

from cases.schema import load_case
from identification.motion import Joined, Trajectory
from identification.trajectories.moves import StraightMove, fastest_profile
from planner.retiming.pacing import PacedMotion, constrained_places, paced
from planner.retiming.path_pace import fitted_spline

CASE = load_case("hexapod")
HOME = CASE.machine.home.vector
BOX = CASE.limits.motion


def slow_move(way: np.ndarray) -> StraightMove:
    """A straight move at a fifth of what the coordinates allow."""
    return StraightMove.fastest(HOME, HOME + way, BOX.rate / 5, BOX.acceleration / 25, BOX.jerk / 125)


def freely_paced(path: Trajectory, margin: float, most: float) -> PacedMotion:
    """With all of every limit, less the margin, at all places."""
    whole = np.ones(len(constrained_places(path.duration)))
    return paced(path, CASE, margin, most, (whole, whole))


def shares_of(motion: StraightMove | PacedMotion) -> list[float]:
    t = np.linspace(0.0, motion.duration, 2000)
    m = motion.at(t)
    pairs = ((m.rates, BOX.rate), (m.accelerations, BOX.acceleration), (m.jerks, BOX.jerk))
    return [float((np.abs(values) / limit).max()) for values, limit in pairs]


@pytest.mark.parametrize("way", [[0.2, 0.0, 0.0, 0.0, 0.0, 0.0], [0.02, 0.01, 0.0, 0.2, 0.1, 0.0]])
def test_a_straight_way_is_covered_in_the_time_of_the_closed_form(way: list[float]):
    """The seven segments of constant jerk are the fastest law there is: nothing may beat them, and little be lost."""
    move = slow_move(np.array(way))
    found = freely_paced(move, 0.0, 20.0)
    length = np.abs(move.end - move.start)
    moves = length > 0.0
    limits = [float(np.min(limit[moves] / length[moves])) for limit in (BOX.rate, BOX.acceleration, BOX.jerk)]
    shortest = fastest_profile(1.0, *limits).duration
    worst = max(share ** (1 / order) for order, share in enumerate(shares_of(found), start=1))
    assert found.duration * max(1.0, worst) >= shortest * (1.0 - 1e-6)
    assert found.duration <= 1.12 * shortest
    assert found.duration < 0.4 * move.duration


def test_its_derivatives_are_those_of_its_poses():
    parts = (slow_move(np.array([0.1, -0.1, 0.02, 0.1, 0.0, 0.1])), slow_move(np.zeros(6) + 0.05))
    path = Joined((parts[0], StraightMove(parts[0].end, HOME, parts[1].profile)))
    smooth = fitted_spline(path, 0.2)  # whose jerks do not leap as often
    found = freely_paced(smooth, 1e-3, 3.0)
    t, h = np.linspace(0.01, found.duration - 0.01, 300), 1e-5
    before, here, after = found.at(t - h), found.at(t), found.at(t + h)
    assert np.allclose((after.pose - before.pose) / (2 * h), here.rates, atol=1e-7)
    assert np.allclose((after.rates - before.rates) / (2 * h), here.accelerations, atol=2e-3)
    off = np.abs((after.accelerations - before.accelerations) / (2 * h) - here.jerks)
    assert np.median(off) < 1e-2  # at the leaps of the path's jerk a difference sees both sides
    assert found.places([0.0])[0] == 0.0
    assert found.places([found.duration])[0] == pytest.approx(smooth.duration, abs=1e-9)


def test_a_motion_that_may_not_be_faster_than_planned_stays_as_it_is_where_it_keeps_the_limits():
    move = slow_move(np.array([0.2, 0.0, 0.0, 0.0, 0.0, 0.0]))
    assert max(shares_of(move)) < 1.0
    found = freely_paced(move, 0.0, 1.0)
    t = np.linspace(0.0, move.duration, 200)
    assert found.duration == pytest.approx(move.duration, rel=1e-4)
    assert np.abs(found.at(t).pose - move.at(t).pose).max() < 1e-4
