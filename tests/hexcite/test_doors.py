"""What a command answers is what the library gives for the same: nothing is computed, joined or edited on the way."""

import doctest
import json
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path
from shutil import copytree
from typing import Any

import numpy as np
import pytest

import hexcite as hx
from cases.base.errors import HexciteError
from cases.schema import Case
from hexcite.studies import conduct
from identification.machines.hexapod import Hexapod
from identification.motion.motion import Standstill
from identification.recording.recording import write_recording
from identification.simulate import simulate_recording
from planner.families.manual import load_poses
from tests.helpers import HOME, SHORT_MOVES, tells
from tests.hexcite.command_line import call, refused
from tests.robots import ur10
from tests.simulated_machine import PoseExecution

ONE_CELL = """
schema_version = 1
name = "moves"
[grid]
family = ["ptp"]
moves = [8]
duration_s = [4.0]
"""


@pytest.fixture(scope="module")
def made(cache: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A program, two runs of it with their results, the second with a weight, a standstill, a robot and a study."""
    folder, case = tmp_path_factory.mktemp("doors"), hx.load_case("hexapod")
    plan = hx.plan(case, hx.Manual(SHORT_MOVES))
    plan.save(folder / "plan")
    program = hx.write(plan, "sinumerik")
    program.save(folder / "run.mpf")
    for name, weights in (("empty", 0), ("loaded", 1)):
        hx.run(program, case, seed=weights, payload=weights).save(folder / name)
        hx.identify(hx.Recording.load(folder / name)).save(folder / f"{name}-result")
    still = PoseExecution(Hexapod.of(case), Standstill(np.asarray(HOME), 1.0))
    write_recording(folder / "still.csv", simulate_recording(case, still, np.zeros((0, 2)), 3, "still.csv"), case)
    (folder / "robot.urdf").write_text(ur10())
    (folder / "moves.toml").write_text(ONE_CELL)
    return folder


def test_a_tare_is_the_same_from_both(made: Path, tmp_path: Path):
    options = ("tare", made / "still.csv", "--parameters", made / "empty-result", "-o", tmp_path / "command")
    answer = call(*options, "--json").json()
    result = hx.Result.load(made / "empty-result")
    tared = hx.tare(hx.Recording.load(made / "still.csv", result.case), result)
    tared.save(tmp_path / "library")
    written = [(tmp_path / name / "result.json").read_bytes() for name in ("command", "library")]
    assert written[0] == written[1]
    assert answer["tared_with"] == str(made / "still.csv")


def test_external_forces_are_the_same_from_both(made: Path, tmp_path: Path):
    call("force", made / "loaded", "--parameters", made / "empty-result", "-o", tmp_path / "command.csv")
    hx.force(hx.Recording.load(made / "loaded"), hx.Result.load(made / "empty-result")).save(tmp_path / "library.csv")
    assert (tmp_path / "command.csv").read_bytes() == (tmp_path / "library.csv").read_bytes()
    with pytest.raises(HexciteError, match="a file stands there"):
        hx.force(hx.Recording.load(made / "loaded"), hx.Result.load(made / "empty-result")).save(
            tmp_path / "library.csv"
        )


def test_a_payload_is_the_same_from_both(made: Path):
    answer = call("payload", made / "empty-result", made / "loaded-result", "--json").json()
    found = hx.payload(*(hx.Result.load(made / f"{name}-result") for name in ("empty", "loaded")))
    assert answer["parameters"] == {name: value._asdict() for name, value in found.parameters.items()}
    assert answer["warnings"] == list(found.warnings)
    assert tells(repr(found), "mass (m)", "kg")
    assert found["m"] == found.parameters["m"]
    with pytest.raises(KeyError, match="k0"):  # as of a result, which names what it lacks
        found["k0"]


def test_a_payload_of_recordings_is_that_of_their_results(made: Path) -> None:
    """A run knows its case; a table takes that of the other run."""
    of_results = call("payload", made / "empty-result", made / "loaded-result", "--json").json()
    table = made / "table.csv"
    table.write_bytes((made / "loaded" / "recording.csv").read_bytes())
    of_runs = call("payload", made / "empty", table, "--json").json()
    empty = hx.Result.load(made / "empty-result")
    of_both = hx.payload(empty, hx.Recording.load(made / "loaded"))
    for name, value in of_results["parameters"].items():
        assert of_runs["parameters"][name] == value, name
        assert of_both[name]._asdict() == value, name
    with pytest.raises(HexciteError, match=r"which machine it is from.*case"):
        hx.payload(*(hx.Recording("made by hand", None, None, None, np.zeros((9, 6)), None) for _ in range(2)))
    reason = refused("payload", made / "empty-result", made / "loaded", "--before", table)
    assert tells(reason, str(table), "empty-result is a result", "alone")


@pytest.mark.repeats
def test_a_second_run_is_predicted_the_same_by_both(made: Path, tmp_path: Path):
    options = ("identify", made / "empty", "--verify", made / "loaded", "-o", tmp_path / "result", "--json")
    result = hx.Result.load(made / "empty-result")
    prediction = hx.verify(hx.Recording.load(made / "loaded"), result)
    answer = call(*options).json()["verify"]
    assert answer.keys() == prediction.to_json().keys()
    assert (answer["recording"], answer["samples"]) == (str(made / "loaded"), prediction.samples)
    np.testing.assert_allclose(answer["force_3s_N"], prediction.force_3s_N, rtol=1e-6)
    assert f"verified on {made / 'loaded'}: residual force" in repr(prediction)


def test_a_program_is_checked_the_same_by_both(made: Path, hexapod_case: Case):
    answer = call("check", made / "run.mpf", "--case", "hexapod", "--json").json()
    checked = hx.check(made / "run.mpf", hexapod_case, accept=())
    assert (answer["ok"], answer["verdict"]) == (checked.proof.ok, checked.proof.verdict)
    assert answer["limits"] == checked.proof.limits.to_json()


@pytest.mark.repeats
def test_limits_are_accepted_one_by_one(hexapod_case: Case):
    plan = hx.plan(hexapod_case, hx.Manual())
    with pytest.raises(HexciteError) as caught:
        hx.write(plan, "linuxcnc", accept="jerk")
    assert "does not enforce strut acceleration" in str(caught.value)
    with pytest.raises(HexciteError, match="'jerk,acceleration' names no such limit"):
        hx.write(plan, "linuxcnc", accept="jerk,acceleration")


def test_a_case_begins_and_is_checked_the_same_by_both(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    call("case", "new", "mill", "-o", "command")
    assert hx.new_case("mill") == Path("mill") / "case.toml"
    assert Path("mill/case.toml").read_bytes() == Path("command/case.toml").read_bytes()
    answer = call("case", "check", "mill", "--json").json()
    checked = hx.check_case("mill")
    assert answer == json.loads(json.dumps({"ok": True, **checked.to_json()}))
    assert "ready for: plan" in repr(checked)
    assert hx.check_case(hx.load_case("mill")).to_json() == checked.to_json()
    assert "exists" in refused("case", "new", "mill")


@pytest.mark.slow
def test_a_study_is_the_same_from_both(tmp_path: Path, hexapod_case: Case, monkeypatch: pytest.MonkeyPatch):
    """Without a cluster: its tasks are answered at once."""

    def answered(client: Any, tasks: Any, limit: float) -> Any:
        row = {"noise_seed": -1, "status": "done", "seconds": 1.0, "iterations": 3, "converged": True}
        for key, job in tasks:
            yield key, [row | {"score": float(job.args[1].family.order), "d_efficiency": 0.5}]

    monkeypatch.setattr(conduct, "local_client", lambda workers, memory: nullcontext())
    monkeypatch.setattr(conduct, "run_tasks", answered)
    spec, counted = tmp_path / "x.toml", []
    spec.write_text('schema_version = 1\nname = "x"\n[grid]\norder = [2, 3]\n')
    first = hx.study(hexapod_case, spec, tmp_path / "s", progress=counted.append)
    assert counted == [f"2 of 2 cells to do, in {tmp_path / 's'}", "1 of 2 cells", "2 of 2 cells"]
    assert (first.computed, first.done, first.failed) == (2, 2, 0)
    answer = call("study", "hexapod", "--spec", spec, "-o", tmp_path / "s", "--json").json()
    again = hx.study(hexapod_case, str(spec), tmp_path / "s").to_json()
    assert answer["best"] == again["best"] == first.to_json()["best"]
    assert {key: answer[key] for key in ("cells", "computed", "done", "failed")} == {
        key: again[key] for key in ("cells", "computed", "done", "failed")
    }
    assert "2 of 2 cells done" in repr(first)


@pytest.mark.repeats
def test_poses_of_ones_own_are_rated_the_same_by_both(tmp_path: Path, hexapod_case: Case):
    file = tmp_path / "three.csv"
    file.write_text("x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\n50,20,930,9,5,-9\n-40,60,880,-8,9,4\n20,-70,950,5,-9,9\n")
    answer = call("poses", "hexapod", "--at", file, "--model", 0, "-o", tmp_path / "plan", "--json").json()
    read, given = (hx.plan_poses(hexapod_case, at, model=0) for at in (file, load_poses(file)))
    for plan in (read, given):
        assert plan.to_json()["predicted_std"] == answer["predicted_std"]
        assert (answer["method"], answer["count"]) == (plan.request.method, len(plan.poses)) == ("given", 3)


@pytest.mark.slow
def test_a_motion_is_retimed(made: Path, hexapod_case: Case, tmp_path: Path):
    plan = hx.plan(hexapod_case, hx.Manual())
    plan.save(tmp_path / "plan")
    assert call("retime", tmp_path / "plan", "-o", tmp_path / "command", "--json").json()["method"] == "ruckig"
    ours, theirs = hx.retime(plan), hx.Plan.load(tmp_path / "command")
    assert ours.predicted_std == pytest.approx(theirs.predicted_std, rel=1e-6)


@pytest.fixture(scope="module")
def copied(made: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same folder, for examples that write into it."""
    return Path(copytree(made, tmp_path_factory.mktemp("examples") / "made"))


def examples(name: str) -> list[doctest.DocTest]:
    """The examples in the docstring of a public name."""
    found = doctest.DocTestFinder(recurse=False).find(getattr(hx, name), name, globs={"hx": hx})
    return [each for each in found if each.examples]


FUNCTIONS_AND_TYPES = [name for name in hx.PUBLIC if name != "__version__"]
LONG = {"demo", "identify_models", "ModelChoice", "study", "validate"}  # examples of several seconds
REPEATED = {"pool", "plan", "retime", "run", "certificate"}  # of a second, whose facts other tests state too
OUTPUT = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name in LONG) + [pytest.mark.repeats] * (name in REPEATED))
        for name in FUNCTIONS_AND_TYPES
    ],
)
def test_examples_of_docstrings_are_true(name: str, copied: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each public name has one, with what it shows."""
    monkeypatch.chdir(copied)
    assert examples(name)
    told: list[str] = []
    for example in examples(name):
        failed, tried = doctest.DocTestRunner(optionflags=OUTPUT).run(example, out=told.append)
        assert tried
        assert not failed, "".join(told)


def test_the_version_is_told_by_both() -> None:
    assert call("--version").out.strip() == f"hexcite {hx.__version__}"
    of_module = subprocess.run(
        [sys.executable, "-m", "hexcite", "--version"], capture_output=True, text=True, check=True
    )
    assert of_module.stdout.strip() == f"hexcite {hx.__version__}"
