"""The shortest motion that reaches targets: it does, a little shorter ones do not; what no duration reaches is said."""

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from cases.base.errors import Code, HexciteError, InfeasiblePlan, Interrupted
from cases.schema import load_case
from planner.families.settings import Fourier, Manual
from planner.plans.making import make, require_plannable
from planner.plans.plan import Plan
from planner.plans.prediction import Promise
from planner.request import Request
from planner.search.parallel import run_here, silent
from planner.shortest import CLOSE, shortest
from tests.hexcite.command_line import call

CASE = load_case("hexapod")
SERIES = Fourier(order=2)


def erring(size: float):
    stated = {"pose_error_N": size, "pose_error_length_mm": 30.0}
    return CASE.model_copy(update={"sensors": CASE.sensors.model_copy(update=stated)})


@pytest.fixture(scope="module")
def plan() -> Plan:
    return make(Request(SERIES, 4.0, starts=1), CASE, silent, run_here)


def following_law(plan: Plan, std_of: Callable[[float], float], asked: list[float]) -> Callable[[Request], Plan]:
    """Plans whose deviation of the mass follows a law of the duration; infinity: there is no such motion."""

    def plan_of(request: Request) -> Plan:
        asked.append(request.duration)
        std = std_of(request.duration)
        if std == float("inf"):
            raise InfeasiblePlan(problem="too short", code=Code.TOO_FEW)
        return replace(plan, request=request, promise=Promise({**plan.predicted_std, "m": std}, {}, {}))

    return plan_of


LAWS = {
    "white": (lambda duration: 0.03 * duration**-0.5, 36.0),
    "floor": (lambda duration: (0.004**2 + 9e-5 / duration) ** 0.5, 10.0),
    "steep": (lambda duration: 0.4 * duration**-2.0, 8.944),
    "too short below 7 s": (lambda duration: 0.005 if duration >= 7.0 else float("inf"), 7.0),
}


@pytest.mark.parametrize("law", LAWS)
def test_it_is_the_shortest_but_for_a_few_percent(plan: Plan, law: str):
    std_of, best = LAWS[law]
    asked: list[float] = []
    found = shortest(Request(SERIES, 60.0, target={"m": 0.005}), CASE, following_law(plan, std_of, asked))
    duration = found.request.duration
    assert found.predicted_std["m"] <= 0.005
    assert best - 0.01 <= duration <= best * CLOSE + 0.01
    assert any(
        duration / CLOSE - 0.02 <= other < duration for other in asked
    )  # which was planned, and did not reach it
    assert len(asked) <= 12
    assert re.search(rf"^{duration:g} s .* m 0\.0050 kg", found.of_motion[1].notes[0])


def test_what_no_duration_reaches_is_said_with_the_best(plan: Plan):
    asked: list[float] = []
    law = following_law(plan, lambda duration: (0.006**2 + 9e-5 / duration) ** 0.5, asked)
    with pytest.raises(InfeasiblePlan, match=r"up to 60 s .*m 0\.0050 kg.*60 s.*0\.0061 kg, 1\.22 times.*hardly"):
        shortest(Request(SERIES, 60.0, target={"m": 0.005}), CASE, law)
    assert max(asked) == 60.0
    white = following_law(plan, lambda duration: 0.2 * duration**-0.5, asked)
    with pytest.raises(InfeasiblePlan, match="longer duration"):
        shortest(Request(SERIES, 60.0, target={"m": 0.005}), CASE, white)


def test_every_target_counts(plan: Plan):
    law = following_law(plan, lambda duration: 0.02 * duration**-0.5, [])
    easy, hard = plan.predicted_std["xC"] * 1.01, plan.predicted_std["xC"] * 0.99
    assert shortest(Request(SERIES, 60.0, target={"m": 0.005, "xC": easy}), CASE, law).request.duration >= 16.0
    with pytest.raises(InfeasiblePlan, match=r"xC .* mm"):
        shortest(Request(SERIES, 60.0, target={"m": 0.005, "xC": hard}), CASE, law)


def test_a_stated_period_is_kept(plan: Plan):
    law = following_law(plan, lambda duration: 0.0185 * duration**-0.5, [])
    found = shortest(Request(Fourier(order=2, period=1.5), 60.0, target={"m": 0.005}), CASE, law)
    assert found.request.duration == pytest.approx(15.0)


def test_ctrl_c_keeps_what_reached_the_targets(plan: Plan):
    law = following_law(plan, lambda duration: 0.01 * duration**-0.5, [])
    stopped = shortest(
        Request(SERIES, 60.0, target={"m": 0.005}), CASE, lambda asked: replace(law(asked), interrupted=True)
    )
    assert stopped.interrupted
    assert stopped.request.duration == 12.0
    with pytest.raises(Interrupted):
        shortest(Request(SERIES, 60.0, target={"m": 1e-3}), CASE, lambda own: replace(law(own), interrupted=True))


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        (Request(SERIES, target={"mass": 1.0}), r"mass.*model 9"),
        (Request(SERIES, target={"m": 0.0}), r"target m.*0"),
        (Request(Manual(), target={"m": 1.0}), r"manual"),
    ],
)
def test_targets_that_cannot_be_are_refused(request_: Request, words: str):
    with pytest.raises(HexciteError, match=words):
        require_plannable(request_, CASE)


@pytest.mark.parametrize(
    ("words", "message"),
    [(["m=5"], "unit"), (["m=5mm"], "kg or g"), (["m=5+-1g"], "m=5g"), (["m=5g", "m=6g"], "already")],
)
def test_the_command_line_refuses_them_too(words: list[str], message: str):
    options = [word for text in words for word in ("--target", text)]
    status, _, errors = call("plan", "hexapod", "--family", "fourier", *options)
    assert status == 1
    assert message in errors


def test_the_request_stands_in_the_file(plan: Plan):
    asked = Request(SERIES, 4.0, target={"m": 0.005})
    data: dict[str, Any] = {"criterion": "D", "model": 9, "payload": 0, "payload_from": 0, "family": "fourier"}
    assert Request.of_json(data | asked.to_json()) == asked


@pytest.mark.slow
def test_where_errors_depend_on_the_pose_the_square_root_law_is_false():
    """A series repeats its places: by the law of white noise, a motion from one plan would miss the target."""
    case, target = erring(0.02), 0.0042

    def plan_of(request: Request) -> Plan:
        return make(request, case, silent, run_here)

    asked = Request(Fourier(order=2, period=1.0), 60.0, starts=1, target={"m": target})
    first = plan_of(replace(asked, duration=4.0, target={}))
    by_law = round(4.0 * (first.predicted_std["m"] / target) ** 2)
    missed = plan_of(replace(asked, duration=by_law, target={}))
    found = shortest(asked, case, plan_of)
    assert missed.predicted_std["m"] > target >= found.predicted_std["m"]
    assert found.request.duration > by_law
