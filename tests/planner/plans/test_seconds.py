"""A search of some seconds: whatever it has found by then is proven; there is always something."""

import time
from dataclasses import replace

import numpy as np
import pytest

import hexcite as hx
from cases.base.errors import HexciteError
from cases.schema import Case
from identification.limits.limit import LimitReport
from identification.limits.proof import PROOF_RATE, prove
from identification.motion.motion import Trajectory
from planner.families.settings import FamilySettings, Fourier, PointToPoint, Spline
from planner.plans.making import ENDING, search
from planner.request import Request
from planner.search.parallel import Listener, Outcome, Schedule, run_here, silent
from planner.search.record import Failed, SolverStatus, StartRecord
from planner.search.solving import Start

LONG = 120.0  # [s] room for a busy computer


@pytest.mark.first(1)
@pytest.mark.parametrize("family", [Fourier(order=3), PointToPoint(moves=8), Spline(knots=20)], ids=lambda f: f.name)
def test_however_short_the_time_what_is_found_is_proven(family: FamilySettings, hexapod_case: Case):
    found = search(Request(family, 2.0, model=6, seconds=1e-3), hexapod_case, silent, run_here)
    assert found.out_of_time
    assert not found.interrupted
    assert found.limits.kept
    assert found.starts[0].record.logdet > -200.0


@pytest.mark.parametrize("case", ["hexapod", "ur10_wrist"])
def test_what_was_only_explored_is_proven_once_at_the_full_rate(case: str, monkeypatch: pytest.MonkeyPatch):
    """To bring it inside takes several proofs, at fewer instants: at 10 kHz each takes a robot longer than a second."""
    rates: list[float] = []

    def counted(motion: Trajectory, case: Case, rate: float = PROOF_RATE) -> LimitReport:
        rates.append(rate)
        return prove(motion, case, rate)

    monkeypatch.setattr("planner.plans.making.prove", counted)
    monkeypatch.setattr("planner.search.feasibility.prove", counted)
    found = search(Request(PointToPoint(moves=8), 2.0, model=6, seconds=1e-3), hx.load_case(case), silent, run_here)
    assert not found.starts[0].record.refined
    assert found.limits.kept
    assert rates.count(PROOF_RATE) == 1


@pytest.mark.parametrize(("ending", "rounds"), [(0.4, [False, True, False, True]), (3.0, [False])])
def test_nothing_is_begun_that_has_no_time_to_end(
    ending: float, rounds: list[bool], hexapod_case: Case, monkeypatch: pytest.MonkeyPatch
):
    """Starts run until they are stopped, and need time to end: of 13 s a search explores for 6 s and refines then.

    The last 3 s are for proof, figures and page. Starts that need 0.4 s to end leave 3.6 s for a refinement, which
    needs 1 s here, and 2.6 s for a round more; of those that need 3 s, 1 s is left: less than a refinement would need
    to end.
    """
    clock, refined = [50.0], list[bool]()
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    request = Request(Fourier(order=3), 2.0, model=6, seconds=10.0 + ENDING)
    (family,) = request.family.families(hexapod_case, 2.0)
    unknowns = family.start(np.random.default_rng(1), lambda unknowns: 4.0 * float(np.abs(unknowns).max()))
    record = StartRecord(1, False, -3.0, -3.0, SolverStatus.SETTLED, True, 9, 1.0)

    def run(schedule: Schedule, listener: Listener) -> Outcome:
        task = schedule.task(0, [])
        assert task is not None
        refined.append(task.refine)
        clock[0] = clock[0] + 1.0 if task.refine else schedule.until + ending
        value = -3.0 + 0.1 * len(refined)
        own = replace(record, seed=task.seed, refined=task.refine, criterion_value=value)
        return [Start(own, unknowns, family, 1.0, unknowns, value)], not task.refine

    found = search(request, hexapod_case, silent, run)
    assert refined == rounds
    assert clock[0] - 50.0 < request.seconds - ENDING + ending
    assert found.out_of_time
    assert not found.interrupted


def test_no_exploration_begins_that_takes_longer_than_what_is_left(hexapod_case: Case, monkeypatch: pytest.MonkeyPatch):
    """Half of a search of 10 s explores: after starts of 2 s, and 3.5 s, there is no time for one of 2 s more."""
    clock, begun = [50.0], list[float]()
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    request = Request(Fourier(order=3), 2.0, model=6, seconds=10.0 + ENDING)
    (family,) = request.family.families(hexapod_case, 2.0)
    unknowns = family.start(np.random.default_rng(1), lambda unknowns: 4.0 * float(np.abs(unknowns).max()))
    lasting = [2.0, 1.5, 1.0, 1.0, 1.0]

    def run(schedule: Schedule, listener: Listener) -> Outcome:
        results: list[Start | Failed] = []
        while (task := schedule.task(len(results), results)) is not None and len(results) < len(lasting):
            begun.append(clock[0] - 50.0)
            took = lasting[len(results)]
            clock[0] += took
            record = StartRecord(task.seed, task.refine, -3.0, -3.0, SolverStatus.SETTLED, True, 9, took)
            results.append(Start(record, unknowns, family, 1.0, unknowns, -3.0))
        clock[0] = max(clock[0], schedule.until)
        return results, True

    search(request, hexapod_case, silent, run)
    assert begun[:3] == [0.0, 2.0, 3.5]
    assert 4.5 not in begun


def test_seconds_count_from_when_the_command_began(hexapod_case: Case, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(time, "monotonic", lambda: 50.0)
    request = Request(Fourier(order=3), 2.0, model=6, seconds=10.0 + ENDING)
    ends: list[float] = []

    def run(schedule: Schedule, listener: Listener) -> Outcome:
        ends.append(schedule.last)
        return [Failed(1, "no motion")], False

    for began in (None, 48.0):
        with pytest.raises(HexciteError):
            search(request, hexapod_case, silent, run, began)
    assert ends == [60.0, 58.0]


@pytest.mark.slow
def test_more_time_finds_more_than_its_beginning(hexapod_case: Case):
    """Rounds go on while there is time, each from further seeds."""
    request = Request(PointToPoint(moves=8), 2.0, model=0, seconds=4.0)
    began = time.monotonic()
    found = search(request, hexapod_case, silent, run_here)
    assert request.seconds / 3 <= time.monotonic() - began < request.seconds + LONG  # it begins nothing that cannot end
    assert found.out_of_time
    seeds = [start.record.seed for start in found.starts if start.record.refined]
    assert len(set(seeds)) == len(seeds)
    first = search(Request(PointToPoint(moves=8), 2.0, model=0, seconds=1e-3), hexapod_case, silent, run_here)
    assert found.starts[0].record.logdet > first.starts[0].record.logdet


def test_a_plan_says_that_its_time_was_over(hexapod_case: Case, cache: None):
    plan = hx.plan(hexapod_case, PointToPoint(moves=8), 2.0, model=6, seconds=0.1, workers=1)
    assert plan.limits.kept
    assert not plan.interrupted
    assert any("0.1 s" in note for note in plan.worth.notes)
    assert Request.of_json(plan.to_json() | {"payload_from": 0}) == plan.request


@pytest.mark.parametrize("settings", [{"seconds": 0.0}, {"seconds": -1.0}, {"seconds": float("nan")},
                                      {"seconds": 10.0, "starts": 2}])  # fmt: skip
def test_times_that_cannot_be_are_refused(settings: dict):
    with pytest.raises(HexciteError, match="seconds"):
        Request(**settings)


def test_at_the_end_of_its_time_a_search_waits_for_a_first_start_that_is_done(monkeypatch: pytest.MonkeyPatch):
    """A start that is stopped early has found little: half of an exploration is not half of its information."""
    clock = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    schedule = Schedule(lambda k, results: None, lambda results: False, until=3.0, last=5.0)
    failed = Failed(1, "no motion")
    record = StartRecord(1, False, -3.0, -3.0, SolverStatus.SETTLED, True, 9, 4.0)
    done = Start(record, np.zeros(1), PointToPoint(moves=8).families(hx.load_case("hexapod"), 4.0)[0], 1.0,
                 np.zeros(1), -3.0)  # fmt: skip
    late = {}
    for clock[0] in (2.9, 3.1, 5.1):
        late[clock[0]] = [schedule.late(results) for results in ((), (failed,), (failed, done))]
    assert late == {2.9: [False] * 3, 3.1: [False, False, True], 5.1: [True] * 3}
