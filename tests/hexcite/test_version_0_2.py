"""Files that version 0.2.0 wrote are read: a case, a plan of standstills, its program, its recording, its result.

They were made by that version's own commands (`poses`, `post`, `run`, `identify`), on a hexapod recorded at 100 Hz.
"""

import shutil
from pathlib import Path

import pytest

from cases.schema import load_case
from identification.results.result import Result
from planner.plans.plan import Plan
from tests.hexcite.command_line import call, refused

WRITTEN = Path(__file__).with_name("version_0_2")


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy to work on, as the working folder."""
    shutil.copytree(WRITTEN, folder := tmp_path / "files")
    monkeypatch.chdir(folder)
    return folder


def test_a_recording_gives_the_result_that_it_gave(files: Path):
    before = Result.load(str(files / "result"))
    answer = call("identify", "recording", "--case", "mill.toml", "-o", "again", "--json").json()
    assert len(answer["parameters"]) == len(before.record.parameters) == 14
    for name, entry in answer["parameters"].items():
        old = before.record.parameters[name]
        assert entry["value"] == pytest.approx(old.value, abs=0.1 * old.std), name


def test_a_plan_is_written_as_a_program_of_today(files: Path):
    plan = Plan.load(files / "poses", load_case("mill.toml"))
    assert len(plan.poses) == 8
    answer = call("post", "poses", "--dialect", "sinumerik", "-o", "again.mpf", "--json").json()
    assert answer["duration_s"] == pytest.approx(9.471, abs=0.01)
    assert call("check", "again.mpf", "--case", "mill.toml", "--json").json()["ok"]


def test_a_program_that_relied_on_what_an_operator_leaves_is_refused_by_the_word_that_it_lacks(files: Path):
    assert "add D0" in refused("check", "poses.mpf", "--case", "mill.toml")


def test_a_result_is_judged_and_used(files: Path):
    assert "rms" in call("force", "recording", "--parameters", "result", "-o", "force.csv", "--json").json()


@pytest.mark.parametrize(
    ("table", "line"), [("sinumerik", 'moves = "poly"'), ("", 'virtual_look_ahead = "block_limited"')]
)
def test_keys_of_earlier_versions_are_read_and_named(table: str, line: str, files: Path):
    head = f"[controller.{table}]".replace(".]", "]")
    text = Path("mill.toml").read_text(encoding="utf-8")
    assert text.count(f"\n{head}\n") == 1
    plain = load_case("mill.toml")
    Path("earlier.toml").write_text(text.replace(f"\n{head}\n", f"\n{head}\n{line}\n"), encoding="utf-8")
    case = load_case("earlier.toml")
    assert case == plain
    assert case.hash == plain.hash
    (doubt,) = (each for each in case.doubts if each not in plain.doubts)
    assert doubt.keys == (f"{head[1:-1]}.{line.split()[0]}",)
    assert "delete the line" in doubt
