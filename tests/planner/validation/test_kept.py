"""What an unfinished validation leaves behind is found again, and only by what it follows from."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NoReturn

import numpy as np
import pytest

from cases.errors import FileProblem
from identification.hexapod import Hexapod
from identification.trajectories.executed import DriveExecution
from planner.interruption import Interrupted
from planner.validation.carrying_out import Settings, _keep, _kept, _key, unfinished
from planner.validation.experiment import Excitation, steps
from planner.validation.remedy import Kept, keep, kept_step, remedy_of
from planner.validation.step import Step
from planner.validation.validate import validate
from postprocessors.execute.executed_run import ExecutedRun
from tests.helpers import Harmonic
from tests.planner.validation.excitations import CASE, FOUND, NO_POSE_ERROR, brisk
from tests.postprocessors.changed_case import changed


class Stopped(Exception):
    """Something that ends a validation."""


@pytest.mark.slow
def test_an_interrupted_validation_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def run_validation(plans: Path | None = None, name: str = "v") -> Any:
        settings, out = Settings("virtual", 1, 0, plans), tmp_path / name
        with unfinished(out, CASE, settings) as work:
            found = validate(CASE, ["Q5N"], [0, 3], settings, folder=work)
            found.save(out)
        return found.to_json()

    kept = tmp_path / "v.unfinished"

    def ends(by: BaseException) -> None:
        def steps(*_: object) -> NoReturn:
            raise by

        monkeypatch.setattr("planner.validation.carrying_out.steps", steps)
        with pytest.raises(type(by)) as raised:
            run_validation()
        assert [p.name for p in tmp_path.iterdir()] == ["v.unfinished"]
        if isinstance(by, Interrupted):
            assert "kept in v.unfinished, the same command goes on" in str(raised.value)

    ends(Interrupted())
    plan = (kept / "plans" / "Q5N" / "plan.json").read_bytes()
    with monkeypatch.context() as patched:
        patched.setattr("planner.validation.carrying_out.poses_planned", None)  # nothing is planned again
        ends(Stopped())
    assert (kept / "plans" / "Q5N" / "plan.json").read_bytes() == plan
    monkeypatch.undo()
    done: list[int] = []

    def one_more(excitation: Excitation, mounted: Sequence[int], *others: object) -> Iterator[Step]:
        done.append(mounted[0])
        yield from steps(excitation, mounted[:1], *others)
        raise Interrupted

    monkeypatch.setattr("planner.validation.carrying_out.steps", one_more)
    for _ in range(2):
        with pytest.raises(Interrupted):
            run_validation()
    assert done == [0, 3]
    monkeypatch.setattr("planner.validation.carrying_out.steps", None)  # nothing is executed or identified again
    monkeypatch.setattr("planner.validation.carrying_out._excitation", None)
    resumed = run_validation()
    assert [p.name for p in tmp_path.iterdir()] == ["v"]
    assert (tmp_path / "v" / "plans" / "Q5N" / "plan.json").read_bytes() == plan
    monkeypatch.undo()
    at_once = run_validation(tmp_path / "v", "w")
    assert resumed["rows"] == at_once["rows"]
    assert resumed["executed"] == at_once["executed"]


def test_a_finished_step_is_found_again_as_it_was(tmp_path: Path):
    (tmp_path / "steps").mkdir()
    heavy = FOUND.model_copy(update={"mode_Hz": 30.0} | NO_POSE_ERROR)
    (step,) = steps(brisk(CASE), (0,), heavy)
    done = Kept("key", "virtual", step, remedy_of(brisk(CASE), step, heavy))
    assert done.remedy is not None
    keep(tmp_path, done)
    assert kept_step(tmp_path, "D", 0, "key") == done
    assert kept_step(tmp_path, "D", 0, "another program's") is None
    assert kept_step(tmp_path, "D", 1, "key") is None
    (file,) = (tmp_path / "steps").iterdir()
    file.write_text(file.read_text(encoding="utf-8").replace('"load"', '"weight"'), encoding="utf-8")
    assert kept_step(tmp_path, "D", 0, "key") is None


def test_what_other_settings_left_behind_is_not_used(tmp_path: Path):
    def left(settings: Settings, make: bool, overwrite: bool = False) -> bool:
        with suppress(Stopped), unfinished(tmp_path / "v", CASE, settings, overwrite) as folder:
            known = (folder / "plans" / "ptp" / "plan.json").is_file()
            if make:
                (folder / "plans" / "ptp").mkdir(exist_ok=True)
                (folder / "plans" / "ptp" / "plan.json").touch()
            raise Stopped
        return known

    assert not left(Settings("virtual", 2, 0), True)
    assert left(Settings("linuxcnc", 2, 0), True)  # plans are the same, whatever executes them
    with pytest.raises(FileProblem, match="--overwrite"):
        left(Settings("virtual", 2, 1), False)
    assert not left(Settings("virtual", 2, 1), False, overwrite=True)
    assert not (tmp_path / "v.unfinished").exists()  # nothing in it is worth keeping
    (tmp_path / "v.unfinished").mkdir()
    (tmp_path / "v.unfinished" / "diary.txt").touch()
    with pytest.raises(FileProblem, match=r"v\.unfinished: is not an unfinished validation .*diary\.txt"):
        left(Settings("virtual", 2, 0), False)


def test_a_run_is_kept_for_exactly_its_program(tmp_path: Path):
    kept = tmp_path / "p.npz"
    assert _kept("key", CASE, True, kept) is None
    t = np.arange(500) * 1e-3
    lengths = Hexapod.of(CASE).strut_lengths(Harmonic(seed=1, duration=0.5).at(t).pose)
    execution = DriveExecution.of_log(Hexapod.of(CASE), 1e-3, lengths)
    run = ExecutedRun("LinuxCNC 2.9", execution, np.array([[0.1, 0.4]]), real=True, remark="late")
    _keep(run, "key", kept)
    again = _kept("key", CASE, True, kept)
    assert again is not None
    assert (again.controller, again.remark, again.real) == ("LinuxCNC 2.9", "late", True)
    np.testing.assert_array_equal(again.trigger, run.trigger)
    for order in (0, 1, 2):
        np.testing.assert_array_equal(again.execution.struts(t, order), execution.struts(t, order))
    assert _kept("another program's", CASE, True, kept) is None


def test_what_a_run_follows_from_changes_its_key():
    keys = set()
    for text, case, on, disturbed in (
        ("G1 X1", CASE, "virtual", FOUND),
        ("G1 X2", CASE, "virtual", FOUND),
        ("G1 X1", CASE, "linuxcnc", FOUND),
        ("G1 X1", CASE, "virtual", None),
        ("G1 X1", changed(CASE, controller__virtual_look_ahead="block_limited"), "virtual", FOUND),
    ):
        program = SimpleNamespace(content=text.encode(), case=case)
        keys.add(_key(program, Settings(on, 1, 0), disturbed))
    assert len(keys) == 5
