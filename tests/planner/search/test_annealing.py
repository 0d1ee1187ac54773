"""Annealed walks of equal moves: inside box and limits, worth what they say, better than chance, reproducible."""

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import reference_scaling
from identification.limits.proof import prove
from identification.model.model import Model, identification_model
from identification.motion.moves import fastest_profile
from planner.families.ptp import PointToPointFamily
from planner.noise import mean_information
from planner.search.annealing import EXCESS, POSE_REACHED, RIDGE, SLACK, Walk, annealed_start
from planner.search.problem import build_program
from tests.bench.machines.description import case_of, reachable
from tests.bench.machines.designed import DESIGNED
from tests.helpers import pose_shares
from tests.random_start import random_start

MOVES = 12
DURATION = 4.0
KINDS = ("shifted", "with_new_waypoint", "with_moved_excursion")


@pytest.fixture(scope="module")
def family(hexapod_case: Case) -> PointToPointFamily:
    return PointToPointFamily.of(hexapod_case, MOVES, DURATION)


def standing(case: Case, model: Model, scaling: np.ndarray, family: PointToPointFamily, size: float = 0.5) -> Walk:
    draw = np.random.default_rng(5)
    return Walk(case, model, scaling, family, draw, np.tile(draw.uniform(-size, size, 6), (MOVES + 1, 1)))


@pytest.fixture(scope="module")
def walk(hexapod_case: Case, model: Model, scaling: np.ndarray, family: PointToPointFamily) -> Walk:
    some = standing(hexapod_case, model, scaling, family)
    for temperature in (0.1, 0.03, 0.01):
        some.anneal(temperature, 1000)
    return some


@pytest.fixture(scope="module")
def tight() -> Case:
    """A machine whose box is not within reach as a whole."""
    case = case_of("small", DESIGNED["small"])
    assert reachable(case, 1000).struts < 0.5
    return case


def unknowns_of(walk: Walk, family: PointToPointFamily) -> np.ndarray:
    return np.concatenate([walk.best_points.ravel(), np.tile(walk.times / family.unit, MOVES)])


def logdet_anew(walk: Walk, points: np.ndarray) -> float:
    """Move by move, without what a walk remembers."""
    rows = np.vstack([walk.rows_of(np.r_[a, b]).full() for a, b in itertools.pairwise(points)])
    return float(np.linalg.slogdet(rows.T @ rows / MOVES + RIDGE * np.eye(walk.size))[1])


def excess_anew(walk: Walk, points: np.ndarray) -> np.ndarray:
    return np.array([walk.excess_of(np.r_[a, b]).full()[:, 0] for a, b in itertools.pairwise(points)])


def test_a_full_step_takes_the_duration_and_one_limit_of_each_coordinate(walk: Walk, family: PointToPointFamily):
    assert walk.times @ [4.0, 2.0, 1.0] == pytest.approx(family.unit)
    fastest = [
        fastest_profile(step, *limits).duration
        for step, limits in zip(walk.steps * family.half, family.limits.T, strict=True)
    ]
    assert max(fastest) == pytest.approx(family.unit)  # that whose times all share
    assert min(fastest) > 0.8 * family.unit


def test_a_walk_stays_in_the_box_and_no_move_is_longer_than_a_step(walk: Walk):
    assert np.abs(walk.best_points).max() <= 1.0
    ways = np.abs(np.diff(walk.best_points, axis=0))
    assert (ways <= walk.steps + 1e-8).all()
    assert ways.max() > 0.5 * walk.steps.min()


def test_its_motion_satisfies_the_limits_of_the_coordinates_and_nearly_the_others(
    walk: Walk, family: PointToPointFamily, hexapod_case: Case
):
    report = prove(family.motion(unknowns_of(walk, family)), hexapod_case, 1000.0)
    for check in report.checks:
        assert check.ratio <= (1.05 if "strut" in check.name or "joint" in check.name else 1.0 + 1e-6), check.name


@pytest.mark.slow
def test_no_waypoint_of_a_walk_exceeds_a_limit_of_poses_on_a_box_that_is_not_within_reach(tight: Case):
    """At any temperature, at every step of the way: limits of poses are no matter of a price."""
    model = identification_model(tight, 9)
    family = PointToPointFamily.of(tight, MOVES, DURATION)
    some = standing(tight, model, reference_scaling(tight, model), family, 0.1)
    seen = 0
    for temperature in (1.0, 0.1, 0.01):
        for _ in range(20):
            before = some.points
            some.anneal(temperature, 40)
            seen += some.points is not before
            poses = family.middle + some.points * family.half
            for kind, shares in pose_shares(tight, poses).items():
                assert shares.max() <= POSE_REACHED + 1e-12, kind
    assert seen > 10


def test_what_a_walk_remembers_is_what_is_computed_anew(walk: Walk):
    assert walk.logdet == pytest.approx(logdet_anew(walk, walk.points), abs=1e-9)
    excess = excess_anew(walk, walk.points)
    assert walk.passed == pytest.approx(excess[:, 0], abs=1e-12)
    assert excess[:, 1].max() <= POSE_REACHED
    assert walk.value == pytest.approx(walk.logdet - EXCESS * excess[:, 0].sum(), abs=1e-9)
    assert walk.best == pytest.approx(
        logdet_anew(walk, walk.best_points) - EXCESS * excess_anew(walk, walk.best_points)[:, 0].sum(), abs=1e-9
    )
    assert walk.best >= walk.value
    inverse = np.linalg.inv(walk.total)
    for k in range(MOVES):
        assert walk.traces[k] == pytest.approx(np.trace(inverse @ walk.rows[k].T @ walk.rows[k]), rel=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_source_and_new_describe_the_points_of_every_proposal(kind: str, walk: Walk):
    points, source, new = getattr(walk, kind)(500)
    assert points.shape == (500, MOVES + 1, 6)
    assert np.abs(points).max() <= 1.0
    assert valid(points, walk).sum() > 20
    assert np.array_equal(points[~new], walk.points[source[~new]])
    if kind != "with_moved_excursion":
        assert np.array_equal(source, np.tile(np.arange(MOVES + 1), (500, 1)))
    assert new.any(axis=1).all()


def valid(points: np.ndarray, walk: Walk) -> np.ndarray:
    return (np.abs(np.diff(points, axis=1)).max(axis=1) <= walk.steps + SLACK).all(axis=1)


def test_a_moved_excursion_goes_there_and_back(walk: Walk):
    """Two waypoints less, two more: the walk goes to a new place and returns to where it was."""
    points, _, new = walk.with_moved_excursion(300)
    index, place = np.nonzero(new)
    assert np.array_equal(index, np.arange(300))
    assert np.array_equal(points[index, place - 1], points[index, place + 1])


def test_the_bound_by_concavity_is_never_below_the_exact_value(walk: Walk):
    """Log det F + trace(F^-1 dF), by which proposals are ruled out."""
    looked_at = 0
    for kind in KINDS:
        proposed = getattr(walk, kind)(60)[0]
        for points in proposed[valid(proposed, walk)]:
            rows = np.array([walk.rows_of(np.r_[a, b]).full() for a, b in itertools.pairwise(points)])
            traces = ((rows.reshape(-1, walk.size) @ walk.root) ** 2).sum()
            bound = walk.logdet + (traces - walk.traces.sum()) / MOVES
            assert bound >= logdet_anew(walk, points) - 1e-9
            looked_at += 1
    assert looked_at > 30


def test_two_instants_a_move_rate_a_walk_well_enough_for_a_choice(
    walk: Walk, family: PointToPointFamily, model: Model, scaling: np.ndarray
):
    motion = family.motion(unknowns_of(walk, family))
    logdet = np.linalg.slogdet(mean_information(model, scaling, motion))[1]
    assert logdet_anew(walk, walk.best_points) == pytest.approx(logdet, abs=0.03 * 20)  # 3 % of an efficiency


@pytest.fixture(scope="module")
def annealed(
    hexapod_case: Case, model: Model, scaling: np.ndarray, family: PointToPointFamily
) -> Callable[[int], np.ndarray]:
    def annealed(seed: int) -> np.ndarray:
        draw = np.random.default_rng(seed)
        return annealed_start(hexapod_case, model, scaling, family, draw, lambda objective: False)

    return annealed


@pytest.mark.slow
def test_annealing_finds_more_than_chance_and_the_same_again(
    annealed: Callable[[int], np.ndarray], hexapod_case: Case, model: Model, scaling: np.ndarray,
    family: PointToPointFamily,
):  # fmt: skip
    def logdet(unknowns: np.ndarray) -> float:
        return float(np.linalg.slogdet(mean_information(model, scaling, family.motion(unknowns)))[1])

    problem = build_program(hexapod_case, model, family, scaling, 0.0)
    by_chance = max(logdet(random_start(family, np.random.default_rng(seed), problem.worst)) for seed in range(5))
    first = annealed(1)
    assert logdet(first) > by_chance + 20 * np.log(2.0)  # twice the efficiency of the best of five
    assert np.array_equal(first, annealed(1))


def test_a_watch_that_has_seen_enough_ends_it(
    hexapod_case: Case, model: Model, scaling: np.ndarray, family: PointToPointFamily
):
    told: list[float] = []

    def watch(objective: float) -> bool:
        told.append(objective)
        return len(told) == 2

    draw = np.random.default_rng(0)
    unknowns = annealed_start(hexapod_case, model, scaling, family, draw, watch)
    assert len(told) == 2
    assert told[1] <= told[0]
    assert np.isfinite(unknowns).all()
