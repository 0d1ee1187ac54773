"""What an unfinished validation leaves behind is found again, and only by what it follows from."""

from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

import pytest

from cases.base.errors import Interrupted
from hexcite.comparison.trials import ValidationSettings, unfinished
from hexcite.comparison.validation import validate
from tests.hexcite.comparison.excitations import CASE


class Stopped(Exception):
    """Something that ends a validation."""


@pytest.mark.slow
def test_an_interrupted_validation_uses_the_plans_that_it_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def run_validation() -> Any:
        settings, out = ValidationSettings("virtual", 1, 0), tmp_path / "v"
        with unfinished(out, CASE, settings) as work:
            found = validate(CASE, ["Q5N"], [0, 3], settings, folder=work)
            found.save(out)
        return found.to_json()

    def ends(by: BaseException) -> Path:
        def trials(*_: object) -> NoReturn:
            raise by

        monkeypatch.setattr("hexcite.comparison.validation.trials", trials)
        with pytest.raises(type(by)) as raised:
            run_validation()
        (folder,) = tmp_path.iterdir()
        if isinstance(by, Interrupted):
            assert f"kept in {folder.name}" in str(raised.value)
        return folder

    kept = ends(Interrupted())
    plan = (kept / "plans" / "Q5N" / "plan.json").read_bytes()
    monkeypatch.setattr("hexcite.comparison.trials.poses_planned", None)  # nothing is planned again
    ends(Stopped())
    assert (kept / "plans" / "Q5N" / "plan.json").read_bytes() == plan
    monkeypatch.undo()
    monkeypatch.setattr("hexcite.comparison.trials.poses_planned", None)
    resumed = run_validation()
    assert [p.name for p in tmp_path.iterdir()] == ["v"]
    assert (tmp_path / "v" / "plans" / "Q5N" / "plan.json").read_bytes() == plan
    assert [row["weights"] for row in resumed["rows"]] == [0, 3]


def test_what_other_settings_left_behind_is_not_used(tmp_path: Path):
    def left(settings: ValidationSettings) -> bool:
        with suppress(Stopped), unfinished(tmp_path / "v", CASE, settings) as folder:
            known = (folder / "plans").is_dir()
            (folder / "plans").mkdir(parents=True, exist_ok=True)
            raise Stopped
        return known

    assert not left(ValidationSettings("virtual", 2, 0))
    assert left(ValidationSettings("linuxcnc", 2, 0))  # plans are the same, whatever executes them
    assert not left(ValidationSettings("virtual", 2, 1))
    with unfinished(tmp_path / "v", CASE, ValidationSettings("virtual", 2, 1)):
        pass
    assert len(list(tmp_path.iterdir())) == 1  # of the first; a validation that is written leaves nothing
