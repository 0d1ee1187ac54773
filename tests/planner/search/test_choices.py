"""Free order and period: whole numbers of periods near the frequency at which velocity and acceleration both bind."""

from collections.abc import Sequence
from dataclasses import asdict
from inspect import signature
from typing import get_type_hints

import numpy as np
import pytest

from cases.errors import HexciteError
from cases.schema import Case
from planner.cli.compare import validate
from planner.cli.plan import OPTIONS, SEARCHED, plan, refuse_foreign
from planner.comparison.methods import ValidationSettings
from planner.families import ptp, spline
from planner.families.settings import FAMILIES, Fourier
from planner.planning import search
from planner.precision import SolverStatus
from planner.request import OWNERS, Request
from planner.search import StartRecord
from planner.search.parallel import Listener, Outcome, silent
from planner.search.solving import Start, Step, Task
from tests.helpers import one_line

MOVING = ("fourier", "ptp", "spline")
BELONGS = dict.fromkeys(SEARCHED, MOVING) | {
    "order": ("fourier",), "period": ("fourier",), "centred": ("fourier",), "moves": ("ptp",),
    "controller": ("ptp",), "knots": ("spline",), "sequence": ("manual",),
}  # fmt: skip


def test_every_setting_of_a_family_is_an_option():
    assert set(BELONGS) == {*SEARCHED, *OWNERS}
    assert set(BELONGS) <= set(signature(plan).parameters)


def test_defaults_and_ranges_of_a_command_are_those_of_the_library():
    defaults = {name: parameter.default for name, parameter in signature(plan).parameters.items()}
    usual = Request()
    assert (defaults["duration"], defaults["criterion"]) == (usual.duration, usual.criterion)
    assert (defaults["seed"], defaults["order"]) == (usual.seed, Fourier().order)
    defaults = {name: parameter.default for name, parameter in signature(validate).parameters.items()}
    settings = asdict(ValidationSettings())
    assert {name: defaults[name] for name in settings} == settings
    texts = get_type_hints(plan, include_extras=True)
    for option, kind in (("moves", ptp), ("knots", spline)):
        assert f", {kind.FEWEST} to {kind.MOST};" in texts[option].__metadata__[0].help


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("option", BELONGS)
def test_options_of_another_family_are_refused_and_its_own_are_taken(option: str, family: str):
    if family in BELONGS[option]:
        refuse_foreign([option], family)
        return
    with pytest.raises(HexciteError, match=f"{OPTIONS.get(option, option)} .*family {family}") as told:
        refuse_foreign([option], family)
    assert all(other in one_line(told.value) for other in BELONGS[option])


def _made_up(task: Task) -> Start:
    """What a start would find: the larger its seed, the better; refinements are better still."""
    promise = float(task.seed)
    refined = task.step is Step.REFINE
    score = promise if refined else -100.0  # drawn back, a motion is worth as little as any
    unknowns = np.full(18, 0.01)
    tried = StartRecord(task.seed, refined, 0.0, 0.0, score, SolverStatus.SETTLED, True, 1, 0.0)
    return Start(tried, unknowns, task.family, 1.0, unknowns, promise)


@pytest.mark.parametrize(("criterion", "refinements"), [("D", 1), ("K", 4)])
def test_the_best_starts_are_refined(criterion: str, refinements: int, hexapod_case: Case):
    request = Request(Fourier(order=2), criterion=criterion, duration=3.0, starts=6)
    tried: list[Task] = []

    def run(tasks: Sequence[Task], listener: Listener, until: float) -> Outcome:
        tried.extend(tasks)
        return [_made_up(task) for task in tasks], False

    found = search(request, hexapod_case, silent, run)
    seeds = [task.seed for task in tried if task.step is Step.EXPLORE]
    assert len(set(seeds)) == len(seeds) == request.starts
    best = sorted(seeds, reverse=True)[:refinements]
    assert [task.seed for task in tried if task.step is Step.REFINE] == best
    glances = [task.family.name for task in tried if task.step is Step.GLANCE]
    assert glances == (["ptp"] if criterion == "D" else [])
    assert (found.rival is None) == (criterion != "D")
    assert all(start.family.name == "fourier" for start in found.starts)
    assert found.starts[0].record.seed == best[0]


def test_the_best_of_two_series_is_refined_and_another_family_looked_at_beside_it(hexapod_case: Case):
    """One refinement leaves a core free."""
    rounds: list[list[Step]] = []

    def run(tasks: Sequence[Task], listener: Listener, until: float) -> Outcome:
        rounds.append([task.step for task in tasks])
        return [_made_up(task) for task in tasks], False

    found = search(Request(Fourier(order=2), duration=3.0), hexapod_case, silent, run)
    assert rounds == [[Step.EXPLORE, Step.EXPLORE], [Step.REFINE, Step.GLANCE]]
    assert found.rival is not None
    assert found.rival.family.name == "ptp"
