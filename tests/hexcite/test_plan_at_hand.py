"""`hexcite identify` finds the plan of a run beside it, and says what the run did otherwise."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from tests.helpers import tells
from tests.hexcite.command_line import ACCEPT, call


@pytest.fixture(scope="module")
def slow(shared: Path, planned: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a plan and the run of a program that was written at half its speed."""
    folder = tmp_path_factory.mktemp("slow")
    shutil.copytree(shared / "plan", folder / "plan")
    program = folder / "p.ngc"
    call("post", folder / "plan", *ACCEPT, "--speed", 0.5, "-o", program, "--json").json()
    call("run", program, "--case", "hexapod", "--on", "virtual", "-o", folder / "run", "--json").json()
    return folder


def test_a_run_as_planned_says_so_in_figures_alone(chain: dict[str, dict[str, Any]]) -> None:
    answer = chain["identify"]
    assert answer["as_planned"]["plan"] == "plan"
    assert answer["as_planned"]["share_of_path"] > 0.98
    assert answer["as_planned"]["times_longer"] == pytest.approx(1.0, abs=0.02)
    assert not any("plan" in sentence for sentence in (*answer["warnings"], *answer["notes"]))


@pytest.mark.repeats
def test_the_plan_that_a_run_names_is_found_beside_it(slow: Path, tmp_path: Path) -> None:
    answer = call("identify", slow / "run", "-o", tmp_path / "r", "--json").json()
    (said,) = (warning for warning in answer["warnings"] if "plan" in warning)
    assert tells(said, "plan plan", "2.00 times slower than planned", "override 50 %")
    assert json.loads((tmp_path / "r" / "result.json").read_text())["as_planned"] == answer["as_planned"]
    assert "2.00 times slower than planned" in (tmp_path / "r" / "report.html").read_text()


@pytest.mark.slow
def test_without_a_plan_nothing_is_said(slow: Path, tmp_path: Path) -> None:
    alone = tmp_path / "alone"
    shutil.copytree(slow / "run", alone)
    record = json.loads((alone / "recording.json").read_text())
    del record["content"]
    (alone / "recording.json").write_text(json.dumps(record | {"program": str(tmp_path / "nowhere" / "p.ngc")}))
    answer = call("identify", alone, "-o", tmp_path / "r", "--json").json()
    assert "as_planned" not in answer


@pytest.mark.slow
def test_a_file_is_compared_with_the_plan_that_is_named_or_lies_beside_it(slow: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    shutil.copy(slow / "run" / "recording.csv", file)
    named = call("identify", file, "--plan", slow / "plan", "-o", tmp_path / "r", "--json").json()  # it knows the case
    assert any("2.00 times slower" in warning for warning in named["warnings"])
    shutil.copytree(slow / "plan", tmp_path / "mine")
    beside = call("identify", file, "--case", "hexapod", "-o", tmp_path / "s", "--json").json()
    assert beside["as_planned"]["plan"] == "mine"
    assert beside["as_planned"]["times_longer"] == named["as_planned"]["times_longer"]
