"""`hexcite look` on the command line: the table that it prints is the table that the case needs."""

import tomllib
from pathlib import Path

from tests.planner.command_line import hexcite


def _recording(folder: Path) -> Path:
    """Twelve standstills of a force/torque sensor under names of a recorder's own."""
    rows = [f"{k / 10};{-k / 7};9.81;0.1;{k / 30};0,2;1;0;0;0;1;0;0;0;1".replace(".", ",") for k in range(12)]
    names = "Kraft x;Kraft y;Kraft z;Moment x;Moment y;Moment z;R11;R12;R13;R21;R22;R23;R31;R32;R33"
    file = folder / "wrist.csv"
    file.write_text("\n".join([names, *rows]) + "\n")
    return file


def test_the_printed_table_is_toml_that_reads_the_file(tmp_path: Path) -> None:
    file = _recording(tmp_path)
    answer = hexcite("look", file, "--case", "ft_wrist", "-o", tmp_path / "look.svg")
    assert answer.code == 0, answer.err
    table = tomllib.loads(answer.out[answer.out.index("[recording]") : answer.out.index("picture written")])
    assert table["recording"]["delimiter"] == ";"
    assert table["recording"]["decimal"] == ","
    assert table["recording"]["columns"]["fx_N"] == "Kraft x"
    assert (tmp_path / "look.svg").read_text().lstrip().startswith("<?xml")


def test_json_says_the_same(tmp_path: Path) -> None:
    answer = hexcite("look", _recording(tmp_path), "--case", "ft_wrist", "-o", tmp_path / "look.png", "--json").json()
    assert answer["reads"]
    assert answer["rows"] == 12
    assert {"name": "Kraft x", "meaning": "fx_N", "unit": "N", "guessed": False} in answer["columns"]


def test_a_picture_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "look.svg").write_text("mine")
    refusal = hexcite("look", _recording(tmp_path), "-o", tmp_path / "look.svg").refusal()
    assert "--overwrite" in refusal
    assert (tmp_path / "look.svg").read_text() == "mine"
