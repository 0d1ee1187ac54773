"""Who gives a command a folder of the wrong kind is told which file is missing, and what writes it."""

from pathlib import Path

import pytest

import hexcite as hx
from cases.base.atomic import atomic_folder
from cases.base.errors import Code, FileProblem
from cases.base.folder_kinds import DEMO
from tests.hexcite.command_line import refused

COMMANDS = {
    ("post",): "hexcite plan writes it",
    ("retime",): "hexcite plan writes it",
    ("identify",): "does not say which machine",
    ("identify", "--case", "hexapod"): "give a recording's CSV or folder",
    ("export", "--to", "c"): "hexcite identify writes it",
    ("check", "--case", "hexapod"): "programs end in .ngc",
    ("run", "--case", "hexapod"): "programs end in .ngc",
}


@pytest.mark.parametrize("command", COMMANDS)
def test_a_folder_of_another_kind_is_refused_with_what_is_wanted(
    command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "comparison.json").write_text("{}")
    line = refused(command[0], "folder", *command[1:])
    assert "folder" in line
    assert COMMANDS[command] in line
    assert [p.name for p in tmp_path.iterdir()] == ["folder"]


def test_a_folder_of_nobody_is_called_none(tmp_path: Path):
    line = refused("post", tmp_path)
    assert "plan.json: cannot be read" in line
    assert "hexcite plan writes it" in line


def test_a_demo_does_not_take_the_place_of_an_earlier_one_unless_it_may(tmp_path: Path):
    with atomic_folder(tmp_path / "demo", DEMO) as part:
        (part / "report.html").write_text("an earlier demo")
    with pytest.raises(FileProblem) as caught:
        hx.demo(hx.load_case("hexapod"), tmp_path / "demo")
    assert caught.value.code is Code.EXISTS
    assert caught.value.place == str(tmp_path / "demo")
    assert (tmp_path / "demo" / "report.html").read_text() == "an earlier demo"
