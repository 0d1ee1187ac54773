# mypy: disable-error-code="call-arg, dict-item, list-item, operator"
# arguments are wrong on purpose
"""Arguments of a wrong type: every public function names the argument, its value and what it should be."""

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hexcite as hx
from cases.base.doors import door
from cases.base.errors import Code, FileProblem
from cases.schema import Case

RECORDING = hx.Recording("run.csv", None, None, None, np.zeros((3, 6)), None)
WRONG: dict[str, tuple[Callable[[Case], Any], tuple[str, ...]]] = {
    "retime": (lambda case: hx.retime("folder"), ("plan = 'folder'", "is not Plan", "hx.Plan.load")),
    "report": (lambda case: hx.report(3, "x.html"), ("value = 3", "Result")),
    "report a case": (lambda case: hx.report(case, "x.html"), ("value = a Case", "is not Plan")),
    "force": (lambda case: hx.force(3, 3), ("recording = 3", "Recording", "hx.read")),
    "tare": (lambda case: hx.tare("run.csv", 3), ("recording = 'run.csv'", "Recording")),
    "plan": (lambda case: hx.plan("hexapod"), ("case = 'hexapod'", "is not Case", "hx.load_case")),
    "plan a family": (lambda case: hx.plan(case, "ptp"), ("family = 'ptp'", "hx.PointToPoint")),
    "plan for long": (lambda case: hx.plan(case, duration="3"), ("duration = '3'", "float")),
    "plan by starts": (lambda case: hx.plan(case, starts=1.5), ("starts = 1.5", "int | None")),
    "compare nothing": (lambda case: hx.compare([]), ("compare", "name plans, runs or results")),
    "plan_poses": (lambda case: hx.plan_poses(case, count="9"), ("count = '9'", "int | None")),
    "plan_poses elsewhere": (
        lambda case: hx.plan_poses(case, np.zeros((3, 5))),
        ("at", "5 coordinates", "hexapod has 6"),
    ),
    "plan_poses one by one": (lambda case: hx.plan_poses(case, np.zeros(5)), ("at", "5 coordinates")),
    "plan_poses of nothing": (
        lambda case: hx.plan_poses(case, np.array([[0.0] * 6, [np.nan] * 6])),
        ("at", "pose 2", "not a number"),
    ),
    "plan_poses listed": (lambda case: hx.plan_poses(case, [[0.0, 0.0], [0.0]]), ("at", "rows of 6")),
    "identifiability of nothing": (
        lambda case: hx.identifiability(np.full((9, 6), np.nan), case=case),
        ("identifiability", "pose 1", "not a number"),
    ),
    "history of nothing": (lambda case: hx.history([]), ("history", "nothing is named")),
    "bound": (lambda case: hx.bound("hexapod"), ("case = 'hexapod'", "is not Case")),
    "write": (lambda case: hx.write("plan"), ("plan = 'plan'", "is not Plan")),
    "run": (lambda case: hx.run(3, case), ("program = 3", "Program | Path")),
    "identify": (lambda case: hx.identify("run.csv"), ("recording = 'run.csv'", "Recording")),
    "identify by a method": (lambda case: hx.identify(RECORDING, how="robust"), ("how = 'robust'", "Method")),
    "identify_models": (lambda case: hx.identify_models("run.csv"), ("recording = 'run.csv'", "Recording")),
    "identifiability": (lambda case: hx.identifiability("plan", 9), ("thing = 'plan'", "Plan")),
    "identify treated": (
        lambda case: hx.identify(RECORDING, treatment="fourier"),
        ("treatment = 'fourier'", "Treatment"),
    ),
    "compare": (lambda case: hx.compare("plan"), ("things = 'plan'", "Plan")),
    "compare numbers": (lambda case: hx.compare([3]), ("things = [3]", "Plan")),
    "validate": (lambda case: hx.validate("hexapod"), ("case = 'hexapod'", "is not Case")),
    "demo": (lambda case: hx.demo("hexapod", "x"), ("case = 'hexapod'", "is not Case")),
    "preview": (lambda case: hx.preview("result", "c"), ("result = 'result'", "Result")),
    "accept": (lambda case: hx.accept("result"), ("result = 'result'", "Result")),
    "history": (lambda case: hx.history("results", case=3), ("case = 3", "str | None")),
    "pool": (lambda case: hx.pool([3]), ("results = [3]", "Result")),
    "validate_results": (lambda case: hx.validate_results([3]), ("results = [3]", "Result")),
    "certificate": (lambda case: hx.certificate("result", "c.pdf"), ("result = 'result'", "Result")),
    "verify_certificate": (lambda case: hx.verify_certificate(3), ("file = 3", "Path")),
    "export": (lambda case: hx.export("result", "c"), ("result = 'result'", "Result")),
    "read": (lambda case: hx.read(3, case), ("paths = 3", "Path")),
    "look": (lambda case: hx.look(3), ("files = 3", "Path")),
    "plot": (lambda case: hx.plot(3), ("value = 3", "Recording")),
    "read_program": (lambda case: hx.read_program(3, case), ("file = 3", "Path")),
    "load_case": (lambda case: hx.load_case(3), ("name = 3", "str")),
    "payload": (lambda case: hx.payload("empty", "loaded"), ("before = 'empty'", "Result", "hx.Result.load")),
    "verify": (lambda case: hx.verify("run", 3), ("recording = 'run'", "Recording")),
    "check": (lambda case: hx.check(3, case), ("program = 3", "Path")),
    "check_case": (lambda case: hx.check_case(3), ("case = 3", "Path")),
    "new_case": (lambda case: hx.new_case(3), ("name = 3", "str")),
    "new_arm": (lambda case: hx.new_arm("arm", 3), ("urdf = 3", "Path")),
    "study": (lambda case: hx.study("hexapod", "paper"), ("case = 'hexapod'", "is not Case")),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_type_is_refused_by_name(name: str, hexapod_case: Case):
    call, words = WRONG[name]
    with pytest.raises(hx.HexciteError) as caught:
        call(hexapod_case)
    for word in (name.split()[0], *words):
        assert word in str(caught.value)


FAMILIES: dict[str, Callable[[], Any]] = {
    "PointToPoint: moves = 40.5: is not int . None": lambda: hx.PointToPoint(moves=40.5),
    "Spline: knots = 'a': is not int . None": lambda: hx.Spline(knots="a"),
    "Fourier: order = 2.5: is not int": lambda: hx.Fourier(2.5),
    "Manual: sequence = 3: is not Path . str . None": lambda: hx.Manual(3),
    "Spline: moves: is not an argument; choose from knots": lambda: hx.Spline(moves=40),
}


@pytest.mark.parametrize("words", FAMILIES)
def test_settings_of_families_are_refused_likewise(words: str) -> None:
    with pytest.raises(hx.HexciteError, match=words):
        FAMILIES[words]()


def test_an_unknown_argument_is_named_with_those_that_there_are(hexapod_case: Case) -> None:
    with pytest.raises(hx.HexciteError, match=r"plan: start: .*choose from case, .*, starts, "):
        hx.plan(hexapod_case, start=1)
    with pytest.raises(hx.HexciteError, match=r"things = a list: is not .*Plan"):
        hx.compare([hexapod_case, "result"])


def test_a_target_as_a_text_is_refused(hexapod_case: Case) -> None:
    with pytest.raises(hx.HexciteError, match=r"target m: '5g' is not .*above 0") as caught:
        hx.plan(hexapod_case, target={"m": "5g"})
    assert caught.value.code == Code.OUT_OF_RANGE


def test_every_public_function_is_here():
    functions = {name for name in dir(hx) if callable(f := getattr(hx, name)) and not isinstance(f, type)}
    assert functions == {name.split()[0] for name in WRONG}


def taken(count: int, length: float, file: Path, names: tuple[str, ...] = ()) -> tuple[Any, ...]:
    return count, length, file, names


def test_what_does_as_well_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "a_module.py").write_text(f"from {__name__} import taken as taken\n")
    monkeypatch.syspath_prepend(tmp_path)
    get, names = door("a_package", {"taken": "a_module"}, checked=True)
    assert names() == ["taken"]
    assert get("taken")(np.int64(3), 2, "x", ["a"]) == (3, 2, "x", ["a"])
    assert get("taken")(3, np.float32(2.0), Path("x"), names=("a",))[1] == 2.0
    with pytest.raises(hx.HexciteError, match="names = 'a'"):
        get("taken")(3, 2.0, "x", "a")


def test_a_function_of_the_library_finds_its_way_to_another_process():
    assert pickle.loads(pickle.dumps(hx.load_case)) is hx.load_case


def test_a_program_is_not_named_as_one_of_another_controller(hexapod_case: Case) -> None:
    """By its suffix a control loads it, and check reads it."""
    plan = hx.plan_poses(hexapod_case, count=8, candidates=64, model=0)
    with pytest.raises(
        FileProblem, match=r"run.ngc: ends in '.ngc'.*sinumerik; name a file that ends in .mpf"
    ) as caught:
        hx.write(plan, "sinumerik", file="run.ngc")
    assert caught.value.code == Code.WRONG_KIND
    assert hx.write(plan, "sinumerik", file="run.MPF").proof.ok
