"""Commands find the case that a result or plan names, also in another folder; --case names another."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from cases.base.errors import Code
from cases.tables import built_in_cases
from tests.helpers import tells
from tests.hexcite.command_line import call, refused


@pytest.fixture(scope="module")
def made(chain: dict[str, Any], shared: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a machine of one's own and a result that names its file."""
    folder = tmp_path_factory.mktemp("mine")
    text = built_in_cases()["hexapod"].read_text(encoding="utf-8").replace('name = "hexapod"', 'name = "mine"')
    (folder / "machine.toml").write_text(text, encoding="utf-8")
    run = shared / "recording" / "recording.csv"
    call("identify", run, "--case", folder / "machine.toml", "-o", folder / "result")
    return folder


@pytest.fixture
def mine(made: Path, tmp_path: Path, hexapod_file: Path) -> Path:
    """A copy of the result, which names the copy of the machine."""
    hexapod_file.write_text((made / "machine.toml").read_text(encoding="utf-8"), encoding="utf-8")
    result = Path(shutil.copytree(made / "result", tmp_path / "result")) / "result.json"
    result.write_text(result.read_text().replace(str(made / "machine.toml"), str(hexapod_file)), encoding="utf-8")
    return result.parent


def test_results_know_their_case(mine: Path, shared: Path, tmp_path: Path, hexapod_file: Path) -> None:
    bare = shared / "recording" / "recording.csv"
    wrench = call("force", bare, "--parameters", mine, "-o", tmp_path / "f.csv", "--json").json()
    assert wrench["samples"] > 100
    assert call("export", mine, "--to", "json", "--force", "-o", tmp_path / "m.json", "--json").json()["case"] == "mine"
    again = Path(shutil.copytree(mine, tmp_path / "again"))
    data = json.loads((again / "result.json").read_text())
    del data["content"]  # as version 0.2 wrote it, which had no fingerprint of what it says
    (again / "result.json").write_text(json.dumps(data | {"inputs": []}))
    assert "not by a payload" in refused("payload", mine, again)  # found, read and compared
    assert "case mine, not hexapod" in refused("export", mine, "--to", "c", "--case", "hexapod")


def test_a_case_that_changed_is_refused_by_key_and_stale_stays_written(
    mine: Path, shared: Path, tmp_path: Path, hexapod_file: Path
) -> None:
    text = hexapod_file.read_text()
    hexapod_file.write_text(text.replace("title = ", 'title = "new" # '), encoding="utf-8")
    call("export", mine, "--to", "json", "--force", "-o", tmp_path / "a.json", "--json").json()
    hexapod_file.write_text(text.replace("range_N = 5000.0", "range_N = 6000.0"), encoding="utf-8")
    bare = shared / "recording" / "recording.csv"
    for words in (
        ("export", mine, "--to", "json", "--force", "-o", tmp_path / "b.json"),
        ("force", bare, "--parameters", mine, "-o", tmp_path / "g.csv"),
        ("compare", mine, "-o", tmp_path / "c"),
    ):
        line = refused(*words)
        assert "sensors.range_N was 5000, is 6000" in line
        assert "--stale" in line
        answer = call(*words, "--stale", "--json").json()
        assert "sensors.range_N was 5000, is 6000" in json.dumps(answer)
    for name in ("b.json", "g.csv"):
        assert "sensors.range_N was 5000, is 6000" in (tmp_path / name).read_text()


def test_a_command_of_the_page_offers_nothing_at_ones_own_risk(mine: Path, hexapod_file: Path) -> None:
    """Which takes an option that the page does not have; the other ways stay, for people and for programs."""
    hexapod_file.write_text(hexapod_file.read_text().replace("range_N = 5000.0", "range_N = 6000.0"), encoding="utf-8")
    words = ["export", str(mine), "--to", "json", "--force", "--json"]
    guest = [sys.executable, "-m", "hexcite.cli.guest", str(os.getpid()), *words]
    ended = subprocess.run(guest, capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    error = json.loads(ended.stdout)["error"]
    assert error["code"] == Code.STALE
    for told in (ended.stderr, json.dumps(error)):
        assert "restore" in told
        assert "--stale" not in told
    assert "--stale" in refused(*words)


@pytest.fixture
def standing(shared: Path, tmp_path: Path) -> Path:
    """The rest before a run, as a recording of its own."""
    lines = (shared / "recording" / "recording.csv").read_text().splitlines()[:180]
    file = tmp_path / "standing.csv"
    file.write_text("".join(line.rsplit(",", 1)[0] + "\n" for line in lines))
    return file


def test_a_tare_finds_the_case_of_its_result(mine: Path, standing: Path, tmp_path: Path, hexapod_file: Path) -> None:
    tared = call("tare", standing, "--parameters", mine, "-o", tmp_path / "tared", "--json").json()
    assert tared["case"] == "mine"
    before = json.loads((mine / "result.json").read_text())["parameters"]
    for k in range(1, 7):
        name = f"f_q0_{k}"
        assert abs(tared["parameters"][name]["value"] - before[name]["value"]) < 2.0
    assert tared["parameters"]["m"] == before["m"]
    hexapod_file.write_text(hexapod_file.read_text().replace("range_N = 5000.0", "range_N = 6000.0"), encoding="utf-8")
    line = refused("tare", standing, "--parameters", mine, "-o", tmp_path / "again")
    assert "sensors.range_N was 5000, is 6000" in line


@pytest.mark.repeats
def test_the_case_of_a_plan_can_be_named_and_is_compared(shared: Path, tmp_path: Path, hexapod_file: Path) -> None:
    plan = Path(shutil.copytree(shared / "plan", tmp_path / "plan"))
    data = json.loads((plan / "plan.json").read_text())
    (plan / "plan.json").write_text(json.dumps(data | {"case_file": "/gone/case.toml"}))
    text = hexapod_file.read_text()
    for words in (
        ("post", plan, "--dialect", "sinumerik", "-o", tmp_path / "a.mpf"),
        ("retime", plan),
        ("compare", plan, "-o", tmp_path / "b"),
    ):
        assert "with --case" in refused(*words)
        hexapod_file.write_text(text.replace("range_N = 5000.0", "range_N = 6000.0"), encoding="utf-8")
        line = refused(*words, "--case", hexapod_file)
        assert "sensors.range_N was 5000, is 6000" in line
        assert str(hexapod_file) in line
        hexapod_file.write_text(text, encoding="utf-8")
        call(*words, "--case", hexapod_file, "--json").json()


def test_a_case_that_is_gone_can_be_named(mine: Path, tmp_path: Path, hexapod_file: Path) -> None:
    moved = tmp_path / "moved.toml"
    hexapod_file.rename(moved)
    assert tells(refused("export", mine, "--to", "json", "--force"), "no such case", "--case")
    call("export", mine, "--to", "json", "--force", "--case", moved, "-o", tmp_path / "m.json", "--json").json()
