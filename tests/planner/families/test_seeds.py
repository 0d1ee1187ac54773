"""What a search finds is decided by its seed alone: nothing is stored that another search has found."""

from functools import cache

import numpy as np
import pytest

from cases.base.units import Array
from cases.schema import Case, load_case
from planner.families.settings import FamilySettings, Fourier, PointToPoint, Spline
from planner.plans.making import search
from planner.request import Request
from planner.search.parallel import Listener, Outcome, Results, Schedule, silent
from planner.search.solving import run_safely

FAMILIES = (Fourier(order=3), PointToPoint(moves=8), Spline(knots=20))
MACHINES = ("hexapod", "five_axis_table")


def stopped_at_once(schedule: Schedule, listener: Listener) -> Outcome:
    """Runs starts that end where the solver begins: what differs between them is where they begin."""
    results = Results(schedule)
    while not results.enough and (task := schedule.task(len(results.in_order), results.in_order)) is not None:
        results.add(len(results.in_order), run_safely(task, lambda objective: True))
    return results.in_order, True


@cache
def motions(machine: str, family: FamilySettings, seed: int) -> tuple[Array, ...]:
    """The motions of all starts of a search, best first, as poses at 50 instants."""
    case: Case = load_case(machine)
    found = search(Request(family, duration=2.0, model=6, starts=1, seed=seed), case, silent, stopped_at_once)
    t = np.linspace(0.0, 2.0, 50)
    return tuple(start.family.motion(start.unknowns).at(t).coordinates for start in found.starts)


@pytest.mark.first(1)
@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_equal_seeds_begin_alike_and_other_seeds_elsewhere(machine: str, family: FamilySettings):
    first, other = motions(machine, family, 1), motions(machine, family, 2)
    motions.cache_clear()
    again = motions(machine, family, 1)
    np.testing.assert_array_equal(first, again)
    assert len(first) == len(other) == 1
    assert np.abs(first[0] - other[0]).max() > 1e-3
