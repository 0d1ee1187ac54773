"""When a search has had enough starts: counted in the order of their seeds, and only where nothing else was asked."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

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


# The process that begins second sleeps before Python has read what it is to do.
LATE = """
import os, sys, time
if "--multiprocessing-fork" in sys.orig_argv:
    try:
        os.mkdir({first!r})
    except FileExistsError:
        time.sleep(2.0)
"""
SCRIPT = """
import operator
from threading import Event
from planner.search import parallel

parallel._work = operator.neg
if __name__ == "__main__":
    with parallel.workers(Event(), 2) as run:
        two = parallel.Schedule(lambda k, _: k + 1 if k < 2 else None, lambda results: len(results) >= 1)
        print(run(two, parallel.silent))
    del run
"""


@pytest.mark.repeats
def test_a_process_that_begins_when_the_search_is_over_says_nothing(tmp_path: Path):
    """On a busy computer a process may take seconds to begin; what it was to join is gone by then, or is it?"""
    (tmp_path / "sitecustomize.py").write_text(LATE.format(first=str(tmp_path / "first")), encoding="ascii")
    (tmp_path / "script.py").write_text(SCRIPT, encoding="ascii")
    places = os.pathsep.join([str(tmp_path), str(Path(__file__).parents[3]), os.environ.get("PYTHONPATH", "")])
    run = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, env=os.environ | {"PYTHONPATH": places}, timeout=300,
        capture_output=True, text=True,
    )  # fmt: skip
    assert (run.stdout, run.stderr, run.returncode) == ("([-1], False)\n", "", 0)
