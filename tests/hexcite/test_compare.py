"""`hexcite compare`: what belongs together is found by what it is, and the advice follows the figures."""

import json
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser

from cases.schema import Case
from hexcite._write import plan_of_program
from hexcite.comparison.comparison import groups, recommend
from hexcite.comparison.entries import Conditions, Entry, read_entry
from hexcite.reports.compare import std_chart
from identification.estimation.fit import Value
from planner.plans.folder import fingerprint_of
from postprocessors.program import DIALECTS
from tests.helpers import SHORT_MOVES, few, tells
from tests.hexcite.browser import opened
from tests.hexcite.command_line import ACCEPT, call, refused

Chain = dict[str, dict[str, Any]]


def entry(case: Case, name: str, std: float, seconds: float, names: tuple[str, ...] = ("m", "zC")) -> Entry:
    told = {n: Value(1.0, std, std, "kg") for n in names}
    return Entry(
        name, "identified", Conditions(case, recordings=frozenset({name})), 9, "", seconds, 1000, {}, told, 1.0, {}
    )  # fmt: skip


def changed(one: Entry, **changes: Any) -> Entry:
    """An entry of another model or under other conditions."""
    model = changes.pop("model", one.model)
    return replace(one, model=model, conditions=one.conditions._replace(**changes))


def noisier(one: Entry, factor: float) -> Entry:
    return replace(
        one,
        parameters={n: t._replace(std=factor * t.std, std_robust=factor * t.std) for n, t in one.parameters.items()},
    )


def test_the_advice_follows_the_noise_and_not_the_order(hexapod_case: Case):
    a, b = entry(hexapod_case, "a", 0.10, 12.0), entry(hexapod_case, "b", 0.15, 12.0)
    assert recommend([[a], [b]]).best == "a"
    assert recommend([[b], [a]]).best == "a"
    assert recommend([[noisier(a, 2.0)], [b]]).best == "b"
    assert recommend([[b], [noisier(a, 2.0)]]).best == "b"
    assert recommend([[a], [b]]).ratios == pytest.approx({"a": 1.0, "b": 1.5})


def test_of_two_that_are_alike_the_shorter_is_advised(hexapod_case: Case):
    long, short = entry(hexapod_case, "long", 0.100, 40.0), entry(hexapod_case, "short", 0.102, 10.0)
    advice = recommend([[long], [short]])
    assert advice.best == "short"
    assert not any("per second" in s for s in advice.sentences)
    assert "10.0 s against 40.0 s" in advice.sentences[0]


def test_a_long_measurement_may_be_best_and_yet_not_per_second(hexapod_case: Case):
    long, short = entry(hexapod_case, "long", 0.10, 1200.0), entry(hexapod_case, "short", 0.20, 12.0)
    advice = recommend([[long], [short]])
    assert advice.best == "long"
    assert any(tells(sentence, "per second", "short ") for sentence in advice.sentences)


def test_what_one_does_not_determine_is_said_and_not_compared(hexapod_case: Case):
    static = entry(hexapod_case, "static", 0.1, 12.0)
    moving = entry(hexapod_case, "moving", 0.2, 12.0, ("m", "zC", "IC33"))
    advice = recommend([[static], [moving]])
    assert advice.best == "static"
    assert any("static does not determine IC33" in s for s in advice.sentences)


@pytest.fixture(scope="module")
def entries(chain: Chain, shared: Path) -> dict[str, Entry]:
    """A plan, its run, which is identified for that, and the result of the run."""
    return {name: read_entry(shared / name) for name in ("result", "plan", "recording")}


def test_a_chain_is_one_excitation(chain: Chain, entries: dict[str, Entry]):
    """The run is known by the fingerprint of its plan, the result by the hash of its recording."""
    found = groups(list(entries.values()))
    assert [[e.level for e in g] for g in found] == [["planned", "identified", "identified"]]
    plan, result, run = found[0]
    assert result.duration == run.duration == pytest.approx(plan.duration, abs=0.01)
    assert {n: v.value for n, v in run.parameters.items()} == pytest.approx(
        {n: v.value for n, v in result.parameters.items()}
    )
    for name, told in plan.parameters.items():
        assert run.parameters[name].std == pytest.approx(told.std, rel=0.2)
    assert run.notes["executed_s"] == chain["run"]["duration_s"]
    assert (run.conditions.machine, run.conditions.load) == ("a simulated machine", 0.0)


def test_a_run_knows_its_plan_by_hash_wherever_the_folders_are(chain: Chain, shared: Path, tmp_path: Path):
    """Two plans of one path: only one of them is the one that the program was written from."""
    twin = shutil.copytree(shared / "plan", tmp_path / "a-twin")
    text = (twin / "plan.json").read_text()
    (twin / "plan.json").write_text(text + " ")
    moved = [shutil.copytree(shared / n, tmp_path / f"moved-{n}") for n in ("plan", "recording", "result")]
    entries = [read_entry(path) for path in (twin, *moved)]
    plan, run, result = (Path(entry.name).name for entry in entries[1:])
    assert (
        entries[2].conditions.plan
        == entries[1].conditions.plan
        == fingerprint_of((shared / "plan" / "plan.json").read_bytes())
        != entries[0].conditions.plan
    )
    found = [[Path(e.name).name for e in g] for g in groups(entries)]
    assert found == [["a-twin"], [plan, run, result]]
    without_run = [[Path(e.name).name for e in g] for g in groups([entries[0], entries[1], entries[3]])]
    assert without_run == [["a-twin"], [plan, result]]


@pytest.fixture(scope="module")
def by_hand(shared: Path, once: Callable[[str, Callable[[], Any]], Any]) -> Path:
    """A plan of the hand-made motion."""
    plan = ("plan", "hexapod", "--family", "manual", "--sequence", SHORT_MOVES, "-o", shared / "by-hand", "--json")
    return Path(once("by-hand", lambda: call(*plan).json())["plan"])


@pytest.mark.first(1)
@pytest.mark.parametrize("dialect", few("linuxcnc", "setpoints", "sinumerik", "twincat", kept=2))
def test_programs_of_every_dialect_carry_the_plans_hash(dialect: str, chain: Chain, shared: Path, tmp_path: Path):
    file = tmp_path / ("p" + DIALECTS[dialect].suffix)
    call("post", shared / "plan", "--dialect", dialect, "-o", file, *ACCEPT)
    assert plan_of_program(file.read_bytes()) == fingerprint_of((shared / "plan" / "plan.json").read_bytes())


def test_criteria_of_a_plan_are_those_that_it_was_chosen_by(chain: Chain, entries: dict[str, Entry]):
    plan = entries["plan"]
    assert plan.criteria["D"] == pytest.approx(chain["plan"]["logdet"], abs=1e-6)
    assert plan.criteria["condition"] == pytest.approx(chain["plan"]["condition"], rel=1e-6)


def test_another_plan_is_not_taken_for_the_runs_own(entries: dict[str, Entry], by_hand: Path):
    found = groups([read_entry(by_hand), entries["recording"]])
    assert [len(g) for g in found] == [1, 1]


def test_the_command_compares_and_writes_a_page(
    chain: Chain, shared: Path, by_hand: Path, tmp_path: Path, browser: Browser
):
    folders = (by_hand, shared / "plan", shared / "recording", shared / "result")
    answer = call("compare", *folders, "-o", tmp_path / "cmp", "--json").json()
    assert {"rows", "recommendation", "report"} <= set(answer)
    assert len(answer["rows"]) == 3  # the run stands in the column of its result
    assert answer["rows"][-1]["execution"]["executed_s"] > 0.0
    assert answer["recommendation"]["best"] == str(shared / "plan")
    assert answer["recommendation"]["level"] == "planned"
    ratios = answer["recommendation"]["ratios"]
    rows = {r["name"]: r["parameters"] for r in answer["rows"]}
    logs = [np.log(rows[str(folders[0])][n]["std"] / rows[str(folders[1])][n]["std"]) for n in rows[str(folders[1])]]
    assert ratios[str(folders[0])] == pytest.approx(np.exp(np.mean(logs)))
    with opened(browser, Path(answer["report"]), 400) as tab:
        assert (tab.errors, tab.requests) == ([], [])
        assert "times as large" in tab.page.locator(".note").first.inner_text()


def test_every_run_of_a_plan_and_every_result_of_a_run_takes_part(hexapod_case: Case):
    """Two controllers, and two evaluations of one of the runs: nothing is left out for having a sibling."""
    planned = Conditions(hexapod_case, plan="p")
    plan = replace(entry(hexapod_case, "plan", 0.1, 12.0), level="planned", conditions=planned)
    runs = [
        replace(entry(hexapod_case, n, 0.5, 12.0), conditions=planned._replace(recordings=frozenset({n}))) for n in "rs"
    ]
    results = [
        replace(entry(hexapod_case, n, std, 1.0), conditions=Conditions(hexapod_case, recordings=frozenset({of})))
        for n, std, of in (("s1", 0.3, "s"), ("r1", 0.2, "r"), ("r2", 0.1, "r"), ("other", 0.4, "elsewhere"))
    ]
    found, alone = groups([*runs, plan, *results])
    assert [e.name for e in found] == ["plan", "r", "s", "s1", "r1", "r2"]
    assert [e.name for e in alone] == ["other"]
    advice = recommend([found, alone])
    assert (advice.best, advice.level) == ("r2", "identified")
    assert advice.ratios == pytest.approx({"r": 5.0, "s": 5.0, "r2": 1.0, "r1": 2.0, "s1": 3.0, "other": 4.0})


def test_a_run_is_not_compared_with_its_own_result(hexapod_case: Case):
    result = entry(hexapod_case, "result", 0.1, 12.0)
    run = replace(result, name="run", notes={"executed_s": 12.0})
    assert recommend([[run, result]]).best is None
    assert recommend([[run, result], [entry(hexapod_case, "other", 0.2, 12.0)]]).ratios.keys() == {"result", "other"}


def test_a_run_stands_in_the_entry_of_its_result_and_no_warning_stands_twice(hexapod_case: Case):
    result = replace(entry(hexapod_case, "result", 0.1, 12.0), warnings=("contact in rows 3 to 9",))
    run = replace(result, name="run", notes={"executed_s": 12.0})
    advice = recommend([[run, result]])
    assert [(e.name, dict(e.notes)) for e in advice.entries] == [("result", {"executed_s": 12.0})]
    assert advice.warnings == ("result: contact in rows 3 to 9",)
    assert any("run of result" in sentence for sentence in advice.sentences)
    other = replace(entry(hexapod_case, "other", 0.2, 12.0), warnings=("contact in rows 3 to 9",))
    assert recommend([[result], [other]]).warnings == ("result, other: contact in rows 3 to 9",)


def test_deviations_do_not_choose_among_models_of_one_run(hexapod_case: Case):
    """The smaller model has smaller deviations, because it knows less."""
    full = entry(hexapod_case, "full", 0.2, 12.0)
    small = changed(replace(full, name="small", parameters=entry(hexapod_case, "", 0.1, 12.0).parameters), model=2)
    advice = recommend([[full, small]])
    assert (advice.best, advice.ratios) == (None, {})
    assert tells(advice.sentences[0], "full, small", "models of one run", "with all models")
    others = [[entry(hexapod_case, name, std, 12.0)] for name, std in (("a", 0.3), ("b", 0.4))]
    assert recommend([[full, small], *others]).best == "a"


def test_warnings_of_the_best_are_told(hexapod_case: Case):
    a, b = entry(hexapod_case, "a", 0.1, 12.0), entry(hexapod_case, "b", 0.2, 12.0)
    doubtful = replace(a, warnings=("contact in rows 3 to 9",))
    assert not any("warnings" in s for s in recommend([[a], [b]]).sentences)
    advice = recommend([[doubtful], [b]])
    assert advice.best == "a"
    assert tells(advice.sentences[1], "warnings of a ")
    assert advice.warnings == ("a: contact in rows 3 to 9",)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"noise": 1.0}, {"noise": 2.0}),
        ({"load": 0.0}, {"load": 59.79}),
        ({"machine": "a real machine"}, {"machine": "x"}),
    ],
)
def test_nothing_is_recommended_across_machines_loads_or_noise(
    hexapod_case: Case, one: dict[str, Any], other: dict[str, Any]
):
    a, b, c = (entry(hexapod_case, n, std, 12.0) for n, std in (("a", 0.1), ("b", 0.2), ("c", 0.3)))
    alone = recommend([[changed(a, **one)], [changed(b, **other)]])
    assert (alone.best, alone.ratios) == (None, {})
    assert tells(alone.sentences[0], "none is preferred", "a (case hexapod")
    advice = recommend([[changed(a, **one)], [changed(b, **other)], [changed(c, **other)]])
    assert advice.best == "b"
    assert set(advice.ratios) == {"b", "c"}


def test_predictions_at_another_rate_are_not_preferred(hexapod_case: Case):
    """Half as many samples: sqrt 2 that no motion is to blame for."""
    slow = hexapod_case.model_copy(update={"recording": hexapod_case.recording.model_copy(update={"rate_Hz": 500.0})})
    a, b = entry(hexapod_case, "a", 0.1, 12.0), entry(hexapod_case, "b", 0.1 * 2**0.5, 12.0)
    advice = recommend([[changed(a, noise=1.0)], [changed(b, noise=1.0, case=slow)]])
    assert advice.best is None
    assert "1000 Hz" in advice.sentences[0]
    assert "500 Hz" in advice.sentences[0]


def test_models_that_differ_are_told(hexapod_case: Case):
    a, b = entry(hexapod_case, "a", 0.1, 12.0), entry(hexapod_case, "b", 0.2, 12.0)
    assert recommend([[a], [b]]).warnings == ()
    (warning,) = recommend([[changed(a, model=5)], [b]]).warnings
    assert "models differ" in warning


@pytest.mark.slow
def test_a_run_at_poses_is_compared_as_what_it_is(shared: Path, tmp_path: Path):
    """Its plan, the run and its result are of the same standstills, averaged, in a static model."""
    few = ("--count", "6", "--method", "backward")
    call("poses", "hexapod", *few, "-o", tmp_path / "p")
    call("post", tmp_path / "p", "--dialect", "sinumerik", "-o", tmp_path / "p.mpf")
    call("run", tmp_path / "p.mpf", "--case", "hexapod", "-o", tmp_path / "r")
    call("identify", tmp_path / "r", "-o", tmp_path / "i")
    plan, run, result = (read_entry(tmp_path / n) for n in ("p", "r", "i"))
    (group,) = groups([plan, run, result])
    assert [e.model for e in group] == [5, 5, 5]
    assert [e.samples for e in group] == [6, 6, 6]
    assert result.duration == run.duration == pytest.approx(plan.duration, abs=0.1)
    assert set(run.parameters) == set(plan.parameters)


@pytest.mark.slow
def test_a_result_of_ones_own_machine_is_compared_by_its_file(chain: Chain, shared: Path, hexapod_file: Path):
    """From any folder, and no longer once the case has changed."""
    hexapod_file.write_text(hexapod_file.read_text().replace('name = "hexapod"', 'name = "mine"'))
    results = [hexapod_file.parent / f"result-{k}" for k in range(2)]
    for result in results:
        call("identify", shared / "recording" / "recording.csv", "--case", hexapod_file, "-o", result)
    entries = [read_entry(result) for result in results]
    assert [e.conditions.case.name for e in entries] == ["mine", "mine"]
    assert entries[0].duration == pytest.approx(chain["run"]["duration_s"], abs=0.05)
    hexapod_file.write_text(hexapod_file.read_text().replace("range_N = 5000.0", "range_N = 6000.0"))
    assert tells(
        refused("compare", *results, "-o", hexapod_file.parent / "c"), "changed", "sensors.range_N was 5000, is 6000"
    )


def test_what_belongs_together_has_one_colour(entries: dict[str, Entry]):
    found = groups(list(entries.values()))
    other = replace(found[0][0], name="another")
    colours = [points.colour for points in std_chart([*found, [other]]).series]
    assert len(set(colours[:3])) == 1
    assert colours[3] != colours[0]


def test_units_stand_in_the_tables(chain: Chain, shared: Path, tmp_path: Path):
    said = call("compare", shared / "plan", shared / "result", "-o", tmp_path / "c").out
    assert re.search(r"\bm\b.* \[kg\]", said)
    assert re.search(r"\bzC\b.* \[mm\]", said)


def test_what_cannot_be_compared_is_refused(chain: Chain, shared: Path, tmp_path: Path):
    assert "no plan, run or result" in refused("compare", tmp_path, "-o", tmp_path / "c")
    assert "nowhere: does not exist" in refused("compare", tmp_path / "nowhere", "-o", tmp_path / "c")
    assert "is a file" in refused("compare", shared / "excitation.ngc", "-o", tmp_path / "c")
    call("compare", shared / "plan", shared / "result", "-o", tmp_path / "old")
    assert "old: holds no plan, run or result" in refused("compare", tmp_path / "old", "-o", tmp_path / "c")
    nameless = shutil.copytree(shared / "recording", tmp_path / "nameless")
    (nameless / "recording.json").write_text("{}")
    assert tells(refused("compare", nameless, "-o", tmp_path / "c"), "nameless: ", "which machine it is from", "--case")
    (nameless / "recording.json").write_text('{"case_file": "hexapod", "case_hash": "0"}')
    assert "case hexapod has changed since" in refused("compare", nameless, "-o", tmp_path / "c")
    assert "named twice" in refused("compare", shared / "plan", shared / "plan", "-o", tmp_path / "c")
    assert not (tmp_path / "c").exists()


@pytest.mark.parametrize("lost", ["unit", "std", "value"])
def test_a_result_whose_parameter_lacks_an_entry_is_refused(lost: str, chain: Chain, shared: Path, tmp_path: Path):
    shutil.copytree(shared / "result", tmp_path / "result")
    file = tmp_path / "result" / "result.json"
    data = json.loads(file.read_text())
    del data["parameters"]["m"][lost]
    file.write_text(json.dumps(data))
    line = refused("compare", tmp_path / "result", "-o", tmp_path / "comparison")
    assert "result.json" in line
    assert "identify again" in line
    assert not (tmp_path / "comparison").exists()
