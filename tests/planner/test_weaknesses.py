"""What a plan says of itself first: why another one would carry more information, and what to do."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cases.schema import Case
from identification.limits import LimitCheck, LimitReport, Status
from identification.model import identification_model
from planner.bounds.kept import Bound
from planner.families.family import box_middle
from planner.families.fourier import FourierFamily
from planner.families.ptp import PointToPointFamily
from planner.noise import expected_noise
from planner.plan import FULL, RIVALS, Plan
from planner.request import Request
from planner.search.solving import DRAWN_BACK, Start

SIZE = 20


def check(name: str, ratio: float) -> LimitCheck:
    return LimitCheck(name, ratio, 1.0, "m/s", ratio, 0.5, Status.PROVEN)


@pytest.fixture
def start(hexapod_case: Case) -> Start:
    family = FourierFamily(2, 3.0, 1, *box_middle(hexapod_case))
    unknowns = 0.01 * np.random.default_rng(0).normal(size=18)
    return Start(1, -9.0, -5.0, -5.0, "Solve_Succeeded", True, 9, 1.0, unknowns, family, 1.0, unknowns, -5.0, True)


@pytest.fixture
def plan(hexapod_case: Case, start: Start) -> Plan:
    """A plan with nothing to be said against it."""
    model = identification_model(hexapod_case, 9)
    return Plan(
        case=hexapod_case, case_file="hexapod", request=Request("hexapod"),
        motion=start.family.motion(start.unknowns), family="fourier", settings=start.family.settings,
        starts=(start,), failed=(), interrupted=False, score=-5.0, logdet=-5.0, condition=10.0,
        bound=Bound(logdet=0.0, design_logdet=-0.1, parameters=SIZE, certified=True, **bound_rest()),
        predicted_std={}, worst_payload={}, noise=expected_noise(hexapod_case, model), noise_note=(),
        limits=LimitReport((check("velocity (x)", 0.999), check("strut length (strut 1)", 0.5))),
        solve_seconds=4.0,
    )  # fmt: skip


def bound_rest() -> dict[str, Any]:
    """Fields of a bound that do not matter here."""
    known = {"logdet", "design_logdet", "parameters", "certified"}
    return {name: 0 for name in Bound.__dataclass_fields__ if name not in known}


def rival(start: Start, case: Case, times: float) -> Start:
    family = PointToPointFamily.of(case, 8, 3.0)
    return replace(start, family=family, logdet=start.logdet + SIZE * np.log(times))


def test_a_good_plan_has_none(plan: Plan):
    assert plan.weaknesses == []


@pytest.mark.parametrize(("times", "told"), [(1.5, True), (RIVALS + 0.005, True), (RIVALS - 0.005, False)])
def test_another_family_that_carries_more(times: float, told: bool, plan: Plan, start: Start, hexapod_case: Case):
    weak = replace(plan, rival=rival(start, hexapod_case, times))
    assert len(weak.weaknesses) == told
    if told:
        assert f"--family ptp has {times:.2f} times the D-efficiency" in weak.weaknesses[0]
        assert weak.to_json()["rival"] == {
            "family": "ptp", "d_efficiency": pytest.approx(times * plan.d_efficiency)
        }  # fmt: skip


@pytest.mark.parametrize("interrupted", [False, True])
def test_a_search_that_had_not_converged(interrupted: bool, plan: Plan, start: Start):
    unfinished = replace(start, converged=False, status="Maximum_Iterations_Exceeded")
    weak = replace(plan, starts=(unfinished,), interrupted=interrupted)
    if interrupted:  # it says so itself
        assert weak.weaknesses == []
    else:
        (told,) = weak.weaknesses
        assert "had not converged where it ended (at its iteration limit): more --seconds" in told


def test_only_the_best_refined_start_need_have_converged(plan: Plan, start: Start):
    explored = replace(start, refined=False, converged=False)
    assert replace(plan, starts=(start, explored, replace(start, converged=False))).weaknesses == []
    assert replace(plan, starts=(explored, start)).weaknesses == []


@pytest.mark.parametrize(("share", "told"), [(DRAWN_BACK - 0.01, True), (DRAWN_BACK, False)])
def test_a_motion_that_was_drawn_back(share: float, told: bool, plan: Plan, start: Start):
    weak = replace(plan, starts=(replace(start, shrunk=share),)).weaknesses
    assert len(weak) == told
    assert not told or f"drawn to {100 * share:.0f} % of its ways" in weak[0]


@pytest.mark.parametrize("place", ["strut length (strut 1)", "position (x)", "base joint angle (joint 2)"])
def test_no_limit_of_speed_is_used(place: str, plan: Plan):
    """That poses are at their limits is no excuse."""
    used = LimitReport((check("velocity (x)", FULL - 0.1), check("strut velocity (strut 3)", 0.7), check(place, 0.999)))
    (told,) = replace(plan, limits=used).weaknesses
    assert f"beyond {100 * (FULL - 0.1):.0f} % (velocity (x))" in told
    force = LimitReport((*used.checks, check("sensor force (sensor 1)", 0.95)))
    assert replace(plan, limits=force).weaknesses == []


def test_what_was_made_by_hand_is_not_judged(plan: Plan):
    slow = LimitReport((check("velocity (x)", 0.2),))
    assert replace(plan, starts=(), family="manual", limits=slow).weaknesses == []
