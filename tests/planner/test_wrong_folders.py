"""Who gives a command a folder of the wrong kind is told which kind it is and who takes it."""

from pathlib import Path

import pytest

from tests.helpers import tells
from tests.planner.command_line import refused

KINDS = {
    "plan.json": ("is a plan", "hexcite post, retime or compare"),
    "recording.json": ("is a run", "hexcite identify, force or compare"),
    "result.json": ("is a result", "hexcite export, force, payload or compare"),
    "comparison.json": ("is a comparison", "report.html"),
}
COMMANDS = {
    "plan.json": (("post",), ("retime",)),
    "recording.json": (("identify",), ("identify", "--case", "hexapod"), ("force", "--parameters", "nowhere")),
    "result.json": (("export", "--to", "c"),),
    "": (("check", "--case", "hexapod"), ("run", "--case", "hexapod")),
}


@pytest.mark.parametrize(
    ("given", "command"), [(g, c) for g in KINDS for w, commands in COMMANDS.items() if w != g for c in commands]
)
def test_the_kind_of_a_wrong_folder_and_its_commands_are_named(
    given: str, command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / given).write_text("{}")
    line = refused(command[0], "folder", *command[1:])
    for word in ("folder", *KINDS[given], "here a ", " wanted"):
        assert word in line
    assert [p.name for p in tmp_path.iterdir()] == ["folder"]


def test_a_file_of_a_plan_is_not_its_folder(tmp_path: Path):
    (tmp_path / "plan.json").write_text("{}")
    assert tells(refused("post", tmp_path / "plan.json"), "not a folder", f"name the folder {tmp_path}")


def test_a_folder_of_nobody_is_called_none(tmp_path: Path):
    line = refused("post", tmp_path)
    assert "plan.json: cannot be read" in line
    assert "hexcite plan writes it" in line
