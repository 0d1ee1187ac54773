"""A motion that exceeds limits is changed as little as they ask for, where shrinking it would lose nearly all of it."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cases.schema import Case, load_case
from identification.estimation.criteria import Criterion
from identification.limits.limit import UNUSED_SHARE, Limit, LimitReport
from identification.limits.proof import prove
from identification.machines.machine import VICINITY
from identification.model.model import full_model
from planner.families.family import Family
from planner.families.fourier import FourierFamily
from planner.families.ptp import PointToPointFamily
from planner.families.spline import SplineFamily
from planner.search.restoration import APART, ClosestProgram, _nearer_than_rows, closest_inside
from planner.search.solving import QUICK_RATE, SLIPPED, Task, _Run, run_start
from tests.bench.machines.description import case_of
from tests.bench.machines.drawn import drawn

ROBOTS = Path(__file__).parents[2] / "bench" / "robots"
BOUND = 1.0 - UNUSED_SHARE - SLIPPED
BEYOND = 1.05  # by which the motions here exceed their limits


@cache
def narrow_case() -> Case:
    """A drawn hexapod whose struts are faster in the middle of its box than near its ends."""
    return case_of("drawn", drawn(5)).within_margin()


def families(case: Case) -> list[Family]:
    """A small one of each kind."""
    spline = SplineFamily.of(case, 20, 3.0)
    fourier = FourierFamily.lasting(3, 2.0, 1, spline.middle, spline.half)
    return [spline, fourier, PointToPointFamily.of(case, 8, 3.0)]


def running(case: Case, family: Family) -> _Run:
    return _Run(Task(case, full_model(case), family, Criterion.D, 3), lambda _: False)


def beyond(run: _Run) -> np.ndarray:
    """Unknowns of a random motion that exceeds its limits a little."""
    unknowns = run.family.start(np.random.default_rng(3), run.program.worst)
    if isinstance(run.family, PointToPointFamily):
        ways = unknowns.copy()
        worst = run.program.worst(ways)
        while worst < BEYOND:
            unknowns, ways = ways, run.family.shrunk(ways, 1.01)
            worst = run.program.worst(ways)
        return ways
    return np.asarray(unknowns * BEYOND / run.program.worst(unknowns))


@pytest.mark.parametrize("number", range(3), ids=["spline", "fourier", "ptp"])
def test_derivatives_are_those_of_the_change(number: int, hexapod_case: Case):
    run = running(hexapod_case, families(hexapod_case)[number])
    motion = run.family.start(np.random.default_rng(3), run.program.worst)
    program = ClosestProgram.of(run.program, motion)
    draw = np.random.default_rng(1)
    at, way = motion + 1e-3 * draw.normal(size=len(motion)), draw.normal(size=len(motion))
    step = 1e-5
    assert program.value(motion) == 0.0
    change = (program.value(at + step * way) - program.value(at - step * way)) / (2 * step)
    assert change == pytest.approx(program.gradient(at) @ way, rel=1e-6)

    weights = draw.normal(size=len(program.row_bounds[0]))
    whole = np.zeros((len(motion), len(motion)))
    whole[program.hessian_pattern] = program.hessian(at, 1.0, weights)
    whole = np.triu(whole) + np.triu(whole, 1).T

    def slope(unknowns: np.ndarray) -> np.ndarray:
        row, column = program.pattern
        rows = np.bincount(column, program.row_slopes(unknowns) * weights[row], len(motion))
        return np.asarray(program.gradient(unknowns) + rows)

    slopes = (slope(at + step * way) - slope(at - step * way)) / (2 * step)
    np.testing.assert_allclose(whole @ way, slopes, rtol=1e-4, atol=1e-6 * np.abs(slopes).max())


@pytest.mark.parametrize("number", range(3), ids=["spline", "fourier", "ptp"])
def test_the_closest_motion_is_inside_and_closer_than_the_shrunk_one(number: int, hexapod_case: Case):
    run = running(hexapod_case, families(hexapod_case)[number])
    outside = beyond(run)
    assert prove(run.family.once.motion(outside), hexapod_case, QUICK_RATE).worst_ratio > 1.01
    closest = closest_inside(run.program, hexapod_case, run.family, outside, BOUND).unknowns
    assert prove(run.family.once.motion(closest), hexapod_case, QUICK_RATE).worst_ratio <= 1.0
    shrunk, share = run.feasible(outside)
    assert share < 0.99
    program = ClosestProgram.of(run.program, outside)
    assert program.value(closest) < program.value(shrunk)


@pytest.mark.slow
def test_where_shrinking_takes_most_the_closest_motion_keeps_the_information():
    case = narrow_case()
    run = running(case, SplineFamily.of(case, 20, 2.0))
    explored = run_start(run.task)
    raised = explored.begin * 1.01
    shrunk, share = run.feasible(raised)
    closest, kept = run.feasible(closest_inside(run.program, case, run.family, raised, BOUND).unknowns)
    size = run.program.size
    assert share < 0.8
    assert kept > 1.0 - SLIPPED
    assert np.exp((run.rate(closest) - run.rate(raised)) / size) > 0.95
    assert np.exp((run.rate(shrunk) - run.rate(raised)) / size) < 0.8
    assert explored.record.logdet > run.rate(explored.begin) - 0.05 * size


def test_bodies_that_are_nearer_than_rows_see_are_kept_further_apart_alone():
    """The proof measures hulls, rows capsules around them: 3 mm that it alone sees lower the bound of one pair."""
    case = load_case(ROBOTS / "irb120").within_margin()
    run = running(case, SplineFamily.of(case, 20, 2.0))
    program, unknowns = run.program, run.family.start(np.random.default_rng(3), run.program.worst)
    motion = run.family.motion(unknowns)
    report = prove(motion, case, QUICK_RATE)
    named = [kernel for kernel in program.limits if kernel.name]
    assert named
    assert _nearer_than_rows(program, motion, report) == {}
    name = named[0].name
    (check,) = (c for c in report.checks if c.of == Limit.named(name.partition(" (")[0]))
    worse = replace(check, place=name.partition("(")[2].removesuffix(")"), worst=-3.0, ratio=1.01, time=0.7)
    bounds = _nearer_than_rows(program, motion, LimitReport((*report.checks, worse)))
    assert [*bounds] == [name]
    at = motion.at(np.array([0.7]))
    state = np.hstack([at.coordinates, at.rates, at.accelerations, np.zeros((1, 1))])
    assert bounds[name] == pytest.approx(float(named[0].values(state)[0, 0]) * np.exp(-(0.003 + APART) / VICINITY))
    lowered = program.bounded(bounds)
    changed = [
        k for k, (a, b) in enumerate(zip(program.rows, lowered.rows, strict=True)) if not np.all(a.bound == b.bound)
    ]
    assert changed == [len(program.rows) - len(program.limits) + program.limits.index(named[0])]
