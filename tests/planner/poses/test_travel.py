"""Moves between poses: as fast as the limits allow and no faster, in an order that no other beats by much."""

from itertools import permutations

import numpy as np
import pytest

from cases.base.errors import InfeasiblePlan
from cases.schema import load_case
from identification.limits.proof import prove
from identification.machines.hexapod import Hexapod
from identification.motion.motion import StandingPoses
from planner.poses.planned_poses import sampled_candidates
from planner.poses.travel import duration, fastest_move, require_ways, shortest_order, travel_times
from tests.postprocessors.changed_case import changed

CASE = load_case("hexapod")
HOME = np.array([0.0, 0.0, 0.9, 0.0, 0.0, 0.0])
STATIONS = np.vstack([HOME, sampled_candidates(CASE, 16, 0)])


def test_times_are_those_of_the_planned_moves() -> None:
    times = travel_times(CASE, STATIONS)
    np.testing.assert_array_equal(times, times.T)
    assert np.all(np.diag(times) == 0.0)
    for a, b in ((0, 1), (3, 7), (12, 5)):
        assert fastest_move(CASE, STATIONS[a], STATIONS[b]).duration == pytest.approx(times[a, b], rel=1e-9)


def test_each_move_keeps_every_limit_and_reaches_one() -> None:
    kinetic = ("velocity", "acceleration", "jerk", "angular", "strut velocity", "strut acceleration")
    for a, b in zip(range(16), range(1, 17), strict=True):
        report = prove(fastest_move(CASE, STATIONS[a], STATIONS[b]), CASE, 2000.0, in_box=False)
        assert report.kept, report.violations
        reached = max(c.ratio for c in report.checks if c.name.startswith(kinetic))
        assert reached > 0.98


def test_moves_are_slowed_where_a_strut_would_be_too_fast() -> None:
    assert CASE.limits is not None
    tight = CASE.limits.motion.model_copy(update={"strut_velocity_m_s": 0.2, "strut_acceleration_m_s2": 2.0})
    slow = CASE.model_copy(update={"limits": CASE.limits.model_copy(update={"motion": tight})})
    assert np.all(travel_times(slow, STATIONS[:5])[np.triu_indices(5, 1)] > 1.2 * travel_times(CASE, STATIONS[:5])[
        np.triu_indices(5, 1)
    ])  # fmt: skip
    for end in STATIONS[1:5]:
        checks = {str(c.of): c for c in prove(fastest_move(slow, HOME, end), slow, 2000.0).checks}
        most = max(checks["strut velocity"].ratio, checks["strut acceleration"].ratio)
        assert 0.98 < most <= 1.0 + 1e-6


def test_moves_are_slowed_where_a_sensor_would_be_overloaded_and_need_be_no_slower() -> None:
    report = prove(fastest_move(CASE, HOME, STATIONS[1]), CASE, 2000.0, in_box=False)
    standing = prove(StandingPoses(STATIONS[:2]), CASE, 2000.0, in_box=False)
    moving, still = (max(c.worst for c in r.checks if c.name.startswith("sensor force")) for r in (report, standing))
    assert moving > 1.2 * still
    weak = changed(CASE, sensors__range_N=1.1 * still / 0.8)
    slow = fastest_move(weak, HOME, STATIONS[1])
    kept = prove(slow, weak, 2000.0, in_box=False)
    assert kept.kept
    assert max(c.ratio for c in kept.checks if c.name.startswith("sensor force")) > 0.9
    assert slow.duration > fastest_move(CASE, HOME, STATIONS[1]).duration


def test_the_order_of_few_poses_is_the_best_of_all_orders() -> None:
    times = travel_times(CASE, STATIONS[:8])
    best = min(duration([0, *order, 0], times) for order in permutations(range(1, 8)))
    assert duration(shortest_order(times), times) == pytest.approx(best, rel=1e-9)


def test_the_order_of_poses_on_a_circle_goes_round_it() -> None:
    angle = np.random.default_rng(2).permutation(40) * 2 * np.pi / 40
    points = np.vstack([[1.0, 0.0], np.column_stack([np.cos(angle), np.sin(angle)])])
    times = np.linalg.norm(points[:, None] - points[None], axis=2)
    order = shortest_order(times)
    assert sorted(order[:-1]) == list(range(41))
    assert order[0] == order[-1] == 0
    assert duration(order, times) == pytest.approx(80 * np.sin(np.pi / 40))


def test_a_place_without_a_way_is_named() -> None:
    assert CASE.workspace is not None
    shortest = 1e3 * float(Hexapod.of(CASE).strut_lengths(HOME[None]).min()) + 1.0  # home itself is out of reach
    changed = CASE.workspace.model_dump() | {"strut_length_mm": (shortest, 1550.0)}
    cramped = type(CASE.workspace).model_validate(changed)
    assert np.isinf(travel_times(CASE.model_copy(update={"workspace": cramped}), STATIONS[:3])[0, 1:]).all()
    times = np.full((3, 3), np.inf)
    with pytest.raises(InfeasiblePlan, match=r"pose 0 to pose 2\b.*0 is home"):
        require_ways(times, np.array([0, 2, 1, 0]))
