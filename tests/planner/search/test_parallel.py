"""When a search has had enough starts: counted in the order of their seeds, and only where nothing else was asked."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.families.fourier import FourierFamily
from planner.families.settings import Fourier, PointToPoint, Spline
from planner.request import Request
from planner.search.parallel import (
    FAILURES,
    MOST,
    WORTHWHILE,
    enough,
    gain,
    most_starts,
)
from planner.search.record import Failed, SolverStatus, StartRecord
from planner.search.solving import Start

SIZE = 20
FAMILY = FourierFamily(2, 3.0, 1, np.zeros(6), np.ones(6))
IDLE = Spline().idle("D")
STEP = SIZE * np.log1p(WORTHWHILE)  # of log det, just worthwhile


def start(promise: float, seed: int = 0) -> Start:
    tried = StartRecord(seed, False, promise, promise, SolverStatus.SETTLED, True, 1, 0.0)
    return Start(tried, np.zeros(1), FAMILY, 1.0, np.zeros(1), promise)


def request(**settings: object) -> Request:
    return replace(Request(Spline()), **settings)


def ended_after(promises: list[float]) -> int | None:
    """How many starts it takes until they are enough."""
    results = [start(p) for p in promises]
    return next((k for k in range(len(results) + 1) if enough(results[:k], request(), SIZE)), None)


def test_it_ends_after_so_many_starts_without_a_worthwhile_gain():
    assert ended_after([-5.0] * 20) == 1 + IDLE
    climbing = [-5.0 + 1.01 * STEP * k for k in range(10)]
    assert ended_after(climbing) is None
    assert ended_after([*climbing, *climbing]) == 10 + IDLE
    assert ended_after([-5.0 + 0.6 * STEP * k for k in range(20)]) is None  # small gains add up
    assert ended_after([-5.0 + 0.3 * STEP * k for k in range(20)]) == 1 + IDLE


@pytest.mark.parametrize("family", [Fourier(), PointToPoint()])
def test_other_families_need_one_start_less(family: Fourier | PointToPoint):
    same = [start(-5.0)] * 3
    assert not enough(same[:1], request(family=family), SIZE)
    assert enough(same[:2], request(family=family), SIZE)
    assert enough(same[:2], request(family=family, criterion="A"), SIZE) == (family.name == "ptp")


@given(promises=st.lists(st.floats(-50.0, 50.0), min_size=0, max_size=30))
def test_never_while_one_of_the_last_was_a_gain(promises: list[float]):
    ended = ended_after(promises)
    if ended is None:
        return
    before, last = promises[: ended - IDLE], promises[ended - IDLE : ended]
    assert len(before) >= 1
    assert max(last) < max(before) + STEP * (1 + 1e-9)


def test_what_was_asked_for_is_not_cut_short():
    asked = request(starts=30)
    assert not any(enough([start(-5.0)] * k, asked, SIZE) for k in range(min(40, most_starts(asked))))
    assert most_starts(asked) == 30
    assert most_starts(request()) == MOST


def test_starts_that_all_fail_end_it_too():
    failed = [Failed(k, "no motion") for k in range(10)]
    assert not enough(failed[: FAILURES - 1], request(), SIZE)
    assert enough(failed[:FAILURES], request(), SIZE)


@pytest.mark.parametrize(
    ("criterion", "old", "new", "expected"),
    [
        ("D", -5.0, -5.0 + 20 * np.log(1.1), 0.1),
        ("D", -5.0, -5.0 - 20 * np.log(2.0), -0.5),
        ("A", -110.0, -100.0, 0.1),
        ("K", -100.0, -200.0, -0.5),
        ("N", 2.0, 2.2, 0.1),
    ],
)
def test_gains_are_ratios_of_what_a_criterion_stands_for(criterion: str, old: float, new: float, expected: float):
    assert gain(criterion, SIZE, old, new) == pytest.approx(expected)
    assert gain(criterion, SIZE, -np.inf, new) == np.inf
    assert gain(criterion, SIZE, old, -np.inf) == 0.0
    assert gain(criterion, SIZE, -np.inf, -np.inf) == 0.0
