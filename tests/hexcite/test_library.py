"""The library as README shows it, in a notebook or a script without a guard, and values that are saved and loaded."""

import functools
import pkgutil
import re
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from importlib import import_module
from inspect import unwrap
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hexcite as hx
from cases.base.errors import Code, HexciteError
from cases.base.phrases import said
from cases.schema import Case
from identification.limits.limit import Limit, LimitCheck, LimitKind, LimitReport, OwnMove, Status
from planner.families.settings import FAMILIES
from planner.plans.plan import Plan
from planner.plans.prediction import Gain
from planner.request import METHODS, PoseRequest, Request
from planner.search import parallel
from tests.helpers import one_line, tells
from tests.hexcite.command_line import refused

README = Path(__file__).parents[2] / "README.md"
QUICK = ("hx.PointToPoint(moves=40), duration=12.0", "hx.PointToPoint(moves=8), duration=2.0, starts=1")


@pytest.fixture(scope="module")
def lines() -> str:
    """README's section on the library, with a smaller plan."""
    (code,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    assert QUICK[0] in code
    return code.replace(*QUICK)


@pytest.fixture(scope="module")
def folder(lines: str, cache: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What these lines leave in an empty folder, run as a script without a guard of `__main__`."""
    folder = tmp_path_factory.mktemp("library")
    script = tmp_path_factory.mktemp("script") / "twelve_lines.py"
    script.write_text(lines, encoding="utf-8")
    run = subprocess.run([sys.executable, script], cwd=folder, capture_output=True, text=True, timeout=1200)
    assert (run.returncode, run.stderr) == (0, "")
    assert tells(run.stdout, "Plan for hexapod", "2.00 s")  # print(plan), once: workers run no script
    assert run.stdout.count("D-efficiency") == 1
    return folder


@pytest.mark.repeats
def test_twelve_lines_write_what_they_are_told_to_and_nothing_else(folder: Path):
    assert {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()} == {
        "run.mpf", "result/result.json", "result/.hexcite", "result.html", "residuals.pdf"
    }  # fmt: skip


def test_the_door_opens_without_loading_what_is_behind_it():
    code = "import hexcite, sys; print([m for m in ('numpy', 'casadi', 'typer', 'matplotlib') if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert run.stdout.strip() == "[]"


def test_every_name_of_the_door_is_there():
    assert [name for name in dir(hx) if getattr(hx, name) is None] == []
    with pytest.raises(AttributeError, match=r"no plans; .*\bplan\b"):
        _ = hx.plans


@pytest.mark.parametrize("door", ["cases", "identification", "planner", "postprocessors", "postprocessors.export"])
def test_every_package_gives_its_public_names_and_no_module_hides_one(door: str):
    package = import_module(door)
    modules = {module.name for module in pkgutil.iter_modules(package.__path__)}
    assert modules.isdisjoint(dir(package))  # a module that is imported would take the place of the name
    for name in dir(package):
        assert unwrap(getattr(package, name)) is unwrap(getattr(hx, name))  # which checks arguments first
    with pytest.raises(AttributeError, match=f"{door} has no nonsense"):
        _ = package.nonsense


@pytest.fixture(scope="module")
def by_hand(hexapod_case: Case, cache: Path) -> Plan:
    return hx.plan(hexapod_case, hx.Manual())


def test_a_plan_comes_back_as_it_was_saved(by_hand: Plan, tmp_path: Path):
    by_hand.save(tmp_path / "plan")
    again = hx.Plan.load(tmp_path / "plan")
    assert {p.name for p in (tmp_path / "plan").iterdir()} == {"plan.json", "motion.csv", ".hexcite"}
    assert again.to_json() == by_hand.to_json()
    assert (again.request.family, again.worth, again.limits) == (hx.Manual(), by_hand.worth, by_hand.limits)
    t = np.linspace(0.0, by_hand.duration, 50)
    np.testing.assert_allclose(again.motion.at(t).coordinates, by_hand.motion.at(t).coordinates, rtol=0.0, atol=1e-14)
    again.save(tmp_path / "twin")
    assert (tmp_path / "twin" / "plan.json").read_bytes() == (tmp_path / "plan" / "plan.json").read_bytes()


def test_a_program_of_a_plan_says_the_same_before_and_after_it_is_saved(by_hand: Plan, tmp_path: Path):
    """Also where it comes from: the fingerprint of a plan does not depend on whether it was saved."""
    program = hx.write(by_hand, "sinumerik")
    program.save(tmp_path / "run.mpf")
    again = hx.Program.load(tmp_path / "run.mpf", by_hand.case)
    assert again.content == program.content
    assert again.proof.verdict == program.proof.verdict
    by_hand.save(tmp_path / "plan")
    saved = hx.write(hx.Plan.load(tmp_path / "plan"), "sinumerik").text
    assert re.findall("plan hash .*", saved) == re.findall("plan hash .*", program.text) != []


def test_a_program_that_relies_on_nobody_is_refused_with_the_limits_by_name(by_hand: Plan):
    with pytest.raises(HexciteError, match="jerk") as caught:
        hx.write(by_hand, "linuxcnc")
    one_line(caught.value)


@given(
    family=st.one_of(
        st.builds(hx.Fourier, st.integers(2, 7), st.just(3.0), st.booleans()),
        st.builds(hx.PointToPoint, st.none() | st.integers(8, 64)),
        st.builds(hx.Spline, st.none() | st.integers(20, 150)),
        st.builds(hx.Manual, st.none() | st.just("steps.toml")),
    ),
    criterion=st.sampled_from("ADKN"),
    model=st.integers(0, 9),
    payload=st.integers(1, 5),
    fewest=st.none() | st.just(0),
    starts=st.none() | st.integers(1, 9),
    seed=st.integers(0, 99),
)  # fmt: skip
def test_what_was_asked_for_comes_back(family: Any, criterion: str, model: int, payload: int, fewest: int | None,
                                       starts: int | None, seed: int):  # fmt: skip
    request = Request(family, 12.0, criterion, model, payload, fewest, starts, seed)
    about = {"family": request.name, "criterion": criterion, "model": model, "payload": payload}
    said = about | request.to_json() | {"settings": {}, "payload_from": request.payloads[0]}
    assert Request.of_json(said) == request
    assert isinstance(family, FAMILIES[request.name])


@given(
    count=st.none() | st.integers(10, 99),
    method=st.sampled_from([m for m in METHODS if m not in ("all", "given")]),
)
def test_what_was_asked_of_poses_comes_back(count: int | None, method: str):
    request = PoseRequest("N", count, method, 3, 500, 7)
    assert PoseRequest.of_json(request.to_json() | {"criterion": "N", "model": 3}) == request


NUMBERS = st.floats(-1e6, 1e6, allow_nan=False)


LIMITS = st.builds(
    Limit, st.sampled_from(LimitKind), st.just(""), move=st.none() | st.sampled_from(OwnMove)
) | st.builds(
    Limit, st.just(LimitKind.DISTANCE_FROM_BOX), st.sampled_from(("vice", "rack (old), left", "strut length"))
)


@given(
    checks=st.lists(
        st.builds(LimitCheck, LIMITS, st.sampled_from(("", "x", "strut 3", "sensor 2, 5 payloads", "tool (long)")),
                  NUMBERS, NUMBERS, st.just("m/s"), NUMBERS, NUMBERS, st.sampled_from(Status),
                  bounds=st.none() | st.tuples(NUMBERS, NUMBERS)),
        max_size=5, unique_by=lambda check: check.of,
    )
)  # fmt: skip
def test_limits_come_back(checks: list[LimitCheck]):
    checks = [replace(check, binding=check.status not in (Status.STEPS, Status.LEFT_OUT)) for check in checks]
    report = LimitReport(tuple(checks))
    assert LimitReport.of_json(report.to_json()) == report


@given(rows=st.integers(2, 30), seed=st.integers(0, 2**32 - 1), feed=st.booleans(), trigger=st.booleans())
def test_a_recording_comes_back_as_far_as_its_decimals_go(
    rows: int, seed: int, feed: bool, trigger: bool, tmp_path_factory: pytest.TempPathFactory, hexapod_case: Case
):
    """Numbers are rounded once; after that a file is a fixed point."""
    draw, folder = np.random.default_rng(seed), tmp_path_factory.mktemp("recording")
    switched = np.arange(rows) >= draw.integers(1, rows)  # a trigger that never switches marks nothing, and is not read
    recording = hx.Recording(
        "made up", np.arange(rows) * 1e-3, 1.0 + 0.1 * draw.random((rows, 6)), None, draw.normal(size=(rows, 6)),
        switched if trigger else None, override=draw.random(rows) if feed else None, case=hexapod_case,
        record={},
    )  # fmt: skip
    recording.save(folder / "one")
    first = hx.Recording.load(folder / "one")
    first.save(folder / "two")
    second = hx.Recording.load(folder / "two")
    assert (folder / "one" / "recording.csv").read_bytes() == (folder / "two" / "recording.csv").read_bytes()
    for name, unit in (("t", 1e-9), ("drives", 1e-11), ("forces", 1e-6), ("override", 1e-14), ("trigger", 0.0)):
        values = [getattr(r, name) for r in (recording, first, second)]
        assert all(v is None for v in values) or np.max(np.abs(values[1] * 1.0 - values[0] * 1.0)) <= 0.51 * unit
        np.testing.assert_array_equal(values[1], values[2])


@pytest.mark.repeats
def test_a_run_is_the_same_to_identification_saved_or_not(folder: Path, hexapod_case: Case, tmp_path: Path):
    recording = hx.run(folder / "run.mpf", hexapod_case, seed=0)
    recording.save(tmp_path / "run")
    at_once, later = hx.identify(recording), hx.identify(hx.Recording.load(tmp_path / "run"))
    for name, value in at_once.parameters.items():
        assert later[name].value == pytest.approx(value.value, abs=1e-3 * value.std)
        assert later[name].std == pytest.approx(value.std, rel=1e-3)
    saved = hx.Result.load(folder / "result")
    assert saved["m"].value == pytest.approx(at_once["m"].value, abs=1e-3 * saved["m"].std)


@pytest.mark.repeats
def test_a_result_comes_back_as_it_was_saved(folder: Path, tmp_path: Path):
    result = hx.Result.load(folder / "result")
    result.save(tmp_path / "twin")
    assert (tmp_path / "twin/result.json").read_bytes() == (folder / "result/result.json").read_bytes()
    hx.report(result, tmp_path / "page.html")  # without the residuals, which are not saved
    assert "centre of gravity" in (tmp_path / "page.html").read_text(encoding="utf-8")


@pytest.mark.first(1)
@pytest.mark.parametrize("workers", [None, 1, 3])
def test_a_search_has_the_processes_that_it_is_given(
    workers: int | None, hexapod_case: Case, monkeypatch: pytest.MonkeyPatch
):
    given = []

    def pool(most: int, **settings: Any) -> ProcessPoolExecutor:
        given.append(most)
        return ProcessPoolExecutor(1, **settings)

    monkeypatch.setattr(parallel, "ProcessPoolExecutor", pool)
    plan = hx.plan(hexapod_case, hx.Fourier(order=2), 4.0, model=0, starts=1, workers=workers)
    assert given == [workers or parallel.cores()]
    assert plan.of_motion[0] == replace(plan.of_motion[0], workers=7)  # how many there were is no part of a plan


def test_a_search_needs_a_process(hexapod_case: Case):
    for refuse in (hx.ValidationSettings, functools.partial(hx.plan, hexapod_case)):
        with pytest.raises(HexciteError, match="0 workers; choose workers 1 to"):
            refuse(workers=0)
    assert tells(refused("plan", "hexapod", "--workers", 0), "0 workers; ", "--workers 1 to 1000")
    assert tells(refused("validate", "hexapod", "--workers", 0), "0 workers; ", "--workers 1 to 1000")
    by_hand = refused("plan", "hexapod", "--family", "manual", "--workers", 2)
    assert tells(by_hand, "--workers ", "--family manual")


@pytest.mark.repeats
def test_plans_of_one_name_are_told_apart_and_one_plan_is_named_once(by_hand: Plan) -> None:
    """Ratios are by name: that of one would hide that of the other."""
    slower = replace(by_hand, solve_s=by_hand.solve_s + 1.0)
    compared = hx.compare([by_hand, slower])
    names = [entry.name for entry in compared.entries]
    assert names == [by_hand.name, f"{by_hand.name} (2)"]
    assert compared.ratios.keys() == {*names}
    with pytest.raises(HexciteError) as caught:
        hx.compare([by_hand, by_hand])
    assert (caught.value.code, caught.value.place) == (Code.CONTRADICTION, by_hand.name)


def test_a_plan_that_has_lost_what_was_known_says_so_at_another_pace(by_hand: Plan) -> None:
    known = replace(by_hand, gain=Gain(("earlier",), {"m": 0.01}, by_hand.promise))
    retimed = hx.retime(known)
    assert retimed.gain is None
    notes = [each for each in map(said, retimed.of_motion[1].notes) if each.code == "known_not_counted"]
    assert [each.values["named"] for each in notes] == ["earlier"]
    assert "known_not_counted" not in {said(each).code for each in hx.retime(by_hand).of_motion[1].notes}


def test_values_are_shown_in_a_few_lines(folder: Path, by_hand: Plan, hexapod_case: Case):
    result = hx.Result.load(folder / "result")
    program = hx.Program.load(folder / "run.mpf", hexapod_case)
    recording = hx.run(program, hexapod_case)
    with pytest.raises(HexciteError, match=r"case hexapod, .*machine or limits"):
        hx.run(program, hx.load_case("strut_sensors").model_copy(update={"workspace": None}))
    value: Any
    for value in (hexapod_case, by_hand, program, recording, result):
        text = repr(value)
        assert 2 <= len(text.splitlines()) <= 14
        assert max(map(len, text.splitlines())) < 200
        assert "hexapod" in text or value is recording
        assert value._repr_html_().startswith("<pre>")
    over_recording, bound = hx.force(recording, result), hx.bound(hexapod_case)
    (low, high), compared = result["m"].interval(1000), hx.compare([by_hand])
    assert low < result["m"].value < high
    for value in (over_recording, bound, compared, result["m"]):
        assert max(map(len, repr(value).splitlines())) < 250
        assert len(repr(value).splitlines()) <= 14
        assert value._repr_html_().startswith("<pre>")
    assert {"rms", "U", "fz", "mx"} <= set(repr(over_recording).replace("(", " ").split())
    assert f"{bound.logdet:.4f}" in repr(bound)


@pytest.mark.parametrize(
    ("raised", "words"),
    [
        (lambda place: hx.load_case("nowhere"), lambda place: ("case", "check", "nowhere")),
        (lambda place: hx.Plan.load(place), lambda place: ("post", place)),
        (
            lambda place: hx.read(place / "no.csv", hx.load_case("hexapod")),
            lambda place: ("identify", place / "no.csv", "--case", "hexapod"),
        ),
        (
            lambda place: hx.read_program(place / "no.ngc", hx.load_case("hexapod")),
            lambda place: ("check", place / "no.ngc", "--case", "hexapod"),
        ),
    ],
)
def test_the_command_line_prints_what_the_library_raises(raised: Any, words: Any, tmp_path: Path):
    with pytest.raises(HexciteError) as caught:
        raised(tmp_path)
    assert caught.value.remedy
    assert caught.value.place
    assert refused(*words(tmp_path)) == f"hexcite: {one_line(caught.value)}"
