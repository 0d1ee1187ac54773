"""Point-to-point excitations: what the optimiser sees is the motion that comes out, and controllers can run it."""

import casadi as ca
import numpy as np
import pytest

from cases.schema import Case
from identification.limits import prove
from identification.model import identification_model
from identification.motion import sample
from identification.reference import reference_scaling
from identification.trajectories.profile import StraightMove
from planner.families.ptp import PointToPointFamily
from planner.search.problem import Problem, build_problem, mean_information
from planner.search.solving import Stage, Task, keep_limits, random_start, run_start
from tests.helpers import taylor_slope

MOVES = 9


@pytest.fixture(scope="module")
def family(hexapod_case: Case) -> PointToPointFamily:
    return PointToPointFamily.of(hexapod_case, MOVES, 4.0)


@pytest.fixture(scope="module")
def problem(hexapod_case: Case, family: PointToPointFamily) -> Problem:
    model = identification_model(hexapod_case, 9)
    return build_problem(hexapod_case, model, family, reference_scaling(hexapod_case, model))


@pytest.fixture(scope="module")
def start(family: PointToPointFamily, problem: Problem) -> np.ndarray:
    return random_start(3, family, problem)


def test_a_random_start_takes_the_duration_and_keeps_the_limits_of_the_coordinates(
    start: np.ndarray, family: PointToPointFamily, problem: Problem
):
    assert family.motion(start).duration == pytest.approx(4.0)
    rows, zeros = ca.Function("rows", [problem.unknowns], [problem.sampling.rows, problem.sampling.zeros])(start)
    assert 0.9 < np.abs(rows.full()).max() <= 1.0 + 1e-9
    assert float(zeros) == pytest.approx(0.0, abs=1e-12)


def test_it_is_at_rest_at_both_ends_and_between_its_moves(start: np.ndarray, family: PointToPointFamily):
    motion = family.motion(start)
    corners = motion.at(motion.starts)
    assert np.abs(corners.rates).max() < 1e-12
    assert np.abs(corners.accelerations).max() < 1e-10
    points = family.split(start)[0]
    assert corners.pose == pytest.approx(family.middle + points * family.half, abs=1e-15)
    assert len(points) == MOVES + 1
    assert len(motion.parts) == MOVES


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
    assert (after.pose - before.pose) / (2 * h) == pytest.approx(now.rates, abs=1e-7)
    assert (after.rates - before.rates) / (2 * h) == pytest.approx(now.accelerations, abs=1e-2)


def test_the_optimisers_information_is_the_time_average_of_the_motion(
    start: np.ndarray, family: PointToPointFamily, problem: Problem, hexapod_case: Case
):
    model = identification_model(hexapod_case, 9)
    fine = mean_information(model, reference_scaling(hexapod_case, model), family.motion(start), 20_000.0)
    seen = ca.Function("information", [problem.unknowns], [problem.information])(start).full()[:, 0]
    row, column = (np.array(index) for index in ca.Sparsity.lower(20).get_triplet())
    assert seen == pytest.approx(fine[row, column], abs=2e-3 * np.abs(fine).max())


@pytest.mark.parametrize("letter", ["A", "D", "K", "N"])
@pytest.mark.parametrize("seed", [0, 1])
def test_the_gradient_of_every_criterion_is_its_slope(letter: str, seed: int, start: np.ndarray, problem: Problem):
    direction = np.random.default_rng(seed).normal(size=len(start)) * 1e-2
    value = problem.objective(letter, 2)
    function = ca.Function("f", [problem.unknowns], [value, ca.gradient(value, problem.unknowns)])
    slope = function(start)[1].full()[:, 0] @ direction
    order = taylor_slope(lambda h: np.array([float(function(start + h * direction)[0])]), 0.0, np.array([slope]), 0.05)
    assert order == pytest.approx(2.0, abs=0.15)


def test_the_jacobian_of_all_rows_is_the_one_that_casadi_finds_without_help(start: np.ndarray, problem: Problem):
    active = problem.held_from_the_start()
    active[[0, 20, 30], [1, 5, 9]] = True
    found = problem.constraints(active)
    both = ca.Function("j", [problem.unknowns], [found.jacobian, ca.jacobian(found.rows, problem.unknowns)])(start)
    assert np.abs(both[0].full() - both[1].full()).max() < 1e-9
    assert found.rows.shape[0] == len(found.lower) == len(found.upper)


def test_rows_bound_every_derivative_at_every_instant(
    start: np.ndarray, family: PointToPointFamily, hexapod_case: Case
):
    """Three rows a coordinate and move stand for all t: the finest grid finds nothing beyond them."""
    motion, box = sample(family.motion(start), 50_000.0), hexapod_case.limits.motion
    for values, limit in ((motion.rates, box.rate), (motion.accelerations, box.acceleration), (motion.jerks, box.jerk)):
        assert np.abs(values / limit).max() <= 1.0 + 1e-9


@pytest.fixture(scope="module")
def found(hexapod_case: Case, family: PointToPointFamily) -> tuple[PointToPointFamily, np.ndarray]:
    first = run_start(Task(hexapod_case, 9, family, "D", "ipopt", Stage("explore", 40, False), 5))
    again = Task(hexapod_case, 9, first.family, "D", "ipopt", Stage("refine", 40, True), 5, first.unknowns)
    second = run_start(again)
    assert second.logdet > first.logdet - 0.5
    return second.family, second.unknowns


def test_an_optimised_motion_is_proven_and_carries_far_more_than_its_start(
    found: tuple[PointToPointFamily, np.ndarray], start: np.ndarray, family: PointToPointFamily, hexapod_case: Case
):
    model = identification_model(hexapod_case, 9)
    scaling = reference_scaling(hexapod_case, model)
    better, unknowns = found
    report = prove(better.motion(unknowns), hexapod_case)
    assert report.kept
    assert 0.99 < report.worst_ratio <= 1.0
    inside, _ = keep_limits(hexapod_case, family, start, 1000.0)
    before, after = (
        np.linalg.slogdet(mean_information(model, scaling, some.motion(values)))[1]
        for some, values in ((family, inside), (better, unknowns))
    )
    assert after > before + 5.0


def test_every_phase_lasts_three_cycles_of_the_controller_or_is_absent(found: tuple[PointToPointFamily, np.ndarray]):
    better, unknowns = found
    for part in better.motion(unknowns).parts:
        assert isinstance(part, StraightMove)
        for phase in part.profile[1:]:
            assert phase == 0.0 or phase >= 0.003 - 1e-12
        assert part.profile.jerk_time >= 0.003 - 1e-12
