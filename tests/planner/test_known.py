"""What earlier results say, before a run is planned: as pooling them with that run will say it."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import hexcite as hx
from cases.base.errors import Code, FileProblem, HexciteError, InfeasiblePlan
from cases.schema import Case
from hexcite._run import execute
from hexcite._write import write
from identification.results.result import Result
from planner.families.settings import Best, PointToPoint
from planner.known import Known
from planner.plans.plan import Plan
from planner.plans.prediction import Gain, Promise
from planner.request import Request
from planner.shortest import CLOSE, require_more, shortest
from tests.helpers import tells
from tests.hexcite.command_line import call, refused
from tests.planner.plans.test_prediction import planned as plan_for
from tests.planner.plans.test_prediction import prediction, tolerant

NAME = "five_axis_table"


@cache
def result_of(seed: int) -> Result:
    plan = plan_for(NAME)
    return hx.identify(execute(write(plan, "setpoints"), plan.case, "virtual", seed)[1], plan.case, plan.model)


def known_by(*seeds: int) -> Known:
    return Known.of([result_of(seed) for seed in seeds], plan_for(NAME).case, 0, standing=False)


def with_tolerances(**tolerances: float) -> Case:
    return tolerant(NAME, **tolerances)


@pytest.mark.repeats
def test_what_is_predicted_with_it_is_what_pooling_the_run_gives():
    gain = Gain.of(prediction(NAME, result_of(3).values), known_by(3))
    pooled = hx.pool([result_of(3), result_of(4)])
    for name, std in gain.after.std.items():
        assert gain.before[name] == pytest.approx(result_of(3)[name].reported, rel=0.05)
        assert std == pytest.approx(pooled[name].reported, rel=0.2), name
    for name in ("m", "xC", "IC12"):
        assert gain.after.std[name] < gain.before[name]
        assert gain.after.std[name] == pytest.approx(pooled[name].reported, rel=0.05)


def test_tolerances_that_results_have_in_common_with_the_run_are_counted_once():
    """What is left of the mass is the gain; of parameters that only noise widens two runs leave the root of a half."""
    run = prediction(NAME, result_of(3).values)
    gain = Gain.of(run, known_by(3))
    assert gain.after.budget["m"]["gains"] == pytest.approx(run.budget["m"]["gains"], rel=0.05)
    assert gain.after.std["m"] > 0.95 * run.std["m"]
    ratio = gain.after.budget["IC12"]["noise"] / run.budget["IC12"]["noise"]
    assert ratio == pytest.approx(np.sqrt(0.5), rel=0.1)
    assert "m" not in gain.loose
    assert "IC12" in gain.loose


def test_a_plan_tells_that_results_do_not_agree():
    known = replace(known_by(3), warnings=("2 runs scatter 5 times as their deviations promise",))
    gain = Gain.of(prediction(NAME, result_of(3).values), known)
    assert any(tells(words, "scatter 5 times") for words in gain.words)
    assert gain.to_json()["warnings"] == known.warnings


def test_targets_hold_for_results_and_run_together():
    plan = plan_for(NAME)
    asked: list[float] = []

    def plan_of(request: Request) -> Plan:
        """By noise alone 10 g after 1 s; what is known says 10 g."""
        asked.append(request.duration)
        own = 0.01 * request.duration**-0.5
        after = (own**-2 + 0.01**-2) ** -0.5
        gain = None if request.known is None else Gain(("earlier",), {"m": 0.01}, Promise({"m": after}, {}, {}))
        return replace(plan, request=request, promise=Promise({"m": own}, {}, {}), gain=gain)

    request = Request(PointToPoint(moves=12), 60.0, model=plan.model, target={"m": 0.005})
    alone, together = (shortest(replace(request, known=known), plan.case, plan_of) for known in (None, known_by(3)))
    assert alone.request.duration == pytest.approx(4.0, rel=0.06)
    assert together.request.duration == pytest.approx(3.0, rel=0.06)


@pytest.mark.parametrize("target", [0.0099, 0.009, 0.005])
def test_few_durations_are_tried_and_none_in_which_no_motion_can_be_made(target: float):
    """Deviations are those of noise beside what is known; below 2 s there is no motion, though it would be enough."""
    plan, family = plan_for(NAME), PointToPoint(moves=12)
    asked: list[float] = []

    def plan_of(request: Request) -> Plan:
        asked.append(request.duration)
        if request.duration < 2.0:
            raise InfeasiblePlan(problem="no motion", code=Code.INFEASIBLE)
        own = 0.02 * request.duration**-0.5
        after = (own**-2 + 0.01**-2) ** -0.5
        gain = Gain(("earlier",), {"m": 0.01}, Promise({"m": after}, {}, {}))
        return replace(plan, request=request, promise=Promise({"m": own}, {}, {}), gain=gain)

    request = Request(family, 60.0, model=plan.model, target={"m": target}, known=known_by(3))
    found = shortest(request, plan.case, plan_of)
    enough = (target**-2 - 0.01**-2) * 0.02**2
    assert len(asked) <= 8
    assert min(asked) >= family.least(plan.case) - 1e-9
    assert max(enough, 2.0) - 0.01 <= found.request.duration <= max(enough, 2.0) * CLOSE + 0.01


def test_the_law_of_what_is_known_finds_the_duration_from_one_plan():
    """Where only noise counts the second duration is the one that is enough; a power of deviations misses it."""
    plan = plan_for(NAME)
    asked: list[float] = []

    def plan_of(request: Request) -> Plan:
        asked.append(request.duration)
        own, gains = 0.02 * request.duration**-0.5, 0.002
        noise = (own**-2 + 0.01**-2) ** -0.5
        std = {"m": np.hypot(noise, gains)}
        after = Promise(std, {"m": {"noise": noise, "gains": gains}}, {"m": gains})
        gain = Gain(("earlier",), {"m": np.hypot(0.01, gains)}, after)
        return replace(plan, request=request, gain=gain)

    target = float(np.hypot((8.0 / 0.02**2 + 0.01**-2) ** -0.5, 0.002))
    shortest(Request(PointToPoint(moves=12), 60.0, model=plan.model, target={"m": target}, known=known_by(3)),
             plan.case, plan_of)  # fmt: skip
    assert asked[1] == pytest.approx(8.0, abs=0.02)


def test_no_duration_has_a_motion_below_the_least_of_its_family():
    case = plan_for(NAME).case
    for family in (PointToPoint(moves=12), PointToPoint(), Best()):
        least = family.least(case)
        family.require_plannable(case, least)
        with pytest.raises(HexciteError, match="too short"):
            family.require_plannable(case, 0.9 * least)


def test_what_is_reached_needs_no_motion():
    request = Request(PointToPoint(moves=8), 3.0, model=plan_for(NAME).model, target={"m": 1.0}, known=known_by(3))
    with pytest.raises(HexciteError, match="no motion is needed"):
        require_more(request, plan_for(NAME).case)


@pytest.mark.repeats
def test_a_plan_says_what_is_known_and_what_stays_loose(tmp_path: Path, cache: Path):
    result, case = result_of(3), plan_for(NAME).case
    plan = hx.plan(case, PointToPoint(moves=8), 3.0, starts=1, workers=1, known=[result])
    assert plan.gain is not None
    assert "with this run" in str(plan)
    assert any("still loose" in remark for remark in plan.remarks)
    plan.save(tmp_path / "plan")
    again = Plan.load(tmp_path / "plan", case)
    assert again.gain == plan.gain
    assert again.std_after == plan.std_after
    hx.report(again, tmp_path / "page.html")
    assert "with this run" in (tmp_path / "page.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"case": "other"}, "is of case other"),
        ({"dropped": ("k0",)}, "was identified with k0 known"),
        ({"known": {"m": 1.0}}, "was identified with m known"),
        ({"delay_s": None}, "is of standstills, a motion is planned"),
        ({"run": {"payload": {"mass_kg": 5.0}}}, "a payload of 5 kg was mounted, 0 kg is planned for"),
        ({"model": 5}, "model 5"),
    ],
)
def test_what_does_not_hold_for_the_run_is_refused_with_what_differs(change: dict[str, object], said: str):
    result = result_of(3)
    other = replace(result, record=result.record.replaced(**change))
    with pytest.raises(HexciteError) as refusal:
        hx.plan(plan_for(NAME).case, PointToPoint(moves=8), 3.0, known=[other], model=plan_for(NAME).model)
    assert tells(str(refusal.value), said)


def test_another_case_is_refused_with_the_value_that_differs():
    with pytest.raises(FileProblem) as refusal:
        Known.of([result_of(3)], with_tolerances(gain_percent=1.0), 0, standing=False)
    assert tells(str(refusal.value), "tolerances.")


def test_runs_that_count_twice_are_refused():
    fields = {"inputs": ({"file": "a.csv", "sha256": "0" * 64},)}
    one, two = (replace(result_of(n), record=result_of(n).record.replaced(**fields)) for n in (3, 4))
    with pytest.raises(FileProblem, match="same recording"):
        Known.of([one, two], plan_for(NAME).case, 0, standing=False)


def test_payloads_are_one_number_where_something_is_known():
    with pytest.raises(HexciteError, match="of one load"):
        Request(PointToPoint(moves=8), model=plan_for(NAME).model, payload=2, payload_from=0, known=known_by(3))


@pytest.mark.repeats
def test_the_command_takes_folders(tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    call("run", _manual(tmp_path), "--case", "hexapod", "--on", "virtual", "-o", "run", "--json").json()
    call("identify", "run", "-o", "result", "--json").json()
    answer = call("plan", "hexapod", "--family", "manual", "--known", "result", "-o", "again", "--json").json()
    assert answer["known"]["results"] == ["result"]
    assert answer["known"]["after"]["std"]["m"] == pytest.approx(answer["predicted_std"]["m"] / np.sqrt(2.0), rel=0.2)
    assert "cannot be read" in refused("plan", "hexapod", "--known", "nothing", "-o", "p")


def _manual(folder: Path) -> Path:
    call("plan", "hexapod", "--family", "manual", "-o", folder / "manual", "--json").json()
    call("post", folder / "manual", "--dialect", "setpoints", "-o", folder / "manual.csv", "--json").json()
    return folder / "manual.csv"
