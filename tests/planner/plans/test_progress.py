"""The line that is shown while a search is under way says what is known, and nothing that was stored."""

import io
import json
import math
import sys
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hexcite as hx
from cases.base import seldom
from cases.schema import Case
from hexcite.cli import console
from planner import _plan
from planner.families.settings import Fourier, PointToPoint
from planner.plans.progress import Follower, Standing, expected_best
from planner.request import Request
from planner.search.parallel import Planned, UnderWay
from planner.search.record import Failed, SolverStatus, StartRecord
from planner.search.solving import Start

pytestmark = pytest.mark.usefixtures("cache")


@given(values=st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=8), further=st.integers(0, 30))
def test_more_starts_let_expect_more_and_never_less_than_there_is(values: list[float], further: int):
    assert expected_best(values, further) >= max(values)
    assert expected_best(values, further + 1) >= expected_best(values, further)


def test_the_best_of_many_draws_is_what_few_of_them_let_expect():
    draws = np.random.default_rng(5).normal(size=(4000, 12))
    told = np.mean([expected_best(row[:4].tolist(), 8) for row in draws])
    assert told == pytest.approx(draws.max(axis=1).mean(), rel=0.1)


def test_it_says_which_start_how_good_and_how_long(hexapod_case: Case, monkeypatch: pytest.MonkeyPatch):
    lines: list[str] = []
    clock = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    request = Request(Fourier(order=3), 3.0, model=6)
    (family,) = request.family.families(hexapod_case, 3.0)
    unknowns = family.start(np.random.default_rng(1), lambda unknowns: 4.0 * float(np.abs(unknowns).max()))
    record = StartRecord(1, True, -3.0, -3.0, SolverStatus.SETTLED, True, 9, 4.0)
    start = Start(record, unknowns, family, 1.0, unknowns, -3.0)
    follow = Follower(hexapod_case, lambda standing: lines.append(str(standing)))
    follow(request)
    follow(Planned("start", 5, False, math.inf))
    assert lines[-1] == "start 1 of at least 5"
    clock[0] += 4.0
    follow(UnderWay(1, 0.5))
    assert lines[-1] == "start 1 of at least 5, about 36 s left"
    clock[0] += 4.0
    follow(start)
    told = lines[-1].split(", ")
    assert told[0] == "start 2 of at least 5"
    assert 0.0 < float(told[1].removeprefix("best ")) < 0.5
    assert told[2] == "about 32 s left"
    follow(replace(start, record=replace(record, seed=2, criterion_value=-5.0), promise=-5.0))
    share = float(lines[-1].split("(")[1].split()[0])
    assert 0.9 < share < 1.0
    follow(Failed(3, "made up"))
    assert lines[-1].startswith("start 4 of at least 5")
    follow(Planned("refinement", 1, True, clock[0] + 7.0))
    assert lines[-1].startswith("refinement 1 of 1, best ")
    assert lines[-1].endswith(", about 7 s left")
    clock[0] += 8.0
    follow(None)
    assert "left" not in lines[-1].split(", ")[-1]


def test_a_search_tells_from_its_beginning(hexapod_case: Case, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(seldom, "EVERY", 0.0)
    lines: list[str] = []
    hx.plan(hexapod_case, PointToPoint(moves=8), 2.0, model=6, starts=2, workers=1, progress=lines.append)
    of_starts = [line for line in lines if line.startswith("start")]
    assert of_starts[0] == "start 1 of 2"
    assert any("start 2 of 2, best 0." in line for line in of_starts)
    assert any("s left" in line for line in of_starts)  # with the first one only where that lasts for a second


def test_progress_is_shown_at_most_once_a_second(hexapod_case: Case, monkeypatch: pytest.MonkeyPatch):
    """In a notebook each line stays: fifty steps within seven seconds are eight lines."""
    clock = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])

    def fifty_steps(request: Request, case: Case, show: Callable[[Standing], None]) -> None:
        for number in range(50):
            show(Standing(f"step {number}"))
            clock[0] += 0.15

    monkeypatch.setattr(_plan, "planned", fifty_steps)
    lines: list[str] = []
    hx.plan(hexapod_case, PointToPoint(moves=8), 2.0, model=6, progress=lines.append)
    assert lines == [f"step {number}" for number in range(0, 50, 7)]


def test_a_search_whose_time_was_not_limited_does_not_say_that_it_is_over(hexapod_case: Case):
    follow = Follower(hexapod_case, lambda standing: None)
    follow(Request(Fourier(order=3), 3.0, model=6))
    follow(Planned("start", 1, True, math.inf))
    follow(Failed(1, "made up"))
    assert follow.standing().line == "start 1 of 1, ending"


def test_programs_read_where_a_search_stands(capfd: pytest.CaptureFixture[str]):
    said = console.as_lines()
    said(Standing("start 1 of 3", 0, 3))
    said(Standing("start 1 of 3, about 9 s left", 0, 3, None, 9.0))  # nothing new within a second
    said(Standing("start 2 of 3, best 0.500", 1, 3, 0.5, 6.0))
    first, second = (json.loads(line) for line in capfd.readouterr().err.splitlines())
    assert (first["done"], first["best"]) == (0, None)
    assert (second["done"], second["least"], second["best"], second["left_s"]) == (1, 3, 0.5, 6.0)


def test_a_listener_that_has_gone_ends_no_search(monkeypatch: pytest.MonkeyPatch):
    class Gone(io.StringIO):
        def write(self, text: str) -> int:
            raise BrokenPipeError

    monkeypatch.setattr(sys, "stderr", Gone())
    console.as_lines()(Standing("start 1 of 3", 0, 3))
