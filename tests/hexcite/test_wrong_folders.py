"""Who gives a command a folder of the wrong kind is told which file is missing, and what writes it."""

from pathlib import Path

import pytest

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
