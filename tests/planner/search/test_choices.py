"""Free order and period: near the frequency at which velocity and acceleration both bind."""

from dataclasses import replace
from inspect import signature

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.base.errors import HexciteError
from cases.base.options import options_of
from cases.schema import Case
from hexcite.cli.plan import FLAGS, SEARCHED, plan, refuse_foreign
from planner.families import ptp, spline
from planner.families.plan_settings import FourierSettings, PlanSettings
from planner.families.settings import FAMILIES, Best, Fourier, PointToPoint, Spline
from planner.options import FAMILY_WORDS, MoveOptions, SplineOptions
from planner.plans.making import search
from planner.plans.rating import PlannedMotion, choice_notes, tried_families
from planner.request import OWNERS, Request
from planner.search.parallel import Listener, Outcome, Results, Schedule, silent
from planner.search.record import Failed, SolverStatus, StartRecord
from planner.search.rounds import KEPT
from planner.search.solving import Start, Task
from tests.helpers import examples, one_line


def test_what_is_fixed_is_the_only_choice(hexapod_case: Case):
    for family in (Fourier(), PointToPoint(moves=20), Spline()):
        assert len(family.families(hexapod_case, 12.0)) == 1


@pytest.mark.parametrize("order", [1, 2, 5, 7])
def test_a_free_period_is_searched_for_from_several_first_ones(order: int, hexapod_case: Case):
    found = Fourier(order, free_period=True).families(hexapod_case, 12.0)
    periods = [family.period for family in found]
    assert len(set(periods)) == len(found) > 2
    assert {family.order for family in found} == {order}
    assert all(family.free.shortest < family.period < family.free.longest for family in found)
    assert all(family.once.free is not None for family in found)


def test_the_best_known_periods_are_within_reach(hexapod_case: Case):
    families = Fourier(free_order=True, free_period=True).families(hexapod_case, 12.0)
    reach = {family.order: family.free for family in families}
    assert set(reach) == set(range(2, 8))
    for order, period in {(5, 3.0), (7, 4.0), (3, 2.0)}:
        assert reach[order].shortest < period < reach[order].longest


def test_velocity_alone_binds_far_below_and_acceleration_far_above_the_choices(hexapod_case: Case):
    """One harmonic of amplitude V / w has an acceleration of V w: the limit A is reached at w = A / V."""
    box = hexapod_case.limits.motion
    free = Fourier(5, free_period=True).families(hexapod_case, 12.0)[0].free
    meets = (box.acceleration / box.rate).max() / (2 * np.pi)
    assert 5 / free.longest == pytest.approx(meets / 3)
    assert 5 / free.shortest == pytest.approx(2 * meets)


def test_a_free_order_keeps_the_period_that_is_fixed(hexapod_case: Case):
    found = Fourier(period=4.0, free_order=True).families(hexapod_case, 12.0)
    assert [family.order for family in found] == [2, 3, 4, 5, 6, 7]
    assert {family.period for family in found} == {4.0}


def test_a_duration_need_not_fit_a_period_that_is_free(hexapod_case: Case):
    family = Fourier(free_period=True)
    assert family.families(hexapod_case, 10.3)
    with pytest.raises(HexciteError, match="not positive"):
        Request(family, duration=-1.0)


def test_too_short_a_duration_is_refused_in_one_line(hexapod_case: Case):
    with pytest.raises(HexciteError, match="no period fits") as caught:
        Fourier(free_period=True).families(hexapod_case, 0.3)
    one_line(caught.value)


@pytest.mark.parametrize("what", ["order", "period"])
def test_fixed_and_free_at_once_is_a_misunderstanding(what: str):
    with pytest.raises(HexciteError, match=f"--{what} does nothing with --free-{what}"):
        refuse_foreign([f"free_{what}", what], "fourier")
    with pytest.raises(HexciteError, match=f"free-{what} .*family ptp"):
        refuse_foreign([f"free_{what}"], "ptp")


MOVING = ("fourier", "ptp", "spline")
BELONGS = dict.fromkeys(SEARCHED, MOVING) | {
    "order": ("fourier",), "period": ("fourier",), "free_order": ("fourier",), "centred": ("fourier",),
    "equal_start": ("fourier",),
    "free_period": ("fourier",), "moves": ("ptp",), "controller": ("ptp",), "without": ("ptp",), "knots": ("spline",),
    "sequence": ("manual",),
}  # fmt: skip


def test_every_setting_of_a_family_is_an_option():
    assert set(BELONGS) == {*SEARCHED, *OWNERS}
    assert set(BELONGS) <= set(signature(plan).parameters)


def test_meanings_of_options_state_the_ranges_that_are_kept():
    for declaration, kind in ((MoveOptions, ptp), (SplineOptions, spline)):
        assert f", {kind.FEWEST} to {kind.MOST};" in options_of(declaration)[0].option.meaning


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("option", BELONGS)
def test_options_of_another_family_are_refused_and_its_own_are_taken(option: str, family: str):
    if family in BELONGS[option]:
        refuse_foreign([option], family)
        return
    typed = FLAGS[option]
    with pytest.raises(HexciteError, match=f"{typed} .*family {family}") as told:
        refuse_foreign([option], family)
    assert all(other in one_line(told.value) for other in BELONGS[option])


def period_of(settings: PlanSettings) -> float:
    """The period of the motion, which is a Fourier series [s]."""
    assert isinstance(settings, FourierSettings)
    return settings.period_s


def _made_up(task: Task) -> Start:
    """What a start would find: the shorter the period, the better."""
    own = task.family.settings
    promise = -own.period_s if isinstance(own, FourierSettings) else -100.0
    refined = task.refine
    score = promise if refined else -100.0  # drawn back, a motion is worth as little as any
    unknowns = np.full(18, 0.01) if getattr(task.family, "free", None) is None else np.r_[np.full(18, 0.01), 1.0]
    tried = StartRecord(task.seed, refined, 0.0, score, SolverStatus.SETTLED, True, 1, 0.0)
    return Start(tried, unknowns, task.family, 1.0, unknowns, promise)


def _all_of(schedule: Schedule) -> tuple[list[Task], list[Start | Failed]]:
    """All starts of a schedule, one after the other, with made-up results."""
    results, tasks = Results(schedule), []
    while not results.enough and (task := schedule.task(len(tasks), results.in_order)) is not None:
        tasks.append(task)
        results.add(len(tasks) - 1, _made_up(task))
    return tasks, results.in_order


@pytest.mark.parametrize(("criterion", "refinements"), [("D", 2), ("K", 4)])
def test_each_choice_is_looked_at_and_the_best_get_all_other_starts(
    criterion: str, refinements: int, hexapod_case: Case
):
    """With results made up: the shorter the period the better, and refinements better still."""
    request = Request(Fourier(order=2, free_period=True), criterion=criterion, duration=3.0)
    periods = sorted(family.period for family in request.family.families(hexapod_case, 3.0))  # type: ignore[attr-defined]
    request = replace(request, starts=len(periods) + 2 * KEPT)
    tried: list[Task] = []

    def run(schedule: Schedule, listener: Listener) -> Outcome:
        tasks, results = _all_of(schedule)
        tried.extend(tasks)
        return results, False

    found = search(request, hexapod_case, silent, run)
    assert len(periods) > KEPT
    explored = [task for task in tried if not task.refine]
    assert len({task.seed for task in explored}) == len(explored) == request.starts
    seen = [period_of(task.family.settings) for task in explored]
    assert sorted(seen[: len(periods)]) == periods
    assert set(seen[len(periods) :]) <= set(periods[:KEPT])
    best = sorted(explored, key=lambda task: period_of(task.family.settings))[:refinements]
    assert {task.seed for task in best} <= {task.seed for task in tried if task.refine}
    assert all(start.family.name == "fourier" for start in found.starts)
    assert period_of(found.settings) == periods[0]


def test_moves_are_as_many_as_there_is_room_for_and_fewer(hexapod_case: Case):
    found = [family.moves for family in PointToPoint().families(hexapod_case, 12.0)]  # type: ignore[attr-defined]
    assert found[0] == PointToPoint().count(hexapod_case, 12.0) == 40
    assert len(found) >= 3
    assert found == sorted(found, reverse=True)
    short = [family.moves for family in PointToPoint().families(hexapod_case, 2.4)]  # type: ignore[attr-defined]
    assert short == [ptp.FEWEST]


def _searched(request: Request, case: Case, worth: dict[str, float]) -> tuple[list[Task], PlannedMotion]:
    """Tasks of a search whose motions are worth what is made up for their families, and what it chose."""
    tasks: list[Task] = []

    def run(schedule: Schedule, listener: Listener) -> Outcome:
        results = Results(schedule)
        while not results.enough and (task := schedule.task(len(results.in_order), results.in_order)) is not None:
            tasks.append(task)
            unknowns = task.family.start(np.random.default_rng(task.seed), lambda unknowns: 1e3)
            value = worth[task.family.name] + 0.1 * task.refine
            tried = StartRecord(task.seed, task.refine, value, value, SolverStatus.SETTLED, True, 1, 0.0)
            results.add(len(results.in_order), Start(tried, unknowns, task.family, 1.0, unknowns, value))
        return results.in_order, False

    return tasks, search(request, case, silent, run)


@pytest.mark.parametrize("best", MOVING)
def test_without_a_family_each_has_a_start_and_the_best_has_the_others(best: str, hexapod_case: Case):
    worth = dict.fromkeys(MOVING, -20.0) | {best: -10.0}
    tasks, found = _searched(Request(Best(), 3.0), hexapod_case, worth)
    first = len(Best().families(hexapod_case, 3.0))
    assert {task.family.name for task in tasks[:first]} == set(MOVING)
    assert {task.family.name for task in tasks[first:]} == {best}
    assert len(tasks) > first
    assert found.starts[0].family.name == best
    tried = tried_families(found, 0.5, 20)
    assert next(iter(tried)) == best
    assert tried[best] == 0.5
    assert set(tried) == set(MOVING)
    others = [efficiency for name, efficiency in tried.items() if name != best]
    assert all(0.25 < other < 0.4 for other in others)  # 0.5 exp(-10 / 20), a little more of what is refined
    assert choice_notes(tried)[0].startswith(f"{FAMILY_WORDS[best]} by trying")


def test_a_family_that_may_pass_the_best_once_it_is_refined_is_refined_too(hexapod_case: Case):
    """Explorations of splines may lie far behind moves that they pass in the end: exp(-4 / 20) is 0.82."""
    worth = {"spline": -14.0, "ptp": -10.0, "fourier": -30.0}
    tasks, _ = _searched(Request(Best(), 3.0), hexapod_case, worth)
    refined = [task.family.name for task in tasks if task.refine]
    assert refined == ["ptp", "ptp", "spline"]


def test_a_controller_with_a_time_law_of_its_own_is_planned_moves_for(hexapod_case: Case):
    own, unkept = (
        hexapod_case.model_copy(update={"controller": hexapod_case.controller.model_copy(update={"plan_for": name})})
        for name in ("sinumerik", "linuxcnc")
    )
    assert {family.name for family in Best().candidates(own, 12.0)} == {"ptp"}
    with pytest.raises(HexciteError, match="without jerk"):
        Best().candidates(unkept, 12.0)
    assert {family.name for family in Best().candidates(hexapod_case, 12.0)} == set(MOVING)
    assert {family.name for family in Best().candidates(hexapod_case, 1.0)} == {"ptp", "fourier"}


def test_the_best_of_two_series_is_refined(hexapod_case: Case):
    rounds: list[list[bool]] = []

    def run(schedule: Schedule, listener: Listener) -> Outcome:
        tasks, results = _all_of(schedule)
        rounds.append([task.refine for task in tasks])
        return results, False

    search(Request(Fourier(order=2), duration=3.0), hexapod_case, silent, run)
    assert rounds == [[False, False], [True]]


@given(width=st.integers(1, 40), seed=st.integers(0, 2**32 - 1), starts=st.sampled_from((None, 5, 30)))
@settings(max_examples=examples(4))
def test_neither_the_number_of_processes_nor_their_pace_changes_what_is_found(
    width: int, seed: int, starts: int | None, hexapod_case: Case
):
    """Starts end in any order, as many at a time as there are processes: the same starts are made and counted."""
    draw = np.random.default_rng(seed)

    def result_of(task: Task) -> Start | Failed:
        if task.seed % 7 == 0:
            return Failed(task.seed, "made up")
        made = _made_up(task)
        return replace(made, promise=made.promise + (task.seed % 11 - 5) * 0.3)

    def in_parallel(schedule: Schedule, listener: Listener) -> Outcome:
        results, running, number = Results(schedule), {}, 0
        while not results.enough:
            while len(running) < width and (task := schedule.task(number, results.in_order)) is not None:
                running[number], number = result_of(task), number + 1
            if not running:
                break
            done = int(draw.choice(list(running)))
            results.add(done, running.pop(done))
        return results.in_order, False

    def one_by_one(schedule: Schedule, listener: Listener) -> Outcome:
        results, number = Results(schedule), 0
        while not results.enough and (task := schedule.task(number, results.in_order)) is not None:
            results.add(number, result_of(task))
            number += 1
        return results.in_order, False

    request = Request(Fourier(order=2, free_period=True), duration=3.0, starts=starts)
    found = [search(request, hexapod_case, silent, run) for run in (in_parallel, one_by_one)]
    assert len(found[0].starts) > 1
    assert [start.record for start in found[0].starts] == [start.record for start in found[1].starts]
    assert found[0].failed == found[1].failed
