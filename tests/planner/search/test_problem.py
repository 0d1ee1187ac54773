"""The optimiser's rows are the limits of the motion, and its random starts keep them."""

import casadi as ca
import numpy as np
import pytest

from cases.schema import Case
from identification.limits import prove
from identification.model import identification_model
from identification.reference import reference_scaling
from planner.families.fourier import START_SHARE, FourierFamily
from planner.search.problem import Problem, build_problem
from planner.search.solving import keep_limits, random_start, seeds_of
from tests.postprocessors.independent import strut_lengths


def family(case: Case, order: int = 4, period: float = 2.0) -> FourierFamily:
    half = np.ptp(case.limits.motion.pose, axis=0) / 2
    return FourierFamily(order, period, 1, case.machine.home.vector, half, 12)


@pytest.fixture(scope="module")
def problem(hexapod_case: Case) -> Problem:
    model = identification_model(hexapod_case, 0)
    return build_problem(hexapod_case, model, family(hexapod_case), reference_scaling(hexapod_case, model))


@pytest.fixture(scope="module")
def unknowns(hexapod_case: Case) -> np.ndarray:
    return np.random.default_rng(8).normal(size=family(hexapod_case).unknowns * 6)


def rows(problem: Problem, unknowns: np.ndarray) -> np.ndarray:
    return np.abs(ca.Function("rows", [problem.unknowns], [problem.sampling.rows])(unknowns).full()[:, 0])


def box_shares(case: Case, some: FourierFamily, unknowns: np.ndarray) -> np.ndarray:
    """Largest share of each limit of pose, rate, acceleration and jerk on the grid."""
    box, motion = case.limits.motion, some.motion(unknowns).at(some.grid)
    half = np.ptp(box.pose, axis=0) / 2
    values = [(motion.pose - some.middle) / half, motion.rates / box.rate]
    values += [motion.accelerations / box.acceleration, motion.jerks / box.jerk]
    return np.array([np.abs(v).max() for v in values])


def test_rows_are_shares_of_the_limits(problem: Problem, unknowns: np.ndarray, hexapod_case: Case):
    assert rows(problem, unknowns).max() == pytest.approx(
        box_shares(hexapod_case, family(hexapod_case), unknowns).max()
    )


@pytest.mark.parametrize(("order", "period"), [(2, 12.0), (3, 6.0), (5, 3.0), (7, 2.0)])
def test_limits_without_rows_are_kept_by_every_motion_that_keeps_the_rows(
    order: int, period: float, hexapod_case: Case
):
    """Bernstein: a slow series cannot reach the limits of the higher derivatives; the optimiser saves their rows."""
    some = family(hexapod_case, order, period)
    model = identification_model(hexapod_case, 0)
    problem = build_problem(hexapod_case, model, some, reference_scaling(hexapod_case, model))
    count = len(some.grid)
    for seed in range(20):
        draw = np.random.default_rng(seed).normal(size=some.unknowns * 6)
        draw /= rows(problem, draw).max()
        allowed = 1.0 / np.cos(np.pi / 12)  # limits slip between the samples of the grid
        assert box_shares(hexapod_case, some, draw).max() <= allowed
    assert problem.sampling.rows.shape[0] <= 4 * 6 * count


def test_strut_rows_are_the_struts_of_the_motion(problem: Problem, unknowns: np.ndarray, hexapod_case: Case):
    """Velocities and accelerations against differences of lengths that follow from the definition."""
    some, h = family(hexapod_case), 1e-4
    motion = some.motion(0.1 * unknowns)
    before, now, after = (strut_lengths(motion.at(some.grid + d).pose, hexapod_case) for d in (-h, 0.0, h))
    box = hexapod_case.limits.motion
    short, long = box.strut_length
    length = (now - (short + long) / 2) / ((long - short) / 2)
    velocity = (after - before) / (2 * h) / box.strut_velocity_m_s
    acceleration = (after - 2 * now + before) / h**2 / box.strut_acceleration_m_s2
    expected = np.abs(np.hstack([length, velocity, acceleration]).T)
    assert np.allclose(problem.limit_shares(0.1 * unknowns)[:18], expected, atol=1e-5)


def test_strut_rows_enter_only_where_they_are_named(problem: Problem, unknowns: np.ndarray):
    shares = problem.limit_shares(unknowns)
    active = np.zeros(shares.shape, dtype=bool)
    active[[0, 7, 16], [3, 0, 20]] = True
    function = ca.Function("rows", [problem.unknowns], [problem.constraints(active).rows])
    added = np.abs(function(unknowns).full()[len(rows(problem, unknowns)) :, 0])
    assert sorted(added) == pytest.approx(sorted(shares[active]))
    assert problem.constraints(np.zeros_like(active)).rows.shape == problem.sampling.rows.shape


@pytest.mark.parametrize("seed", range(5))
def test_a_random_start_is_inside_all_limits_and_far_from_rest(seed: int, problem: Problem, hexapod_case: Case):
    some = family(hexapod_case)
    start = random_start(seed, some, problem)
    worst = max(rows(problem, start).max(), problem.limit_shares(start).max())
    assert worst <= START_SHARE * (1 + 1e-9)
    assert rows(problem, start).max() > 0.1


def test_a_random_start_depends_on_its_seed_alone(problem: Problem, hexapod_case: Case):
    some = family(hexapod_case)
    assert np.array_equal(random_start(3, some, problem), random_start(3, some, problem))
    assert not np.allclose(random_start(3, some, problem), random_start(4, some, problem))


def test_more_starts_go_on_where_fewer_ended():
    assert seeds_of(7, 8)[:3] == seeds_of(7, 3)
    assert len(set(seeds_of(7, 100))) == 100
    assert set(seeds_of(7, 8)).isdisjoint(seeds_of(8, 8))


def test_scaling_back_ends_inside_every_limit_and_keeps_the_shape(hexapod_case: Case, unknowns: np.ndarray):
    some = family(hexapod_case)
    kept, report = keep_limits(hexapod_case, some, 3.0 * unknowns, 1000.0)
    assert prove(some.motion(kept), hexapod_case, 1000.0).kept
    assert 0.9 < report.worst_ratio <= 1.0
    assert np.allclose(kept / kept[0], unknowns / unknowns[0])
