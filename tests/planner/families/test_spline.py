"""Jerk-limited splines: rows that hold at some instants hold the limits at all of them."""

import casadi as ca
import numpy as np
import pytest

from cases.schema import Case
from identification.hexapod import Hexapod
from identification.model import identification_model
from identification.motion import sample
from identification.reference import reference_scaling
from planner.families.ptp import PointToPointFamily
from planner.families.spline import CRITICAL, SplineFamily
from planner.search.problem import Problem, build_problem, mean_information
from planner.search.solving import Stage, Task, random_start, run_start
from planner.search.state_limits import STRUT_VELOCITY
from tests.helpers import taylor_slope


@pytest.fixture(scope="module")
def family(hexapod_case: Case) -> SplineFamily:
    return SplineFamily.of(hexapod_case, 40, 4.0)


@pytest.fixture(scope="module")
def problem(hexapod_case: Case, family: SplineFamily) -> Problem:
    model = identification_model(hexapod_case, 9)
    return build_problem(hexapod_case, model, family, reference_scaling(hexapod_case, model))


@pytest.fixture(scope="module")
def start(family: SplineFamily, problem: Problem) -> np.ndarray:
    return random_start(2, family, problem)


def test_it_is_at_rest_at_both_ends_which_differ(start: np.ndarray, family: SplineFamily):
    ends = family.motion(start).at([0.0, 4.0])
    assert np.abs(ends.rates).max() < 1e-9
    assert np.abs(ends.accelerations).max() < 1e-7
    assert np.abs(ends.pose[1] - ends.pose[0]).max() > 1e-3


def test_its_derivatives_are_those_of_its_poses(start: np.ndarray, family: SplineFamily):
    motion, h = family.motion(start), 1e-5
    t = np.arange(2, 78) * 0.05 + 0.023  # away from the knots, where the jerk jumps
    before, now, after = (motion.at(t + d) for d in (-h, 0.0, h))
    assert (after.pose - before.pose) / (2 * h) == pytest.approx(now.rates, abs=1e-8)
    assert (after.rates - before.rates) / (2 * h) == pytest.approx(now.accelerations, abs=1e-4)
    assert (after.accelerations - before.accelerations) / (2 * h) == pytest.approx(now.jerks, abs=1e-3)


@pytest.mark.parametrize("seed", range(6))
def test_what_keeps_the_rows_keeps_the_limits_at_every_instant(
    seed: int, family: SplineFamily, problem: Problem, hexapod_case: Case
):
    """The slip between the instants of positions and rates is left free by the rows, not taken from the limits."""
    draw = np.random.default_rng(seed).normal(size=(family.unknowns, 6)).cumsum(axis=0).ravel()
    rows = ca.Function("rows", [problem.unknowns], [problem.sampling.rows])
    draw /= np.abs(rows(draw).full()).max()
    motion, box = sample(family.motion(draw), 20_000.0), hexapod_case.limits.motion
    shares = [(motion.pose - family.middle) / family.half, motion.rates / box.rate]
    shares += [motion.accelerations / box.acceleration, motion.jerks / box.jerk]
    assert max(np.abs(s).max() for s in shares) <= 1.0 + 1e-9
    assert max(np.abs(s).max() for s in shares) > 0.95


@pytest.mark.parametrize("seed", range(4))
def test_strut_velocities_peak_near_the_instants_at_which_they_are_held(
    seed: int, family: SplineFamily, problem: Problem, hexapod_case: Case
):
    """Held at the knots alone, they would pass their limit by much more: they peak where accelerations vanish."""
    unknowns = np.random.default_rng(seed).normal(size=family.unknowns * 6)
    unknowns *= 0.9 / problem.worst()(unknowns)
    held = problem.sampling.struts[0]
    shares = np.abs(problem.limit_shares(unknowns)[STRUT_VELOCITY])
    motion = sample(family.motion(unknowns), 5_000.0)
    lengths = Hexapod.of(hexapod_case).strut_lengths(motion.pose)
    peak = np.abs(np.gradient(lengths, motion.t, axis=0)).max() / hexapod_case.limits.motion.strut_velocity_m_s
    assert shares[:, held].max() > 0.9 * peak
    assert shares[:, ::CRITICAL].max() < shares[:, held].max()


def test_the_optimisers_information_is_the_time_average_of_the_motion(
    start: np.ndarray, family: SplineFamily, problem: Problem, hexapod_case: Case
):
    model = identification_model(hexapod_case, 9)
    fine = mean_information(model, reference_scaling(hexapod_case, model), family.motion(start), 20_000.0)
    seen = ca.Function("information", [problem.unknowns], [problem.information])(start).full()[:, 0]
    row, column = (np.array(index) for index in ca.Sparsity.lower(20).get_triplet())
    assert seen == pytest.approx(fine[row, column], abs=2e-3 * np.abs(fine).max())


@pytest.mark.parametrize("letter", ["A", "D", "K", "N"])
def test_the_gradient_of_every_criterion_is_its_slope(letter: str, start: np.ndarray, problem: Problem):
    direction = np.random.default_rng(1).normal(size=len(start)) * 1e-2
    value = problem.objective(letter, 2)
    function = ca.Function("f", [problem.unknowns], [value, ca.gradient(value, problem.unknowns)])
    slope = function(start)[1].full()[:, 0] @ direction
    order = taylor_slope(lambda h: np.array([float(function(start + h * direction)[0])]), 0.0, np.array([slope]), 0.05)
    assert order == pytest.approx(2.0, abs=0.2)


def test_a_spline_of_its_own_kind_is_found_again_through_its_motion(start: np.ndarray, family: SplineFamily):
    assert family.through(family.motion(start)) == pytest.approx(start, abs=1e-9)


@pytest.mark.slow
def test_improving_a_point_to_point_motion_yields_more_than_it(hexapod_case: Case, family: SplineFamily):
    moves = PointToPointFamily.of(hexapod_case, 13, 4.0)
    first = run_start(Task(hexapod_case, 9, moves, "D", "ipopt", Stage("explore", 60, False), 1))
    unknowns = family.through(moves.motion(first.unknowns))
    again = Task(hexapod_case, 9, family, "D", "ipopt", Stage("refine", 300, True, barrier=1e-4), 1, unknowns)
    assert run_start(again).logdet > first.logdet
