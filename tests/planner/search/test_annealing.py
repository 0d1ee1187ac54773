"""Annealed walks of equal moves: inside box and limits, worth what they say, better than chance, reproducible."""

import numpy as np
import pytest

from cases.schema import Case
from identification.limits import prove
from identification.model import Model
from identification.trajectories.profile import fastest_profile
from planner.families.ptp import PointToPointFamily
from planner.search.annealing import EXCESS, NEW, Walk, annealed_start
from planner.search.equal_moves import EqualMoves
from planner.search.problem import build_problem, mean_information
from planner.search.solving import random_start

MOVES = 12
DURATION = 4.0


@pytest.fixture(scope="module")
def family(hexapod_case: Case) -> PointToPointFamily:
    return PointToPointFamily.of(hexapod_case, MOVES, DURATION)


@pytest.fixture(scope="module")
def moves(hexapod_case: Case, model: Model, scaling: np.ndarray, family: PointToPointFamily) -> EqualMoves:
    return EqualMoves.of(hexapod_case, model, scaling, family)


def standing(moves: EqualMoves) -> Walk:
    draw = np.random.default_rng(5)
    return Walk(moves, np.tile(draw.uniform(-0.5, 0.5, 6), (MOVES + 1, 1)), draw)


@pytest.fixture(scope="module")
def walk(moves: EqualMoves) -> Walk:
    some = standing(moves)
    for temperature in (0.1, 0.03, 0.01):
        some.anneal(temperature, 1000)
    return some


def unknowns_of(points: np.ndarray, moves: EqualMoves, family: PointToPointFamily) -> np.ndarray:
    return np.concatenate([points.ravel(), np.tile(moves.times / family.unit, MOVES)])


def test_a_full_step_takes_the_duration_and_one_limit_of_each_coordinate(moves: EqualMoves, family: PointToPointFamily):
    assert moves.times @ [4.0, 2.0, 1.0] == pytest.approx(family.unit)
    fastest = [
        fastest_profile(step, *limits).duration
        for step, limits in zip(moves.steps * family.half, family.limits.T, strict=True)
    ]
    assert max(fastest) == pytest.approx(family.unit)  # that whose times all share
    assert min(fastest) > 0.8 * family.unit


def test_a_walk_stays_in_the_box_and_no_move_is_longer_than_a_step(walk: Walk, moves: EqualMoves):
    assert np.abs(walk.best_points).max() <= 1.0
    ways = np.abs(np.diff(walk.best_points, axis=0))
    assert (ways <= moves.steps + 1e-8).all()
    assert ways.max() > 0.5 * moves.steps.min()


def test_its_motion_keeps_the_limits_of_the_coordinates_and_nearly_the_others(
    walk: Walk, moves: EqualMoves, family: PointToPointFamily, hexapod_case: Case
):
    report = prove(family.motion(unknowns_of(walk.best_points, moves, family)), hexapod_case, 1000.0)
    for check in report.checks:
        assert check.ratio <= (1.05 if "strut" in check.name or "joint" in check.name else 1.0 + 1e-6), check.name


def test_what_was_added_up_move_by_move_is_the_information_of_the_walk(walk: Walk, moves: EqualMoves):
    anew = standing(moves)
    parts = anew.rate(walk.points[:-1], walk.points[1:])
    assert walk.total == pytest.approx(parts.mean(axis=0), rel=1e-9, abs=1e-12)
    assert walk.value == pytest.approx(anew.worth(parts.mean(axis=0)), abs=1e-6)


def test_the_value_of_a_walk_is_log_det_less_what_it_passes(walk: Walk):
    information = walk.total[:-1].reshape(20, 20)
    logdet = np.linalg.slogdet(information)[1]
    assert walk.value == pytest.approx(logdet - EXCESS * MOVES * walk.total[-1], abs=1e-5)
    assert walk.worth(walk.total + np.r_[np.zeros(400), 0.1]) == pytest.approx(walk.value - EXCESS * MOVES * 0.1)
    assert walk.worth(np.r_[-information.ravel(), 0.0]) == -np.inf


@pytest.mark.parametrize("kind", ["_shifted", "_with_new_waypoint", "_with_moved_excursion"])
def test_every_proposal_is_a_walk_whose_moves_are_new_or_those_of_before(kind: str, walk: Walk, moves: EqualMoves):
    proposals = [p for _ in range(2000) if (p := getattr(walk, kind)()) is not None]
    assert len(proposals) > 100
    before = np.hstack([walk.points[:-1], walk.points[1:]])
    for points, origins in proposals:
        assert points.shape == walk.points.shape
        assert np.abs(points).max() <= 1.0
        assert (np.abs(np.diff(points, axis=0)) <= moves.steps + 1e-8).all()
        now = np.hstack([points[:-1], points[1:]])
        old = origins != NEW
        assert 0 < (~old).sum() < MOVES + 1
        assert len(set(origins[old])) == old.sum()
        assert np.array_equal(now[old], before[origins[old]])


def test_a_moved_excursion_goes_there_and_back(walk: Walk):
    """Two waypoints less, two more: elsewhere the walk goes out by a move and returns to where it was."""
    for _ in range(200):
        if (proposal := walk._with_moved_excursion()) is None:
            continue
        points, origins = proposal
        out = np.flatnonzero((origins[:-1] == NEW) & (origins[1:] == NEW))
        assert any(np.array_equal(points[k], points[k + 2]) for k in out)


def test_two_instants_a_move_rate_a_walk_well_enough_for_a_choice(
    walk: Walk, moves: EqualMoves, family: PointToPointFamily, model: Model, scaling: np.ndarray
):
    motion = family.motion(unknowns_of(walk.best_points, moves, family))
    logdet = np.linalg.slogdet(mean_information(model, scaling, motion))[1]
    assert walk.best == pytest.approx(logdet, abs=0.03 * 20)  # 3 % of an efficiency


def test_annealing_finds_more_than_chance_and_the_same_again(
    hexapod_case: Case, model: Model, scaling: np.ndarray, family: PointToPointFamily
):
    def logdet(unknowns: np.ndarray) -> float:
        return float(np.linalg.slogdet(mean_information(model, scaling, family.motion(unknowns)))[1])

    def annealed(seed: int) -> np.ndarray:
        draw = np.random.default_rng(seed)
        return annealed_start(hexapod_case, model, scaling, family, draw, 6000, lambda objective: False)

    problem = build_problem(hexapod_case, model, family, scaling)
    by_chance = max(logdet(random_start(seed, family, problem)) for seed in range(5))
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
    unknowns = annealed_start(hexapod_case, model, scaling, family, draw, 50_000, watch)
    assert len(told) == 2
    assert told[1] <= told[0]
    assert np.isfinite(unknowns).all()
