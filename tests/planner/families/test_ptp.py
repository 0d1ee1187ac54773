"""Point-to-point excitations: what the optimiser sees is the motion that comes out, and controllers can run it."""

from typing import Any

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import reference_scaling
from identification.limits.limit import UNUSED_SHARE
from identification.limits.proof import prove
from identification.model.model import identification_model
from identification.motion.motion import Standstill, sample
from identification.motion.moves import StraightMove
from planner.controller_limits import controlled
from planner.families.ptp import PointToPointFamily
from planner.families.rows import StateRows
from planner.noise import mean_information
from planner.plans.rating import with_jerk_limited
from planner.search.feasibility import keep_limits
from planner.search.nlp import NonlinearProgram
from planner.search.problem import build_program
from planner.search.solving import Start, Task, run_start
from tests.helpers import pose_shares
from tests.random_start import random_start

MOVES = 9


@pytest.fixture(scope="module", params=["sinumerik", "linuxcnc"])
def case(request: pytest.FixtureRequest, hexapod_case: Case) -> Case:
    """With the limits that count on a controller that limits jerk, and on one that does not."""
    return controlled(hexapod_case, request.param)[0]


@pytest.fixture(scope="module")
def family(case: Case) -> PointToPointFamily:
    return PointToPointFamily.of(case, MOVES, 4.0)


@pytest.fixture(scope="module")
def problem(case: Case, family: PointToPointFamily) -> NonlinearProgram:
    model = identification_model(case, 9)
    return build_program(case, model, family, reference_scaling(case, model), UNUSED_SHARE)


@pytest.fixture(scope="module")
def start(family: PointToPointFamily, problem: NonlinearProgram) -> np.ndarray:
    return random_start(family, np.random.default_rng(3), problem.worst)


def test_a_random_start_takes_the_duration_and_satisfies_the_limits_of_the_coordinates(
    start: np.ndarray, family: PointToPointFamily, problem: NonlinearProgram
):
    assert family.motion(start).duration == pytest.approx(4.0)
    duration, peaks = problem.rows[:2]
    assert isinstance(peaks, StateRows)
    assert 0.9 < np.abs(peaks.values(start)).max() <= 1.0 + 1e-9
    assert duration.values(start) == pytest.approx(1.0, abs=1e-12)
    assert duration.upper == duration.equal == 1.0


def test_it_is_at_rest_at_both_ends_and_between_its_moves(start: np.ndarray, family: PointToPointFamily):
    motion = family.motion(start)
    corners = motion.at(motion.starts)
    assert np.abs(corners.rates).max() < 1e-12
    assert family.steps or np.abs(corners.accelerations).max() < 1e-10
    points = family.split(start)[0]
    assert corners.coordinates == pytest.approx(family.middle + points * family.half, abs=1e-15)
    assert len(points) == MOVES + 1
    assert len(motion.parts) == MOVES


def test_a_move_that_goes_nowhere_is_a_pause_which_can_be_timed_within_jerk(
    start: np.ndarray, family: PointToPointFamily, hexapod_case: Case
):
    """A search that is stopped early may have two equal waypoints one after the other."""
    points, times = family.split(start)
    stopped = points.copy()
    stopped[4] = stopped[3]
    motion = family.motion(np.concatenate([stopped.ravel(), times.ravel()]))
    pause = motion.parts[3]
    assert isinstance(pause, Standstill)
    assert pause.duration == pytest.approx(family.motion(start).parts[3].duration, rel=1e-12)
    assert motion.duration == pytest.approx(4.0, abs=1e-12)
    timed = with_jerk_limited(motion, hexapod_case)
    assert timed.parts[3] == pause
    assert np.isfinite(timed.at(np.linspace(0.0, timed.duration, 500)).jerks).all()


def test_a_search_that_was_stopped_early_still_takes_the_duration(start: np.ndarray, family: PointToPointFamily):
    """Times of an unfinished iterate do not add up yet; drawn back to the limits they do."""
    points, times = family.split(start)
    unfinished = np.concatenate([points.ravel(), 1.01 * times.ravel()])
    assert family.motion(unfinished).duration > 4.03
    assert family.motion(family.shrunk(unfinished, 0.9)).duration == pytest.approx(4.0, abs=1e-12)
    assert family.shrunk(start, 1.0) == pytest.approx(start, abs=1e-12)


def test_its_derivatives_are_those_of_its_poses(start: np.ndarray, family: PointToPointFamily):
    motion, h = family.motion(start), 1e-5
    t = np.linspace(0.1, 3.9, 400)
    before, now, after = (motion.at(t + d) for d in (-h, 0.0, h))
    assert (after.coordinates - before.coordinates) / (2 * h) == pytest.approx(now.rates, abs=1e-7)
    smooth = np.abs(after.accelerations - before.accelerations).max(axis=1) < 0.1
    assert smooth.mean() > 0.9
    slopes = (after.rates - before.rates) / (2 * h)
    assert slopes[smooth] == pytest.approx(now.accelerations[smooth], abs=1e-2)


def test_states_of_the_optimiser_are_states_of_the_motion(
    start: np.ndarray, family: PointToPointFamily, problem: NonlinearProgram
):
    """Of information and of limits: each is found along the motion of its move, at the share of its phase."""
    states = problem.states.at(start)
    assert states.shape == (MOVES, 5 if family.steps else 11, 19)
    assert states[:, :, 18].sum() == pytest.approx(1.0)  # shares of the duration
    motion = family.motion(start)
    lasting = states[:, :, 18].sum(axis=1) * motion.duration
    assert lasting == pytest.approx(np.diff(motion.starts), abs=1e-12)
    fine = motion.at(np.linspace(0.0, motion.duration, 40_001))
    found = np.hstack([fine.coordinates, fine.rates])
    for some in (states, problem.rows[-1].states.at(start)):
        for state in some[::3].reshape(-1, 19)[:, :12]:
            assert np.abs(found - state).max(axis=1).min() < 2e-3


def test_rows_bound_every_derivative_at_every_instant(start: np.ndarray, family: PointToPointFamily, case: Case):
    """Three rows a coordinate and move stand for all t: the finest grid finds nothing beyond them."""
    motion, box = sample(family.motion(start), 50_000.0), case.limits.motion
    for values, limit in ((motion.rates, box.rate), (motion.accelerations, box.acceleration), (motion.jerks, box.jerk)):
        assert np.abs(values / limit).max() <= 1.0 + 1e-9


@pytest.fixture(scope="module")
def explored(case: Case, family: PointToPointFamily) -> Start:
    return run_start(Task(case, 9, family, "D", 5))


@pytest.fixture(scope="module")
def found(explored: Start, case: Case, family: PointToPointFamily) -> Start:
    return run_start(Task(case, 9, family, "D", 5, begin=explored.begin))


@pytest.mark.repeats
def test_an_optimised_motion_is_proven_and_carries_far_more_than_a_random_one(
    found: Start, start: np.ndarray, family: PointToPointFamily, case: Case
):
    model = identification_model(case, 9)
    scaling = reference_scaling(case, model)
    report = prove(found.family.motion(found.unknowns), case)
    assert report.kept
    assert 0.99 < report.worst_ratio <= 1.0
    assert found.record.refined
    inside = keep_limits(case, family, start, 1000.0)[0]
    before, after = (
        np.linalg.slogdet(mean_information(model, scaling, some.motion(values)))[1]
        for some, values in ((family, inside), (found.family, found.unknowns))
    )
    assert after > before + 10.0
    assert found.record.logdet == pytest.approx(after, abs=1e-9)


def test_every_phase_lasts_three_cycles_of_the_controller_or_is_absent(explored: Start, found: Start):
    """A search that is stopped may end with what it only explored."""
    assert not explored.record.refined
    family: Any = found.family
    motions: list[Any] = [start.family.motion(start.unknowns) for start in (explored, found)]
    assert [motion.duration for motion in motions] == pytest.approx([4.0, 4.0], abs=1e-12)
    for part in [part for motion in motions for part in motion.parts]:
        assert isinstance(part, StraightMove)
        for phase in part.profile[1:]:
            assert phase == 0.0 or phase >= 0.003 - 1e-12
        assert max(part.profile.jerk_time, part.profile.hold_time) >= 0.003 - 1e-12
        assert (part.profile.jerk_time == 0.0) == family.steps


def test_limits_of_poses_are_constrained_at_every_waypoint(
    start: np.ndarray, family: PointToPointFamily, problem: NonlinearProgram, case: Case
):
    """At the first as well, where no move ends: drawn out of reach alone, it is outside a row."""
    for waypoint in range(MOVES + 1):
        far = start.copy()
        far[6 * waypoint : 6 * waypoint + 6] = 3.0
        poses = family.middle + family.split(far)[0] * family.half
        shares = pose_shares(case, poses)["strut length"].max(axis=1)
        assert np.flatnonzero(shares > 1.0).tolist() == [waypoint]
        rows = [part for part in problem.rows if isinstance(part, StateRows)]
        assert max(np.abs(part.values(far)).max(initial=0.0) for part in rows) > 1.0
