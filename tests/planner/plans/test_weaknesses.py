"""What a plan says of itself first: why another one would carry more information, and what to do."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import box_middle
from identification.limits.limit import Limit, LimitCheck, LimitKind, LimitReport, Status
from planner.families.fourier import FourierFamily
from planner.families.ptp import PointToPointFamily
from planner.plans.rating import FULL, PlannedMotion, notes, search_notes, weaknesses
from planner.request import Request
from planner.search.record import SolverStatus, StartRecord
from planner.search.solving import DRAWN_BACK, Start
from tests.helpers import tells


def check(kind: LimitKind, place: str, ratio: float) -> LimitCheck:
    return LimitCheck(Limit(kind), place, ratio, 1.0, "m/s", ratio, 0.5, Status.PROVEN)


@pytest.fixture
def start(hexapod_case: Case) -> Start:
    family = FourierFamily(2, 3.0, 1, *box_middle(hexapod_case))
    unknowns = 0.01 * np.random.default_rng(0).normal(size=18)
    tried = StartRecord(1, True, -5.0, -5.0, "solve succeeded", True, 9, 1.0)
    return Start(tried, unknowns, family, 1.0, unknowns, -5.0)


@pytest.fixture
def found(start: Start) -> PlannedMotion:
    """A search with nothing to be said against it."""
    limits = LimitReport((check(LimitKind.VELOCITY, "x", 0.999), check(LimitKind.STRUT_LENGTH, "strut 1", 0.5)))
    return PlannedMotion(start.family.motion(start.unknowns), start.family.settings, limits, (start,))


Said = Callable[[PlannedMotion], tuple[str, ...]]


@pytest.fixture
def said() -> Said:
    return lambda found: weaknesses(found, Request(starts=1))


def test_a_good_plan_has_none(found: PlannedMotion, said: Said):
    assert said(found) == ()


@pytest.mark.parametrize("interrupted", [False, True])
def test_a_search_that_had_not_converged(interrupted: bool, found: PlannedMotion, start: Start, said: Said):
    tried = replace(start.record, converged=False, solver=SolverStatus.ITERATION_LIMIT)
    unfinished = replace(start, record=tried)
    weak = said(found._replace(starts=(unfinished,), interrupted=interrupted))
    if interrupted:  # it says so itself
        assert weak == ()
    else:
        (told,) = weak
        assert tells(told, "only start", "not converged", "iteration limit", "no number of starts")
    assert weaknesses(found._replace(starts=(unfinished,)), Request()) == ()  # which went on until it was enough


def test_a_search_that_ends_by_itself_says_how_close_its_starts_are(found: PlannedMotion, start: Start) -> None:
    """Two parameters, log det with what is known 0.02 apart: 1 % of an efficiency."""
    best = start.record
    behind = best.criterion_value - 0.02
    other = replace(start, record=replace(best, seed=best.seed + 1, criterion_value=behind))
    explored = [replace(start, record=replace(best, seed=best.seed + k, refined=False)) for k in range(3)]
    two = found._replace(starts=(start, other, *explored))
    (note,) = search_notes(two, Request(), 2)
    assert tells(note, "best of 3 starts", "1.0 % less")
    assert search_notes(two, Request(starts=2), 2) == ()
    assert search_notes(found, Request(), 2) == ()
    assert search_notes(two._replace(interrupted=True), Request(), 2) == ()


def test_only_the_best_refined_start_need_have_converged(found: PlannedMotion, start: Start, said: Said):
    unfinished = replace(start.record, converged=False)
    explored = replace(start, record=replace(unfinished, refined=False))
    assert said(found._replace(starts=(start, explored, replace(start, record=unfinished)))) == ()
    assert said(found._replace(starts=(explored, start))) == ()


@pytest.mark.parametrize(("share", "told"), [(DRAWN_BACK - 0.01, True), (DRAWN_BACK, False)])
def test_a_motion_that_was_drawn_back(share: float, told: bool, found: PlannedMotion, start: Start, said: Said):
    weak = said(found._replace(starts=(replace(start, shrunk=share),)))
    assert len(weak) == told
    assert not told or f"{100 * share:.0f} % of its displacements" in weak[0]


@pytest.mark.parametrize(
    "kind", [LimitKind.STRUT_LENGTH, LimitKind.POSITION, LimitKind.BASE_JOINT_ANGLE, LimitKind.JOINT_ANGLE]
)
def test_no_limit_of_speed_is_used(kind: LimitKind, found: PlannedMotion, said: Said):
    """That poses are at their limits is not an excuse."""
    used = LimitReport(
        (
            check(LimitKind.VELOCITY, "x", FULL - 0.1),
            check(LimitKind.STRUT_VELOCITY, "strut 3", 0.7),
            check(kind, "strut 1", 0.999),
        )
    )
    (told,) = said(found._replace(limits=used))
    assert f"beyond {100 * (FULL - 0.1):.0f} % (velocity (x))" in told
    force = LimitReport((*used.checks, check(LimitKind.SENSOR_FORCE, "sensor 1", 0.95)))
    assert said(found._replace(limits=force)) == ()


def test_what_was_made_by_hand_is_not_judged(found: PlannedMotion, said: Said):
    slow = LimitReport((check(LimitKind.VELOCITY, "x", 0.2),))
    assert said(found._replace(starts=(), limits=slow)) == ()


def test_a_plan_of_moves_says_of_which_numbers_its_own_is_the_best(
    found: PlannedMotion, start: Start, hexapod_case: Case
) -> None:
    few, many = (replace(start, family=PointToPointFamily.of(hexapod_case, n, 6.0)) for n in (12, 20))
    both = found._replace(starts=(many, few), settings=many.family.settings)
    assert any("20 moves" in note and "12, 20" in note for note in notes(both))
    assert not any("moves are" in note for note in notes(both._replace(starts=(many,))))
